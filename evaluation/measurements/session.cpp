// SPDX-License-Identifier: Apache-2.0
#include "evaluation/measurements/session.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "evaluation/measurements/smoothing.h"
#include "evaluation/measurements/tremor.h"
#include "hal/steady_view.h"

namespace im2fit::lab {
namespace {

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
        tremor_(person.tremor_deg, person.capture.seed, sensor),
        poses_told_(person.poses_told),
        upright_k_(hal::rotate_upright(sensor, rotate_deg_)),
        delivered_(static_cast<std::size_t>(sensor.width) * static_cast<std::size_t>(sensor.height)),
        upright_(delivered_.size()),
        sensor_image_(delivered_.data(), sensor.width, sensor.height),
        image_(upright_.data(), upright_k_.width, upright_k_.height) {
    steady_.prepare(upright_k_.width, upright_k_.height);
  }
  DepthView take(VirtualScene& scene, std::uint64_t frame) {
    scene.render(frame, sensor_image_);
    tremor_.run(frame, sensor_image_);
    edges_.run(sensor_image_);
    if (smooths_) smoothing_.run(sensor_image_);
    if (scale_ != 1)
      for (std::uint16_t& depth_mm : delivered_) depth_mm = scaled(depth_mm);
    hal::rotate_upright(sensor_image_, rotate_deg_, image_);
    if (poses_told_ && steady_.take(hal::rotate_upright(tremor_.pose(frame), rotate_deg_)))
      steady_.run(upright_k_, image_);
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
  Tremor tremor_;
  bool poses_told_;
  hal::SteadyView steady_;
  TemporalSmoothing smoothing_;
  Intrinsics upright_k_;
  std::vector<std::uint16_t> delivered_, upright_;
  DepthImage sensor_image_, image_;
};

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
  if (views == Views::both) settings.turn = Turn::asked;
  auto engine = Engine::create(settings, models.joints, models.index);
  if (!engine) return engine.error();

  std::vector<bool> sides;
  if (views != Views::back) sides.push_back(false);
  if (views != Views::front) sides.push_back(true);
  const int shown_a_side = std::max(kShownMin, capture.frame_count * kShownPerWanted);
  std::uint64_t frame = 0;
  StandingPose pose = capture.scene.pose;
  for (const bool back : sides) {
    SceneOptions options = capture.scene;
    options.back_view = back;
    options.pose = pose;
    VirtualScene scene(models.body, person.subject, options, capture.sensor, capture.intrinsics, capture.seed);
    Camera camera(capture.intrinsics, person);
    for (int i = 0; i < shown_a_side && !(*engine)->result().measured; ++i, ++frame) {
      hal::FrameInfo info;
      info.sequence = frame;
      info.host_ns = static_cast<std::int64_t>(frame) * 33'333'333;
      if (auto pushed = (*engine)->push(camera.take(scene, frame), info); !pushed) return pushed.error();
      const EngineResult now = (*engine)->result();
      if (now.has_joints && watch) watch(now.joints, scene.joints(frame));
      if (!back && now.state == SessionState::turning) break;  // the turn itself is not shown
      if (pose == StandingPose::relaxed && told_to_lift_arms(now, capture.frame_count)) {
        options.pose = pose = StandingPose::arms_out;
        scene.restage(person.subject, options, capture.sensor, capture.seed);
      }
    }
  }
  (*engine)->finish();
  if (auto sound = (*engine)->fault(); !sound) return sound.error();
  return std::move(*engine);
}

}  // namespace im2fit::lab
