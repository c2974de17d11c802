// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/lazy_zeros.h"
#include "kernels/fpfh/fpfh.h"
#include "kernels/normals/normals.h"
#include "perception/fuse/decimate.h"
#include "perception/fuse/depth_fusion.h"
#include "perception/fuse/outline_losses.h"
#include "perception/fuse/temporal_noise.h"
#include "perception/observe/observe.h"

namespace im2fit {
namespace {

constexpr int kFramesMax = 64;          // joints kept for the median
constexpr int kStepMin = 2;             // of the grid: bounds its buffers; a person beyond 4 m is refused anyway
constexpr float kDriftMaxMm = 60.0F;    // further from where accumulation began: the person moved
constexpr float kNormalStepMm = 60.0F;  // between grid points 20 mm apart: steeper than 70 degrees is an edge

float median(std::array<float, kFramesMax>& values, int count) {
  const auto middle = values.begin() + count / 2;
  std::nth_element(values.begin(), middle, values.begin() + count);
  return *middle;
}

int whole_mm(float mm) {
  constexpr float kMostMm = 65535;
  return mm > 0 ? static_cast<int>(std::min(mm, kMostMm) + 0.5F) : 0;  // 0 also for not-a-number
}

}  // namespace

struct Fuser::Workspace {
  Workspace(int width, int height)
      : fusion(width, height),
        noise(width, height),
        paper(width, height),
        fpfh(width / kStepMin, height / kStepMin),
        profile(width, height),
        around(width, height),
        grid(static_cast<std::size_t>(width / kStepMin) * static_cast<std::size_t>(height / kStepMin) * 6) {}

  DepthFusion fusion;
  TemporalNoise noise;
  OutlineLosses outline;
  PaperWorkspace paper;
  FpfhWorkspace fpfh;
  ProfileWorkspace profile;
  Surroundings around;
  LazyZeros<float> grid;  // x y z nx ny nz of the decimated person, whose grid is coarser the nearer they stand
  std::array<JointSet, kFramesMax> joints;
  int joints_count = 0;
  Intrinsics intrinsics;
  Vec3f start_mm;
  Vec3f up_sum;
  float camera_height_sum = 0;
  int floor_count = 0;
  bool edges_restored = false;  // of the latest frame
  Vec3f hidden_up;              // of the latest frame without a floor
  Description description;

  JointSet median_joints() const;
  FloorPlane mean_floor() const;
  void fpfh_values(std::span<float> out);
};

JointSet Fuser::Workspace::median_joints() const {
  JointSet out;
  std::array<float, kFramesMax> values{};
  const auto count = static_cast<std::size_t>(joints_count);
  const auto of = [&](auto&& pick) {
    for (std::size_t i = 0; i < count; ++i) values[i] = pick(joints[i]);
    return median(values, joints_count);
  };
  for (std::size_t j = 0; j < kJointCount; ++j) {
    out.position_mm[j].x = of([j](const JointSet& s) { return s.position_mm[j].x; });
    out.position_mm[j].y = of([j](const JointSet& s) { return s.position_mm[j].y; });
    out.position_mm[j].z = of([j](const JointSet& s) { return s.position_mm[j].z; });
    out.confidence[j] = of([j](const JointSet& s) { return s.confidence[j]; });
  }
  return out;
}

FloorPlane Fuser::Workspace::mean_floor() const {
  FloorPlane floor;
  floor.up = hidden_up;
  if (floor_count == 0) return floor;
  floor.known = true;
  floor.up = normalized(up_sum);
  floor.camera_height_mm = camera_height_sum / static_cast<float>(floor_count);
  return floor;
}

void Fuser::Workspace::fpfh_values(std::span<float> out) {
  const float distance = description.joints[Joint::TO].z;
  const int step = std::max(kStepMin, grid_step_px(intrinsics, distance));
  const Intrinsics k = grid_intrinsics(intrinsics, step);
  const auto size = static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height);
  const auto plane = [&](std::size_t i) { return std::span(grid.data(), grid.size()).subspan(i * size, size); };
  decimate(fusion.depth_q4(), fusion.mask(), k, step, plane(0), plane(1), plane(2));
  normals(k, plane(0).data(), plane(1).data(), plane(2).data(), 1, kNormalStepMm, plane(3).data(), plane(4).data(),
          plane(5).data());
  const OrganisedCloud cloud{
      k, plane(0).data(), plane(1).data(), plane(2).data(), plane(3).data(), plane(4).data(), plane(5).data()};
  im2fit::fpfh(cloud, description.joints.position_mm, kFpfhRadiusMm, fpfh, out);
}

Fuser::Fuser(int width, int height) : work_(std::make_unique<Workspace>(width, height)) {
  reset();
}
Fuser::~Fuser() = default;
Fuser::Fuser(Fuser&&) noexcept = default;

void Fuser::reset() {
  Workspace& w = *work_;
  w.fusion.reset();
  w.noise.reset();
  w.outline.reset();
  w.around.reset();
  w.joints_count = 0;
  w.up_sum = {};
  w.camera_height_sum = 0;
  w.floor_count = 0;
  w.hidden_up = FloorPlane{}.up;
  w.description.valid = false;
}

GuidanceSet Fuser::add(DepthView depth, MaskView mask, const Intrinsics& intrinsics, const Detection& detection) {
  Workspace& w = *work_;
  const Person& person = detection.person;
  if (w.fusion.frame_count() == 0) {
    w.start_mm = person.centroid_mm;
    w.intrinsics = intrinsics;
  } else if (norm(person.centroid_mm - w.start_mm) > kDriftMaxMm) {
    return static_cast<GuidanceSet>(Guidance::moving);
  }
  w.edges_restored = detection.edges_restored;
  w.fusion.add(depth, mask, person.u_min, person.v_min, person.u_max, person.v_max);
  w.noise.add(depth, mask, person.u_min, person.v_min, person.u_max, person.v_max);
  w.outline.add(depth, mask, person.u_min, person.v_min, person.u_max, person.v_max);
  w.around.add(depth, mask, intrinsics, person, detection.view == ViewSide::front);
  if (w.joints_count < kFramesMax) w.joints[static_cast<std::size_t>(w.joints_count++)] = detection.joints;
  if (person.floor.known) {
    w.up_sum = w.up_sum + person.floor.up;
    w.camera_height_sum += person.floor.camera_height_mm;
    ++w.floor_count;
  } else {
    w.hidden_up = person.floor.up;
  }
  return 0;
}

int Fuser::frame_count() const {
  return work_->fusion.frame_count();
}

SurroundingsSigns Fuser::surroundings() const {
  return work_->around.signs();
}

const Intrinsics& Fuser::intrinsics() const {
  return work_->intrinsics;
}

const Fuser::Description& Fuser::describe(SensorKind kind, float ground_mm) {
  Workspace& w = *work_;
  Description& d = w.description;
  d.valid = false;
  if (w.fusion.frame_count() == 0) return d;
  w.fusion.finish();
  d.joints = w.median_joints();
  d.floor = w.mean_floor();
  d.floor.camera_height_mm -= d.floor.known ? ground_mm : 0.0F;
  d.distance_mm = whole_mm(d.joints[Joint::TO].z);
  d.paper = measure_paper(w.fusion.depth_q4(), w.fusion.mask(), w.intrinsics, d.joints, w.paper);

  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  const PaperMeasurements& p = d.paper;
  const std::array<float, 6> head = {p.stature_mm,  p.sleeve_mm,   p.leg_mm,
                                     p.shoulder_mm, p.chest_ratio, p.hip_waist_ratio};
  const auto feature = std::span<float>(d.feature);
  for (std::size_t i = 0; i < head.size(); ++i) feature[i] = p.valid ? head[i] : kNaN;
  w.fpfh_values(feature.subspan(head.size(), kPaperFeatureSize - head.size()));
  section_profile(w.fusion.depth_q4(), w.fusion.mask(), w.intrinsics, d.joints, d.floor, w.profile,
                  feature.subspan(kPaperFeatureSize, kProfileSize));
  const SensorSigns signs{w.noise.sd_mm(), w.outline.lost(), w.outline.one_sided(), w.edges_restored};
  const auto traits = sensor_traits(signs, d.joints[Joint::TO].z, w.intrinsics.fx, kind);
  std::copy(traits.begin(), traits.end(), feature.end() - kSensorTraits);
  d.crown_flatness = crown_flatness(w.fusion.depth_q4(), w.fusion.mask(), w.intrinsics, d.joints, d.floor);
  d.valid = true;
  return d;
}

ImageView<const std::uint16_t> Fuser::depth_q4() const {
  return work_->fusion.depth_q4();
}
MaskView Fuser::mask() const {
  return work_->fusion.mask();
}

}  // namespace im2fit
