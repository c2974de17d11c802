// SPDX-License-Identifier: Apache-2.0
// The paper's own measurements, as published (Eqs. 1-4), in fixed point: the baseline beside ours.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/camera.h"
#include "core/joints.h"
#include "core/measurement.h"
#include "kernels/rayform/ray_form.h"
#include "kernels/section/section.h"
#include "kernels/unproject/unproject.h"
#include "perception/paper/ellipse.h"

namespace im2fit {

// Principal axes of the rigid torso: u down the spine (NE->TO), v = LS->RS, w = u x v (section 3.2 of the paper).
struct BodyFrame {
  Vec3f u, v, w;         // unit
  float lateral = 1.0F;  // sqrt(1 - (u.d)^2), d = TO -> mid-hips: the corrected Eq. (1); upright below 0.1
  bool upright = false;  // and the hips lie below the torso: u.d > 0
};
inline constexpr float kUprightMax = 0.1F;  // epsilon 1
// Joints that coincide, are not finite or lie beyond 30 m leave zero axes, lateral 1 and upright false.
BodyFrame body_frame(const JointSet& joints);

// valid: the joints span a frame and both ends of the body's axis were seen; the lengths are then numbers. The caller
// judges the posture (BodyFrame). Girths whose section has no ellipse are NaN, and so is a ratio that needs them.
struct PaperMeasurements {
  bool valid = false;
  float stature_mm = 0, sleeve_mm = 0, leg_mm = 0;
  float shoulder_mm = 0;  // |LS - RS|; the paper's group one names no formula
  float neck_mm = 0, shoulder_girth_mm = 0, chest_mm = 0, waist_mm = 0, hip_mm = 0;  // ellipse perimeters
  float chest_ratio = 0;  // geodesic over Euclidean distance between the surface points seen at LS and RS
  float hip_waist_ratio = 0;
};

inline constexpr std::size_t kPaperSectionCount = 5;  // neck, shoulder, chest, waist, hip

// Buffers sized once, for images up to width x height.
class PaperWorkspace {
 public:
  PaperWorkspace(int width, int height);

  static constexpr int kBinCount = 128;  // of 8 mm across the section
  RayTable rays;
  RayForm spine, across, depth;      // coordinates along the body's axes, of all pixels
  int point_capacity;                // of a section
  std::vector<SectionPoint> points;  // of all sections: see kernels/section
};

// `depth` in 1/16 mm (Q12.4 fixed point, 0 = none) so that fused depth keeps its fraction; masked pixels only.
// It agrees with the reference in double (tests/perception/paper_ref.h) to 0.05 mm in lengths (coordinates are
// rounded to 2^-11 mm and sums of a few stay below) and to 1 mm in girths (section points are rounded to 1/8 mm, rms
// 0.036 mm; over the hundred or more points of a section that moves the mean by 0.004 mm, and the half-seen ellipse
// magnifies it by up to some tens). Integers, and floats in written order: the same bits on every machine and in
// every tier of the kernel it calls (section). No allocation after construction, no threads.
PaperMeasurements measure_paper(ImageView<const std::uint16_t> depth_q4, MaskView mask, const Intrinsics& intrinsics,
                                const JointSet& joints, PaperWorkspace& work);

// In the id table's order; ids the paper does not measure are NaN.
MeasurementValues to_values(const PaperMeasurements& m);

}  // namespace im2fit
