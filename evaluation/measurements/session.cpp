// SPDX-License-Identifier: Apache-2.0
#include "evaluation/measurements/session.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <vector>

#include "core/camera.h"
#include "core/rng.h"
#include "evaluation/measurements/driver_filters.h"
#include "hal/source.h"

namespace im2fit::lab {
namespace {

// Each of the three angles is a sum of slow sway (0.3 and 0.9 Hz) and of a hand's tremor (2 and 9 Hz), at frames of
// 30 Hz; each reaches `amplitude_deg` at most. Samples come from the nearest pixel; pixels from outside the picture
// have no data.
class Tremor {
 public:
  Tremor(float amplitude_deg, std::uint64_t seed, const Intrinsics& k);
  // Radians about x, y and z.
  struct Turn {
    double x = 0, y = 0, z = 0;
  };
  Turn at(std::uint64_t frame) const;
  // The same as a device reports it.
  hal::CameraPose pose(std::uint64_t frame) const;
  // In place.
  void run(std::uint64_t frame, DepthImage picture);

 private:
  double amplitude_rad_;
  std::uint64_t seed_;
  Intrinsics k_;
  std::vector<std::uint16_t> before_;
};

constexpr std::uint64_t kTremorStream = 0x7E3038;
constexpr double kFrameS = 1.0 / 30;
struct Wave {
  double hertz, share;
};
constexpr std::array<Wave, 4> kWaves = {{{0.3, 0.5}, {0.9, 0.3}, {2, 0.1}, {9, 0.1}}};

Tremor::Tremor(float amplitude_deg, std::uint64_t seed, const Intrinsics& k)
    : amplitude_rad_(static_cast<double>(amplitude_deg) * std::numbers::pi / 180), seed_(seed), k_(k) {}

Tremor::Turn Tremor::at(std::uint64_t frame) const {
  Rng rng = Rng::for_item(seed_, kTremorStream, 0);
  const auto angle = [&] {
    double sum = 0;
    for (const Wave& wave : kWaves) {
      const double phase = rng.uniform(0, 2 * std::numbers::pi);
      sum += wave.share * std::sin(2 * std::numbers::pi * wave.hertz * kFrameS * static_cast<double>(frame) + phase);
    }
    return amplitude_rad_ * sum;
  };
  Turn turn;
  turn.x = angle();
  turn.y = angle();
  turn.z = angle();
  return turn;
}

hal::CameraPose Tremor::pose(std::uint64_t frame) const {
  const Turn t = at(frame);
  const double cx = std::cos(t.x / 2), sx = std::sin(t.x / 2), cy = std::cos(t.y / 2), sy = std::sin(t.y / 2),
               cz = std::cos(t.z / 2), sz = std::sin(t.z / 2);
  // Quaternions of the turns about z, then y, then x, multiplied.
  return {static_cast<float>(sx * cy * cz + cx * sy * sz),
          static_cast<float>(cx * sy * cz - sx * cy * sz),
          static_cast<float>(cx * cy * sz + sx * sy * cz),
          static_cast<float>(cx * cy * cz - sx * sy * sz),
          {}};
}

void Tremor::run(std::uint64_t frame, DepthImage picture) {
  if (amplitude_rad_ == 0) return;
  before_.resize(static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height));
  const DepthImage before(before_.data(), picture.width, picture.height);
  for (int v = 0; v < picture.height; ++v) std::copy_n(picture.row(v), picture.width, before.row(v));
  const Turn t = at(frame);
  const double cx = std::cos(t.x), sx = std::sin(t.x), cy = std::cos(t.y), sy = std::sin(t.y), cz = std::cos(t.z),
               sz = std::sin(t.z);
  const double fx = static_cast<double>(k_.fx), fy = static_cast<double>(k_.fy), px = static_cast<double>(k_.cx),
               py = static_cast<double>(k_.cy);
  for (int v = 0; v < picture.height; ++v)
    for (int u = 0; u < picture.width; ++u) {
      // The ray of the turned camera's pixel in the axes of the camera at rest: about z, then y, then x.
      const double x = (u - px) / fx, y = (v - py) / fy;
      const double x1 = cz * x - sz * y, y1 = sz * x + cz * y;
      const double x2 = cy * x1 + sy, z2 = cy - sy * x1;
      const double y3 = cx * y1 - sx * z2, z3 = sx * y1 + cx * z2;
      const double from_u = px + fx * x2 / z3 + 0.5, from_v = py + fy * y3 / z3 + 0.5;
      std::uint16_t mm = 0;
      if (from_u >= 0 && from_u < picture.width && from_v >= 0 && from_v < picture.height)
        mm = before.at(static_cast<int>(from_u), static_cast<int>(from_v));
      picture.at(u, v) = mm == 0 ? mm : static_cast<std::uint16_t>(std::lround(mm / z3));
    }
}

// What a device tells of a camera that is carried: 5 mm and 0.3 degrees off, half of it drifting slowly. Of one that
// only turns in a hand, exactly where it looks.
constexpr double kToldMm = 5, kToldDeg = 0.3;
constexpr std::uint64_t kToldStream = 0x701D;

hal::CameraPose after(const hal::CameraPose& a, const hal::CameraPose& b) {
  return {a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
          a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
          a.position_mm};
}

// `held`: how the hand turns the camera.
hal::CameraPose told_pose(const hal::CameraPose& carried, const hal::CameraPose& held, std::uint64_t seed,
                          std::uint64_t frame) {
  if (carried.w == 1 && norm(carried.position_mm) == 0) return held;
  Rng drift = Rng::for_item(seed, kToldStream, 0), white = Rng::for_item(seed, kToldStream, 1 + frame);
  const auto error = [&](double sd) {
    const double phase = drift.uniform(0, 2 * std::numbers::pi), hertz = drift.uniform(0.05, 0.2);
    return static_cast<float>(sd *
                              (std::sin(2 * std::numbers::pi * hertz * kFrameS * static_cast<double>(frame) + phase) +
                               white.normal() * std::numbers::sqrt2 / 2));
  };
  // Of a small turn the quaternion is half of it, in radians.
  constexpr double kHalf = std::numbers::pi / 360 / std::numbers::sqrt3;
  hal::CameraPose off;
  for (float* value : {&off.x, &off.y, &off.z}) *value = error(kToldDeg * kHalf);
  Vec3f step;
  for (float* value : {&step.x, &step.y, &step.z}) *value = error(kToldMm / std::numbers::sqrt3);
  const hal::CameraPose told = after(after(carried, off), held);
  const float length = std::sqrt(told.x * told.x + told.y * told.y + told.z * told.z + told.w * told.w);
  return {told.x / length, told.y / length, told.z / length, told.w / length, told.position_mm + step};
}

constexpr int kShownPerWanted = 3;
constexpr int kShownMin = 15;  // detecting a person takes some frames, however few are wanted

// Frames of one scene as the engine wants them.
class Camera {
 public:
  Camera(const Intrinsics& sensor, const HeldOutPerson& person)
      : rotate_deg_(person.capture.scene.rotate_deg),
        smooths_(person.smoothed),
        scale_(person.camera_scale),
        edges_(person.edges),
        change_(person.change),
        tremor_(person.tremor_deg, person.capture.seed, sensor),
        poses_told_(person.poses_told),
        seed_(person.capture.seed),
        upright_k_(hal::rotate_upright(sensor, rotate_deg_)),
        delivered_(static_cast<std::size_t>(sensor.width) * static_cast<std::size_t>(sensor.height)),
        upright_(delivered_.size()),
        sensor_image_(delivered_.data(), sensor.width, sensor.height),
        image_(upright_.data(), upright_k_.width, upright_k_.height) {}
  // Of the frame taken last, where the device tells it.
  std::optional<hal::CameraPose> pose(const VirtualScene& scene, std::uint64_t frame) const {
    if (!poses_told_) return std::nullopt;
    const hal::CameraPose held = hal::rotate_upright(tremor_.pose(frame), rotate_deg_);
    return told_pose(scene.camera_pose(frame), held, seed_, frame);
  }
  DepthView take(VirtualScene& scene, std::uint64_t frame) {
    scene.render(frame, sensor_image_);
    tremor_.run(frame, sensor_image_);
    edges_.run(sensor_image_);
    if (smooths_) smoothing_.run(sensor_image_);
    if (scale_ != 1)
      for (std::uint16_t& depth_mm : delivered_) depth_mm = scaled(depth_mm);
    hal::rotate_upright(sensor_image_, rotate_deg_, image_);
    if (change_) change_(upright_k_, scene, image_);
    return image_;
  }

 private:
  // No depth stays none.
  std::uint16_t scaled(std::uint16_t depth_mm) const {
    return static_cast<std::uint16_t>(std::min(65535.0F, std::floor(static_cast<float>(depth_mm) * scale_ + 0.5F)));
  }
  int rotate_deg_;
  bool smooths_;
  float scale_;
  EdgeFilter edges_;
  PictureChange change_;
  Tremor tremor_;
  bool poses_told_;
  std::uint64_t seed_;
  TemporalSmoothing smoothing_;
  Intrinsics upright_k_;
  std::vector<std::uint16_t> delivered_, upright_;
  DepthImage sensor_image_, image_;
};

constexpr int kFrontShown = 90;  // before the first step
constexpr std::uint64_t kSessionTurnStream = 0x7024E;

// One scene: the person stands, steps round, and stands a second. `walk`: or is walked round.
Status show_turn(Engine& engine, const SessionModels& models, const HeldOutPerson& person, float degrees, bool walk,
                 const JointWatch& watch) {
  const auto& capture = person.capture;
  Rng rng = Rng::for_item(capture.seed, kSessionTurnStream, 0);
  SceneOptions options = capture.scene;
  const double whole_s = walk ? rng.uniform(kWalkRoundSecondsMin, kWalkRoundSecondsMax)
                              : rng.uniform(kStepRoundSecondsMin, kStepRoundSecondsMax);
  options.step_round = {kFrontShown, static_cast<float>(whole_s) * degrees / 360, degrees, walk};
  VirtualScene scene(models.body, person.subject, options, capture.sensor, capture.intrinsics, capture.seed);
  Camera camera(capture.intrinsics, person);
  const auto frames = static_cast<std::uint64_t>(kFrontShown + 30 + options.step_round.seconds * 30);
  for (std::uint64_t frame = 0; frame < frames && !engine.result().measured; ++frame) {
    hal::FrameInfo info;
    info.sequence = frame;
    info.host_ns = static_cast<std::int64_t>(frame) * 33'333'333;
    const DepthView picture = camera.take(scene, frame);
    info.pose = camera.pose(scene, frame);
    if (auto pushed = engine.push(picture, info); !pushed) return pushed;
    const EngineResult now = engine.result();
    if (now.has_joints && watch) watch(now.joints, scene.joints(frame));
  }
  return Ok{};
}

}  // namespace

bool told_to_lift_arms(const EngineResult& result, int frames_wanted) {
  constexpr auto kBit = static_cast<std::size_t>(std::countr_zero(static_cast<GuidanceSet>(Guidance::arms_close)));
  return static_cast<int>(result.guidance_frames[kBit]) >= std::max(frames_wanted, kShownMin / kShownPerWanted);
}

Result<std::unique_ptr<Engine>> run_session(const SessionModels& models, const HeldOutPerson& person, Views views,
                                            const JointWatch& watch) {
  const auto& capture = person.capture;
  EngineSettings settings;
  settings.intrinsics = hal::rotate_upright(capture.intrinsics, capture.scene.rotate_deg);
  settings.width = settings.intrinsics.width;
  settings.height = settings.intrinsics.height;
  settings.frames_wanted = capture.frame_count;
  settings.frames_min = std::min(settings.frames_min, settings.frames_wanted);
  settings.single_thread = true;
  if (person.sensor_reported) settings.sensor = capture.sensor.kind;
  settings.shape_space = models.shape_space;
  settings.site = models.site;
  const bool dressed = capture.scene.clothing != Clothing::none && models.shape_space != nullptr;
  settings.clothing =
      person.clothing_reported ? dressed ? ClothingGiven::dressed : ClothingGiven::bare : ClothingGiven::unknown;
  if (views == Views::both) settings.turn = Turn::back;
  if (views == Views::around || views == Views::half || views == Views::walk) {
    settings.turn = views == Views::walk ? Turn::walk : Turn::around;
    settings.body = &models.body;
  }
  auto engine = Engine::create(settings, models.joints, models.index);
  if (!engine) return engine.error();

  if (is_all_round(settings.turn)) {
    const float degrees = views == Views::half ? 180.0F : 360.0F;
    if (auto shown = show_turn(**engine, models, person, degrees, settings.turn == Turn::walk, watch); !shown)
      return shown.error();
    (*engine)->finish();
    if (auto sound = (*engine)->fault(); !sound) return sound.error();
    return std::move(*engine);
  }
  std::vector<bool> sides;
  if (views != Views::back) sides.push_back(false);
  if (views == Views::back || views == Views::both) sides.push_back(true);
  const int shown_a_side = std::max(kShownMin, capture.frame_count * kShownPerWanted);
  std::uint64_t frame = 0;
  StandingPose pose = capture.scene.pose;
  for (const bool back : sides) {
    SceneOptions options = capture.scene;
    options.back_view = back;
    options.pose = pose;
    VirtualScene scene(models.body, person.subject, options, capture.sensor, capture.intrinsics, capture.seed);
    if (!person.rest.empty()) scene.restage(person.subject, options, capture.sensor, capture.seed, person.rest);
    Camera camera(capture.intrinsics, person);
    for (int i = 0; i < shown_a_side && !(*engine)->result().measured; ++i, ++frame) {
      hal::FrameInfo info;
      info.sequence = frame;
      info.host_ns = static_cast<std::int64_t>(frame) * 33'333'333;
      const DepthView picture = camera.take(scene, frame);
      info.pose = camera.pose(scene, frame);
      if (auto pushed = (*engine)->push(picture, info); !pushed) return pushed.error();
      const EngineResult now = (*engine)->result();
      if (now.has_joints && watch) watch(now.joints, scene.joints(frame));
      if (!back && now.state == SessionState::turning) break;  // the turn itself is not shown
      if (pose == StandingPose::relaxed && told_to_lift_arms(now, capture.frame_count)) {
        options.pose = pose = StandingPose::arms_out;
        scene.restage(person.subject, options, capture.sensor, capture.seed, person.rest);
      }
    }
  }
  (*engine)->finish();
  if (auto sound = (*engine)->fault(); !sound) return sound.error();
  return std::move(*engine);
}

}  // namespace im2fit::lab
