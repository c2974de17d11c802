// SPDX-License-Identifier: Apache-2.0
#include "estimate/refined_query.h"

#include <algorithm>
#include <limits>

namespace im2fit {
namespace {

body::FitView view_of(const RefinedQuery::Side& side) {
  return {side.fuser.depth_q4(), side.fuser.mask(), side.fuser.intrinsics(), side.description.joints,
          side.description.floor};
}

}  // namespace

bool RefinedQuery::fits(const index::Index& index, const body::ShapeSpace* space) {
  return space != nullptr && space->point_count > 0 && index.shape_key() == space->key &&
         index.fit_layout() == body::fit_layout(*space);
}

RefinedQuery::RefinedQuery(const index::Index& index, const body::ShapeSpace* space, ClothingGiven clothing)
    : index_(index), space_(space), clothing_(clothing), scratch_(index.make_scratch()) {
  if (!fits(index, space)) return;
  fitter_ = std::make_unique<body::ShapeFitter>(*space);
  points_.resize(space->point_count);
}

// None of a fit that is not valid.
std::span<const float> RefinedQuery::values_of(const body::ShapeFit& fit, FitValues& out) const {
  const auto values = std::span(out).first(fit.valid ? body::fit_layout(*space_).size() : 0);
  if (fit.valid) body::fit_values(fit, *space_, values);
  return values;
}

std::span<const float> RefinedQuery::unknown_fit() {
  const std::span<float> values(front_fit_.data(), index_.fit_layout().size());
  std::fill(values.begin(), values.end(), std::numeric_limits<float>::quiet_NaN());
  return values;
}

// Of the last fit, whose first view is the front.
FittedStance RefinedQuery::stance(const body::ShapeFit& front, const FloorPlane& floor) {
  if (!front.valid) return {};
  fitter_->points_in_view(0, points_);
  return stance_of(fitter_->bones_in_view(0), points_, floor);
}

// Of a small index a large count would hold people who are hardly alike.
Result<AgeAnswer> RefinedQuery::age_of(const index::Seen& seen) {
  constexpr std::size_t kAlikeMin = 32, kShareOfIndex = 40;
  const std::size_t wanted = std::clamp(index_.size() / kShareOfIndex, kAlikeMin, kAlikeMax);
  const auto found = index_.alike(seen, std::span(alike_).first(wanted), *scratch_);
  if (!found) return found.error();
  for (std::size_t i = 0; i < *found; ++i) {
    const auto age = index_.age_of(alike_[i]);
    if (!age) return age.error();
    ages_[i] = *age;
  }
  return age_among(std::span(ages_).first(*found));
}

Result<RefinedQuery::Queried> RefinedQuery::queried(index::Seen seen, const index::QueryOptions& options) {
  const auto answer = index_.query(seen, options, *scratch_);
  if (!answer) return answer.error();
  seen.clothing = answer->clothed ? ClothingGiven::dressed : ClothingGiven::bare;
  const auto age = age_of(seen);
  if (!age) return age.error();
  return Queried{*answer, *age, {}, {}};
}

Result<RefinedQuery::Queried> RefinedQuery::query(const Side& front, const std::optional<Side>& back) {
  index::QueryOptions options;
  options.frame_count = front.fuser.frame_count();
  options.distance_mm = front.description.distance_mm;
  index::Seen seen{front.description.feature, {}, {}, {}, clothing_, options.frame_count};
  if (fitter_ == nullptr) return queried(seen, options);
  body::SeenBody body;
  if (back) {
    const std::array<body::FitView, 2> views = {view_of(front), view_of(*back)};
    const body::ShapeFit& both = fitter_->run(views);
    const body::ShapeFit& alone = fitter_->first_alone();
    seen.fit_both = values_of(both, both_fit_);
    seen.fit = values_of(alone, front_fit_);
    body = body::seen_body(both.valid ? both : alone, both.valid);
  } else {
    const std::array<body::FitView, 1> views = {view_of(front)};
    const body::ShapeFit& alone = fitter_->run(views);
    seen.fit = values_of(alone, front_fit_);
    body = body::seen_body(alone, false);
  }
  const FittedStance stands = stance(fitter_->first_alone(), front.description.floor);
  body.valid = body.valid && front.description.floor.known;
  if (!seen.fit_both.empty() && !seen.fit.empty()) {
    seen.back = back->description.feature;
    seen.frame_count = options.frame_count = std::min(options.frame_count, back->fuser.frame_count());
    options.distance_mm = std::max(options.distance_mm, back->description.distance_mm);
  } else if (clothing_ == ClothingGiven::dressed && seen.fit.empty()) {
    // Without a fit the others are answered by features alone; of people in clothes these say too little.
    seen.fit = unknown_fit();
  }
  auto answered = queried(seen, options);
  if (!answered) return answered;
  answered->seen = body;
  answered->stance = stands;
  return answered;
}

}  // namespace im2fit
