// SPDX-License-Identifier: Apache-2.0
// Where a moving camera stood for each frame, as a table: poses.csv of a depth folder, odometry.csv of Stray Scanner.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "core/status.h"
#include "hal/source.h"

namespace im2fit::hal {

// Reads a number to the nearest double, whatever the locale, with an exponent: from_chars for floats is not in every
// standard library we build with, and CsvReader::number() takes no exponent. False: the text is not a number.
class NumberReader {
 public:
  NumberReader();
  bool read(const std::string& text, double& value);

 private:
  std::istringstream stream_;
};

// Camera to world, for the axes of the frame as stored: x right, y down, z forward.
struct PoseRow {
  std::uint64_t sequence = 0;
  int line = 0;
  CameraPose pose;
  std::optional<double> time_s;              // growing from row to row
  std::optional<std::array<float, 4>> lens;  // fx, fy, cx, cy in pixels, of a camera with autofocus
};

enum class PoseTable {
  // sequence,x_m,y_m,z_m,qx,qy,qz,qw (PoseRow::time_s and lens: none)
  poses_csv,
  // timestamp, frame, x, y, z, qx, qy, qz, qw, and in later versions of the app fx, fy, cx, cy; in the first ones
  // neither timestamp nor frame, and no header: a row is a frame
  odometry_csv
};

// Rows in growing order of `sequence`. A quaternion that is unit within rounding is kept to the bit, one within 1 %
// is normalised. Errors name file and line: corrupt, not_found, io, unsupported (more rows than a folder may have
// frames).
Result<std::vector<PoseRow>> read_pose_rows(const std::string& path, PoseTable table);

// Of poses.csv. Nine digits give every float back to the bit.
inline constexpr const char* kPosesHeader = "sequence,x_m,y_m,z_m,qx,qy,qz,qw\n";
std::string poses_line(std::uint64_t sequence, const CameraPose& pose);

}  // namespace im2fit::hal
