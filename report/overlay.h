// SPDX-License-Identifier: Apache-2.0
// The camera's picture and the results in one image: shaded depth, the person tinted, joints and bones, and the lines
// where girths are measured.
#pragma once

#include <string>
#include <vector>

#include "core/camera.h"
#include "core/joints.h"
#include "perception/observe/chain_filter.h"
#include "perception/segment/segment.h"
#include "report/canvas.h"

namespace im2fit {

struct SectionLine {
  std::string label;        // for example "CHEST 1012 MM"
  float height_mm = 0;      // above the floor
  float half_width_mm = 0;  // from the trunk's middle; pixels beyond (arms) are not drawn
};

struct OverlayInput {
  Intrinsics intrinsics;                    // of the upright pictures below
  DepthView frame;                          // a whole frame, mm, behind the person
  ImageView<const std::uint16_t> fused_q4;  // 1/16 mm; may be empty
  MaskView mask;                            // may be empty
  bool has_joints = false;
  JointSet joints;
  FloorPlane floor;
  std::vector<SectionLine> sections;
  std::vector<std::string> captions;  // lines in the upper left corner
};

Canvas draw_overlay(const OverlayInput& input);

// One frame with the tracker's results, for viewers: depth by brightness, the person tinted with an
// outline, left limbs orange and right limbs violet, joints from red (guessed) over yellow to green (sure), inferred
// ones hollow.
struct PreviewInput {
  Intrinsics intrinsics;
  DepthView depth;
  MaskView mask;  // may be empty
  bool has_joints = false;
  JointSet joints;
  JointFlags inferred = 0;
  std::vector<User> users;            // those with an id are labelled with it
  int measured_user = 0;              // this one's label is bright
  std::vector<std::string> captions;  // lines in the upper left corner
};

// `height_px` of the picture, of any size: its width follows. Text (captions, ids) only when `text`.
Canvas draw_preview(const PreviewInput& input, int height_px, bool text = true);

}  // namespace im2fit
