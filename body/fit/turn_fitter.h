// SPDX-License-Identifier: Apache-2.0
// One body from many depth pictures of a person who turns round before a fixed camera, or round whom a camera is
// carried. The body known from the front is followed from picture to picture by its pose alone; then one shape and a
// pose of each of some pictures are fitted together, the shape by people's components and smooth bumps; what is left
// between skin and pictures becomes a field of offsets. What two views on opposite sides never see, a thickness, is
// measured so.
// Equations and weights: docs/fit.md.
//
// Only + - * / and sqrt in written order: the same bits on every machine. No allocation after construction.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "body/fit/shape_fitter.h"
#include "body/fit/turn_sight.h"
#include "body/person_axes.h"
#include "body/shape_space.h"
#include "body/skeleton.h"

namespace im2fit::body {

inline constexpr std::size_t kTurnViewMax = 8;  // more change nothing (docs/notebook/fit.md)

// A picture, and about how the person stands in it: axes of the fit (PersonAxes of the front).
struct TurnView {
  TurnPicture picture;
  Pose pose;
};

struct TurnFit {
  bool valid = false;
  std::array<float, kShapeMax> shape{};  // coefficients; the first shape_count are set
  // At rest, in the space's order: where the points of the skin lie, mm, mesh axes.
  std::vector<Vec3f> points;
  Skeleton bones;                                // at rest
  std::array<Pose, kTurnViewMax> poses;          // of the views
  std::array<float, kTurnViewMax> surface_mm{};  // mean absolute distance of the surface, of each view
  std::array<float, kSeenPointMax> beyond_mm{};  // `points` before the skin of `shape`: SeenBody
};
// As the product keeps it. Not valid where the fit is not.
SeenBody seen_body(const TurnFit& fit);

// Not shareable between threads.
class TurnFitter {
 public:
  // The space must outlive the fitter and have points.
  explicit TurnFitter(const ShapeSpace& space);
  ~TurnFitter();

  // Begins with the body fitted to the front: its shape, and the pose and axes of that picture. `floor`: the floor is
  // y = 0 of the axes.
  void begin(std::span<const float> shape, const Pose& pose, const PersonAxes& axes, bool floor);
  // The next picture of the turn, at most about 25 degrees further. False, and the pose kept, when too little of the
  // body is seen.
  bool follow(const TurnPicture& picture);
  const Pose& pose() const;
  // How far the camera has seen the person turn since begin(), degrees: + to the person's left. Through 180 and
  // beyond.
  float turned_deg() const;

  // One to kTurnViewMax pictures; further ones are ignored. Depends on begin() and the views alone, and does not
  // change what follow() goes on from. Not valid: a picture is not usable(), or too little of the body is seen in the
  // pictures. The result stands until the next call.
  const TurnFit& run(std::span<const TurnView> views);

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

}  // namespace im2fit::body
