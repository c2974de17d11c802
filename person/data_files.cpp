// SPDX-License-Identifier: Apache-2.0
#include "person/data_files.h"

#include <cstdint>
#include <cstring>
#include <utility>

#include "body/model_data.h"
#include "index/format.h"
#include "perception/joints/model_data.h"

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

constexpr KnownModel kKnownModels[] = {{"I2BD", "body", kPackedBody, body::kBodyVersion},
                                       {"I2TR", "tracker", kPackedTracker, joints::kTrackerVersion},
                                       {"I2FX", "index", kPackedIndex, index::kVersion}};

}  // namespace

std::span<const KnownModel> known_models() {
  return kKnownModels;
}

Result<std::vector<std::byte>> model_of(const ModelPack& pack, const std::string& path, const std::string& name) {
  auto bytes = pack.file(name);
  if (!bytes) return bytes.error();
  std::uint32_t version = 0;
  constexpr std::size_t kVersionAt = 4;  // core/container.h
  if (bytes->size() < kVersionAt + sizeof version) return bytes;
  std::memcpy(&version, bytes->data() + kVersionAt, sizeof version);
  for (const KnownModel& known : kKnownModels)
    if (name == known.file && version != known.version)
      return other_format(path, known.kind, name, version, known.version);
  return bytes;
}

Result<std::vector<std::byte>> model_bytes(const std::string& path, const std::string& name) {
  if (!is_model_pack(path)) return read_file(path);
  const auto file = MappedFile::open(path);
  if (!file) return file.error();
  const auto pack = ModelPack::parse(file->bytes(), path, false);
  if (!pack) return pack.error();
  return model_of(*pack, path, name);
}

std::string name_in_pack(const std::string& pack, const std::string& name) {
  return pack + ": " + name;
}

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
    auto bytes = model_bytes(path, kPackedBody);
    if (!bytes) return bytes.error();
    return body::BodyModel::parse(std::move(*bytes), name_in_pack(path, kPackedBody));
  }
  auto model = body::BodyModel::load(path);
  if (!model) return advised(model.error(), kBodyMaker);
  return model;
}

Result<index::Index> load_index(const std::string& path) {
  if (is_model_pack(path)) {
    auto bytes = model_bytes(path, kPackedIndex);
    if (!bytes) return bytes.error();
    return index::Index::parse(std::move(*bytes), name_in_pack(path, kPackedIndex));
  }
  auto index = index::Index::open(path);
  if (!index) return advised(index.error(), kIndexMaker);
  return index;
}

Result<Tracker> Tracker::load(const std::string& path) {
  if (is_model_pack(path)) {
    auto bytes = model_bytes(path, kPackedTracker);
    if (!bytes) return bytes.error();
    return parse(std::move(*bytes), name_in_pack(path, kPackedTracker));
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
