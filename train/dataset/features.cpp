// SPDX-License-Identifier: Apache-2.0
#include "train/dataset/features.h"

#include <algorithm>
#include <cmath>

#include "core/guidance.h"
#include "core/rng.h"
#include "hal/source.h"
#include "train/common/stopwatch.h"
#include "train/dataset/median_frame.h"

namespace im2fit::lab {
namespace {

constexpr std::uint64_t kCaptureStream = 0xCA97;
constexpr double kMoreFramesShare = 1.0 / 3;
constexpr double kNearestMm = 1800;  // people fit from about 1.9 m on
// Of captures by another sensor than a Kinect: what their outlines lose goes by the pixel.
constexpr double kOtherWideShare = 0.1;
// Of sensing the median before a capture is given up: a candidate of the first may be confirmed by the next.
constexpr int kCaptureAttempts = 4;
constexpr int kMarginShare = 20;  // of the picture's width: about the person's box, where frames differ

template <class T>
ImageView<T> part_of(ImageView<T> image, const PixelBox& box) {
  return {image.row(box.v0) + box.u0, box.u1 - box.u0, box.v1 - box.v0, image.stride};
}

void copy(DepthView from, DepthImage to) {
  for (int v = 0; v < from.height; ++v) std::copy_n(from.row(v), from.width, to.row(v));
}

// Where a box of the frame as delivered is in the upright picture (virtual_camera.h).
PixelBox upright_box(const PixelBox& box, int width, int height, int rotate_deg) {
  switch (rotate_deg) {
    case 90:
      return {height - box.v1, box.u0, height - box.v0, box.u1};
    case 180:
      return {width - box.u1, height - box.v1, width - box.u0, height - box.v0};
    case 270:
      return {box.v0, width - box.u1, box.v1, width - box.u0};
    default:
      return box;
  }
}

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
        pixels(static_cast<std::size_t>(kImages) * w * h),
        masks(static_cast<std::size_t>(kMasks) * w * h) {}
  int width, height;
  PersonDetector sensor;
  Fuser fuser;
  MedianFrame median_of;
  enum Image { kMedian, kFrame, kImages };
  enum Mask { kMedianMask, kFrameMask, kMasks };
  DepthImage image(Image i) { return {pixels.data() + std::ptrdiff_t{i} * width * height, width, height}; }
  MaskImage mask(Mask i) { return {masks.data() + std::ptrdiff_t{i} * width * height, width, height}; }
  std::vector<std::uint16_t> pixels;
  std::vector<std::uint8_t> masks;
  std::vector<std::uint16_t> part_pixels;
  std::vector<DepthView> parts;  // of every frame
  PixelBox box;                  // of the parts
};

// Copies: the rig's next run overwrites its fused data.
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

// The frames of a capture differ by noise alone, so that sensing their median once detects the person that sensing
// each would; noise about the person is made for all of them, that of the room for the first.
void CaptureRig::shoot(Station& at, VirtualScene& scene, const CaptureOptions& options) {
  const Intrinsics& k = options.intrinsics;
  delivered_.resize(static_cast<std::size_t>(k.width) * k.height);
  const DepthImage delivered(delivered_.data(), k.width, k.height);
  const int rotate_deg = options.scene.rotate_deg;
  const DepthImage first = at.image(Station::kMedian);  // and beyond the person's box it stays the first
  scene.render(0, delivered);
  hal::rotate_upright(delivered, rotate_deg, first);

  const PixelBox frame = whole(k.width, k.height), person = scene.person_box();
  const PixelBox box = person.empty() ? frame : intersect(frame, grown(person, k.width / kMarginShare));
  const PixelBox upright = upright_box(box, k.width, k.height, rotate_deg);
  const auto count = static_cast<std::size_t>(std::max(options.frame_count, 1));
  const auto area = static_cast<std::size_t>(box.u1 - box.u0) * static_cast<std::size_t>(box.v1 - box.v0);
  at.part_pixels.resize(std::max(at.part_pixels.size(), count * area));
  at.parts.clear();
  for (std::size_t f = 0; f < count; ++f) {
    if (f > 0) scene.render_part(f, box, delivered);
    const DepthImage part(&at.part_pixels[f * area], upright.u1 - upright.u0, upright.v1 - upright.v0);
    hal::rotate_upright(part_of(delivered, box), rotate_deg, part);
    at.parts.push_back(part);
  }
  copy(first, at.image(Station::kFrame));
  at.median_of.run(at.parts, part_of(at.image(Station::kMedian), upright));
  at.box = upright;
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
  cost.scene += watch.lap();
  shoot(at, scene, options);
  cost.render += watch.lap();

  const DepthImage median = at.image(Station::kMedian), frame = at.image(Station::kFrame);
  const MaskImage mask = at.mask(Station::kMedianMask), frame_mask = at.mask(Station::kFrameMask);
  Detection detection;
  for (int attempt = 0; attempt < kCaptureAttempts; ++attempt) {
    detection = at.sensor.sense(median, upright, mask);
    for (std::size_t g = 0; g < kGuidanceCount; ++g)
      capture_.refused[g] += static_cast<int>(detection.guidance >> g & 1U);
    ++capture_.frames_seen;
    if (detection.guidance == 0) break;
  }
  cost.sense += watch.lap();
  if (detection.guidance != 0) return capture_;
  for (const DepthView part : at.parts) {
    copy(part, part_of(frame, at.box));
    mask_near(frame, median, mask, frame_mask);
    at.fuser.add(frame, frame_mask, upright, detection);
  }
  cost.fuse += watch.lap();
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

const Fuser* CaptureRig::fused() const {
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
  const auto values_of = [&](const body::ShapeFit& fit) {
    std::vector<float> values(fit.valid ? body::fit_layout(model_.shape_space()).size() : 0);
    if (fit.valid) body::fit_values(fit, model_.shape_space(), values);
    return values;
  };
  fits.layout = body::fit_layout(model_.shape_space());
  fits.both = values_of(fitter_->run(views));
  fits.front = values_of(fitter_->first_alone());
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
  const double distance_mm = rng.uniform(kNearestMm, kTooFarMm);
  if (anywhere) {
    out.scene.distance_mm = static_cast<float>(distance_mm);
    out.scene.enlarge_to_fit = true;
  }
  if (rng.uniform() < variety.other_sensor_share) {
    const float depth_scale = out.sensor.depth_scale;
    out.sensor = rng.uniform() < 0.5 ? tof_sensor() : exact_sensor();
    out.sensor.depth_scale = depth_scale;
    if (rng.uniform() < kOtherWideShare) out.intrinsics = kinect_intrinsics(640, 480);
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
          part("scene", L::kSceneValues, L::kSize),
          {"sensor", static_cast<std::uint32_t>(kSensorTraits)}};
}

}  // namespace im2fit::lab
