// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "perception/observe/arm_gap.h"
#include "perception/observe/gate.h"
#include "perception/observe/observe.h"

// The thresholds of this file. When a user is accepted as a person: segment/person_tracker_limits.h.
namespace im2fit::sensor_limits {

constexpr float kLostShareMax = 0.30F;  // pixels without data: as in segment/advice.cpp

}  // namespace im2fit::sensor_limits

namespace im2fit {

using namespace sensor_limits;

namespace {

// Level, or as gravity says, under the lowest row of a mask that ends in the picture; for the votes on a person,
// which know heights above a floor. Unknown where the feet are cut off.
FloorPlane assumed_floor(DepthView depth, MaskView mask, const Intrinsics& k, const Person& person) {
  FloorPlane floor = person.floor;
  if (person.cut_bottom) return floor;
  const int v = person.v_max;
  float sum_mm = 0;
  float sum_u = 0;
  int count = 0;
  for (int u = person.u_min; u <= person.u_max; ++u) {
    if (mask.at(u, v) == 0 || depth.at(u, v) == 0) continue;
    sum_mm += static_cast<float>(depth.at(u, v));
    sum_u += static_cast<float>(u);
    ++count;
  }
  if (count == 0) return floor;
  const float z = sum_mm / static_cast<float>(count);
  const float x = (sum_u / static_cast<float>(count) - k.cx) / k.fx * z;
  floor.known = true;
  floor.camera_height_mm = -dot(floor.up, {x, (static_cast<float>(v) - k.cy) / k.fy * z, z});
  return floor;
}

Lean lean_of_chosen(DepthView depth, MaskView mask, const Intrinsics& intrinsics, const Detection& detection) {
  const auto users = std::span(detection.users).first(static_cast<std::size_t>(detection.user_count));
  const auto is_chosen = [&](const User& user) { return user.id == detection.person.id; };
  const auto user = std::find_if(users.begin(), users.end(), is_chosen);
  return lean_of(depth, mask, intrinsics, detection.person, user != users.end() ? &*user : nullptr);
}

}  // namespace

PersonDetector::PersonDetector(int width, int height, const JointModel& model)
    : holes_(width, height), segmenter_(width, height), tracker_(model) {}

Detection PersonDetector::sense(DepthView depth, const Intrinsics& intrinsics, MaskImage mask, float seconds,
                                GuidanceSet frame_guidance) {
  Detection detection;
  const DepthView filled = holes_.run(depth);
  detection.person = segmenter_.run(filled, intrinsics, people_, mask, seconds, up_);
  for (const User& user : people_.users()) detection.users[static_cast<std::size_t>(detection.user_count++)] = user;
  detection.guidance = detection.person.guidance;
  if (!detection.person.found) {
    previous_user_ = 0;
    return detection;
  }
  detection.guidance |= frame_guidance;
  const bool judged = !people_.accepted(detection.person.id);
  Person standing = detection.person;
  if (judged && !standing.floor.known) standing.floor = assumed_floor(filled, mask, intrinsics, standing);
  const bool follows = previous_user_ != 0 && previous_user_ == detection.person.id;
  detection.joints = tracker_.track(filled, mask, intrinsics, standing, follows);
  previous_user_ = detection.person.id;
  if (judged && !people_.judge(detection.person.id, evidence(detection.person)))
    return without_person(detection, mask);
  const Lean lean = lean_of_chosen(filled, mask, intrinsics, detection);
  // Other people are a guess in such a picture, too.
  if (holes_.filled() && drop_lost_pixels(depth, mask) > kLostShareMax)
    detection.guidance = (detection.guidance & ~static_cast<GuidanceSet>(Guidance::several_people)) |
                         static_cast<GuidanceSet>(Guidance::too_noisy);
  judge_pose(filled, intrinsics, mask, lean, detection);
  return detection;
}

void PersonDetector::judge_pose(DepthView depth, const Intrinsics& intrinsics, MaskView mask, const Lean& lean,
                                Detection& detection) {
  detection.back_chance = tracker_.back_chance();
  detection.view = view_side(detection.joints, detection.person.floor, detection.back_chance);
  GuidanceSet pose = pose_gate(detection.joints, detection.person.floor, detection.view, lean);
  detection.arms_close =
      hands_close(detection.joints, detection.person.floor) | arms_joined(depth, mask, intrinsics, detection.joints);
  if (detection.arms_close != 0) pose |= static_cast<GuidanceSet>(Guidance::arms_close);
  detection.guidance |= pose & pose_codes_seen(detection.guidance, detection.view);
  if (!has(detection.guidance, Guidance::arms_close)) detection.arms_close = 0;
  judge_height(depth, intrinsics, mask, detection);
}

// Once the whole person is seen to stand. What children are asked for would not help them.
void PersonDetector::judge_height(DepthView depth, const Intrinsics& intrinsics, MaskView mask,
                                  Detection& detection) {
  constexpr auto kArms = static_cast<GuidanceSet>(Guidance::arms_close);
  if ((detection.guidance & ~kArms) != 0) return;
  detection.height_mm = mask_height_mm(depth, mask, intrinsics, detection.person);
  if (!stands_small(detection.height_mm, detection.joints, detection.person.floor)) return;
  detection.guidance = static_cast<GuidanceSet>(Guidance::out_of_population);
  detection.arms_close = 0;
}

JointEvidence PersonDetector::evidence(const Person& person) const {
  const float shape = people_.shape_odds(person.id);
  // With the shape and without: real clothes are flatter than those the shape's odds were fitted on, and what
  // a person touches counts with the shape; without it furniture comes too near to people.
  const float odds = 0.5F * (tracker_.person_odds(shape) + tracker_.person_odds(0));
  return {tracker_.person_score(), odds, person.floor.known};
}

Detection PersonDetector::without_person(const Detection& refused, MaskImage mask) {
  for (int v = 0; v < mask.height; ++v) std::fill_n(mask.row(v), mask.width, std::uint8_t{0});
  Detection detection;
  detection.person.floor = refused.person.floor;
  for (int i = 0; i < refused.user_count; ++i)
    if (refused.users[static_cast<std::size_t>(i)].id != refused.person.id)
      detection.users[static_cast<std::size_t>(detection.user_count++)] = refused.users[static_cast<std::size_t>(i)];
  detection.person.people_count = std::max(0, refused.person.people_count - 1);
  // Too near to distinguish a person from furniture: report too_near.
  const auto near = refused.person.guidance & static_cast<GuidanceSet>(Guidance::too_near);
  detection.guidance = detection.person.guidance = near != 0 ? near : static_cast<GuidanceSet>(Guidance::no_person);
  previous_user_ = 0;
  return detection;
}

void PersonDetector::reset() {
  segmenter_.reset();
  people_.reset();
  up_.reset();
  previous_user_ = 0;
}

}  // namespace im2fit
