// SPDX-License-Identifier: Apache-2.0
// The skin's texture, drawn for this project by rules: no picture of anybody's. Places are those of MakeHuman's base
// mesh, mm.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "body/look.h"
#include "core/status.h"
#include "core/vec3.h"

namespace im2fit::body::makehuman {

// What a pixel of the texture shows.
struct SkinPlace {
  Vec3f at;       // on the base mesh, mm
  float arm = 0;  // 0..1, how much of it moves with an arm
};
using Colour = std::array<float, 3>;  // as displayed (sRGB), 0..255

Colour skin_colour(const SkinPlace& place, LookOf whose);
// `right`, `above`: from the pupil's middle; 1: 75 degrees aside (look.cpp).
Colour eye_colour(float right, float above);

struct SkinMesh {
  std::span<const Vec3f> positions;  // mm
  std::span<const float> arm;        // of each
  std::span<const std::array<std::int32_t, 4>> quads;
  std::span<const std::array<TexturePlace, 4>> corners;
};
struct SkinTextures {
  std::array<std::vector<std::byte>, 2> png;  // a man's, a woman's
  float eye_u = 0, eye_v = 0, eye_r = 0;      // where the eye is drawn: the largest place no skin lies in
};
Result<SkinTextures> draw_skin_textures(const SkinMesh& mesh, int side_pixels);

}  // namespace im2fit::body::makehuman
