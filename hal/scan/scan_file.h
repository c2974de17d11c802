// SPDX-License-Identifier: Apache-2.0
// Files of body scanners: a mesh or a cloud of points in whatever unit and axes its program had.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/status.h"
#include "core/vec3.h"

namespace im2fit::hal {

using ScanTriangle = std::array<std::uint32_t, 3>;

struct Scan {
  std::vector<Vec3f> points;
  std::vector<ScanTriangle> triangles;  // of `points`; empty: a cloud
};

// A name that ends in .ply, .obj, .glb or .pcd, in either case.
bool is_scan_name(const std::string& path);

// PLY (text and binary), OBJ, glTF 2 in one file (.glb) and PCD (text, binary, compressed), by the name's ending.
// Positions and faces alone are read; faces of more than three corners are cut into triangles. A point that is not
// finite, or farther than 10 million units from the origin, is left out together with its faces.
// Errors: as read_file; corrupt: what is wrong and where; unsupported: a kind of content that is not read.
Result<Scan> read_scan(const std::string& path);

}  // namespace im2fit::hal
