// SPDX-License-Identifier: Apache-2.0
// The paper's figures of the machine: runtime against models, error against ICP iterations.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "evaluation/measurements/figures.h"
#include "evaluation/measurements/paper_says.h"

namespace im2fit::lab {
namespace {

struct Series {
  std::string words;
  const char* colour;
  const char* dash;
  std::vector<SvgPoint> values;  // models, ms
};

std::vector<Series> series_of(const std::vector<RuntimeRow>& rows, const std::vector<ReferenceLine>& references) {
  std::vector<Series> all = {{"clothed body", kPink, "", {}},
                             {"naked body", kGreen, "", {}},
                             {"measurements only", kSky, "", {}},
                             {"the query in it", kBlue, "", {}}};
  for (const RuntimeRow& row : rows) {
    const auto models = static_cast<double>(row.models);
    if (row.clothed_ms > 0) all[0].values.push_back({models, row.clothed_ms});
    if (row.naked_ms > 0) all[1].values.push_back({models, row.naked_ms});
    all[2].values.push_back({models, row.measurements_ms});
    all[3].values.push_back({models, row.query_p50_ms});
  }
  for (const ReferenceLine& reference : references) {
    const bool ours = reference.name == "im2fit";
    Series line{ours ? "query, bench/index" : reference.name + ", bench/index", ours ? kBlue : kOrange, "5 4", {}};
    for (const auto& point : reference.points) line.values.push_back({point.models, point.p50_ms});
    all.push_back(std::move(line));
  }
  std::erase_if(all, [](const Series& s) { return s.values.empty(); });
  return all;
}

}  // namespace

Figure runtime_figure(const std::vector<RuntimeRow>& rows, const std::vector<ReferenceLine>& references) {
  const std::vector<Series> all = series_of(rows, references);
  Svg svg(930, 420, "Runtime against the number of models");
  const Panel panel(svg, {70, 24, 600, 330}, {100, 1e7, "models", true, 5}, {1e-3, 2e3, "ms, one thread", true, 5});
  std::vector<LineEnd> ends;
  for (const Series& s : all) {
    std::vector<SvgPoint> points;
    for (const auto& [models, ms] : s.values) points.push_back(panel.at(models, ms));
    svg.polyline(points, {s.colour, 2, s.dash});
    ends.push_back({points.back(), s.words, s.colour});
    for (std::size_t i = 0; i < points.size(); ++i)
      svg.disc(points[i], 3, s.colour, 1,
               fmt::format("{}: {} models, {:.3g} ms", s.words, tick_label(s.values[i].first), s.values[i].second));
  }
  name_line_ends(svg, ends, 690, 24, 354);
  for (const auto& [models, ms, words] :
       {std::tuple{kPaperModels, kPaperQueryMs, "paper: 50,000 models, 800 ms"},
        std::tuple{kPaperModelsMost, kPaperQueryMostMs, "paper: 5,000,000 models, < 500 ms"}}) {
    svg.disc(panel.at(models, ms), 5, kRed, 1, words);
    svg.text({panel.x(models), panel.y(ms) + 18}, words, {Lettering::Anchor::middle, 11, kRed});
  }
  return {
      "runtime", "Time to a result",
      "The paper's runtime figure. Measurements only: features of the fused frames and the query; naked and clothed: "
      "also the body fitted to the result, posed, and written as .glb. Processor time of one thread on the machine "
      "that made this page; frames before fusion are not included (bench/results has those). Dashed lines come from "
      "the "
      "benchmark of the index, if its file was given. The paper's figures are of a Xeon E5507 of 2009.",
      std::move(svg)};
}

Figure icp_figure(const std::vector<IcpCurve>& curves) {
  double most = 1.2 * kPaperIcpMm, least = 2;
  std::size_t iterations = 2;
  std::vector<std::pair<std::string, std::vector<const IcpCurve*>>> by_method;  // as they come, ours first
  for (const IcpCurve& c : curves) {
    if (c.error_mm.empty()) continue;
    auto same = std::find_if(by_method.begin(), by_method.end(), [&](const auto& m) { return m.first == c.method; });
    if (same == by_method.end()) same = by_method.insert(same, {c.method, {}});
    same->second.push_back(&c);
    most = std::max(most, 1.1 * *std::max_element(c.error_mm.begin(), c.error_mm.end()));
    least = std::min(least, std::max(0.01, 0.8 * *std::min_element(c.error_mm.begin(), c.error_mm.end())));
    iterations = std::max(iterations, c.error_mm.size());
  }
  Svg svg(930, 400, "Mean registration error by ICP iteration");
  const auto last = static_cast<double>(iterations - 1);
  const Panel panel(svg, {60, 24, 620, 310}, {0, last, "iteration", false, static_cast<int>(iterations)},
                    {least, most, "mean distance to the body, mm", true, 6});
  svg.line(panel.at(kPaperIcpIterations, kPaperIcpMm), panel.at(last, kPaperIcpMm), {kRed, 1.6, "6 4"});
  svg.text({panel.x(last), panel.y(kPaperIcpMm) - 6}, "paper, 4 real people: below 90 mm after 6 iterations",
           {Lettering::Anchor::end, 12, kRed});
  constexpr std::array<const char*, 4> kColours = {kBlue, kOrange, kGreen, kPink};
  std::size_t method = 0;
  double y = 40;
  std::string ends;
  for (const auto& [name, its] : by_method) {
    const char* colour = kColours[method++ % kColours.size()];
    double first = 0, final = 0;
    for (const IcpCurve* c : its) {
      std::vector<SvgPoint> points;
      for (std::size_t i = 0; i < c->error_mm.size(); ++i)
        points.push_back(panel.at(static_cast<double>(i), c->error_mm[i]));
      svg.polyline(points, {colour, 1.8});
      for (std::size_t i = 0; i < points.size(); ++i)
        svg.disc(points[i], 2.6, colour, 1,
                 fmt::format("{}, {}: {:.1f} mm after {}", name, c->who, c->error_mm[i], i));
      first += c->error_mm.front() / static_cast<double>(its.size());
      final += c->error_mm.back() / static_cast<double>(its.size());
    }
    svg.rectangle({700, y - 9}, 11, 11, colour);
    svg.text({716, y + 1}, name);
    svg.text({716, y + 17}, fmt::format("{:.1f} mm, then {:.1f} mm", first, final),
             {Lettering::Anchor::start, 12, kGrey});
    y += 42;
    ends += fmt::format("{}{:.1f} mm ({})", ends.empty() ? "" : ", ", final, name);
  }
  return {
      "icp", "The retrieved body lies " + ends + " from the depth",
      "The paper's ICP figure: mean distance of the fused depth from the retrieved body in the measured pose, by "
      "iteration; at 0 the joints alone align them. The body is that of the result: nearest entry, brought to the "
      "measured stature and weight. Each line is a person.",
      std::move(svg)};
}

}  // namespace im2fit::lab
