// SPDX-License-Identifier: Apache-2.0
#include "index/answering.h"

#include <algorithm>
#include <cmath>

#include "kernels/standardise/standardise.h"

namespace im2fit::index {
namespace {

constexpr std::size_t kBodyNeighbours = 256;
constexpr double kBodySlopePenalty = 0.005;  // little: the body is to follow the measurements exactly

}  // namespace

Answerer::Answerer(const Contents& contents)
    : contents_(contents),
      regressor_(contents.ridge, contents.ridge_bias, contents.meta.feature_size),
      points_(contents.point_code, contents.grid_steps()),
      entries_(contents.entry_code, contents.grid_steps()) {}

Answerer::Workspace::Workspace(const Answerer& answerer)
    : standardised(answerer.regressor_.padded_size()), points(answerer.points_), entries(answerer.entries_) {}

Targets Answerer::regressed(std::span<const float> feature, Workspace& work) const {
  if (feature.size() == contents_.meta.feature_size)
    im2fit::standardise(feature.data(), contents_.feature_mean.data(), contents_.feature_scale.data(),
                        static_cast<int>(feature.size()), work.standardised.data());
  else
    std::fill(work.standardised.begin(), work.standardised.end(), std::int16_t{0});
  return regressor_(work.standardised);
}

Coordinates Answerer::key_of(const Targets& targets) const {
  const Contents& c = contents_;
  const int dimensions = static_cast<int>(c.meta.dimensions);
  return to_grid(project(targets, static_cast<int>(c.meta.target_count), c.projection, dimensions), dimensions,
                 c.meta.grid_unit);
}

Targets Answerer::corrected(const Targets& regressed, const QueryOptions& options, Workspace& work,
                            Targets& spread) const {
  const Contents& c = contents_;
  const int targets = static_cast<int>(c.meta.target_count);
  const int dimensions = static_cast<int>(c.meta.dimensions);
  Targets value = regressed;
  if (c.meta.quadratic != 0) {
    std::array<double, kQuadraticTermMax> buffer{};
    const auto terms = std::span(buffer).first(static_cast<std::size_t>(quadratic_term_count(dimensions)));
    quadratic_terms(project(regressed, targets, c.projection, dimensions), c.inverse_spread, dimensions, terms);
    const Targets correction = apply_quadratic(terms, c.quadratic, targets);
    for (int t = 0; t < targets; ++t) value[t] += correction[t];
  }
  const Coordinates grid = key_of(regressed);
  const int wanted = options.neighbour_count > 0 ? options.neighbour_count : static_cast<int>(c.meta.neighbour_count);
  const auto found = work.points.nearest(grid, static_cast<std::size_t>(std::min(wanted, kNeighbourMax)));
  fit_local(c.local_data(), grid, found,
            {static_cast<LocalMethod>(c.meta.local_method), c.meta.intercept_penalty, c.meta.slope_penalty},
            work.local);
  const LocalAnswer local = apply_local(work.local, c.local_data(), found);
  for (int t = 0; t < targets; ++t)
    if ((c.meta.local_targets >> t & 1U) != 0) value[t] += local.correction[t];
  spread = local.spread;
  return value;
}

Answer Answerer::answer(const Targets& regressed, const QueryOptions& options, Workspace& work) const {
  const Contents& c = contents_;
  Targets spread{};
  const Targets value = corrected(regressed, options, work, spread);
  Answer out;
  fill_estimates(value, spread, options.frame_count, out);
  const auto nearest = work.entries.nearest(key_of(value), 1);
  out.nearest = nearest[0].index;
  out.nearest_distance = static_cast<float>(std::sqrt(static_cast<double>(nearest[0].distance)) * c.meta.grid_unit);
  std::copy_n(c.entry_truth.begin() + static_cast<std::ptrdiff_t>(out.nearest * kMeasurementCount), kMeasurementCount,
              out.nearest_values.begin());
  return out;
}

void Answerer::body(const Targets& regressed, const QueryOptions& options, Workspace& work,
                    std::span<float> out) const {
  const Contents& c = contents_;
  Targets spread{};
  const Coordinates key = key_of(corrected(regressed, options, work, spread));
  const auto found = work.entries.nearest(key, kBodyNeighbours);
  LocalData data = {c.entry_code, c.grid_steps(), static_cast<int>(c.meta.dimensions), c.body, c.body_scale, 0, 0};
  fit_local(data, key, found, {LocalMethod::linear, 0, kBodySlopePenalty}, work.local);
  const auto row_size = static_cast<int>(c.meta.body_size);
  for (int first = 0; first < row_size; first += kTargetMax) {
    const int count = std::min(kTargetMax, row_size - first);
    const auto from = static_cast<std::size_t>(first);
    data.residuals = c.body.subspan(from);
    data.residual_scale = c.body_scale.subspan(from);
    data.target_count = count;
    data.row_size = row_size;
    const LocalAnswer local = apply_local(work.local, data, found);
    for (int t = 0; t < count; ++t)
      out[from + static_cast<std::size_t>(t)] = static_cast<float>(
          static_cast<double>(c.body_offset[from + static_cast<std::size_t>(t)]) + local.correction[t]);
  }
}

void Answerer::fill_estimates(const Targets& targets, const Targets& spread, int frame_count, Answer& out) const {
  const Contents& c = contents_;
  const double frames = static_cast<double>(std::max(frame_count, 1));
  const double frame_factor = std::sqrt(c.meta.frame_model + c.meta.frame_noise / frames);
  const bool local = c.meta.interval_kind == static_cast<std::uint32_t>(IntervalKind::local_spread);
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    const double unit = static_cast<double>(c.target_scale[m]);
    const double value = static_cast<double>(c.target_mean[m]) + unit * targets[m];
    const double floor = static_cast<double>(c.spread_floor[m]);
    const double width = unit * frame_factor * (local ? 0.5 * (floor + spread[m]) : floor);
    out.measurements[m] = {static_cast<float>(value),
                           static_cast<float>(value + width * static_cast<double>(c.interval[2 * m])),
                           static_cast<float>(value + width * static_cast<double>(c.interval[2 * m + 1]))};
  }
  out.female = female_probability(static_cast<double>(c.target_mean[kSexTarget]) +
                                  static_cast<double>(c.target_scale[kSexTarget]) * targets[kSexTarget]);
}

float Answerer::female_probability(double score) const {
  const double last = static_cast<double>(kSexTableSize - 1);
  const double place = std::clamp((score + kSexScoreMax) / (2 * kSexScoreMax) * last, 0.0, last);
  const auto cell = std::min(static_cast<std::size_t>(place), kSexTableSize - 2);
  const double part = place - static_cast<double>(cell);
  const auto low = static_cast<double>(contents_.sex_table[cell]);
  const auto high = static_cast<double>(contents_.sex_table[cell + 1]);
  return static_cast<float>(low + part * (high - low));
}

}  // namespace im2fit::index
