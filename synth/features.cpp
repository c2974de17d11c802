// SPDX-License-Identifier: Apache-2.0
#include "synth/features.h"

#include <algorithm>
#include <cmath>

#include "base/rng.h"
#include "hal/source.h"
#include "synth/stopwatch.h"

namespace im2fit::synth {
namespace {

constexpr std::uint64_t kCaptureStream = 0xCA97;
constexpr double kMoreFramesShare = 1.0 / 3;
constexpr double kNearestMm = 1800, kFarthestMm = 4000;  // people fit from about 1.9 m on; beyond 4 m it is TOO_FAR
constexpr int kPatience = 4;  // frames beyond 1.5 times those wanted before a capture is given up
// Frames rendered, then sensed, in turns: renderer and tracker each need more than a core's own cache.
constexpr int kTogether = 3;

}  // namespace

CaptureCost& CaptureCost::operator+=(const CaptureCost& o) {
  draw += o.draw;
  scene += o.scene;
  render += o.render;
  sense += o.sense;
  fuse += o.fuse;
  describe += o.describe;
  fit += o.fit;
  return *this;
}

struct CaptureRig::Station {
  Station(int w, int h, const JointModel& model)
      : width(w),
        height(h),
        sensor(w, h, model),
        fuser(w, h),
        depth(static_cast<std::size_t>(kTogether) * w * h),
        mask(static_cast<std::size_t>(w) * h) {}
  int width, height;
  Sensor sensor;
  Fuser fuser;
  DepthImage frame(int i) { return {depth.data() + static_cast<std::ptrdiff_t>(i) * width * height, width, height}; }
  std::vector<std::uint16_t> depth;  // kTogether frames
  std::vector<std::uint8_t> mask;
};

// Copies: the rig's next run overwrites what it has gathered.
struct CaptureRig::Kept {
  std::vector<std::uint16_t> depth;
  std::vector<std::uint8_t> mask;
  body::FitView view;
};

CaptureRig::CaptureRig(const body::BodyModel& model, const JointModel& joint_model)
    : model_(model), joint_model_(joint_model), front_(std::make_unique<Kept>()), back_(std::make_unique<Kept>()) {
  if (model.shape_space().point_count > 0) fitter_ = std::make_unique<body::ShapeFitter>(model.shape_space());
}
CaptureRig::~CaptureRig() = default;

CaptureRig::Station& CaptureRig::station(int width, int height) {
  for (const auto& s : stations_)
    if (s->width == width && s->height == height) return *s;
  return *stations_.emplace_back(std::make_unique<Station>(width, height, joint_model_));
}

VirtualScene& CaptureRig::stage(const Subject& subject, const CaptureOptions& options, std::span<const Vec3f> rest) {
  const Intrinsics& k = options.intrinsics;
  for (VirtualScene& scene : scenes_) {
    const Intrinsics& its = scene.intrinsics();
    if (its.width != k.width || its.height != k.height || its.fx != k.fx || its.fy != k.fy || its.cx != k.cx ||
        its.cy != k.cy)
      continue;
    scene.restage(subject, options.scene, options.sensor, options.seed, rest);
    return scene;
  }
  return scenes_.emplace_back(model_, subject, options.scene, options.sensor, k, options.seed);
}

const Capture& CaptureRig::run(const Subject& subject, const CaptureOptions& options, std::span<const Vec3f> rest) {
  Stopwatch watch;
  const Intrinsics upright = hal::rotate_upright(options.intrinsics, options.scene.rotate_deg);
  Station& at = station(upright.width, upright.height);
  last_ = &at;
  upright_ = upright;
  at.sensor.reset();
  at.fuser.reset();
  capture_ = {};
  VirtualScene& scene = stage(subject, options, rest);
  delivered_.resize(static_cast<std::size_t>(options.intrinsics.width) * options.intrinsics.height);
  const DepthImage delivered(delivered_.data(), options.intrinsics.width, options.intrinsics.height);
  const MaskImage mask(at.mask.data(), at.width, at.height);
  cost.scene += watch.lap();

  const int frames_max = options.frame_count + options.frame_count / 2 + kPatience;
  int first = 0, rendered = 0;  // of the frames at hand; those rendered so far
  for (int i = 0; i < frames_max && at.fuser.frame_count() < options.frame_count; ++i) {
    if (i == rendered) {
      first = i;
      rendered += std::min({kTogether, options.frame_count - at.fuser.frame_count(), frames_max - i});
      for (int f = first; f < rendered; ++f) {
        scene.render(static_cast<std::uint64_t>(f), delivered);
        hal::rotate_upright(delivered, options.scene.rotate_deg, at.frame(f - first));
      }
      cost.render += watch.lap();
    }
    const DepthImage depth = at.frame(i - first);
    const Sighting sighting = at.sensor.sense(depth, upright, mask);
    cost.sense += watch.lap();
    GuidanceSet guidance = sighting.guidance;
    if (guidance == 0) guidance = at.fuser.add(depth, mask, upright, sighting);
    for (std::size_t g = 0; g < kGuidanceCount; ++g) capture_.refused[g] += static_cast<int>(guidance >> g & 1U);
    cost.fuse += watch.lap();
    ++capture_.frames_seen;
    // Nothing changes but noise: what refuses the first frames will refuse the rest.
    if (i + 1 >= kPatience && at.fuser.frame_count() == 0) break;
  }
  capture_.frame_count = at.fuser.frame_count();
  if (capture_.frame_count < kCaptureFramesMin) return capture_;
  const Fuser::Description& description = at.fuser.describe();
  cost.describe += watch.lap();
  capture_.valid = description.valid;
  capture_.joints = description.joints;
  capture_.floor = description.floor;
  capture_.distance_mm = description.distance_mm;
  capture_.paper = description.paper;
  capture_.feature = description.feature;
  return capture_;
}

const Fuser* CaptureRig::gathered() const {
  return last_ == nullptr ? nullptr : &last_->fuser;
}

void CaptureRig::keep(Kept& kept) const {
  const auto depth = last_->fuser.depth_q4();
  const auto mask = last_->fuser.mask();
  kept.depth.assign(depth.pixels, depth.pixels + static_cast<std::ptrdiff_t>(depth.height) * depth.stride);
  kept.mask.assign(mask.pixels, mask.pixels + static_cast<std::ptrdiff_t>(mask.height) * mask.stride);
  kept.view.depth_q4 = {kept.depth.data(), depth.width, depth.height, depth.stride};
  kept.view.mask = {kept.mask.data(), mask.width, mask.height, mask.stride};
  kept.view.intrinsics = upright_;
  kept.view.joints = capture_.joints;
  kept.view.floor = capture_.floor;
}

void CaptureRig::keep_front() {
  keep(*front_);
}

CaptureRig::Fits CaptureRig::fit_both() {
  Fits fits;
  if (!fitter_) return fits;
  Stopwatch watch;
  keep(*back_);
  const std::array<body::FitView, 2> views = {front_->view, back_->view};
  std::array<float, body::kShapeMax + body::kFitQualityCount> values;
  const auto fit = [&](std::span<const body::FitView> seen) {
    const auto filled = body::fit_values(fitter_->run(seen), model_.shape_space(), values);
    return std::vector<float>(filled.begin(), filled.end());
  };
  fits.front = fit(std::span(views).first(1));
  fits.both = fit(views);
  cost.fit += watch.lap();
  if (fits.front.empty() || fits.both.empty()) return {};
  return fits;
}

CaptureOptions draw_capture(const CaptureVariety& variety, std::uint64_t seed, std::uint64_t subject, int capture) {
  Rng rng = Rng::for_item(seed ^ (static_cast<std::uint64_t>(capture) << 48), kCaptureStream, subject);
  CaptureOptions out;
  out.seed = rng.next();
  out.intrinsics = rng.uniform() < variety.wide_share ? kinect_intrinsics(640, 480) : kinect_intrinsics(320, 240);
  const double pose = rng.uniform();
  out.scene.pose = variety.plain || pose < 0.8 ? StandingPose::relaxed
                   : pose < 0.95               ? StandingPose::a_pose
                                               : StandingPose::psi;
  const double mount = rng.uniform();
  out.scene.rotate_deg = mount < variety.landscape_share ? 0 : mount < 0.9 ? 90 : 270;
  out.scene.wall = rng.uniform() < 0.85;
  const bool furnished = rng.uniform() < 0.35;
  const int furniture = 1 + rng.index(4);
  out.scene.furniture_count = furnished && !variety.plain ? furniture : 0;
  out.scene.sway = false;
  out.sensor = kinect_sensor();
  out.sensor.depth_scale = static_cast<float>(1 + rng.uniform(-0.003, 0.003));
  // Odd numbers: a pixel must be seen in half of the frames, and half of an even number is reached more often than
  // half of the thirty a device takes, above all at outlines (docs/dataset.md).
  out.frame_count = variety.frames_min;
  while (out.frame_count + 2 <= variety.frames_max && rng.uniform() < kMoreFramesShare) out.frame_count += 2;
  const bool anywhere = rng.uniform() < variety.anywhere_share;
  const double distance_mm = rng.uniform(kNearestMm, kFarthestMm);
  if (anywhere) {
    out.scene.distance_mm = static_cast<float>(distance_mm);
    out.scene.enlarge_to_fit = true;
  }
  return out;
}

std::vector<index::FeatureGroup> feature_groups() {
  using L = ProfileLayout;
  const auto part = [](const char* name, int first, int last) {
    return index::FeatureGroup{name, static_cast<std::uint32_t>(last - first)};
  };
  return {{"lengths", 4},
          {"ratios", 2},
          {"fpfh", 33 * kJointCount},
          part("trunk", L::kTrunk, L::kLegs),
          part("legs", L::kLegs, L::kHead),
          part("head", L::kHead, L::kArms),
          part("arms", L::kArms, L::kCrown),
          part("crown and soles", L::kCrown, L::kJoints),
          part("joints", L::kJoints, L::kBoneLengths),
          part("bones", L::kBoneLengths, L::kSceneValues),
          part("scene", L::kSceneValues, L::kSize)};
}

}  // namespace im2fit::synth
