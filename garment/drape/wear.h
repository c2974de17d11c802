// SPDX-License-Identifier: Apache-2.0
// A draped outfit as parts of an avatar (body/export).
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "body/export/export.h"
#include "garment/drape/outfit.h"

namespace im2fit::body {

struct ClothLook {
  std::string name;                                       // of the material
  std::array<float, 3> colour = {0.5F, 0.5F, 0.5F};       // linear
  std::vector<std::array<float, 3>> vertex_colours = {};  // of each vertex of the garment instead, or none
};

enum class ClothMotion { still, moves };

// Gives the avatar one part a garment, as they are draped, and hides the skin below them. `outfit` is dressed on the
// avatar's body in the avatar's pose; `looks`: one a garment, grey cloth where there are fewer.
// ClothMotion::moves, of an outfit that can_move(): each vertex carries which vertices of the garment's moving mesh
// move it (MovingClothes), and skin and cloth that motion may uncover are drawn.
void wear(Avatar& avatar, const Outfit& outfit, std::span<const ClothLook> looks = {},
          ClothMotion motion = ClothMotion::still);

}  // namespace im2fit::body
