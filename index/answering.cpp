// SPDX-License-Identifier: Apache-2.0
#include "index/answering.h"

#include <algorithm>
#include <cmath>

#include "index/regression.h"

namespace im2fit::index {
namespace {

double squared(double x) {
  return x * x;
}

}  // namespace

Answerer::Answerer(const Contents& contents)
    : contents_(contents), regressor_(contents.ridge, contents.ridge_unit, contents.ridge_bias) {
  for (const Refinement kind : kRefinements)
    if (const auto& c = contents.refinements[static_cast<std::size_t>(kind)])
      refiners_[static_cast<std::size_t>(kind)].emplace(kind, *c, contents.meta.feature_size);
  for (std::size_t v = 0; v < kClothingViews.size(); ++v)
    if (const auto& c = contents.clothing[v])
      clothing_estimators_[v].emplace(kClothingViews[v], *c, contents.meta.feature_size);
}

Answerer::Workspace::Workspace(const Answerer& answerer)
    : standardised(answerer.regressor_.padded_size()), search(answerer.contents_.tree) {
  for (std::size_t i = 0; i < kRefinementCount; ++i)
    if (answerer.refiners_[i]) refining[i].emplace(answerer.refiners_[i]->map());
  for (std::size_t v = 0; v < kClothingViews.size(); ++v)
    if (answerer.clothing_estimators_[v]) clothing[v].emplace(answerer.clothing_estimators_[v]->map());
}

Targets Answerer::regressed(std::span<const float> feature, Workspace& work) const {
  if (feature.size() == contents_.meta.feature_size)
    standardise(feature.data(), contents_.feature_mean.data(), contents_.feature_scale.data(),
                static_cast<int>(feature.size()), work.standardised.data());
  else
    std::fill(work.standardised.begin(), work.standardised.end(), std::int16_t{0});
  return regressor_(work.standardised);
}

Position Answerer::place_of(const Targets& targets) const {
  return project(targets, static_cast<int>(contents_.meta.target_count), contents_.projection,
                 static_cast<int>(contents_.meta.dimensions));
}

Coordinates Answerer::grid_of(const Targets& targets) const {
  return to_grid(place_of(targets), static_cast<int>(contents_.meta.dimensions), contents_.meta.grid_unit);
}

Result<Answerer::Corrected> Answerer::corrected(const Targets& regressed, const QueryOptions& options,
                                                Workspace& work) const {
  const Contents& c = contents_;
  const int targets = static_cast<int>(c.meta.target_count);
  const Surface surface = c.surface();
  const Targets bend = surface.targets_at(place_of(regressed));
  Corrected out;
  out.shift = surface.shift_of(bend);
  const Coordinates grid = grid_of(regressed);
  const int wanted = options.neighbour_count > 0 ? options.neighbour_count : static_cast<int>(c.meta.neighbour_count);
  const auto count = static_cast<std::size_t>(std::min(wanted, kNeighbourMax));
  out.neighbours = options.exhaustive ? work.search.exhaustive(grid, count) : work.search.nearest(grid, count);
  if (!work.search.intact()) return work.search.damage();
  for (const Neighbour& n : out.neighbours) {
    const ByteRange range = c.residual_of(n.index);
    if (!c.residual_pages.intact(range)) return c.residual_pages.damage(range);
    __builtin_prefetch(c.residual.data() + range.first);
  }
  const LocalAnswer local = local_regression(
      c.local_data(), grid, out.neighbours,
      {static_cast<LocalMethod>(c.meta.local_method), c.meta.intercept_penalty, c.meta.slope_penalty});
  for (int t = 0; t < targets; ++t)
    out.value[t] = regressed[t] + bend[t] + ((c.meta.local_targets >> t & 1U) != 0 ? local.correction[t] : 0.0);
  out.spread = local.spread;
  return out;
}

const Refiner* Answerer::refiner_for(const Seen& seen, bool dressed) const {
  constexpr std::array kBare = {Refinement::turned, Refinement::fitted};
  constexpr std::array kDressed = {Refinement::clothed_turned, Refinement::clothed};
  for (const Refinement kind : dressed ? kDressed : kBare)
    if (const auto& refiner = refiners_[static_cast<std::size_t>(kind)]; refiner && refiner->map().applies(seen))
      return &*refiner;
  return nullptr;
}

const ClothingEstimator* Answerer::clothing_estimator_for(const Seen& seen, std::size_t& view) const {
  for (view = kClothingViews.size(); view-- > 0;)
    if (const auto& estimator = clothing_estimators_[view]; estimator && estimator->map().applies(seen))
      return &*estimator;
  return nullptr;
}

// People in clothes are searched for at the refined answer; it has no shape latents, so these stay zero.
Targets Answerer::position_targets_of(const Seen& seen, const Refiner* refiner, Workspace& work) const {
  if (refiner == nullptr || !is_of_clothed(refiner->map().kind())) return regressed(seen.front, work);
  Targets sought{};
  refiner->apply(seen, *work.refining[static_cast<std::size_t>(refiner->map().kind())], sought);
  return sought;
}

Result<std::span<const Neighbour>> Answerer::alike(const Seen& seen, std::size_t count, Workspace& work) const {
  const Coordinates grid =
      grid_of(position_targets_of(seen, refiner_for(seen, seen.clothing == ClothingGiven::dressed), work));
  const std::span<const Neighbour> found = work.search.nearest(grid, std::min<std::size_t>(count, kNeighbourMax));
  if (!work.search.intact()) return work.search.damage();
  return found;
}

Result<Answer> Answerer::answer(const Seen& seen, const QueryOptions& options, Workspace& work) const {
  std::size_t view = 0;
  const ClothingEstimator* estimator = clothing_estimator_for(seen, view);
  if (estimator == nullptr || refiner_for(seen, true) == nullptr)
    return answer_as(seen.clothing == ClothingGiven::dressed, seen, options, work);
  const float seen_dressed = estimator->probability(seen, *work.clothing[view]);
  const float probability = with_given(seen_dressed, seen.clothing);
  const auto bare = answer_as(false, seen, options, work);
  if (!bare) return bare.error();
  const auto dressed = answer_as(true, seen, options, work);
  if (!dressed) return dressed.error();
  const bool told = seen.clothing == ClothingGiven::dressed;
  Answer out = told ? *dressed : *bare;
  if (!told && probability > 0) widen_for(*dressed, probability, out);
  out.clothing = {seen_dressed, probability * ease_between_mm(*bare, *dressed)};
  return out;
}

Result<Answer> Answerer::answer_as(bool dressed, const Seen& seen, const QueryOptions& options,
                                   Workspace& work) const {
  const Refiner* refiner = refiner_for(seen, dressed);
  ValueMap::Work* refining = refiner ? &*work.refining[static_cast<std::size_t>(refiner->map().kind())] : nullptr;
  const Targets sought = position_targets_of(seen, refiner, work);
  auto found = this->corrected(sought, options, work);
  if (!found) return found.error();
  Corrected& corrected = *found;
  if (dressed && refiner) corrected.value = sought;
  const MetaRecord& meta = contents_.meta;
  Uncertainty uncertainty{meta.noise, meta.interval_kind == static_cast<std::uint32_t>(IntervalKind::local_spread),
                          contents_.interval, contents_.spread_floor, contents_.sex_table};
  Answer out;
  if (refiner != nullptr) {
    if (!dressed) refiner->apply(seen, *refining, corrected.value);
    corrected.spread = {};  // of the regression's residuals, not of these
    const RefinementContents& c = refiner->contents();
    uncertainty = {c.record.noise, c.record.interval_kind == static_cast<std::uint32_t>(IntervalKind::local_spread),
                   c.interval, c.spread_floor, c.sex_table};
    if (dressed) uncertainty.novelty = ValueMap::novelty(*refining);
    out.from = sees_back(refiner->map().kind()) ? AnsweredFrom::front_and_back : AnsweredFrom::fitted_front;
    out.clothed = dressed;
  }
  fill_estimates(corrected.value, corrected.spread, uncertainty, options, out);
  fill_nearest(corrected, out);
  return out;
}

// Of the neighbours, whose features resemble the query's, the one whose true place is nearest to the answer. The
// surface is taken to shift all of them as it shifts the query.
void Answerer::fill_nearest(const Corrected& corrected, Answer& out) const {
  Position wanted = place_of(corrected.value);
  for (std::size_t d = 0; d < contents_.meta.dimensions; ++d) wanted[d] -= corrected.shift[d];
  double best = 1e300;
  for (const Neighbour& n : corrected.neighbours) {
    const Position code = contents_.code_place(n.index), error = contents_.error_of(n.index);
    double sum = 0;
    for (std::size_t d = 0; d < contents_.meta.dimensions; ++d) sum += squared(code[d] + error[d] - wanted[d]);
    // Ties to the smaller index, in whatever order neighbours come.
    if (sum > best || (sum == best && n.index > out.nearest)) continue;
    best = sum;
    out.nearest = n.index;
  }
  out.nearest_distance = static_cast<float>(std::sqrt(best));
  out.nearest_values = contents_.measurements_of_entry(out.nearest);
}

void Answerer::fill_estimates(const Targets& targets, const Targets& spread, const Uncertainty& uncertainty,
                              const QueryOptions& options, Answer& out) const {
  const Contents& c = contents_;
  const double noise = uncertainty.noise.width(options.frame_count, options.distance_mm, uncertainty.novelty);
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    const double unit = static_cast<double>(c.target_scale[m]);
    const double value = static_cast<double>(c.target_mean[m]) + unit * targets[m];
    const double floor = static_cast<double>(uncertainty.spread_floor[m]);
    const double width = unit * noise * (uncertainty.local ? 0.5 * (floor + spread[m]) : floor);
    out.measurements[m] = {static_cast<float>(value),
                           static_cast<float>(value + width * static_cast<double>(uncertainty.interval[2 * m])),
                           static_cast<float>(value + width * static_cast<double>(uncertainty.interval[2 * m + 1]))};
  }
  out.female = probability_at(uncertainty.sex_table,
                              static_cast<double>(c.target_mean[kSexTarget]) +
                                  static_cast<double>(c.target_scale[kSexTarget]) * targets[kSexTarget]);
}

}  // namespace im2fit::index
