// SPDX-License-Identifier: Apache-2.0
// What every writer needs of an avatar: its meshes, bones and where the floor is.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "body/export/export.h"

namespace im2fit::body {

struct Figure {
  std::vector<Vec3f> rest;   // mm, model axes
  std::vector<Vec3f> posed;  // mm, lowest body vertex at y = 0
  Skeleton skeleton;
  Pose pose;         // translation such that the posed figure stands on y = 0
  float floor_rest;  // lowest y of the rest mesh, mm
};
// `rest`: the mesh of the avatar's params, all vertices, where it is there; empty: it is morphed.
Result<Figure> make_figure(const Avatar& avatar, std::span<const Vec3f> rest = {});

// The writers of export.h for a figure that is there: an avatar in several forms is morphed and posed once. `figure`
// is that of the avatar's model, params and pose.
std::vector<std::byte> glb_of(const Avatar& avatar, const Figure& figure);
Status write_textured_obj(const Avatar& avatar, const Figure& figure, const std::string& path);
Status write_bvh(const Figure& figure, const std::string& path);

// Rotation of a segment relative to its parent.
Mat3f local_rotation(const Pose& pose, std::size_t segment);

// Appends with a fixed number of decimals and a point whatever the locale.
void append_number(std::string& out, double value, int decimals);

}  // namespace im2fit::body
