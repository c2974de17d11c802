// SPDX-License-Identifier: Apache-2.0
#include "train/camera/synthetic_person.h"

#include <charconv>

#include "hal/synthetic_source.h"
#include "person/data_files.h"

namespace im2fit::lab {

SceneOptions furnished_room() {
  SceneOptions scene;
  scene.furniture_count = 3;
  return scene;
}

AboutTurn turn_after(int frames) {
  return frames > 0 ? AboutTurn{frames, kTurnFrames} : AboutTurn{};
}

StepRound step_round_after(int frames) {
  constexpr float kSeconds = 9;  // people take 6 to 15
  return {frames, kSeconds, 360};
}

StepRound walk_round_after(int frames) {
  constexpr float kSeconds = 15;  // people take 10 to 30
  return {frames, kSeconds, 360, true};
}

void dress(SceneOptions& scene) {
  scene.clothing = Clothing::normal;
  scene.hair = true;
}

SensorOptions sensor_of(bool noise) {
  return {noise, noise, noise, noise};
}

Result<Family> family_of(const std::string& word) {
  if (word == "paper") return Family::paper;
  if (word == "training") return Family::training;
  if (word == "held_out") return Family::held_out;
  return Error{ErrorCode::invalid_argument, "no family '" + word + "'; use paper, training or held_out"};
}

std::string name_of(Family family) {
  switch (family) {
    case Family::paper:
      return "paper";
    case Family::training:
      return "training";
    case Family::held_out:
      break;
  }
  return "held_out";
}

Result<StandingPose> pose_of(const std::string& word) {
  if (word == "relaxed") return StandingPose::relaxed;
  if (word == "a_pose") return StandingPose::a_pose;
  if (word == "psi") return StandingPose::psi;
  if (word == "free") return StandingPose::free;
  if (word == "bowed") return StandingPose::bowed;
  if (word == "arms_out") return StandingPose::arms_out;
  if (word == "squat") return StandingPose::squat;
  if (word == "bent_knees") return StandingPose::bent_knees;
  if (word == "arm_raised") return StandingPose::arm_raised;
  return Error{
      ErrorCode::invalid_argument,
      "no pose '" + word + "'; use relaxed, arms_out, a_pose, psi, free, bowed, squat, bent_knees or arm_raised"};
}

SyntheticPerson::SyntheticPerson(const body::BodyModel& model, const PersonOptions& options)
    : options_(options),
      subject_(draw_subject(model, options.family, options.seed, options.subject)),
      // The OpenNI2 virtual camera seeds its scene alike, so that both show the same frames.
      scene_(model, subject_, options.scene, sensor_of(options.noise),
             kinect_intrinsics(options.width, options.height), options.seed + options.subject) {}

Truth SyntheticPerson::truth(int frame_count) const {
  Truth truth;
  truth.seed = options_.seed;
  truth.subject = options_.subject;
  truth.family = name_of(options_.family);
  truth.woman = subject_.woman;
  truth.values = subject_.truth;
  truth.floor = scene_.floor();
  for (int i = 0; i < frame_count; ++i) truth.joints.push_back(scene_.joints(static_cast<std::uint64_t>(i)));
  return truth;
}

Result<SyntheticInput> open_synthetic(const std::string& seed, const std::string& body_path, int rotate_deg,
                                      int width, int height, const SyntheticActing& acting) {
  PersonOptions options;
  options.scene = furnished_room();
  options.scene.rotate_deg = rotate_deg;
  options.scene.turn = acting.turn;
  options.scene.step_round = acting.step_round;
  if (acting.step_round.seconds > 0) options.scene.pose = StandingPose::arms_out;
  if (acting.clothed) dress(options.scene);
  options.width = width;
  options.height = height;
  if (!seed.empty()) {
    const auto [end, error] = std::from_chars(seed.data(), seed.data() + seed.size(), options.seed);
    if (error != std::errc() || end != seed.data() + seed.size())
      return Error{ErrorCode::invalid_argument, "synthetic:" + seed + ": the seed must be a whole number"};
  }
  options.subject = subject_of_seed(options.seed);
  auto loaded = load_body(body_path);
  if (!loaded) return loaded.error();
  // The generator keeps its model alive.
  const auto model = std::make_shared<const body::BodyModel>(std::move(*loaded));
  const auto person = std::make_shared<SyntheticPerson>(*model, options);
  hal::SourceInfo info;
  info.uri = "synthetic:" + std::to_string(options.seed);
  info.name = "virtual Kinect";
  info.sensor = kinect_sensor().kind;
  info.rotate_deg = rotate_deg;
  hal::SyntheticSource::Poser poser;
  // Turned back: the source turns it upright.
  if (acting.step_round.camera)
    poser = [person, rotate_deg](std::uint64_t index) {
      return hal::rotate_upright(person->scene().camera_pose(index), (360 - rotate_deg) % 360);
    };
  auto source = hal::SyntheticSource::create(
      person->scene().intrinsics(), info,
      [model, person](std::uint64_t index, DepthImage out) {
        person->scene().render(index, out);
        return true;
      },
      poser);
  if (!source) return source.error();
  return SyntheticInput{std::move(*source), person->truth(0)};
}

}  // namespace im2fit::lab
