// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include <nlohmann/json.hpp>

#include "engine/report/text_table.h"
#include "lab/evaluation/section_study.h"

namespace im2fit::lab {
namespace {

constexpr std::array<const char*, 2> kSexes = {"women", "men"};

}  // namespace

std::string text_of(const SectionStudy& study) {
  std::vector<std::string> header = {"real people: bias / MAE, mm"};
  for (const char* sex : kSexes)
    for (const auto girth : kTrunkGirthNames) header.push_back(fmt::format("{} {}", sex, girth));
  TextTable table(header);
  for (std::size_t estimator = 0; estimator < kSectionEstimatorCount; ++estimator) {
    std::vector<std::string> row = {std::string(kSectionEstimatorNames[estimator])};
    for (const auto& sex : study.errors[estimator])
      for (const ErrorStatistics& s : sex)
        row.push_back(s.count > 0 ? number(s.bias, 1) + " / " + number(s.mae, 1) : "-");
    table.add(row);
  }
  const auto fitted = [&](const char* name, const auto& values) {
    std::vector<std::string> row = {name};
    for (const auto& sex : values)
      for (const double value : sex) row.push_back(number(value, 3));
    table.add(row);
  };
  fitted("factor of the ellipse", study.factor);
  fitted("exponent", study.exponent);
  return table.text();
}

std::string json_of(const SectionStudy& study, double noise_mm) {
  nlohmann::ordered_json json = {
      {"schema", "im2fit.sections/1"}, {"label", "real people, ANSUR II"}, {"noise_mm", noise_mm}};
  for (std::size_t s = 0; s < 2; ++s)
    for (std::size_t g = 0; g < kTrunkGirths; ++g) {
      auto& out = json[kSexes[s]][std::string(kTrunkGirthNames[g])];
      out = {{"factor", study.factor[s][g]}, {"exponent", study.exponent[s][g]}};
      for (std::size_t estimator = 0; estimator < kSectionEstimatorCount; ++estimator) {
        const ErrorStatistics& e = study.errors[estimator][s][g];
        if (e.count > 0)
          out["estimators"][std::string(kSectionEstimatorNames[estimator])] = {
              {"people", e.count}, {"bias", e.bias}, {"mae", e.mae}, {"sd", e.sd}, {"p95", e.p95}};
      }
    }
  return json.dump(1) + "\n";
}

Svg picture_of(const SectionStudy& study) {
  constexpr double kWide = 210, kStepX = 240, kLeft = 180, kStepY = 22, kHigh = kStepY * kSectionEstimatorCount;
  Svg svg(kLeft + 3 * kStepX + 10, 2 * (kHigh + 92), "Girth from breadth and depth on real people");
  for (std::size_t s = 0; s < 2; ++s)
    for (std::size_t g = 0; g < kTrunkGirths; ++g) {
      const double x = kLeft + kStepX * static_cast<double>(g), y = 34 + (kHigh + 88) * static_cast<double>(s);
      svg.text({x, y - 8}, fmt::format("{}, {}", kSexes[s], kTrunkGirthNames[g]),
               {Lettering::Anchor::start, 12, kInk, true});
      const Panel panel(svg, {x, y, kWide, kHigh}, {10, 300, g == 1 ? "mean absolute error, mm" : "", true, 5},
                        {0, 1, "", false, 0});
      for (std::size_t estimator = 0; estimator < kSectionEstimatorCount; ++estimator) {
        const double row = y + kStepY * (static_cast<double>(estimator) + 0.5);
        const ErrorStatistics& e = study.errors[estimator][s][g];
        if (g == 0) svg.text({kLeft - 8, row + 4}, kSectionEstimatorNames[estimator], {Lettering::Anchor::end});
        svg.line({x, row}, {x + kWide, row}, {kFaint, 0.8});
        if (e.count == 0) continue;
        const char* colour = estimator == 0                                                       ? kRed
                             : estimator == static_cast<std::size_t>(SectionEstimator::synthetic) ? kOrange
                                                                                                  : kBlue;
        svg.disc({panel.x(std::max(10.0, e.mae)), row}, 5, colour, 1,
                 fmt::format("{}: bias {:+.1f}, MAE {:.1f} mm", kSectionEstimatorNames[estimator], e.bias, e.mae));
        const bool right = panel.x(e.mae) > x + kWide - 40;
        svg.text({panel.x(e.mae) + (right ? -9 : 9), row + 4}, fmt::format("{:.1f}", e.mae),
                 {right ? Lettering::Anchor::end : Lettering::Anchor::start, 11, kGrey});
      }
    }
  return svg;
}

}  // namespace im2fit::lab
