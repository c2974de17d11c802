// SPDX-License-Identifier: Apache-2.0
#include "body/fit/skin_bumps.h"

#include <algorithm>
#include <cmath>

namespace im2fit::body {
namespace {

// Sizes of the prototype (docs/fit.md).
constexpr float kApartMm = 90;
constexpr float kWidthMm = 70;
constexpr float kSdMm = 8;
constexpr float kCutOff = 3;          // widths
constexpr float kLeftOutMin = 0.3F;   // weight of head, hands and feet: no centre there
constexpr float kSameSideMin = 0.3F;  // cosine between the normals of neighbours
constexpr float kNeighbourMaxMm = 80;

Vec3f middle(const ShapeSpace& space, std::size_t i) {
  const float* at = space.point_mean.data() + i * kPointValues;
  return {at[0], at[1], at[2]};
}

float weight_of(const SkinRecord& skin, auto... segments) {
  float sum = 0;
  for (std::size_t k = 0; k < 4; ++k)
    if (((skin.segment[k] == static_cast<std::uint8_t>(segments)) || ...)) sum += skin.weight[k];
  return sum;
}

// e^-x for x >= 0, to 0.2 %: (1 + x / 256)^-256. + - * / only, the same bits on every machine.
float decay(float x) {
  float y = 1 / (1 + x * (1.0F / 256));
  for (int i = 0; i < 8; ++i) y *= y;
  return y;
}

}  // namespace

SkinBumps::SkinBumps(const ShapeSpace& space) {
  for (std::size_t i = 0; i < space.point_count; ++i) {
    const float* at = space.point_mean.data() + i * kPointValues;
    normal.push_back(normalized(cross(Vec3f{at[3], at[4], at[5]}, Vec3f{at[6], at[7], at[8]})));
  }
  std::vector<std::size_t> centres;
  for (std::size_t i = 0; i < space.point_count; ++i) {
    if (weight_of(space.skin[i], Segment::head, Segment::left_hand, Segment::right_hand, Segment::left_foot,
                  Segment::right_foot) > kLeftOutMin)
      continue;
    if (!(norm(normal[i]) > 0) || centres.size() == kBumpMax) continue;
    const bool apart = std::all_of(centres.begin(), centres.end(), [&](std::size_t c) {
      return norm(middle(space, c) - middle(space, i)) >= kApartMm || dot(normal[c], normal[i]) <= 0;
    });
    if (apart) centres.push_back(i);
  }
  count = centres.size();
  move.assign(space.point_count * count, 0.0F);
  for (std::size_t k = 0; k < count; ++k)
    for (std::size_t i = 0; i < space.point_count; ++i) {
      const Vec3f d = middle(space, centres[k]) - middle(space, i);
      const float square = dot(d, d) / (kWidthMm * kWidthMm);
      if (square > kCutOff * kCutOff) continue;
      const float side = std::clamp(dot(normal[centres[k]], normal[i]) + 0.3F, 0.0F, 1.0F);
      const float body =
          std::max(0.0F, 1 - weight_of(space.skin[i], Segment::head, Segment::left_hand, Segment::right_hand));
      move[i * count + k] = kSdMm * decay(square / 2) * side * body;
    }
}

SkinGraph::SkinGraph(const ShapeSpace& space, std::span<const Vec3f> normals)
    : neighbours(space.point_count * kSkinNeighbours) {
  for (std::size_t i = 0; i < space.point_count; ++i) {
    SkinNeighbour* own = neighbours.data() + i * kSkinNeighbours;
    std::size_t found = 0;
    for (std::size_t j = 0; j < space.point_count; ++j) {
      if (j == i || dot(normals[i], normals[j]) < kSameSideMin) continue;
      const float mm = norm(middle(space, i) - middle(space, j));
      if (mm > kNeighbourMaxMm || !(mm > 0)) continue;
      std::size_t place = found;
      while (place > 0 && own[place - 1].distance_mm > mm) --place;
      if (place == kSkinNeighbours) continue;
      found = std::min(found + 1, kSkinNeighbours);
      for (std::size_t k = found - 1; k > place; --k) own[k] = own[k - 1];
      own[place] = {static_cast<std::uint32_t>(j), mm};
    }
  }
}

}  // namespace im2fit::body
