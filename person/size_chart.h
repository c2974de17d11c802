// SPDX-License-Identifier: Apache-2.0
// Size charts (files of data/size-charts/) and the probability of each size given a chest girth and its interval.
//
// A chart is CSV by chest (bust) girth of the body, with header lines before the column names:
//
//   # name: EN 13402-3          the chart's id; charts of both sexes share it
//   # sex: men                  men | women | any
//   # unit: mm
//   # source: ...               where the figures come from
//   # date: 2004                and of when
//   size,low_mm,high_mm
//   XS,780,860                  low <= girth < high; rows ascending without overlap; at most 32
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/status.h"
#include "index/index.h"

namespace im2fit {

struct SizeRow {
  std::string size;
  float low_mm = 0;
  float high_mm = 0;
};

enum class ChartSex { men, women, any };

struct SizeChart {
  std::string name;
  ChartSex sex = ChartSex::any;
  std::string source;
  std::string date;
  std::vector<SizeRow> rows;
};

// `what` names the file in errors, which also name line and field.
Result<SizeChart> parse_size_chart(std::string_view text, const std::string& what);
Result<SizeChart> load_size_chart(const std::string& path);

// Charts for both sexes, which may be the same chart.
struct SizeSystem {
  SizeChart men;
  SizeChart women;
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
  std::vector<Entry> entries;  // from small to large; they sum to 1
};

// The chest's error is taken as normal with the interval as its 95 %. Both sexes' charts are mixed by `female`
// (0..1): a size's probability is that of the wearer taking that label, whichever rack they shop from. Bit-exact on
// every machine.
SizeAnswer size_probabilities(const SizeSystem& system, const index::IntervalEstimate& chest_mm, float female);

// Standard normal distribution function by Abramowitz and Stegun 26.2.19: absolute error below 1.5e-7, from
// + - * / alone.
double normal_cdf(double x);

// The text of the charts compiled in, so that a device needs no files for them.
extern const char* const kBuiltinMenChart;
extern const char* const kBuiltinWomenChart;

}  // namespace im2fit
