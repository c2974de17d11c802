// SPDX-License-Identifier: Apache-2.0
// The avatar as files other programs read (docs/formats-body.md). Each is written atomically; the lowest body vertex
// of the posed avatar stands on y = 0. Errors: the avatar names no model; the file cannot be written.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "body/garment/outfit.h"
#include "body/model.h"
#include "body/skeleton.h"
#include "core/status.h"

namespace im2fit::body {

struct ClothLook {
  std::string name;                                       // of the material
  std::array<float, 3> colour = {0.5F, 0.5F, 0.5F};       // linear
  std::vector<std::array<float, 3>> vertex_colours = {};  // of each vertex of the garment instead, or none
};

struct Avatar {
  const BodyModel* model = nullptr;
  Params params;
  Pose pose;  // how it stands in .obj and in the default pose of .glb
  // .glb: what the body wears, draped in `pose`, as primitives of their own; the skin it hides is left out.
  const Outfit* outfit = nullptr;
  std::vector<ClothLook> looks = {};  // of each garment of the outfit
  // .glb: cloth, of an outfit that can_move(), will be moved by offsets of its moving mesh (MovingClothes). Each of
  // its vertices says which of those it is moved by, and what cloth may uncover is left in.
  bool cloth_moves = false;
};
// metres, +Y up, skinned, 19 joints; the file's bytes
Result<std::vector<std::byte>> glb_of(const Avatar& avatar);
// `material_library`: the file beside it that says where the texture is; "": it names none.
Result<std::string> obj_of(const Avatar& avatar, const std::string& material_library = "");
Result<std::string> bvh_of(const Avatar& avatar);  // the text that write_bvh writes
Status write_glb(const Avatar& avatar, const std::string& path);
Status write_obj(const Avatar& avatar, const std::string& path);  // metres, posed
// Beside NAME.obj also NAME.mtl and NAME_skin.png, its materials and their texture, where the body file has a look.
Status write_textured_obj(const Avatar& avatar, const std::string& path);
Status write_bvh(const Avatar& avatar, const std::string& path);   // centimetres, one frame: the pose
Status write_skel(const Avatar& avatar, const std::string& path);  // the fifteen joints, mm
// The paper's nine attributes, one "name value" a line (docs/formats-body.md).
Status write_attributes(const Avatar& avatar, const std::string& path);

}  // namespace im2fit::body
