// SPDX-License-Identifier: Apache-2.0
#include "person/garment_fit.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <utility>

namespace im2fit {
namespace {

constexpr float kNormal95 = 1.96F;  // half width of the 95 % interval, in standard deviations
// What costs 1: so much less than meant, so much below what binds, so much more than meant. Loose clothes are worn,
// tight ones are brought back.
constexpr double kShortMm = 20, kBindsMm = 10, kWideMm = 40;
// Among sizes that all fit as designed, prefers the one nearest to the middle of the design range.
constexpr double kOffMiddle = 0.05;

FitVerdict verdict_of(const body::FitRegion& region, float ease) {
  if (ease < region.tight_mm) return FitVerdict::tight;
  if (ease < region.good_low_mm) return FitVerdict::snug;
  return ease > region.good_high_mm ? FitVerdict::loose : FitVerdict::good;
}

double square(double v) {
  return v * v;
}

double cost_of(const body::FitRegion& region, double ease) {
  const double low = region.good_low_mm, high = region.good_high_mm, tight = region.tight_mm;
  double cost = kOffMiddle * square((ease - (low + high) / 2) / (high - low));
  if (ease < low) cost += square((low - ease) / kShortMm);
  if (ease < tight) cost += square((tight - ease) / kBindsMm);
  if (ease > high) cost += square((ease - high) / kWideMm);
  return cost;
}

// Over a normal error, by Gauss and Hermite's three points: exact for cubics.
double expected_cost(const body::FitRegion& region, double ease, double sd) {
  constexpr double kNode = 1.7320508075688772;  // sqrt(3)
  return cost_of(region, ease) * (2.0 / 3) +
         (cost_of(region, ease - kNode * sd) + cost_of(region, ease + kNode * sd)) * (1.0 / 6);
}

}  // namespace

std::string_view name_of(FitVerdict verdict) {
  constexpr std::array<std::string_view, 4> kNames = {"tight", "snug", "good", "loose"};
  return kNames[static_cast<std::size_t>(verdict)];
}

float size_chest_mm(const SizeRow& row) {
  return (row.low_mm + row.high_mm) / 2;
}

GarmentFit fit_garment(const body::GarmentPattern& pattern, const body::CutRegression& regression,
                       const SizeChart& chart, bool woman, std::span<const BodyGirth> girths) {
  assert(girths.size() == pattern.regions.size());
  GarmentFit fit;
  fit.garment = pattern.id;
  fit.chart = chart.name;
  for (const body::FitRegion& region : pattern.regions) fit.region_ids.push_back(region.id);
  std::vector<std::vector<double>> costs;
  for (const SizeRow& row : chart.rows) {
    SizeFit size;
    size.size = row.size;
    size.chest_mm = size_chest_mm(row);
    const auto finished = body::finished_girths(pattern, body::cut_body(regression, woman, size.chest_mm));
    costs.emplace_back();
    for (std::size_t r = 0; r < girths.size(); ++r) {
      RegionFit region;
      region.ease_mm = finished[r] - girths[r].value_mm;
      region.low_mm = region.ease_mm - kNormal95 * girths[r].sd_mm;
      region.high_mm = region.ease_mm + kNormal95 * girths[r].sd_mm;
      region.verdict = verdict_of(pattern.regions[r], region.ease_mm);
      costs.back().push_back(expected_cost(pattern.regions[r], static_cast<double>(region.ease_mm),
                                           static_cast<double>(girths[r].sd_mm)));
      size.cost += costs.back().back();
      size.regions.push_back(region);
    }
    fit.sizes.push_back(std::move(size));
  }
  if (fit.sizes.empty()) return fit;
  for (std::size_t i = 1; i < fit.sizes.size(); ++i)
    if (fit.sizes[i].cost < fit.sizes[fit.best].cost) fit.best = i;
  const bool has_smaller = fit.best > 0, has_larger = fit.best + 1 < fit.sizes.size();
  fit.other = fit.best;
  if (has_smaller) fit.other = fit.best - 1;
  if (has_larger && (!has_smaller || fit.sizes[fit.best + 1].cost < fit.sizes[fit.best - 1].cost))
    fit.other = fit.best + 1;
  double most = -1e300;
  for (std::size_t r = 0; r < girths.size(); ++r) {
    const double more = costs[fit.other][r] - costs[fit.best][r];
    if (more <= most) continue;
    most = more;
    fit.other_region = r;
  }
  bool all_loose = true;
  for (const RegionFit& region : fit.sizes[fit.best].regions) {
    fit.none_fits = fit.none_fits || region.verdict == FitVerdict::tight;
    all_loose = all_loose && region.verdict == FitVerdict::loose;
  }
  fit.none_fits = fit.none_fits || all_loose;
  return fit;
}

std::string advice_words(const GarmentFit& fit) {
  if (fit.sizes.empty()) return "no size";
  const SizeFit &best = fit.sizes[fit.best], &other = fit.sizes[fit.other];
  std::string words = best.size;
  if (fit.none_fits) words += ", which is the nearest: no size fits";
  if (fit.other == fit.best) return words;
  const RegionFit& region = other.regions[fit.other_region];
  const std::string place = fit.region_ids[fit.other_region];
  words += "; then " + other.size + ", in which the " + place + " is " + std::string(name_of(region.verdict)) + " (" +
           std::to_string(static_cast<int>(std::lround(region.ease_mm))) + " mm of ease, " +
           std::to_string(static_cast<int>(std::lround(best.regions[fit.other_region].ease_mm))) + " in " +
           best.size + ")";
  return words;
}

Result<std::vector<BodyGirth>> girths_for(const body::GarmentPattern& pattern, const body::Tape& tape,
                                          std::span<const float> values, std::span<const TapeInterval> intervals) {
  constexpr float kSdsInInterval = 2 * 1.96F;  // 95 % of a normal distribution
  std::vector<BodyGirth> girths;
  for (const body::FitRegion& region : pattern.regions) {
    const int index = definition_index(tape, region.measure);
    if (index < 0)
      return Error{ErrorCode::invalid_argument, pattern.id + ": regions." + region.id + " names " + region.measure +
                                                    ", which is not a measurement of the tape"};
    const auto i = static_cast<std::size_t>(index);
    if (!(values[i] > 0)) return Error{ErrorCode::unsupported, region.measure + " is not measured on this body"};
    BodyGirth girth{values[i], 0};
    if (i < intervals.size() && intervals[i].known)
      girth.sd_mm = (intervals[i].high - intervals[i].low) / kSdsInInterval;
    girths.push_back(girth);
  }
  return girths;
}

std::vector<GarmentFit> fits_of(const Wardrobe& wardrobe, const SizeSystem& charts, float female,
                                const body::Tape& tape, std::span<const float> values,
                                std::span<const TapeInterval> intervals) {
  const bool woman = female > 0.5F;
  std::vector<GarmentFit> fits;
  for (const body::GarmentPattern& pattern : wardrobe.garments) {
    const auto girths = girths_for(pattern, tape, values, intervals);
    if (!girths) continue;
    fits.push_back(fit_garment(pattern, wardrobe.regression, woman ? charts.women : charts.men, woman, *girths));
  }
  return fits;
}

std::vector<Worn> everyday_clothes(const Wardrobe& wardrobe, std::span<const GarmentFit> fits) {
  std::vector<Worn> worn;
  for (const char* id : {"trousers", "t_shirt"})
    for (const GarmentFit& fit : fits)
      if (fit.garment == id && !fit.sizes.empty())
        worn.push_back({wardrobe.garment(id), fit.sizes[fit.best].chest_mm});
  return worn;
}

}  // namespace im2fit
