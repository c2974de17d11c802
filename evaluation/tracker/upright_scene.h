// SPDX-License-Identifier: Apache-2.0
// A scene before the virtual camera, turned upright as the program sees it, with the truth about it.
#pragma once

#include <cstdint>
#include <vector>

#include "body/model.h"
#include "core/camera.h"
#include "evaluation/tracker/statistics.h"
#include "perception/segment/segment.h"
#include "train/camera/virtual_camera.h"

namespace im2fit::lab {

// What stands before which camera. `intrinsics`: as the sensor delivers, landscape.
struct Shot {
  SceneOptions scene;
  SensorOptions sensor;
  Intrinsics intrinsics;
  std::uint64_t seed = 0;
};

// Not shareable between threads; the model must outlive it.
class UprightScene {
 public:
  UprightScene(const body::BodyModel& model, const Subject& subject, const Shot& shot);
  void show(std::uint64_t frame);
  const Intrinsics& intrinsics() const { return upright_; }
  // Of the frame shown last. The depth may be spoilt on purpose before it is judged.
  DepthImage depth() { return {depth_.data(), upright_.width, upright_.height}; }
  // Where that frame's depth is the main person's; or another's (SceneOptions::others from 1), valid until
  // another is requested.
  MaskView truth_mask() const { return {mask_.data(), upright_.width, upright_.height}; }
  MaskView other_mask(std::size_t who);
  // Those of truth_mask() whose depth is a mixture with another surface (VirtualScene::mixed_mask).
  MaskView mixed_mask();
  JointSet truth(std::size_t who = 0) const { return scene_.joints(frame_, who); }
  FloorPlane floor() const { return scene_.floor(); }
  const VirtualScene& staged() const { return scene_; }

 private:
  void turn_mask(std::vector<std::uint8_t>& out);  // of delivered_mask_

  int rotate_deg_;
  VirtualScene scene_;
  Intrinsics upright_;
  std::uint64_t frame_ = 0;
  std::vector<std::uint16_t> delivered_, turned_, depth_;
  std::vector<std::uint8_t> delivered_mask_, mask_, other_mask_, mixed_mask_;
};

// A frame as it was when judged.
struct JudgedPicture {
  Intrinsics intrinsics;
  std::vector<std::uint16_t> depth;
  std::vector<std::uint8_t> mask;
  bool found = false;
  JointSet joints, truth;
};

// The box and size of a mask, as the segmenter reports it; for masks that are given.
Person person_of_mask(MaskView mask);

// Pixels with data in both masks, in either, in each.
struct Overlap {
  std::uint64_t both = 0, ours = 0, truth = 0;
  void count(bool in_ours, bool in_truth);
  double iou() const;  // 0 for two empty masks
  // Whose mask ours is: the person's when more of it lies on the person than beside.
  Finding finding() const;
};
Overlap overlap_of(DepthView depth, MaskView ours, MaskView truth);
// Without the pixels of `unowned`: mixed depth that belongs to no person.
Overlap overlap_of(DepthView depth, MaskView ours, MaskView truth, MaskView unowned);

// Joints found against the true ones; `finding` and confidence are taken over.
JointFrame judge_joints(const JointSet& found, const JointSet& truth, const Intrinsics& k, Finding finding);

}  // namespace im2fit::lab
