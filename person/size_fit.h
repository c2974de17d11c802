// SPDX-License-Identifier: Apache-2.0
// What a size costs a body, which size costs least, and why not its neighbour: of garments (garment_fit.h) and of
// size charts (size_chart.h).
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "garment/pattern.h"

namespace im2fit {

// tight: it binds; snug: closer than meant; good; loose: wider than meant.
enum class FitVerdict { tight, snug, good, loose };
std::string_view name_of(FitVerdict verdict);

struct RegionFit {
  float ease_mm = 0;              // finished girth less the body's
  float low_mm = 0, high_mm = 0;  // 95 % interval
  FitVerdict verdict = FitVerdict::good;
};
struct SizeFit {
  std::string size;
  float chest_mm = 0;              // it is cut for
  double cost = 0;                 // 0: as meant everywhere; comparable between sizes of one garment
  std::vector<RegionFit> regions;  // in the pattern's order
};
struct GarmentFit {
  std::string garment, chart;
  std::vector<std::string> region_ids;
  std::vector<SizeFit> sizes;  // from small to large
  std::size_t best = 0;
  std::size_t other = 0;         // the size that comes next: `best` lies between the two; `best`: there is none
  std::size_t other_region = 0;  // why not that one: where it costs most more than `best`
  bool none_fits = false;        // `best` is tight somewhere, or loose at every region
};

struct BodyGirth {
  float value_mm = 0, sd_mm = 0;
};

// The cost of a size grows with the square of the ease it lacks (more where it binds) and, less, of its excess ease.
// + - * / alone: the same advice on every machine.
double fit_cost(const body::FitRegion& region, double ease_mm);

// Adds one size after another, then chooses.
class SizeChoice {
 public:
  explicit SizeChoice(GarmentFit& fit) : fit_(fit) {}
  // `finished_mm`: a value a region. The cost is expected over the girths' errors, taken as normal.
  void add(SizeFit size, std::span<const body::FitRegion> regions, std::span<const float> finished_mm,
           std::span<const BodyGirth> girths);
  // The size that costs least, with the reason against its cheaper neighbour: sizes in a row.
  void choose();
  // The size at `best`, with the reason against the cheapest of all others: sizes that differ in several ways.
  void choose_among_all(std::size_t best);

 private:
  void give_reason();
  GarmentFit& fit_;
  std::vector<std::vector<double>> costs_;  // [size][region]
};

}  // namespace im2fit
