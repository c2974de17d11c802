// SPDX-License-Identifier: Apache-2.0
// The clothes of an avatar while its body moves, simulated as rough meshes. The output is each rough vertex's offset,
// at rest, from its place by the skeleton alone, enlarged where the shown mesh would lie inside the body.
// docs/garments.md specifies how a viewer applies the offsets.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "body/model.h"
#include "body/skeleton.h"
#include "garment/drape/offset_clearing.h"
#include "garment/drape/outfit.h"

namespace im2fit::body {

// Not shareable between threads; the model must outlive it. + - * / and sqrt only: the same bits on every machine.
class MovingClothes {
 public:
  // Most a joint moves in a frame, about the speed of a hand; a longer way takes more frames.
  static constexpr float kStrideMm = 120;
  static constexpr float kFarthestMm = 500;  // an offset's length at most, before it is pushed out of the skin

  // `dressed`: of pieces with moving meshes, standing in the pose it was dressed in, of this rest skeleton. Those
  // come to rest there, which is where all offsets are nought until they are found first. Allocates, and frees the
  // fine meshes.
  MovingClothes(const BodyModel& model, std::unique_ptr<Outfit> dressed, const Skeleton& rest);

  // Advances by a thirtieth of a second, in which the body moves towards `pose` (translation ignored). No allocation.
  void frame(const Pose& pose);
  // Computes the offsets of the last frame; needed only for the frames a caller outputs. No allocation.
  void find_offsets();

  std::size_t size() const { return bound_.size(); }
  // Of the last find_offsets(), for each vertex of a garment's moving mesh, mm in the axes of the rest mesh: a viewer
  // adds it before skinning.
  std::span<const Vec3f> offsets(std::size_t garment) const { return bound_[garment].offsets; }
  const Outfit& outfit() const { return *outfit_; }  // of moving meshes

 private:
  struct Bound {
    std::vector<std::array<std::uint8_t, 4>> segments;
    std::vector<std::array<float, 4>> weights;
    std::vector<Vec3f> rest, offsets;
    OffsetClearing fine;
  };
  float stride_mm(const Pose& pose) const;

  std::unique_ptr<Outfit> outfit_;
  Skeleton rest_;
  std::vector<Bound> bound_;
};

}  // namespace im2fit::body
