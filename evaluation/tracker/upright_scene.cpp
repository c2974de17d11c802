// SPDX-License-Identifier: Apache-2.0
#include "evaluation/tracker/upright_scene.h"

#include <algorithm>

#include "hal/source.h"

namespace im2fit::lab {
namespace {

std::size_t pixels_of(const Intrinsics& k) {
  return static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height);
}

}  // namespace

UprightScene::UprightScene(const body::BodyModel& model, const Subject& subject, const Shot& shot)
    : rotate_deg_(shot.scene.rotate_deg),
      scene_(model, subject, shot.scene, shot.sensor, shot.intrinsics, shot.seed),
      upright_(hal::rotate_upright(shot.intrinsics, rotate_deg_)),
      delivered_(pixels_of(shot.intrinsics)),
      turned_(delivered_.size()),
      depth_(delivered_.size()),
      delivered_mask_(delivered_.size()),
      mask_(delivered_.size()),
      other_mask_(delivered_.size()),
      mixed_mask_(delivered_.size()) {}

void UprightScene::show(std::uint64_t frame) {
  frame_ = frame;
  const Intrinsics& k = scene_.intrinsics();
  const DepthImage delivered(delivered_.data(), k.width, k.height);
  scene_.render(frame, delivered);
  hal::rotate_upright(delivered, rotate_deg_, depth());
  scene_.person_mask(MaskImage(delivered_mask_.data(), k.width, k.height));
  turn_mask(mask_);
}

MaskView UprightScene::other_mask(std::size_t who) {
  const Intrinsics& k = scene_.intrinsics();
  scene_.person_mask(MaskImage(delivered_mask_.data(), k.width, k.height), who);
  turn_mask(other_mask_);
  return {other_mask_.data(), upright_.width, upright_.height};
}

MaskView UprightScene::mixed_mask() {
  const Intrinsics& k = scene_.intrinsics();
  scene_.mixed_mask(MaskImage(delivered_mask_.data(), k.width, k.height));
  turn_mask(mixed_mask_);
  return {mixed_mask_.data(), upright_.width, upright_.height};
}

void UprightScene::turn_mask(std::vector<std::uint8_t>& out) {
  const Intrinsics& k = scene_.intrinsics();
  // Only depth pictures are turned elsewhere: the mask goes through as one.
  std::copy(delivered_mask_.begin(), delivered_mask_.end(), delivered_.begin());
  hal::rotate_upright(DepthImage(delivered_.data(), k.width, k.height), rotate_deg_,
                      DepthImage(turned_.data(), upright_.width, upright_.height));
  std::transform(turned_.begin(), turned_.end(), out.begin(),
                 [](std::uint16_t value) { return static_cast<std::uint8_t>(value); });
}

Person person_of_mask(MaskView mask) {
  Person person;
  person.u_min = mask.width;
  person.v_min = mask.height;
  for (int v = 0; v < mask.height; ++v)
    for (int u = 0; u < mask.width; ++u) {
      if (mask.at(u, v) == 0) continue;
      ++person.pixel_count;
      person.u_min = std::min(person.u_min, u);
      person.u_max = std::max(person.u_max, u);
      person.v_min = std::min(person.v_min, v);
      person.v_max = std::max(person.v_max, v);
    }
  person.found = person.pixel_count > 0;
  return person;
}

void Overlap::count(bool in_ours, bool in_truth) {
  ours += in_ours ? 1 : 0;
  truth += in_truth ? 1 : 0;
  both += in_ours && in_truth ? 1 : 0;
}

double Overlap::iou() const {
  const std::uint64_t either = ours + truth - both;
  return either > 0 ? static_cast<double>(both) / static_cast<double>(either) : 0;
}

Finding Overlap::finding() const {
  if (ours == 0) return Finding::none;
  return 2 * both > ours ? Finding::person : Finding::other;
}

Overlap overlap_of(DepthView depth, MaskView ours, MaskView truth) {
  Overlap o;
  for (int v = 0; v < depth.height; ++v)
    for (int u = 0; u < depth.width; ++u)
      if (depth.at(u, v) != 0) o.count(ours.at(u, v) != 0, truth.at(u, v) != 0);
  return o;
}

Overlap overlap_of(DepthView depth, MaskView ours, MaskView truth, MaskView unowned) {
  Overlap o;
  for (int v = 0; v < depth.height; ++v)
    for (int u = 0; u < depth.width; ++u)
      if (depth.at(u, v) != 0 && unowned.at(u, v) == 0) o.count(ours.at(u, v) != 0, truth.at(u, v) != 0);
  return o;
}

JointFrame judge_joints(const JointSet& found, const JointSet& truth, const Intrinsics& k, Finding finding) {
  JointFrame frame;
  frame.finding = finding;
  frame.confidence = found.confidence;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const Vec3f& t = truth.position_mm[j];
    frame.error_mm[j] = norm(found.position_mm[j] - t);
    if (t.z <= 0) continue;
    const float u = t.x * k.fx / t.z + k.cx;
    const float v = t.y * k.fy / t.z + k.cy;
    frame.in_picture[j] =
        u >= -0.5F && v >= -0.5F && u < static_cast<float>(k.width) - 0.5F && v < static_cast<float>(k.height) - 0.5F;
  }
  return frame;
}

}  // namespace im2fit::lab
