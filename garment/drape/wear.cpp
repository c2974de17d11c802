// SPDX-License-Identifier: Apache-2.0
#include "garment/drape/wear.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "garment/drape/cloth_part.h"

namespace im2fit::body {
namespace {

constexpr float kUncoversMm = 60;  // cloth that moves, on either side of a hem

SkinnedPart part_of(const BodyModel& model, const Outfit& outfit, std::size_t index, const ClothLook& look,
                    bool moves) {
  ClothPart cloth = cloth_part(model, outfit, index, outfit.skeleton());
  SkinnedPart part;
  part.material = look.name;
  part.colour = look.colour;
  part.positions = std::move(cloth.rest);
  part.normals = std::move(cloth.normals);
  for (const Flat& at : cloth.texture) part.texture.push_back({at.x, at.y});
  part.segments = std::move(cloth.segments);
  part.weights = std::move(cloth.weights);
  if (look.vertex_colours.size() == part.positions.size()) part.vertex_colours = look.vertex_colours;
  if (moves)
    for (const Refinement::Spot& spot : outfit.refinement(index).spots()) {
      const auto corner = [&](std::size_t k) { return static_cast<std::uint16_t>(spot.corner[k]); };
      part.corners.push_back({corner(0), corner(1), corner(2)});
      part.shares.push_back(spot.share);
    }
  std::vector<std::uint8_t> hidden(part.positions.size());
  outfit.hidden_cloth(index, hidden, moves ? kUncoversMm : 0);
  for (const auto& t : outfit.cloth(index).mesh().triangles)
    if (std::any_of(t.begin(), t.end(), [&](std::int32_t v) { return hidden[static_cast<std::size_t>(v)] == 0; }))
      part.triangles.push_back(t);
  return part;
}

}  // namespace

void wear(Avatar& avatar, const Outfit& outfit, std::span<const ClothLook> looks, ClothMotion motion) {
  const bool moves = motion == ClothMotion::moves;
  avatar.parts.clear();
  avatar.hidden_skin.assign(static_cast<std::size_t>(avatar.model->body_vertex_count()), 0);
  outfit.hidden_skin(avatar.hidden_skin, moves ? kUncoversMm : 0);
  for (std::size_t i = 0; i < outfit.size(); ++i)
    avatar.parts.push_back(
        part_of(*avatar.model, outfit, i, i < looks.size() ? looks[i] : ClothLook{"cloth"}, moves));
}

}  // namespace im2fit::body
