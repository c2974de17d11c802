// SPDX-License-Identifier: Apache-2.0
#include "person/data_files.h"

#include <cstdint>
#include <utility>

#include "formats/model_pack.h"

namespace im2fit {
namespace {

constexpr const char* kBodyMaker = "im2fit-lab fetch";
constexpr const char* kIndexMaker = "im2fit-lab index";
constexpr const char* kTrackerMaker = "im2fit-lab train";

// A missing file is the first thing a newcomer meets: say what makes it. One that may not be read is there.
Error advised(const Error& error, const char* maker) {
  if (error.code == ErrorCode::io) return {error.code, error.message + "; check the file and its permissions"};
  const bool absent = error.code == ErrorCode::not_found;
  return {error.code, error.message + (absent ? "; make it with " : "; make it again with ") + maker +
                          (absent ? ", or install a pack with im2fit models install" : "")};
}

// Of a pack that holds the file among others.
Result<std::vector<std::byte>> packed_file(const std::string& pack, const char* name) {
  const auto file = MappedFile::open(pack);
  if (!file) return file.error();
  const auto opened = ModelPack::parse(file->bytes(), pack, false);
  if (!opened) return opened.error();
  return opened->file(name);
}

std::string name_in(const std::string& pack, const char* name) {
  return pack + ": " + name;
}

}  // namespace

Status check_data_files(const std::string& tracker, const std::string& index, const std::string& body) {
  const std::pair<const std::string&, const char*> files[] = {
      {tracker, kTrackerMaker}, {index, kIndexMaker}, {body, kBodyMaker}};
  std::vector<std::byte> nothing;
  for (const auto& [path, maker] : files) {
    if (path.empty()) continue;
    if (auto opened = read_file_into(path, SIZE_MAX, 0, nothing); !opened) return advised(opened.error(), maker);
  }
  return Ok{};
}

Result<body::BodyModel> load_body(const std::string& path) {
  if (is_model_pack(path)) {
    auto bytes = packed_file(path, kPackedBody);
    if (!bytes) return bytes.error();
    return body::BodyModel::parse(std::move(*bytes), name_in(path, kPackedBody));
  }
  auto model = body::BodyModel::load(path);
  if (!model) return advised(model.error(), kBodyMaker);
  return model;
}

Result<index::Index> load_index(const std::string& path) {
  if (is_model_pack(path)) {
    auto bytes = packed_file(path, kPackedIndex);
    if (!bytes) return bytes.error();
    return index::Index::parse(std::move(*bytes), name_in(path, kPackedIndex));
  }
  auto index = index::Index::open(path);
  if (!index) return advised(index.error(), kIndexMaker);
  return index;
}

Result<Tracker> Tracker::load(const std::string& path) {
  if (is_model_pack(path)) {
    auto bytes = packed_file(path, kPackedTracker);
    if (!bytes) return bytes.error();
    return parse(std::move(*bytes), name_in(path, kPackedTracker));
  }
  auto file = MappedFile::open(path);
  if (!file) return advised(file.error(), kTrackerMaker);
  auto model = JointModel::parse(file->bytes(), path);
  if (!model) return advised(model.error(), kTrackerMaker);
  return Tracker(std::move(*file), std::move(*model));
}

Result<Tracker> Tracker::parse(std::vector<std::byte> bytes, const std::string& name) {
  auto model = JointModel::parse(bytes, name);
  if (!model) return model.error();
  return Tracker(std::move(bytes), std::move(*model));
}

}  // namespace im2fit
