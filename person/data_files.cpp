// SPDX-License-Identifier: Apache-2.0
#include "person/data_files.h"

namespace im2fit {
namespace {

// A missing file is the first thing a newcomer meets: say what makes it. One that may not be read is there.
Error advised(const Error& error, const char* maker) {
  if (error.code == ErrorCode::io) return {error.code, error.message + "; check the file and its permissions"};
  const bool absent = error.code == ErrorCode::not_found;
  return {error.code, error.message + (absent ? "; make it with " : "; make it again with ") + maker +
                          (absent ? ", or install a pack with im2fit models install" : "")};
}

}  // namespace

Result<body::BodyModel> load_body(const std::string& path) {
  auto model = body::BodyModel::load(path);
  if (!model) return advised(model.error(), "im2fit-lab fetch");
  return model;
}

Result<index::Index> load_index(const std::string& path) {
  auto index = index::Index::open(path);
  if (!index) return advised(index.error(), "im2fit-lab index");
  return index;
}

Result<Tracker> Tracker::load(const std::string& path) {
  auto file = MappedFile::open(path);
  if (!file) return advised(file.error(), "im2fit-lab train");
  auto model = JointModel::parse(file->bytes(), path);
  if (!model) return advised(model.error(), "im2fit-lab train");
  return Tracker(std::move(*file), std::move(*model));
}

Result<Tracker> Tracker::parse(std::vector<std::byte> bytes, const std::string& name) {
  auto model = JointModel::parse(bytes, name);
  if (!model) return model.error();
  return Tracker(std::move(bytes), std::move(*model));
}

}  // namespace im2fit
