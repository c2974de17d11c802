// SPDX-License-Identifier: Apache-2.0
#include "estimate/turn_measurement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "body/fit/point_mesh.h"
#include "body/fit/turn_fitter.h"
#include "body/measure.h"
#include "body/shape_space.h"
#include "estimate/turned_values.h"

namespace im2fit {
namespace {

constexpr std::size_t kViews = body::kTurnViewMax;
constexpr float kApartDeg = 360.0F / kViews;
// Mean distance of a picture's surface from the fitted body. It is 2 to 4 mm of people who turn as they are asked to
// (`im2fit-lab eval-turn`). Where it is 10, the picture was followed wrong, or an arm lies on the body.
constexpr float kSurfaceMaxMm = 10;

// Of what a turn measures: mean error, subtracted, and half of the 95 % interval, mm and kg; of waist and hip without
// the level's part, which follows. Set so that the intervals of people of ansur hold
// (`im2fit-lab eval --condition around --family ansur`); 0: the front's answer stays.
struct Spread {
  float bias = 0, half = 0;
};
constexpr std::array<Spread, kMeasurementCount> kSpreads = {{
    {2.5F, 9},     // stature
    {0, 0},        // sleeve length
    {0, 0},        // leg length
    {0, 0},        // shoulder breadth
    {-2, 25},      // neck girth
    {3, 28},       // shoulder girth
    {0, 25},       // chest girth
    {-1, 14},      // waist girth
    {3, 18},       // hip girth
    {0, 0},        // inside leg
    {0.5F, 2.3F},  // weight
}};

// How much the levels of nipples and navel differ among people of one stature, mm. ANSUR II: standard deviation of
// chestheight and waistheightomphalion about their straight line on stature, the larger of women and men. The surface
// says little about these levels, so a girth is as uncertain as they make it. The buttocks are seen: half of
// buttockheight's 28 mm, which is what their fitted level errs by (`im2fit-lab eval-turn`, 12 to 15 mm).
constexpr float kChestHeightSdMm = 22, kWaistHeightSdMm = 22, kHipHeightSdMm = 14;
constexpr float kOf95 = 1.96F;

// Halves of the 95 % intervals that come from not knowing the height, mm.
std::array<float, kMeasurementCount> level_doubts(const body::Measurer::Slopes& slopes) {
  std::array<float, kMeasurementCount> out{};
  const auto set = [&](Measurement id, double slope, float sd_mm) {
    out[measurement_index(id)] = kOf95 * sd_mm * static_cast<float>(slope);
  };
  set(Measurement::chest_girth, slopes.chest, kChestHeightSdMm);
  set(Measurement::waist_girth, slopes.waist, kWaistHeightSdMm);
  set(Measurement::hip_girth, slopes.hip, kHipHeightSdMm);
  return out;
}

}  // namespace

struct TurnMeasurement::Work {
  Work(const body::BodyModel& m, int width, int height)
      : model(m),
        fitter(m.shape_space()),
        points(m),
        measurer(m),
        mesh(static_cast<std::size_t>(m.vertex_count())),
        pixel_count(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)),
        depth((kViews - 1) * pixel_count),
        mask(depth.size()) {}

  void keep(DepthView seen, MaskView inside, const Intrinsics& intrinsics,
            const std::optional<body::PersonAxes>& axes) {
    const std::size_t at = (view_count - 1) * pixel_count;
    for (int v = 0; v < seen.height; ++v) {
      const auto row = at + static_cast<std::size_t>(v) * static_cast<std::size_t>(seen.width);
      std::copy_n(seen.row(v), seen.width, depth.begin() + static_cast<std::ptrdiff_t>(row));
      std::copy_n(inside.row(v), inside.width, mask.begin() + static_cast<std::ptrdiff_t>(row));
    }
    views[view_count++] = {{{depth.data() + at, seen.width, seen.height},
                            1,
                            {mask.data() + at, seen.width, seen.height},
                            intrinsics,
                            axes},
                           fitter.pose()};
  }

  const body::BodyModel& model;
  body::TurnFitter fitter;
  body::PointMesh points;
  body::Measurer measurer;
  std::vector<Vec3f> mesh;
  body::PersonAxes axes;  // of the front
  std::size_t pixel_count;
  std::vector<std::uint16_t> depth;
  std::vector<std::uint8_t> mask;
  std::array<body::TurnView, kViews> views{};
  std::size_t view_count = 0;  // 0: nothing has begun
  float farthest_deg = 0;      // signed
};

TurnMeasurement::TurnMeasurement(const body::BodyModel& model, int width, int height)
    : work_(std::make_unique<Work>(model, width, height)) {}
TurnMeasurement::~TurnMeasurement() = default;

void TurnMeasurement::reset() {
  work_->view_count = 0;
  work_->farthest_deg = 0;
}

bool TurnMeasurement::begin(const Front& front) {
  Work& w = *work_;
  reset();
  if (!front.seen.valid || !front.floor.known || !w.points.valid()) return false;
  const std::size_t count = w.model.shape_space().shape_count;
  w.axes = body::PersonAxes(front.joints, front.floor);
  w.fitter.begin(std::span(front.seen.shape).first(count), front.seen.pose, w.axes, true);
  w.views[0] = {{front.depth_q4, 1.0F / 16, front.mask, front.intrinsics, {}}, front.seen.pose};
  w.view_count = 1;
  return true;
}

bool TurnMeasurement::follow(DepthView depth, MaskView mask, const Intrinsics& intrinsics,
                             const std::optional<Camera>& camera) {
  Work& w = *work_;
  const auto pixels = static_cast<std::size_t>(depth.width) * static_cast<std::size_t>(depth.height);
  if (w.view_count == 0 || pixels > w.pixel_count) return false;
  std::optional<body::PersonAxes> axes;
  if (camera) axes = w.axes.seen_from(camera->turn, camera->step_mm, camera->floor);
  if (!w.fitter.follow({depth, 1, mask, intrinsics, axes})) return false;
  if (std::fabs(w.fitter.turned_deg()) > std::fabs(w.farthest_deg)) w.farthest_deg = w.fitter.turned_deg();
  if (w.view_count < kViews && std::fabs(w.farthest_deg) >= kApartDeg * static_cast<float>(w.view_count))
    w.keep(depth, mask, intrinsics, axes);
  return true;
}

float TurnMeasurement::turned_deg() const {
  return work_->farthest_deg;
}

bool TurnMeasurement::measure(index::Answer& answer, body::SeenBody& seen) {
  Work& w = *work_;
  if (w.view_count == 0) return false;
  const body::TurnFit& fit = w.fitter.run(std::span(w.views).first(w.view_count));
  if (!fit.valid) return false;
  for (std::size_t v = 0; v < w.view_count; ++v)
    if (fit.surface_mm[v] > kSurfaceMaxMm) return false;
  body::Params base;
  base.gender = answer.female >= 0.5F ? 0.0F : 1.0F;
  w.model.morph(base, w.mesh);
  w.points.run(fit.points, fit.bones, w.mesh);
  const TurnedValues turned = measure_turned(w.model, w.measurer, w.mesh, base.gender == 0);
  const MeasurementValues& values = turned.values;
  for (std::size_t m = 0; m < kMeasurementCount; ++m)
    if (kSpreads[m].half > 0 && !std::isfinite(values[m])) return false;
  const std::array<float, kMeasurementCount> doubts = level_doubts(turned.slopes);
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    const Spread& spread = kSpreads[m];
    if (spread.half == 0) continue;
    const float value = values[m] - spread.bias;
    const float half = std::sqrt(spread.half * spread.half + doubts[m] * doubts[m]);
    answer.measurements[m] = {value, value - half, value + half};
  }
  answer.from = index::AnsweredFrom::around;
  seen = body::seen_body(fit);
  return true;
}

}  // namespace im2fit
