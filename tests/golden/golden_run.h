// SPDX-License-Identifier: Apache-2.0
// One depth clip through the device's own stages, as text that names each stage: what must be equal on every machine.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/file.h"
#include "core/status.h"
#include "hal/source.h"
#include "index/index.h"
#include "perception/joints/tracker.h"

namespace im2fit::golden {

inline constexpr int kFramesWanted = 6;  // of the clip's 8: the session ends on its own

// DIRECTORY/clip (a depth folder), DIRECTORY/tracker.i2t and DIRECTORY/index.i2f.
class Data {
 public:
  static Result<Data> load(const std::string& directory);

  const JointModel& tracker() const { return *tracker_; }
  const index::Index& index() const { return *index_; }
  const Intrinsics& intrinsics() const { return intrinsics_; }
  std::vector<std::vector<std::uint16_t>>& frames() { return frames_; }  // upright, mm
  const std::vector<std::vector<std::uint16_t>>& frames() const { return frames_; }

 private:
  Data() = default;
  Status load_clip();
  std::string directory_;
  std::vector<std::byte> tracker_bytes_;
  std::optional<JointModel> tracker_;
  std::optional<index::Index> index_;
  Intrinsics intrinsics_;
  std::vector<std::vector<std::uint16_t>> frames_;
};

// A line for each stage of each frame (mask, person, joints), then of the fused picture (depth, points, normals,
// paper, FPFH, profile, feature), then of the answer (measurements, entry, body): checksums, and values where a
// person may want to read them. Errors: the clip is refused somewhere.
Result<std::string> stages(const Data& data);

// result.json of the whole engine, fed by the folder source.
Result<std::string> result(const Data& data, const std::string& directory, bool single_thread);

// Bodies fitted to measurements, a line for each of their measurements and parameters. First the checksum of the
// meshes in the body file: with another file nothing below is comparable. Errors: the file does not load.
Result<std::string> bodies(const std::string& body_path);

// "" when both are the same; else the first line that differs, with its number, expected and found.
std::string first_difference(const std::string& expected, const std::string& found);

}  // namespace im2fit::golden
