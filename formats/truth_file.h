// SPDX-License-Identifier: Apache-2.0
// truth.json beside the frames of a synthetic person: who stood there and where the joints were. docs/formats.md.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/floor_plane.h"
#include "core/joints.h"
#include "core/measurement.h"
#include "core/status.h"

namespace im2fit {

struct Truth {
  std::uint64_t seed = 0;
  std::uint64_t subject = 0;  // number within the family and seed
  std::string family;
  bool woman = false;
  MeasurementValues values{};
  FloorPlane floor;              // camera axes of upright frames
  std::vector<JointSet> joints;  // a set a frame, camera axes of upright frames
};

Status write_truth(const Truth& truth, const std::string& path);
// Errors: not_found, io; unsupported: JSON of another make, or another version; corrupt.
Result<Truth> read_truth(const std::string& path);

}  // namespace im2fit
