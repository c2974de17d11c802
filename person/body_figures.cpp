// SPDX-License-Identifier: Apache-2.0
#include "person/body_figures.h"

#include <cmath>
#include <initializer_list>
#include <limits>
#include <numbers>
#include <vector>

#include "body/measure.h"

namespace im2fit {
namespace {

using index::IntervalEstimate;

constexpr double kSds = 1.96;  // of a 95 % interval, to either side
constexpr double kMmPerCm = 10, kMmPerM = 1000;
constexpr double kSquareMmPerM2 = 1e6;
// Density falls as a body of one stature grows (body/measure.h): by 25 of 1000 kg/m^3 while it becomes 2.3 times as
// large, so a hundredth of weight is up to 1.03 hundredths of volume.
constexpr double kVolumePerWeight = 1.03;
// Mosteller's surface goes with the roots of stature and weight (N. Engl. J. Med. 317:1098, 1987).
constexpr double kSurfaceShare = 0.5;
constexpr double kFatMaxPercent = 75;  // beyond, the equation means nothing

// How far each end of an interval is from the value, as a share of it.
struct Reach {
  double below = 0, above = 0;
};
Reach reach_of(const IntervalEstimate& e) {
  const auto value = static_cast<double>(e.value);
  return {(value - static_cast<double>(e.low)) / value, (static_cast<double>(e.high) - value) / value};
}
Reach times(Reach r, double factor) {
  return factor < 0 ? Reach{-factor * r.above, -factor * r.below} : Reach{factor * r.below, factor * r.above};
}
Reach together(std::initializer_list<Reach> all) {
  Reach sum;
  for (const Reach& r : all) {
    sum.below += r.below * r.below;
    sum.above += r.above * r.above;
  }
  return {std::sqrt(sum.below), std::sqrt(sum.above)};
}
IntervalEstimate estimate(double value, Reach r) {
  return {static_cast<float>(value), static_cast<float>(value * (1 - r.below)),
          static_cast<float>(value * (1 + r.above))};
}

// What the tape has an interval of.
std::optional<IntervalEstimate> taped(const body::Tape& tape, std::span<const float> values,
                                      std::span<const TapeInterval> intervals, std::string_view id) {
  const int place = definition_index(tape, id);
  const auto i = static_cast<std::size_t>(place);
  if (place < 0 || i >= values.size() || i >= intervals.size() || !intervals[i].known || !(values[i] > 0))
    return std::nullopt;
  return IntervalEstimate{values[i], intervals[i].low, intervals[i].high};
}

// Fat grows with the girths and falls with the stature.
std::optional<NavyFat> navy_fat(const index::Answer& answer, const body::Tape& tape, std::span<const float> values,
                                std::span<const TapeInterval> intervals) {
  const bool woman = answer.female >= kFatSexSure;
  if (!woman && answer.female > 1 - kFatSexSure) return std::nullopt;
  const auto waist = taped(tape, values, intervals, woman ? "natural_waist_girth" : "navel_girth");
  if (!waist) return std::nullopt;
  const auto measured = [&](Measurement m) { return answer.measurements[measurement_index(m)]; };
  const IntervalEstimate neck = measured(Measurement::neck_girth), stature = measured(Measurement::stature);
  const IntervalEstimate hip = woman ? measured(Measurement::hip_girth) : IntervalEstimate{};
  const auto girths = [&](float around, float about_neck) {
    return static_cast<double>(around) - static_cast<double>(about_neck);
  };
  const double at = girths(waist->value + hip.value, neck.value);
  const double fat = navy_fat_percent(woman, at, static_cast<double>(stature.value));
  if (!(fat > 0 && fat < kFatMaxPercent)) return std::nullopt;
  const double error = static_cast<double>(woman ? kNavyErrorWomen : kNavyErrorMen);
  // One after the other; waist and hip, whose errors go together, at once.
  const auto moved = [&](float around, float about_neck, float tall) {
    const double change = navy_fat_percent(woman, girths(around, about_neck), static_cast<double>(tall)) - fat;
    return std::isfinite(change) ? change : fat;
  };
  const auto half = [&](double a, double b, double c) {
    return std::sqrt(a * a + b * b + c * c + kSds * error * kSds * error);
  };
  const double below = half(moved(waist->low + hip.low, neck.value, stature.value),
                            moved(waist->value + hip.value, neck.high, stature.value),
                            moved(waist->value + hip.value, neck.value, stature.high));
  const double above = half(moved(waist->high + hip.high, neck.value, stature.value),
                            moved(waist->value + hip.value, neck.low, stature.value),
                            moved(waist->value + hip.value, neck.value, stature.low));
  NavyFat out;
  out.woman = woman;
  out.standard_error = static_cast<float>(error);
  out.percent = {static_cast<float>(fat), static_cast<float>(fat > below ? fat - below : 0),
                 static_cast<float>(fat + above)};
  return out;
}

}  // namespace

std::optional<IntervalEstimate> shoulder_tilt_deg(const JointSet& joints, const FloorPlane& floor) {
  constexpr float kSeen = 0.25F;  // confidence; below it a joint is inferred (docs/result.md)
  for (const Joint one : {Joint::LS, Joint::RS})
    if (!(joints.confidence[static_cast<std::size_t>(one)] >= kSeen)) return std::nullopt;
  const Vec3f across = joints[Joint::LS] - joints[Joint::RS];
  const float rise = dot(floor.up, across);
  const float run = norm(across - floor.up * rise);
  if (!floor.known || !(run > 0)) return std::nullopt;
  const float deg = std::atan2(rise, run) * 180 / std::numbers::pi_v<float>;
  return IntervalEstimate{deg, deg - kShoulderTiltErrorDeg, deg + kShoulderTiltErrorDeg};
}

double surface_area_m2(const body::BodyModel& model, std::span<const Vec3f> vertices) {
  double twice_mm2 = 0;
  for (const auto& t : model.body_triangles()) {
    const Vec3f a = vertices[static_cast<std::size_t>(t[0])];
    twice_mm2 += static_cast<double>(
        norm(cross(vertices[static_cast<std::size_t>(t[1])] - a, vertices[static_cast<std::size_t>(t[2])] - a)));
  }
  return twice_mm2 / 2 / kSquareMmPerM2;
}

double navy_fat_percent(bool woman, double girths_mm, double stature_mm) {
  if (!(girths_mm > 0 && stature_mm > 0)) return std::numeric_limits<double>::quiet_NaN();
  const double girths = std::log10(girths_mm / kMmPerCm), stature = std::log10(stature_mm / kMmPerCm);
  const double density =
      woman ? 1.29579 - 0.35004 * girths + 0.22100 * stature : 1.0324 - 0.19077 * girths + 0.15456 * stature;
  return 495 / density - 450;
}

BodyFigures body_figures(const index::Answer& answer, const AnsweredBody& body, const body::BodyModel& model,
                         const body::Tape* tape, std::span<const float> tape_values,
                         std::span<const TapeInterval> tape_intervals) {
  const auto measured = [&](Measurement m) { return answer.measurements[measurement_index(m)]; };
  const IntervalEstimate stature = measured(Measurement::stature), weight = measured(Measurement::weight);
  const IntervalEstimate waist = measured(Measurement::waist_girth), hip = measured(Measurement::hip_girth);
  const Reach of_stature = reach_of(stature), of_weight = reach_of(weight);
  std::vector<Vec3f> morphed;
  if (body.rest.empty()) {
    morphed.resize(static_cast<std::size_t>(model.vertex_count()));
    model.morph(body.params, morphed);
  }
  const std::span<const Vec3f> rest = body.rest.empty() ? morphed : body.rest;
  const auto ratio = [](const IntervalEstimate& over, const IntervalEstimate& under) {
    return estimate(static_cast<double>(over.value) / static_cast<double>(under.value),
                    together({reach_of(over), times(reach_of(under), -1)}));
  };
  BodyFigures out;
  out.volume_l = estimate(body::volume_litres(model, rest), times(of_weight, kVolumePerWeight));
  out.surface_area_m2 = estimate(surface_area_m2(model, rest), together({times(of_weight, kSurfaceShare),
                                                                         times(of_stature, kSurfaceShare),
                                                                         {kSurfaceShapeShare, kSurfaceShapeShare}}));
  out.waist_to_hip = ratio(waist, hip);
  out.waist_to_height = ratio(waist, stature);
  const double metres = static_cast<double>(stature.value) / kMmPerM;
  out.body_mass_index =
      estimate(static_cast<double>(weight.value) / (metres * metres), together({of_weight, times(of_stature, -2)}));
  if (tape != nullptr) out.fat = navy_fat(answer, *tape, tape_values, tape_intervals);
  return out;
}

}  // namespace im2fit
