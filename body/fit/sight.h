// SPDX-License-Identifier: Apache-2.0
// What one view says about a point of a body: where it lies in the picture, how far the surface seen there is, how
// far the outline. In the camera's axes and the person's levelled ones (body/person_axes.h).
#pragma once

#include "body/fit/shape_fitter.h"
#include "body/person_axes.h"

namespace im2fit::body {

class Sight {
 public:
  // Whether there is anything to fit to: pictures of the intrinsics' size, joints and floor of finite numbers. The
  // view must outlive the sight.
  bool look(const FitView& view);

  const JointSet& joints() const { return joints_; }  // levelled
  const PersonAxes& axes() const { return axes_; }
  bool floor_known() const { return view_->floor.known; }

  // The point of the picture straight over p (camera axes), levelled axes. False outside the mask and within 2 px of
  // its edge, without depth, and where the surface is `gate_mm` or more before or behind p.
  bool surface_over(Vec3f p, float gate_mm, Vec3f& seen) const;

  // How far the mask's edge lies from p along the picture of p's normal (unit, camera axes): positive when p must
  // move along the normal. False when there is no edge within reach_mm, when the surface inside it is not p's own
  // (another limb's, more than 120 mm before or behind), or when the normal looks at the camera.
  bool outline_beside(Vec3f p, Vec3f normal, float reach_mm, float& distance_mm) const;

 private:
  bool inside(int u, int v) const {
    return u >= 0 && v >= 0 && u < view_->mask.width && v < view_->mask.height && view_->mask.at(u, v) != 0;
  }
  float depth_mm(int u, int v) const { return static_cast<float>(view_->depth_q4.at(u, v)) * (1.0F / 16); }

  const FitView* view_ = nullptr;
  PersonAxes axes_;
  JointSet joints_;
};

}  // namespace im2fit::body
