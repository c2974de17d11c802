// SPDX-License-Identifier: Apache-2.0
// A point of a body in one view: its place in the picture, its distance from the surface seen there and from the
// outline. In the camera's axes and the person's levelled ones (body/person_axes.h).
#pragma once

#include "body/fit/shape_fitter.h"
#include "body/person_axes.h"

namespace im2fit::body {

class Sight {
 public:
  // Whether the view can be fitted to: pictures of the intrinsics' size, joints and floor of finite numbers. The view
  // must outlive the sight.
  bool look(const FitView& view);

  const JointSet& joints() const { return joints_; }  // levelled
  const PersonAxes& axes() const { return axes_; }
  bool floor_known() const { return view_->floor.known; }

  // The seen surface point at p's pixel (p: camera axes), levelled axes. False outside the mask and within 2 px of
  // its edge, without depth, and where the surface is `gate_mm` or more before or behind p.
  bool surface_over(Vec3f p, float gate_mm, Vec3f& seen) const;

  // The distance of the mask's edge from p along the image of p's normal (unit, camera axes): positive when p must
  // move along the normal. False without an edge within reach_mm, when the surface within it belongs to another limb
  // (more than 120 mm before or behind p), or when the normal points at the camera.
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
