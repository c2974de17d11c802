// SPDX-License-Identifier: Apache-2.0
// What changes with the condition: errors beside other estimators', and whether intervals hold their nominal
// coverage.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "evaluation/measurements/figures.h"

namespace im2fit::lab {
namespace {

constexpr std::array<const char*, kEstimatorCount> kEstimatorColours = {kBlue, kSky, kOrange, kRed};

void draw_measurement(Svg& svg, const Frame& frame, const std::vector<ConditionRun>& runs, std::size_t m,
                      bool names) {
  double low = 1e9, high = 0;
  for (const ConditionRun& run : runs)
    for (const ErrorStatistics& s : run.report.measurements[m].errors) {
      if (s.count == 0 || s.mae <= 0) continue;
      low = std::min(low, s.mae);
      high = std::max(high, s.mae);
    }
  svg.text({frame.x, frame.y - 8}, fmt::format("{}, {}", words_of(m), kMeasurementTable[m].unit),
           {Lettering::Anchor::start, 12, kInk, true});
  if (high <= 0) return;
  // At least a decade, so that small differences appear small.
  low = std::min(low / 1.3, high / 10);
  const Panel panel(svg, frame, {low, 1.3 * high, "", true, 4}, {0, 1, "", false, 0});
  const double step = frame.height / static_cast<double>(runs.size());
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const Report& report = runs[i].report;
    const double y = frame.y + step * (static_cast<double>(i) + 0.5);
    svg.line({frame.x, y}, {frame.x + frame.width, y}, {kFaint, 0.8});
    if (names) svg.text({frame.x - 8, y + 4}, title_of(report), {Lettering::Anchor::end});
    for (std::size_t estimator = kEstimatorCount; estimator-- > 0;) {
      const ErrorStatistics& s = report.measurements[m].errors[estimator];
      if (s.count > 0)
        svg.disc(
            {panel.x(s.mae), y}, estimator == 0 ? 5 : 3.6, kEstimatorColours[estimator], 0.95,
            fmt::format("{}, {}, {}: {:.1f}", title_of(report), words_of(m), kEstimators[estimator].words, s.mae));
    }
  }
}

// Covered by nominal share, a line a measurement.
void draw_levels(Svg& svg, const Frame& frame, const ConditionRun& run) {
  constexpr double kLeast = 20;
  const Panel panel(svg, frame, {40, 100, "nominal coverage, %", false, 6}, {kLeast, 100, "coverage, %", false, 8});
  svg.line(panel.at(40, 40), panel.at(100, 100), {kInk, 1, "5 4"});
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    if (!run.report.measurements[m].judged()) continue;
    std::vector<SvgPoint> points;
    for (std::size_t i = 0; i < kLevels.size(); ++i)
      points.push_back(
          panel.at(100 * kLevels[i].share, std::max(kLeast, 100 * run.report.measurements[m].covered[i])));
    const bool girth = kMeasurementTable[m].id.ends_with("girth");
    const char* colour = girth ? kRed : m == measurement_index(Measurement::weight) ? kGreen : kBlue;
    svg.polyline(points, {colour, 1.3});
    for (std::size_t i = 0; i < kLevels.size(); ++i)
      svg.disc(points[i], 2.6, colour, 1,
               fmt::format("{}: {:.0f} % nominal, {:.1f} % covered", words_of(m), 100 * kLevels[i].share,
                           100 * run.report.measurements[m].covered[i]));
  }
  draw_legend(svg, {frame.x, frame.y - 12}, {{"lengths", kBlue}, {"girths", kRed}, {"weight", kGreen}});
}

// The stated 95 %, a row a condition, a dot a measurement.
void draw_coverage(Svg& svg, const Frame& frame, const std::vector<ConditionRun>& runs) {
  constexpr double kLowest = 60;
  const Panel panel(svg, frame, {kLowest, 100, "coverage of the 95 % interval, %", false, 8}, {0, 1, "", false, 0});
  svg.rectangle({panel.x(93), frame.y}, panel.x(97) - panel.x(93), frame.height, kGreen, 0.15);
  const double step = frame.height / static_cast<double>(runs.size());
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const double y = frame.y + step * (static_cast<double>(i) + 0.5);
    svg.text({frame.x - 8, y + 4}, title_of(runs[i].report), {Lettering::Anchor::end});
    svg.line({frame.x, y}, {frame.x + frame.width, y}, {kFaint, 0.8});
    if (runs[i].report.measured == 0) continue;
    for (std::size_t m = 0; m < kMeasurementCount; ++m) {
      if (!runs[i].report.measurements[m].judged()) continue;
      const double covered = 100 * runs[i].report.measurements[m].coverage();
      svg.disc({panel.x(std::max(kLowest, covered)), y}, 3.2,
               kMeasurementTable[m].id.ends_with("girth") ? kRed : kBlue, 0.6,
               fmt::format("{}, {}: {:.1f} %", title_of(runs[i].report), words_of(m), covered));
    }
    const double x = panel.x(std::max(kLowest, 100 * mean_coverage(runs[i].report)));
    svg.line({x, y - 7}, {x, y + 7}, {kInk, 2.4});
  }
}

}  // namespace

Figure conditions_figure(const std::vector<ConditionRun>& runs) {
  constexpr std::size_t kColumns = 3;
  const double high = 17 * static_cast<double>(runs.size()), step_y = high + 58;
  const double left = 170, wide = 220, step_x = 252;  // "clothed+both of modifiers" to the left
  Svg svg(930, 44 + step_y * std::ceil(static_cast<double>(kMeasurementCount) / kColumns),
          "Mean absolute error by condition");
  std::vector<LegendEntry> legend;
  for (std::size_t estimator = 0; estimator < kEstimatorCount; ++estimator)
    legend.push_back({std::string(kEstimators[estimator].words), kEstimatorColours[estimator]});
  draw_legend(svg, {left, 14}, legend);
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    const std::size_t column = m % kColumns, row = m / kColumns;
    draw_measurement(
        svg, {left + step_x * static_cast<double>(column), 52 + step_y * static_cast<double>(row), wide, high}, runs,
        m, m % kColumns == 0);
  }
  return {
      "conditions", "Mean absolute error by condition",
      "Left is better; the scale is logarithmic. Each row changes one thing of the first. The nearest entry is "
      "what our projection finds before regression; the raw nearest neighbour is the paper's answer from the same "
      "models; the paper's estimators are its joint sums and ellipses on the same frames.",
      std::move(svg)};
}

Figure calibration_figure(const std::vector<ConditionRun>& runs) {
  const double high = std::max(280.0, 24.0 * static_cast<double>(runs.size()));
  Svg svg(930, high + 84, "Calibration of intervals");
  draw_levels(svg, {56, 34, 300, high}, runs.front());
  const int people = runs.front().report.measured;
  draw_coverage(svg, {550, 34, 360, high}, runs);
  return {"calibration", "Coverage of the intervals",
          fmt::format(
              "Left, the first condition: the stated interval is one of 95 %; other shares read it as a normal's, as "
              "the probability of a size does. On the dashed line they hold their nominal coverage, below it they "
              "promise "
              "too much. Right: the stated 95 % by condition, a dot a measurement, the black mark their mean, green "
              "the goal. Of {0} people a true 95 % shows as 95 ± {1:.1f} %.",
              people, people > 0 ? 196 * std::sqrt(0.95 * 0.05 / people) : 100.0),
          std::move(svg)};
}

}  // namespace im2fit::lab
