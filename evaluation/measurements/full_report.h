// SPDX-License-Identifier: Apache-2.0
// An evaluation with everything beside it: as one page to read, as JSON, as files of figures.
#pragma once

#include <string>
#include <vector>

#include "evaluation/measurements/figures.h"

namespace im2fit::lab {

struct FullReport {
  std::string provenance;          // seed, people, index: one line
  std::vector<ConditionRun> runs;  // at least one; the others are variations of the first
  std::vector<RuntimeRow> runtime;
  std::vector<ReferenceLine> references;
  std::vector<IcpCurve> icp;
};

// Those there are data for, in the order of the page.
std::vector<Figure> figures_of(const FullReport& report);

// One HTML file that needs no network: styles and pictures inside, no scripts.
std::string html_of(const FullReport& report);

// im2fit.evaluation-set/1: `conditions` as im2fit.evaluation/1 each, `runtime`, `icp`.
std::string json_of(const FullReport& report);

}  // namespace im2fit::lab
