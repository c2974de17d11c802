// SPDX-License-Identifier: Apache-2.0
// A scan put on the floor: which way is up, what its unit is, where the person faces.
#pragma once

#include <string>
#include <vector>

#include "core/status.h"
#include "hal/scan/scan_file.h"

namespace im2fit::hal {

struct ScanOptions {
  double unit_mm = 0;  // millimetres a unit of the file; 0: found by the person's height
  std::string up;      // the file's axis that points up: "x", "-x", "y", "-y", "z", "-z"; "": found
};

// In mm: y up from the floor at 0, the person about the y axis and facing +z, their left at +x.
struct StandingScan {
  std::vector<Vec3f> points;
  std::vector<ScanTriangle> triangles;  // outside counter-clockwise, where the file's agree with one another
  double unit_mm = 1;
  std::string up;  // of the file
  float height_mm = 0;
  bool straightened = false;  // it leaned as nobody can stand
};

// Up: away from a floor or platform that was scanned, which is then left out; else along the longest axis, the crown
// of the head at the end that reaches less far aside. A body that leans by more than 4 degrees from its feet to its
// head is straightened. Unit: the one of mm, cm, dm, m, inches and feet by which the height is 1.2 to 2.3 m. Facing:
// from the ankles to the toes, then square to the trunk. `what`: the file's name, for errors. Errors: corrupt or
// invalid_argument: no person who stands; what to give instead.
Result<StandingScan> stand_scan(Scan scan, const ScanOptions& options, const std::string& what);

}  // namespace im2fit::hal
