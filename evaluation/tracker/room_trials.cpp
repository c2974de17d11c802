// SPDX-License-Identifier: Apache-2.0
#include "evaluation/tracker/room_trials.h"

#include <algorithm>

#include "core/rng.h"
#include "evaluation/tracker/upright_scene.h"
#include "perception/observe/observe.h"
#include "train/common/parallel.h"

namespace im2fit::lab {
namespace {

constexpr std::uint64_t kRoomStream = 0xE3927;

Shot draw_room(const RoomTrialOptions& options, std::uint64_t room, std::string& kind) {
  Rng rng = Rng::for_item(options.seed, kRoomStream, room);
  Shot shot;
  shot.seed = rng.next();
  shot.sensor = rng.uniform() < 0.7 ? kinect_sensor() : tof_sensor();
  shot.intrinsics = rng.uniform() < 0.25 ? kinect_intrinsics(640, 480) : kinect_intrinsics(320, 240);
  SceneOptions& scene = shot.scene;
  scene.person = false;
  scene.floor = !options.hidden_floor;
  scene.rotate_deg = rng.uniform() < 0.5 ? 90 : 0;
  scene.camera_height_mm = static_cast<float>(rng.uniform(600, 2000));
  scene.pitch_limit_deg = 20;
  const double what = rng.uniform();
  kind = what < 0.15 ? "bare walls" : what < 0.5 ? "furniture" : "coat stands, coats, dogs";
  if (what >= 0.15) scene.furniture_count = 1 + rng.index(5);
  if (what >= 0.5) scene.decoy_count = 1 + rng.index(3);
  return shot;
}

// A room before the tracker, frame after frame.
class Watch {
 public:
  Watch(const body::BodyModel& model, const JointModel& joint_model, const RoomTrialOptions& options,
        std::uint64_t room)
      // No person is shown, but the camera is placed as for this person.
      : scene_(model, draw_subject(model, Family::held_out, options.seed, room % kPlacingPeople),
               draw_room(options, room, kind_)),
        sensor_(scene_.intrinsics().width, scene_.intrinsics().height, joint_model),
        mask_(static_cast<std::size_t>(scene_.intrinsics().width) *
              static_cast<std::size_t>(scene_.intrinsics().height)) {}

  bool finds_person(std::uint64_t frame) {
    scene_.show(frame);
    return sensor_.sense(scene_.depth(), scene_.intrinsics(), mask()).person.found;
  }
  const std::string& kind() const { return kind_; }
  JudgedPicture picture() {
    const DepthView depth = scene_.depth();
    const auto pixels = static_cast<std::ptrdiff_t>(mask_.size());
    return {scene_.intrinsics(), {depth.pixels, depth.pixels + pixels}, mask_, false, {}, {}};
  }

 private:
  static constexpr std::uint64_t kPlacingPeople = 16;
  MaskImage mask() { return {mask_.data(), scene_.intrinsics().width, scene_.intrinsics().height}; }

  std::string kind_;
  UprightScene scene_;
  PersonDetector sensor_;
  std::vector<std::uint8_t> mask_;
};

}  // namespace

std::vector<RoomOutcome> run_rooms(const body::BodyModel& model, const JointModel& joint_model,
                                   const RoomTrialOptions& options) {
  const int rooms = (options.frames + kFramesPerRoom - 1) / kFramesPerRoom;
  std::vector<RoomOutcome> outcomes(static_cast<std::size_t>(rooms));
  for_each_item(
      outcomes.size(), options.threads,
      [&](std::uint64_t room) {
        RoomOutcome& outcome = outcomes[static_cast<std::size_t>(room)];
        Watch watch(model, joint_model, options, room);
        outcome.room = room;
        outcome.kind = watch.kind();
        outcome.frames = static_cast<std::uint64_t>(
            std::min(kFramesPerRoom, options.frames - static_cast<int>(room) * kFramesPerRoom));
        for (std::uint64_t frame = 0; frame < outcome.frames; ++frame)
          if (watch.finds_person(frame) && outcome.false_users++ == 0) outcome.first_false = frame;
      },
      begin_progress(options.progress, "empty rooms", outcomes.size()));
  return outcomes;
}

JudgedPicture picture_of(const body::BodyModel& model, const JointModel& joint_model, const RoomTrialOptions& options,
                         const RoomOutcome& outcome) {
  Watch watch(model, joint_model, options, outcome.room);
  const std::uint64_t last = outcome.false_users > 0 ? outcome.first_false : outcome.frames - 1;
  for (std::uint64_t frame = 0; frame <= last; ++frame) watch.finds_person(frame);
  return watch.picture();
}

}  // namespace im2fit::lab
