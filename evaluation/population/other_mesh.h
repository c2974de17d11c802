// SPDX-License-Identifier: Apache-2.0
// The mean man of the evaluation's family `other`: a mesh that a body model learned from scans of people, of another
// topology and another surface than MakeHuman's, without a rig. It is read at run time from beside the checkout and
// judges only: nothing made from it may teach, calibrate, tune or ship.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/status.h"
#include "core/vec3.h"

namespace im2fit::lab {

inline constexpr std::size_t kOtherVertexCount = 6449, kOtherTriangleCount = 12894;

struct OtherMesh {
  std::vector<Vec3f> vertices;                         // mm; x the person's left, y up, z front
  std::vector<std::array<std::int32_t, 3>> triangles;  // counter-clockwise from outside
};

// `file`: s-scape_male.obj, in mm, y up. Feet come to stand on y = 0 and shoulders and hips to lie across.
// Errors name the file and what is wrong with it.
Result<OtherMesh> read_other_mesh(const std::string& file);
// A point of the file, where read_other_mesh() puts it: for constants found by looking at the file.
Vec3f placed_as_read(Vec3f in_file);

// Folder of that file when no option says: $IM2FIT_SHARED/data/other-makes, else ../shared/data/other-makes from the
// folder the program is called in.
std::string default_other_folder();
std::string other_mesh_file(const std::string& folder);

}  // namespace im2fit::lab
