// SPDX-License-Identifier: Apache-2.0
#include "person/garment_fit.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

namespace im2fit {

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
  SizeChoice choice(fit);
  for (const SizeRow& row : chart.rows) {
    SizeFit size;
    size.size = row.size;
    size.chest_mm = size_chest_mm(row);
    const auto finished = body::finished_girths(pattern, body::cut_body(regression, woman, size.chest_mm));
    choice.add(std::move(size), pattern.regions, finished, girths);
  }
  choice.choose();
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
    fits.push_back(fit_garment(pattern, wardrobe.regression, charts.cut_by(woman), woman, *girths));
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
