// SPDX-License-Identifier: Apache-2.0
// Loads generated data files; errors name the command that makes them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "body/model.h"
#include "core/file.h"
#include "core/status.h"
#include "formats/model_pack.h"
#include "index/index.h"
#include "perception/joints/tracker.h"

namespace im2fit {

// Wherever a path names a body, an index or a tracker, it may name a model pack that holds one.
Result<body::BodyModel> load_body(const std::string& path);
Result<index::Index> load_index(const std::string& path);

// What this program reads of its own files; a pack has one of each.
struct KnownModel {
  const char* magic;
  const char* kind;  // for messages
  const char* file;  // in packs and in directories
  std::uint32_t version;
};
std::span<const KnownModel> known_models();

// A model's bytes, of a file or out of a pack; `name` is what a pack calls it (formats/model_pack.h). Errors: as of
// reading them; unsupported for a packed model of another format.
Result<std::vector<std::byte>> model_bytes(const std::string& path, const std::string& name);
// Of an opened pack.
Result<std::vector<std::byte>> model_of(const ModelPack& pack, const std::string& path, const std::string& name);
// "PACK: index.i2f"
std::string name_in_pack(const std::string& pack, const std::string& name);

// Whether the files can be opened; "" is passed over. Nothing is read. Errors: as of loading them.
Status check_data_files(const std::string& tracker, const std::string& index, const std::string& body);

// A joint model and the mapping or the bytes it views into.
class Tracker {
 public:
  static Result<Tracker> load(const std::string& path);
  static Result<Tracker> parse(std::vector<std::byte> bytes, const std::string& name);
  const JointModel& model() const { return model_; }

 private:
  Tracker(MappedFile file, JointModel model) : file_(std::move(file)), model_(std::move(model)) {}
  Tracker(std::vector<std::byte> bytes, JointModel model) : bytes_(std::move(bytes)), model_(std::move(model)) {}
  MappedFile file_;
  std::vector<std::byte> bytes_;
  JointModel model_;
};

}  // namespace im2fit
