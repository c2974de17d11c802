// SPDX-License-Identifier: Apache-2.0
// How two methods of measuring agree: Bland-Altman, the bias of ISO 20685, repeatability.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "evaluation/measurements/figures.h"

namespace im2fit::lab {
namespace {

void draw_agreement(Svg& svg, const Frame& frame, const ConditionRun& run, std::size_t m) {
  const Agreement& a = run.report.measurements[m].agreement;
  double low = 1e9, high = -1e9, reach = 1e-6;
  for (const Outcome& o : run.outcomes) {
    if (!o.measured || !std::isfinite(o.truth[m])) continue;
    const double value = value_of(o, Estimator::ours, m), truth = o.truth[m];
    low = std::min(low, (value + truth) / 2);
    high = std::max(high, (value + truth) / 2);
    reach = std::max(reach, 1.15 * std::abs(value - truth));
  }
  svg.text({frame.x, frame.y - 8}, fmt::format("{}, {}", words_of(m), kMeasurementTable[m].unit),
           {Lettering::Anchor::start, 12, kInk, true});
  if (a.count == 0) return;
  const double margin = 0.03 * (high - low) + 1e-6;
  const Panel panel(svg, frame, {low - margin, high + margin, "", false, 4}, {-reach, reach, "", false, 4});
  svg.rectangle(panel.at(low - margin, a.high), frame.width, panel.y(a.low) - panel.y(a.high), kBlue, 0.08);
  svg.line(panel.at(low - margin, 0), panel.at(high + margin, 0), {kInk, 0.8});
  svg.line(panel.at(low - margin, a.bias), panel.at(high + margin, a.bias), {kBlue, 1.6});
  for (const double limit : {a.low, a.high})
    svg.line(panel.at(low - margin, limit), panel.at(high + margin, limit), {kBlue, 1, "5 4"});
  for (const Outcome& o : run.outcomes) {
    if (!o.measured || !std::isfinite(o.truth[m])) continue;
    const double value = value_of(o, Estimator::ours, m), truth = o.truth[m];
    svg.disc(panel.at((value + truth) / 2, value - truth), 2, o.woman ? kPink : kSky, 0.85,
             fmt::format("{}: measured {:.1f}, true {:.1f}", o.woman ? "woman" : "man", value, truth));
  }
  svg.text({frame.x + frame.width, frame.y - 8}, fmt::format("{:+.1f} ({:+.1f} to {:+.1f})", a.bias, a.low, a.high),
           {Lettering::Anchor::end, 11, kGrey});
}

}  // namespace

Figure agreement_figure(const ConditionRun& run) {
  constexpr std::size_t kColumns = 3;
  constexpr double kWide = 270, kHigh = 120, kStepX = 310, kStepY = 178;
  Svg svg(930, 40 + kStepY * std::ceil(static_cast<double>(kMeasurementCount) / kColumns), "Bland-Altman plots");
  draw_legend(svg, {38, 14}, {{"women", kPink}, {"men", kSky}, {"bias and limits of agreement", kBlue}});
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    const std::size_t column = m % kColumns, row = m / kColumns;
    draw_agreement(svg,
                   {38 + kStepX * static_cast<double>(column), 54 + kStepY * static_cast<double>(row), kWide, kHigh},
                   run, m);
  }
  return {
      "bland-altman", "Errors against the truth",
      "Bland and Altman's plot: error (upright) against the mean of measured and true. The band holds 95 % of the "
      "errors if they are normal; a slope means that errors of large people differ from those of small ones.",
      std::move(svg)};
}

Figure bias_figure(const ConditionRun& run) {
  constexpr double kStep = 26;
  std::vector<std::size_t> limited;
  double reach = 1.5;
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    const double limit = iso_20685_limit_mm(static_cast<Measurement>(m));
    if (limit <= 0 || !run.report.measurements[m].judged()) continue;
    limited.push_back(m);
    const ErrorStatistics& s = run.report.measurements[m].of(Estimator::ours);
    reach = std::max({reach, 1.1 * std::abs(s.mean_low) / limit, 1.1 * std::abs(s.mean_high) / limit});
  }
  const double high = kStep * static_cast<double>(limited.size());
  Svg svg(920, high + 74, "Bias against the limits of ISO 20685");
  const Panel panel(svg, {170, 20, 560, high}, {-reach, reach, "bias, in limits of ISO 20685", false, 6},
                    {0, 1, "", false, 0});
  svg.rectangle({panel.x(-1), 20}, panel.x(1) - panel.x(-1), high, kGreen, 0.12);
  svg.line({panel.x(0), 20}, {panel.x(0), 20 + high}, {kInk, 0.8});
  int inside = 0;
  for (std::size_t i = 0; i < limited.size(); ++i) {
    const std::size_t m = limited[i];
    const double limit = iso_20685_limit_mm(static_cast<Measurement>(m));
    const ErrorStatistics& s = run.report.measurements[m].of(Estimator::ours);
    const bool good = within_iso_20685(s, static_cast<Measurement>(m));
    inside += good ? 1 : 0;
    const double y = 20 + kStep * (static_cast<double>(i) + 0.5);
    const char* colour = good ? kGreen : kRed;
    svg.text({162, y + 4}, words_of(m), {Lettering::Anchor::end});
    svg.line({panel.x(s.mean_low / limit), y}, {panel.x(s.mean_high / limit), y}, {colour, 4});
    svg.disc({panel.x(s.bias / limit), y}, 4.5, colour);
    svg.text({744, y + 4}, fmt::format("{:.1f} to {:.1f} mm of {:.0f}", s.mean_low, s.mean_high, limit),
             {Lettering::Anchor::start, 12, colour});
  }
  return {"bias", fmt::format("{} of {} biases within ISO 20685's limits", inside, limited.size()),
          "The standard for body scanners limits the mean error: its 95 % interval (bar) must lie within the limit "
          "(green). Reported, not claimed: it requires real people and a tape.",
          std::move(svg)};
}

Figure repeatability_figure(const ConditionRun& run) {
  constexpr double kStep = 26, kGirthGoal = 5, kStatureGoal = 3;
  const double high = kStep * kMeasurementCount;
  double most = 6;
  for (const auto& r : run.report.measurements) most = std::max(most, 1.1 * r.repeatability.tem);
  Svg svg(920, high + 74, "Repeatability");
  const Panel panel(svg, {170, 20, 520, high}, {0, most, "TEM, mm (weight: kg)", false, 6}, {0, 1, "", false, 0});
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    const Repeatability& r = run.report.measurements[m].repeatability;
    const std::string words = words_of(m);
    const double goal = m == measurement_index(Measurement::stature) ? kStatureGoal
                        : words.ends_with("girth")                   ? kGirthGoal
                                                                     : 0;
    const double y = 20 + kStep * static_cast<double>(m);
    svg.text({162, y + 17}, words, {Lettering::Anchor::end});
    svg.rectangle({170, y + 5}, panel.x(r.tem) - 170, 16, goal > 0 && r.tem > goal ? kOrange : kBlue);
    if (goal > 0) svg.line({panel.x(goal), y + 2}, {panel.x(goal), y + 24}, {kInk, 2});
    svg.text({700, y + 17}, fmt::format("{:.1f} {}, {:.1f} %, R {:.3f}", r.tem, kMeasurementTable[m].unit, r.percent,
                                        r.reliability));
  }
  return {
      "repeatability", "The same person, measured twice",
      fmt::format("{} people shown a second time in a new pose, room and noise. TEM = √(Σd² / 2n); black marks are "
                  "the goals (girths 5 mm, stature 3 mm); R = 1 − TEM² / SD², 0.95 is good.",
                  run.report.measurements[0].repeatability.pairs),
      std::move(svg)};
}

}  // namespace im2fit::lab
