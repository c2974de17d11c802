// SPDX-License-Identifier: Apache-2.0
// The clothes of an avatar while its body moves: simulated as rough meshes, and told as what each rough vertex adds,
// at rest, to where the skeleton alone would take it, and more where what is shown would lie inside the body.
// docs/garments.md says how a viewer shows that.
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
  // A joint moves by so much in a frame at most, about as fast as a hand does; what is farther takes more frames.
  static constexpr float kStrideMm = 120;
  static constexpr float kFarthestMm = 500;  // an offset's length at most, before it is pushed out of the skin

  // `dressed`: of pieces with moving meshes, standing in the pose it was dressed in, of this rest skeleton. Those
  // come to rest there, which is where all offsets are nought until they are found first. Allocates, and frees the
  // fine meshes.
  MovingClothes(const BodyModel& model, std::unique_ptr<Outfit> dressed, const Skeleton& rest);

  // A thirtieth of a second, in which the body goes towards `pose` (translation not heeded). No allocation.
  void frame(const Pose& pose);
  // Offsets of the last frame: whoever tells of few frames asks for few. No allocation.
  void find_offsets();

  std::size_t size() const { return bound_.size(); }
  // As found last, of each vertex of a garment's moving mesh, mm in the axes of the rest mesh: a viewer adds it
  // before it skins.
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
