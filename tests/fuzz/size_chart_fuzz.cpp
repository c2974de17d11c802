// SPDX-License-Identifier: Apache-2.0
// A size chart as a spreadsheet or anyone may write it: refused with one line, or a chart that answers.
#include <cmath>
#include <cstdint>
#include <string>

#include "person/size_chart.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace im2fit;
  const auto chart = parse_size_chart({reinterpret_cast<const char*>(data), size}, "chart.csv");
  if (!chart) {
    if (chart.error().message.empty()) __builtin_trap();
    return 0;
  }
  float low_mm = 0;
  for (const SizeRow& row : chart->rows) {
    if (row.size.empty() || row.size.size() > 30 || !(row.low_mm >= low_mm && row.high_mm > row.low_mm))
      __builtin_trap();
    low_mm = row.high_mm;
  }
  double sum = 0;
  for (const auto& entry : size_probabilities({*chart, *chart}, {1000, 950, 1050}, 0.5F).entries)
    sum += entry.probability;
  if (!(std::abs(sum - 1) < 1e-9)) __builtin_trap();
  return 0;
}
