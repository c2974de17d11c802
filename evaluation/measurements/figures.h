// SPDX-License-Identifier: Apache-2.0
// The figures of an evaluation: the paper's, and ours. Each comes with a text that explains it.
#pragma once

#include <string>
#include <vector>

#include "evaluation/measurements/icp.h"
#include "evaluation/measurements/report.h"
#include "evaluation/measurements/runtime.h"
#include "report/svg_plot.h"

namespace im2fit::lab {

struct Figure {
  std::string id;       // file name and anchor
  std::string heading;  // the finding
  std::string words;    // how to read it, HTML
  Svg picture;
};

// Of one condition.
Figure distribution_figure(const ConditionRun& run);   // the paper's box plots of the measurements
Figure height_error_figure(const ConditionRun& run);   // the paper's height error by range of height
Figure sex_and_size_figure(const ConditionRun& run);   // the paper's counts
Figure agreement_figure(const ConditionRun& run);      // Bland-Altman, a panel a measurement
Figure bias_figure(const ConditionRun& run);           // ISO 20685
Figure repeatability_figure(const ConditionRun& run);  // TEM

// Of all; the first is the one the others are variations of.
Figure conditions_figure(const std::vector<ConditionRun>& runs);
Figure calibration_figure(const std::vector<ConditionRun>& runs);

Figure runtime_figure(const std::vector<RuntimeRow>& rows,
                      const std::vector<ReferenceLine>& references);  // the paper's
Figure icp_figure(const std::vector<IcpCurve>& curves);               // the paper's

// "chest girth"
std::string words_of(std::size_t measurement);

}  // namespace im2fit::lab
