// SPDX-License-Identifier: Apache-2.0
#include "person/size_fit.h"

#include <array>
#include <utility>

namespace im2fit {
namespace {

constexpr float kIntervalSds = 1.96F;  // half width of the 95 % interval, in standard deviations
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

// Over a normal error, by Gauss and Hermite's three points: exact for cubics.
double expected_cost(const body::FitRegion& region, double ease, double sd) {
  constexpr double kNode = 1.7320508075688772;  // sqrt(3)
  return fit_cost(region, ease) * (2.0 / 3) +
         (fit_cost(region, ease - kNode * sd) + fit_cost(region, ease + kNode * sd)) * (1.0 / 6);
}

}  // namespace

std::string_view name_of(FitVerdict verdict) {
  constexpr std::array<std::string_view, 4> kNames = {"tight", "snug", "good", "loose"};
  return kNames[static_cast<std::size_t>(verdict)];
}

double fit_cost(const body::FitRegion& region, double ease_mm) {
  const double low = region.good_low_mm, high = region.good_high_mm, tight = region.tight_mm;
  double cost = kOffMiddle * square((ease_mm - (low + high) / 2) / (high - low));
  if (ease_mm < low) cost += square((low - ease_mm) / kShortMm);
  if (ease_mm < tight) cost += square((tight - ease_mm) / kBindsMm);
  if (ease_mm > high) cost += square((ease_mm - high) / kWideMm);
  return cost;
}

void SizeChoice::add(SizeFit size, std::span<const body::FitRegion> regions, std::span<const float> finished_mm,
                     std::span<const BodyGirth> girths) {
  costs_.emplace_back();
  for (std::size_t r = 0; r < girths.size(); ++r) {
    RegionFit region;
    region.ease_mm = finished_mm[r] - girths[r].value_mm;
    region.low_mm = region.ease_mm - kIntervalSds * girths[r].sd_mm;
    region.high_mm = region.ease_mm + kIntervalSds * girths[r].sd_mm;
    region.verdict = verdict_of(regions[r], region.ease_mm);
    costs_.back().push_back(
        expected_cost(regions[r], static_cast<double>(region.ease_mm), static_cast<double>(girths[r].sd_mm)));
    size.cost += costs_.back().back();
    size.regions.push_back(region);
  }
  fit_.sizes.push_back(std::move(size));
}

void SizeChoice::choose() {
  GarmentFit& fit = fit_;
  if (fit.sizes.empty()) return;
  for (std::size_t i = 1; i < fit.sizes.size(); ++i)
    if (fit.sizes[i].cost < fit.sizes[fit.best].cost) fit.best = i;
  const bool has_smaller = fit.best > 0, has_larger = fit.best + 1 < fit.sizes.size();
  fit.other = fit.best;
  if (has_smaller) fit.other = fit.best - 1;
  if (has_larger && (!has_smaller || fit.sizes[fit.best + 1].cost < fit.sizes[fit.best - 1].cost))
    fit.other = fit.best + 1;
  give_reason();
}

void SizeChoice::choose_among_all(std::size_t best) {
  fit_.best = fit_.other = best;
  for (std::size_t i = 0; i < fit_.sizes.size(); ++i)
    if (i != best && (fit_.other == best || fit_.sizes[i].cost < fit_.sizes[fit_.other].cost)) fit_.other = i;
  give_reason();
}

void SizeChoice::give_reason() {
  GarmentFit& fit = fit_;
  double most = -1e300;
  for (std::size_t r = 0; r < costs_[fit.best].size(); ++r) {
    const double more = costs_[fit.other][r] - costs_[fit.best][r];
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
}

}  // namespace im2fit
