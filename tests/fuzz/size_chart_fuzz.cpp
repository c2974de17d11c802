// SPDX-License-Identifier: Apache-2.0
// A size chart as a spreadsheet or anyone may write it: refused with one line, or a chart that answers.
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "person/size_chart.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace im2fit;
  const auto chart = parse_size_chart({reinterpret_cast<const char*>(data), size}, "chart.csv");
  if (!chart) {
    if (chart.error().message.empty()) __builtin_trap();
    return 0;
  }
  if (chart->measures.empty() || chart->measures.size() > 8) __builtin_trap();
  for (const SizeRow& row : chart->rows) {
    if (row.size.empty() || row.size.size() > 30 || row.more.size() + 1 != chart->measures.size()) __builtin_trap();
    for (std::size_t m = 0; m < chart->measures.size(); ++m)
      if (!(row.range(m).high_mm > row.range(m).low_mm)) __builtin_trap();
  }
  const auto lookup = [&](std::string_view id) {
    return id == "stature" ? std::optional<index::IntervalEstimate>() : index::IntervalEstimate{1000, 950, 1050};
  };
  const SizeAnswer answer = size_answer({*chart, *chart}, lookup, 0.5F);
  double sum = 0;
  for (const auto& entry : answer.entries) sum += entry.probability;
  if (!answer.entries.empty() && !(std::abs(sum - 1) < 1e-9)) __builtin_trap();
  if (answer.reason && size_advice_words(*answer.reason).empty()) __builtin_trap();
  return 0;
}
