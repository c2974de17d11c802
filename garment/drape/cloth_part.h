// SPDX-License-Identifier: Apache-2.0
// A draped garment as a skinned mesh: in the avatar's pose it lies as it was draped, in others it follows the skin
// below it.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "body/skeleton.h"
#include "garment/drape/outfit.h"

namespace im2fit::body {

struct ClothPart {
  std::vector<Vec3f> rest, normals;  // mm, as the rest mesh; unit
  std::vector<Flat> texture;         // metres of cloth, along weft and warp
  std::vector<std::array<std::uint8_t, 4>> segments;
  std::vector<std::array<float, 4>> weights;  // sum to 1, heaviest first
};
// `rest`: the skeleton the outfit's body has.
ClothPart cloth_part(const BodyModel& model, const Outfit& outfit, std::size_t index, const Skeleton& rest);

// The motion that a vertex's four segments mix (linear blend skinning).
struct MixedMotion {
  std::array<float, 9> m{};  // rows
  Vec3f shift;
  Vec3f of(Vec3f at_rest) const;
  Vec3f transposed(Vec3f direction) const;
};

// From rest to a pose and back.
class Unposing {
 public:
  Unposing(const Skeleton& rest, const Pose& pose);
  MixedMotion motion(const std::array<std::uint8_t, 4>& segments, const std::array<float, 4>& weights) const;
  // False where the four are turned so far against each other that their mean is useless: `at_rest` is unchanged.
  bool undo(const std::array<std::uint8_t, 4>& segments, const std::array<float, 4>& weights, Vec3f posed,
            Vec3f& at_rest) const;

 private:
  std::array<Mat3f, kSegmentCount> rotation_;
  std::array<Vec3f, kSegmentCount> shift_;
};

}  // namespace im2fit::body
