// SPDX-License-Identifier: Apache-2.0
// Size charts (files of data/size-charts/, and a shop's own) and the probability of each size given what was measured
// and its intervals.
//
// A chart is CSV of the body's measurements, with header lines before the column names:
//
//   # name: EN 13402-3          the chart's id; charts of both sexes share it
//   # sex: men                  men | women | any
//   # unit: mm                  mm | cm | in; or the columns name it
//   # source: ...               where the figures come from
//   # date: 2004                and of when
//   size,low_mm,high_mm         of the chest
//   XS,780,860                  low <= girth < high; at most 128 sizes
//
// More columns: chest_low_cm, "Waist (in)", inseam, any measurement of the tape (docs/tape.md). A cell is a number or
// a range (86-94). One number a size means the size made for it. Without any header line, a chart has the name of its
// file and is for any sex, and its columns name the unit.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/status.h"
#include "index/index.h"
#include "person/size_fit.h"

namespace im2fit {

struct SizeRange {
  float low_mm = 0;
  float high_mm = 0;
};
struct SizeRow {
  std::string size;
  float low_mm = 0;  // of the chart's first measure
  float high_mm = 0;
  std::vector<SizeRange> more;  // of the others, in order
  SizeRange range(std::size_t measure) const { return measure == 0 ? SizeRange{low_mm, high_mm} : more[measure - 1]; }
};

enum class ChartSex { men, women, any };

struct SizeChart {
  std::string name;
  ChartSex sex = ChartSex::any;
  std::string source;
  std::string date;
  std::vector<std::string> measures;  // of the tape; at most 8; chest_girth, if the chart has it, is the first
  std::vector<SizeRow> rows;          // from small to large by the first measure, then by the next
  bool has_chest() const { return !measures.empty() && measures.front() == "chest_girth"; }
};

// `what` names the file in errors, which also name line and field.
Result<SizeChart> parse_size_chart(std::string_view text, const std::string& what);
Result<SizeChart> load_size_chart(const std::string& path);

// Charts for both sexes, which may be the same chart.
struct SizeSystem {
  SizeChart men;
  SizeChart women;
  // Garments are cut by the chest: the built-in chart, where this one does not have it.
  const SizeChart& cut_by(bool woman) const;
};
// One chart of sex `any`, or one of each sex with the same name.
Result<SizeSystem> make_size_system(std::vector<SizeChart> charts);
// EN 13402-3, compiled in from data/size-charts/.
const SizeSystem& builtin_size_system();

struct SizeAnswer {
  struct Entry {
    std::string size;  // as in the chart; "<XS" and ">3XL" for what lies outside it
    double probability = 0;
  };
  std::string chart;
  std::string best;
  std::vector<Entry> entries;  // from small to large; they sum to 1. Empty: nothing that the chart needs was measured
  // Of a chart by several measures, of the likelier sex: each size's distance from the body (ease: the middle of the
  // size less the body), and why the best is best.
  std::optional<GarmentFit> reason;
  std::vector<std::string> left_out;  // measures of the chart that this body has no value of
};

// A measurement of the tape, if the body has it.
using MeasureLookup = std::function<std::optional<index::IntervalEstimate>(std::string_view id)>;

// Errors are taken as normal with the interval as their 95 %. Both sexes' charts are mixed by `female` (0..1): a
// size's probability is that of the wearer taking that label, whichever rack they shop from. By one measure the
// probabilities are the normal distribution's; by several, shares of a thousand bodies within the errors, each taking
// the size that costs it least (fit_cost). Bit-exact on every machine.
SizeAnswer size_answer(const SizeSystem& system, const MeasureLookup& lookup, float female);
// SizeAnswer::reason in words for people.
std::string size_advice_words(const GarmentFit& reason);
// size_answer of charts by the chest.
SizeAnswer size_probabilities(const SizeSystem& system, const index::IntervalEstimate& chest_mm, float female);

// Standard normal distribution function by Abramowitz and Stegun 26.2.19: absolute error below 1.5e-7, from
// + - * / alone.
double normal_cdf(double x);

// The text of the charts compiled in, so that a device needs no files for them.
extern const char* const kBuiltinMenChart;
extern const char* const kBuiltinWomenChart;

}  // namespace im2fit
