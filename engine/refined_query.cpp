// SPDX-License-Identifier: Apache-2.0
#include "engine/refined_query.h"

#include <algorithm>
#include <limits>

namespace im2fit {
namespace {

// What a fit ends with, as its maker and the index see it.
static_assert(body::kFitQualityCount == index::kFitQualities);

body::FitView view_of(const RefinedQuery::Side& side) {
  return {side.fuser.depth_q4(), side.fuser.mask(), side.fuser.intrinsics(), side.description.joints,
          side.description.floor};
}

}  // namespace

bool RefinedQuery::fits(const index::Index& index, const body::ShapeSpace* space) {
  return space != nullptr && space->point_count > 0 && index.fit_size() > 0 && index.shape_key() == space->key;
}

RefinedQuery::RefinedQuery(const index::Index& index, const body::ShapeSpace* space, bool clothed)
    : index_(index), space_(space), clothed_(clothed), scratch_(index.make_scratch()) {
  if (fits(index, space)) fitter_ = std::make_unique<body::ShapeFitter>(*space);
}

std::span<const float> RefinedQuery::fit(std::span<const body::FitView> views) {
  return body::fit_values(fitter_->run(views), *space_, values_);
}

std::span<const float> RefinedQuery::unknown_fit() {
  const std::span<float> values(values_.data(), index_.fit_size());
  std::fill(values.begin(), values.end(), std::numeric_limits<float>::quiet_NaN());
  return values;
}

Result<index::Answer> RefinedQuery::ask(const Side& front, const std::optional<Side>& back) {
  index::QueryOptions options;
  options.frame_count = front.fuser.frame_count();
  index::Seen seen{front.description.feature, {}, {}, {}, clothed_};
  if (fitter_ == nullptr) return index_.query(seen, options, *scratch_);
  if (back) {
    const std::array<body::FitView, 2> views = {view_of(front), view_of(*back)};
    seen.fit_both = fit(views);
  }
  if (seen.fit_both.empty()) {
    const std::array<body::FitView, 1> views = {view_of(front)};
    seen.fit = fit(views);
    // Without a fit the others are answered by features alone; of people in clothes these say too little.
    if (clothed_ && seen.fit.empty()) seen.fit = unknown_fit();
  } else {
    seen.back = back->description.feature;
    options.frame_count = std::min(options.frame_count, back->fuser.frame_count());
  }
  return index_.query(seen, options, *scratch_);
}

}  // namespace im2fit
