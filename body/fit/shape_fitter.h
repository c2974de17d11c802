// SPDX-License-Identifier: Apache-2.0
// Shape and pose of a body to fused depth pictures: Gauss-Newton on point-to-plane distances of the skin (Chen and
// Medioni 1991), distances of the outline from the mask's edge, the joints and the floor, with the population as
// prior. One shape behind all views, a pose of its own in each (a person who turns round stands differently).
// Equations and weights: docs/fit.md.
//
// Only + - * / and sqrt in written order: the same bits on every machine. No allocation after construction.
#pragma once

#include <array>
#include <memory>
#include <span>

#include "body/fit/limb_axes.h"
#include "body/fit/skin_patches.h"
#include "body/shape_space.h"
#include "body/skeleton.h"
#include "core/camera.h"
#include "core/fit_layout.h"
#include "core/floor_plane.h"
#include "core/joints.h"

namespace im2fit::body {

inline constexpr std::size_t kFitViewMax = 2;

// Upright pictures of the intrinsics' size; what they point to must stand until run() returns.
struct FitView {
  ImageView<const std::uint16_t> depth_q4;  // 1/16 mm, 0 = none
  MaskView mask;
  Intrinsics intrinsics;
  JointSet joints;  // camera axes; confidence is not used
  FloorPlane floor;
};

struct ShapeFit {
  // False: too little was seen, or a view is unusable (docs/fit.md). Numbers are finite in either case.
  bool valid = false;
  std::array<float, kShapeMax> shape{};  // coefficients; the first shape_count are set
  // How far before the body's skin, along its normals, the surface seen lies, mm: mean of a patch's points, of each
  // view. NaN where none of them is seen.
  std::array<std::array<float, kPatchMax>, kFitViewMax> off_mm{};
  std::array<LimbAxes, kFitViewMax> limbs{};  // of the pose in each view; NaN without a view
  Pose pose;                                  // in the first view, PersonAxes of its joints and floor
  float surface_mm = 0;                       // mean absolute distances at the end
  float rim_mm = 0;
  int surface_rows = 0, rim_rows = 0;
};

// Of the space's points, in its order, every so many is kept of a body measured all round.
inline constexpr std::size_t kSeenEach = 4, kSeenPointMax = 600;

// The part of a fit that is kept after its pictures are gone.
struct SeenBody {
  bool valid = false;
  bool back = false;    // from both sides
  bool around = false;  // from all sides: `beyond_mm` holds, and limbs are as true as the trunk
  std::array<float, kShapeMax> shape{};
  Pose pose;  // in the first view, axes of PersonAxes
  // How far before the skin of `shape`, along its normals, the person's skin lies, mm.
  std::array<float, kSeenPointMax> beyond_mm{};
};
inline SeenBody seen_body(const ShapeFit& fit, bool back) {
  return {fit.valid, back, false, fit.shape, fit.pose, {}};
}

// As indexes and queries take a fit: its coefficients, off_mm of both views, limbs of both. `out` has
// fit_layout(space).size() places.
inline constexpr std::size_t kFitValueMax = kShapeMax + kFitViewMax * (kPatchMax + kLimbValues);
inline FitLayout fit_layout(const ShapeSpace& space) {
  return {static_cast<std::uint32_t>(space.shape_count), static_cast<std::uint32_t>(patch_count(space)), kLimbValues};
}
void fit_values(const ShapeFit& fit, const ShapeSpace& space, std::span<float> out);

// Not shareable between threads.
class ShapeFitter {
 public:
  // The space must outlive the fitter and have points.
  explicit ShapeFitter(const ShapeSpace& space);
  ~ShapeFitter();
  // One to kFitViewMax views; further ones are ignored. The result is valid until the next call.
  const ShapeFit& run(std::span<const FitView> views);
  // The last run()'s fit to its first view alone, the same as run() of only that view.
  const ShapeFit& first_alone() const;
  // Of the last valid fit, while its views stand: where the space's points lie in a view, camera axes, mm.
  // `out` has point_count places.
  void points_in_view(std::size_t view, std::span<Vec3f> out);
  // The same, where its bones lie: levelled axes (y up from the floor where it is known, z towards the camera).
  PosedSkeleton bones_in_view(std::size_t view);

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

}  // namespace im2fit::body
