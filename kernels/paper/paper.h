// SPDX-License-Identifier: Apache-2.0
// The paper's own measurements, as published (Eqs. 1-4), in fixed point: the baseline beside ours.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/camera.h"
#include "kernels/core/joints.h"
#include "kernels/core/measurement.h"

namespace im2fit {

// Principal axes of the rigid torso: u down the spine (NE->TO), v = LS->RS, w = u x v (section 3.2 of the paper).
struct BodyFrame {
  Vec3f u, v, w;          // unit
  float lateral = 1.0F;   // sqrt(1 - (u.d)^2), d = TO -> mid-hips: the mended Eq. (1); upright below 0.1
  bool upright = false;
};
BodyFrame body_frame(const JointSet& joints);

struct PaperMeasurements {
  bool valid = false;
  float stature_mm = 0, sleeve_mm = 0, leg_mm = 0, shoulder_mm = 0;
  float neck_mm = 0, shoulder_girth_mm = 0, chest_mm = 0, waist_mm = 0, hip_mm = 0;  // ellipse perimeters
  float chest_ratio = 0;  // geodesic over Euclidean distance LS..RS
  float hip_waist_ratio = 0;
};

// Buffers sized once.
class PaperWorkspace {
 public:
  PaperWorkspace(int width, int height);
  std::vector<std::int32_t> points;
};

// `depth` in 1/16 mm (Q12.4 fixed point, 0 = none) so that fused depth keeps its fraction; masked pixels only.
PaperMeasurements measure_paper(ImageView<const std::uint16_t> depth_q4, MaskView mask, const Intrinsics& intrinsics,
                                const JointSet& joints, PaperWorkspace& work);
PaperMeasurements measure_paper_ref(ImageView<const std::uint16_t> depth_q4, MaskView mask,
                                    const Intrinsics& intrinsics, const JointSet& joints, PaperWorkspace& work);

// In the id table's order; ids the paper does not measure are NaN.
MeasurementValues to_values(const PaperMeasurements& m);

}  // namespace im2fit
