// SPDX-License-Identifier: Apache-2.0
// What was measured, for machines and for people.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bench/index/measure.h"

namespace im2fit::bench {

struct Measured {
  std::string origin, processor;
  std::size_t models_real = 0, queries = 0, feature_size = 0;
  double seconds = 0, memory_peak_gb = 0;
  std::vector<Row> rows;
  std::vector<Row> searches;  // without errors
};

struct Target {
  std::string what, target, measured;
  std::optional<bool> met;  // none: was not measured
};
std::vector<Target> targets_of(const Measured& all);

std::string json_of(const Measured& all);
std::string markdown_of(const Measured& all, const std::string& plot_file);
std::string plot_of(const Measured& all);  // SVG

}  // namespace im2fit::bench
