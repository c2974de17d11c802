// SPDX-License-Identifier: Apache-2.0
// The avatar as files other programs read (docs/formats-body.md). Each is written atomically; the lowest body vertex
// of the posed avatar stands on y = 0. Errors: the avatar names no model; the file cannot be written.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "body/look.h"
#include "body/model.h"
#include "body/skeleton.h"
#include "core/status.h"

namespace im2fit::body {

// A mesh beside the skin, as clothes are: a primitive of its own in .glb, skinned to the body's segments.
struct SkinnedPart {
  std::string material;
  std::array<float, 3> colour = {0.5F, 0.5F, 0.5F};  // linear
  // One of each a vertex: mm, as the rest mesh; unit; texture repeats, so beyond 0..1.
  std::vector<Vec3f> positions, normals;
  std::vector<TextureCoordinate> texture;
  std::vector<std::array<std::uint8_t, 4>> segments;
  std::vector<std::array<float, 4>> weights;              // sum to 1, heaviest first
  std::vector<std::array<float, 3>> vertex_colours = {};  // linear, instead of `colour`; or none
  // Of parts that are moved by a coarser mesh, one a vertex: three of that mesh's vertices and their shares. Or none.
  std::vector<std::array<std::uint16_t, 3>> corners = {};
  std::vector<std::array<float, 3>> shares = {};
  std::vector<std::array<std::int32_t, 3>> triangles;  // those that are drawn
};

struct Avatar {
  const BodyModel* model = nullptr;
  Params params;
  Pose pose;  // how it stands in .obj and in the default pose of .glb
  // .glb: parts drawn besides the skin, and a flag for each body vertex, 1: hidden; a quad whose corners are all
  // hidden is not drawn. wear() of garment/drape makes both of clothes.
  std::vector<SkinnedPart> parts = {};
  std::vector<std::uint8_t> hidden_skin = {};  // or none
};
// metres, +Y up, skinned, 19 joints; the file's bytes
Result<std::vector<std::byte>> glb_of(const Avatar& avatar);
// `material_library`: the file beside it that names the texture; "": none.
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
