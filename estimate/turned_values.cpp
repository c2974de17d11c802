// SPDX-License-Identifier: Apache-2.0
#include "estimate/turned_values.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

#include "body/model_data.h"

namespace im2fit {
namespace {

// People are seen with their arms some 30 degrees off the body, and a chest is measured so. Linear blend skinning
// draws the flesh of the armpits inwards when it lowers the arms: by 22 and 40 mm of men's girth on two meshes. What
// lowering the arms takes off a person's chest is not known (docs/notebook/fit.md).
constexpr float kArmsOffDeg = 30;

// A chest's section lies at the fitted nipples, moved towards the height that a stature lets expect: chestheight of
// ANSUR II about its straight line on stature. A mesh carries its maker's nipples, and what a camera sees of a flat
// chest does not correct them. Women's are seen better, and vary more. The fitted nipples of men are 10 mm too low
// (men among twelve people of ansur, `im2fit-lab eval-turn --family ansur --subjects 12 --seed 9 --people FILE`). The
// share of men is that of the prototype (docs/notebook/fit.md).
struct Nipples {
  float at_1700_mm = 0, a_mm = 0;  // of ANSUR II
  float too_low_mm = 0, share = 0;
};
constexpr Nipples kNipplesOfWomen = {1228.2F, 0.791F, 0, 0.25F}, kNipplesOfMen = {1246.8F, 0.788F, 10, 0.3F};
constexpr float kRaiseMaxMm = 40;

// How much higher than at the fitted nipples the chest is to be measured, mm.
float chest_raised_mm(const body::Measurer& measurer, const body::BodyModel& model, bool woman, float stature_mm) {
  const Nipples& expected = woman ? kNipplesOfWomen : kNipplesOfMen;
  float low_mm = std::numeric_limits<float>::max();
  for (const Vec3f p : measurer.posed().first(static_cast<std::size_t>(model.body_vertex_count())))
    low_mm = std::min(low_mm, p.y);
  for (const body::Section& section : measurer.sections())
    if (section.id == Measurement::chest_girth && !section.hull.empty()) {
      const float seen_mm = section.hull.front().y - low_mm + expected.too_low_mm;
      const float expected_mm = expected.at_1700_mm + expected.a_mm * (stature_mm - 1700);
      return std::clamp(expected.too_low_mm + expected.share * (expected_mm - seen_mm), -kRaiseMaxMm, kRaiseMaxMm);
    }
  return 0;
}

// How much higher than at the rearmost vertex the hip is to be measured, mm: the middle of all that lies nearly as
// far back, because one vertex is rearmost by chance. On people of `ansur` this errs by 9 mm instead of 13.
float hip_raised_mm(const body::Measurer& measurer, const body::BodyModel& model) {
  constexpr float kNearlyMm = 4, kAboutMm = 30;
  const auto hip = std::find_if(measurer.sections().begin(), measurer.sections().end(), [](const body::Section& s) {
    return s.id == Measurement::hip_girth && !s.hull.empty();
  });
  if (hip == measurer.sections().end()) return 0;
  const float level = hip->hull.front().y;
  const std::span<const Vec3f> skin = measurer.posed().first(static_cast<std::size_t>(model.body_vertex_count()));
  const auto is_seat = [&](std::size_t v) {
    const auto part = static_cast<body::Segment>(model.data().skin[v].segment[0]);
    return (part == body::Segment::pelvis || part == body::Segment::left_upper_leg ||
            part == body::Segment::right_upper_leg) &&
           std::fabs(skin[v].y - level) < kAboutMm;
  };
  float rearmost = std::numeric_limits<float>::max();
  for (std::size_t v = 0; v < skin.size(); ++v)
    if (is_seat(v)) rearmost = std::min(rearmost, skin[v].z);
  float weight = 0, sum = 0;
  for (std::size_t v = 0; v < skin.size(); ++v)
    if (const float w = rearmost + kNearlyMm - skin[v].z; w > 0 && is_seat(v)) {
      weight += w;
      sum += w * (skin[v].y - level);
    }
  return weight > 0 ? sum / weight : 0;
}

}  // namespace

TurnedValues measure_turned(const body::BodyModel& model, body::Measurer& measurer,
                            std::span<const Vec3f> rest_vertices, bool woman) {
  TurnedValues out;
  out.values = measurer.measure_rest_mesh(rest_vertices, woman ? 0.0F : 1.0F);
  out.slopes = measurer.girth_slopes();
  out.values[measurement_index(Measurement::hip_girth)] +=
      static_cast<float>(out.slopes.hip) * hip_raised_mm(measurer, model);
  const float raised_mm =
      chest_raised_mm(measurer, model, woman, out.values[measurement_index(Measurement::stature)]);
  float& chest = out.values[measurement_index(Measurement::chest_girth)];
  if (std::isfinite(chest))
    chest = static_cast<float>(measurer.chest_girth_mm(rest_vertices, kArmsOffDeg, raised_mm));
  return out;
}

}  // namespace im2fit
