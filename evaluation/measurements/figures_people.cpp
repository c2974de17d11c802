// SPDX-License-Identifier: Apache-2.0
// The paper's figures of people: measurements, height error, sex and size.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "evaluation/measurements/figures.h"
#include "evaluation/measurements/paper_says.h"

namespace im2fit::lab {
namespace {

constexpr std::size_t kStature = measurement_index(Measurement::stature);
constexpr std::size_t kWeight = measurement_index(Measurement::weight);

std::vector<double> of_measured(const ConditionRun& run, const auto& value) {
  std::vector<double> values;
  for (const Outcome& o : run.outcomes)
    if (o.measured) values.push_back(value(o));
  return values;
}

std::string spread_words(const BoxStatistics& box, double scale) {
  return fmt::format("median {:.1f}, half within {:.1f} to {:.1f}", box.median * scale, box.quartile_1 * scale,
                     box.quartile_3 * scale);
}

std::string person_words(const Outcome& o) {
  return fmt::format("{}, {:.0f} mm: {:+.1f} mm", o.woman ? "woman" : "man", o.truth[kStature],
                     o.answer.measurements[kStature].value - o.truth[kStature]);
}

// Tukey's box upright about the pixel column `x_px`, values by the panel's y.
void draw_box(Svg& svg, const Panel& panel, double x_px, double width_px, const BoxStatistics& box,
              const char* colour, std::string_view hover) {
  if (box.count == 0) return;
  const double half = width_px / 2;
  svg.line({x_px, panel.y(box.low)}, {x_px, panel.y(box.quartile_1)}, {colour, 1.2});
  svg.line({x_px, panel.y(box.quartile_3)}, {x_px, panel.y(box.high)}, {colour, 1.2});
  for (const double end : {box.low, box.high})
    svg.line({x_px - half / 2, panel.y(end)}, {x_px + half / 2, panel.y(end)}, {colour, 1.2});
  const double top = panel.y(box.quartile_3);
  svg.rectangle({x_px - half, top}, width_px, panel.y(box.quartile_1) - top, colour, 0.35, hover);
  svg.line({x_px - half, panel.y(box.median)}, {x_px + half, panel.y(box.median)}, {colour, 2.4});
  for (const double value : box.outliers) svg.disc({x_px, panel.y(value)}, 1.8, colour, 0.7);
}

// Bars of shares, one under the other.
struct Bar {
  std::string words;
  double share;
  const char* colour;
};
void draw_bars(Svg& svg, const Frame& frame, const std::vector<Bar>& bars) {
  constexpr double kHigh = 20, kStep = 32;
  double y = frame.y;
  for (const Bar& bar : bars) {
    svg.rectangle({frame.x, y}, frame.width, kHigh, kFaint);
    svg.rectangle({frame.x, y}, frame.width * bar.share, kHigh, bar.colour);
    svg.text({frame.x - 8, y + 14}, bar.words, {Lettering::Anchor::end});
    svg.text({frame.x + frame.width + 8, y + 14}, fmt::format("{:.1f} %", 100 * bar.share),
             {Lettering::Anchor::start, 12, kInk, true});
    y += kStep;
  }
}

}  // namespace

std::string words_of(std::size_t measurement) {
  std::string words(kMeasurementTable[measurement].id);
  std::replace(words.begin(), words.end(), '_', ' ');
  return words;
}

Figure distribution_figure(const ConditionRun& run) {
  Svg svg(920, 400, "Distribution of measurements, measured and true");
  const Panel panel(svg, {60, 34, 840, 290}, {0, kWeight, "", false, 0}, {0, 220, "cm", false, 8});
  for (std::size_t m = 0; m < kWeight; ++m) {
    const double middle = panel.x(static_cast<double>(m) + 0.5);
    const auto measured =
        box_statistics(of_measured(run, [&](const Outcome& o) { return value_of(o, Estimator::ours, m) / 10; }));
    const auto truth = box_statistics(of_measured(run, [&](const Outcome& o) { return o.truth[m] / 10.0; }));
    draw_box(svg, panel, middle - 15, 24, measured, kBlue,
             words_of(m) + ", measured, cm: " + spread_words(measured, 1));
    draw_box(svg, panel, middle + 15, 24, truth, kGrey, words_of(m) + ", true, cm: " + spread_words(truth, 1));
    const std::string words = words_of(m);
    const std::size_t gap = std::min(words.find(' '), words.size());
    svg.text({middle, 345}, words.substr(0, gap), {Lettering::Anchor::middle});
    if (gap < words.size()) svg.text({middle, 360}, words.substr(gap + 1), {Lettering::Anchor::middle});
  }
  draw_legend(svg, {60, 18}, {{"measured", kBlue}, {"true", kGrey}});
  return {"distribution", "Distribution of the measurements",
          fmt::format(
              "The paper's figure of estimated anthropometrics: boxes hold the middle half, whiskers reach 1.5 "
              "boxes, dots lie beyond. {} people measured; beside each box is the box of the truth, which the paper "
              "did not have.",
              run.report.measured),
          std::move(svg)};
}

Figure height_error_figure(const ConditionRun& run) {
  constexpr double kBin = 50;
  std::vector<double> errors =
      of_measured(run, [](const Outcome& o) { return value_of(o, Estimator::ours, kStature) - o.truth[kStature]; });
  double reach = 1.3 * kPaperStatureMaeMm, low = 1500, high = 1900;
  for (const double e : errors) reach = std::max(reach, 1.1 * std::abs(e));
  for (const Outcome& o : run.outcomes) {
    if (!o.measured) continue;
    low = std::min(low, kBin * std::floor(static_cast<double>(o.truth[kStature]) / kBin));
    high = std::max(high, kBin * std::ceil(static_cast<double>(o.truth[kStature]) / kBin));
  }
  Svg svg(920, 380, "Height error by range of height");
  const Panel panel(svg, {60, 20, 840, 300}, {low, high, "true stature, mm", false, 10},
                    {-reach, reach, "error, mm", false, 8});
  svg.line(panel.at(low, 0), panel.at(high, 0), {kInk, 1});
  for (const double sign : {-1.0, 1.0})
    svg.line(panel.at(low, sign * kPaperStatureMaeMm), panel.at(high, sign * kPaperStatureMaeMm), {kRed, 1.2, "6 4"});
  svg.text({panel.x(high) - 4, panel.y(kPaperStatureMaeMm) - 6}, "mean error of the paper, 83 real people: 18.7 mm",
           {Lettering::Anchor::end, 12, kRed});
  const int bins = static_cast<int>(std::lround((high - low) / kBin));
  for (int bin = 0; bin < bins; ++bin) {
    const double from = low + kBin * bin;
    std::vector<double> here;
    for (const Outcome& o : run.outcomes) {
      const double stature = o.truth[kStature];
      if (!o.measured || stature < from || stature >= from + kBin) continue;
      const double error = value_of(o, Estimator::ours, kStature) - stature;
      here.push_back(error);
      svg.disc(panel.at(stature, error), 2.4, o.woman ? kPink : kSky, 0.8, person_words(o));
    }
    // A box of fewer shows less than its dots.
    if (here.size() < 5) continue;
    const auto box = box_statistics(here);
    draw_box(svg, panel, panel.x(from + kBin / 2), 0.45 * (panel.x(from + kBin) - panel.x(from)), box, kBlue,
             fmt::format("{:.0f} to {:.0f} mm, {} people: {}", from, from + kBin, box.count, spread_words(box, 1)));
  }
  draw_legend(svg, {60, 372}, {{"women", kPink}, {"men", kSky}, {"box of each 50 mm", kBlue}});
  const ErrorStatistics& s = run.report.measurements[kStature].of(Estimator::ours);
  return {
      "height-error", fmt::format("Height is off by {:.1f} mm on average", s.mae),
      fmt::format("The paper's height estimation error by height range. Bias {:+.1f} mm, SD {:.1f} mm, 95 % within "
                  "{:.1f} mm. A dot is a person: point at it.",
                  s.bias, s.sd, s.p95),
      std::move(svg)};
}

Figure sex_and_size_figure(const ConditionRun& run) {
  const Report& r = run.report;
  std::vector<Bar> bars = {{"sex right, ours", r.sex_accuracy, kBlue}};
  if (r.has_raw()) bars.push_back({"raw nearest neighbour", r.raw_sex_accuracy, kOrange});
  bars.push_back({"paper, 83 real people", kPaperSexRight, kRed});
  bars.push_back({"size right outright, ours", r.size_accuracy, kBlue});
  bars.push_back({"among our two most probable", r.size_top_two, kSky});
  bars.push_back({"paper, real people", kPaperSizeRight, kRed});
  Svg svg(920, 40 + 32 * static_cast<double>(bars.size()), "Sex and size accuracy");
  draw_bars(svg, {190, 24, 250, 0}, bars);
  const int most = std::max(1, *std::max_element(r.size_steps.begin(), r.size_steps.end()));
  const double high = 32 * static_cast<double>(bars.size()) - 50;
  svg.text({740, 22}, "letter size, labels off", {Lettering::Anchor::middle, 12, kInk, true});
  for (int step = -kSizeStepMost; step <= kSizeStepMost; ++step) {
    const int people = r.size_steps[static_cast<std::size_t>(step + kSizeStepMost)];
    const double x = 740 + 62 * step, top = high * people / most;
    svg.rectangle({x - 24, 46 + high - top}, 48, top, step == 0 ? kBlue : kSky, 1, fmt::format("{} people", people));
    svg.text({x, 41 + high - top}, fmt::format("{}", people), {Lettering::Anchor::middle, 11, kGrey});
    const char* beyond = std::abs(step) == kSizeStepMost ? (step < 0 ? " or less" : " or more") : "";
    svg.text({x, 62 + high}, step == 0 ? "right" : fmt::format("{:+d}{}", step, beyond), {Lettering::Anchor::middle});
  }
  return {"sex-and-size",
          fmt::format("Sex {:.1f} % right, letter size {:.1f} %", 100 * r.sex_accuracy, 100 * r.size_accuracy),
          "The paper got the sex of all 83 people and 87.5 % of their T-shirt sizes right. Ours are synthetic people "
          "and the "
          "chart of EN 13402-3; at the right, by the chest alone, how many labels too small or too large.",
          std::move(svg)};
}

}  // namespace im2fit::lab
