// SPDX-License-Identifier: Apache-2.0
// Query time against models, log-log: one line a reference, p50 drawn through and p99 dashed.
#include <array>
#include <map>
#include <tuple>

#include "bench/index/report.h"
#include "report/svg_plot.h"

namespace im2fit::bench {
namespace {

using lab::Lettering;
using lab::Panel;
using lab::Svg;
using lab::SvgPoint;

// Colours that stay apart for most eyes (Okabe and Ito), and then some.
constexpr std::array<const char*, 10> kColours = {"#d55e00", "#e69f00", "#a0522d", "#000000", "#7f7f7f",
                                                  "#0072b2", "#56b4e9", "#009e73", "#cc79a7", "#6a3d9a"};

const lab::Axis kModels = {
    800,  6.5e6, "models in the index",
    true, 5,     {{1e3, "1,000"}, {1e4, "10,000"}, {5e4, "50,000"}, {5e5, "500,000"}, {5e6, "5,000,000"}}};
const lab::Axis kTime = {
    1e-3,
    1e3,
    "",
    true,
    6,
    {{1e-3, "1 µs"}, {1e-2, "10 µs"}, {1e-1, "100 µs"}, {1, "1 ms"}, {10, "10 ms"}, {100, "100 ms"}, {1e3, "1 s"}}};

std::vector<SvgPoint> points_of(const Panel& panel, const std::vector<const Row*>& rows,
                                std::optional<double> Row::*time) {
  std::vector<SvgPoint> points;
  for (const Row* row : rows)
    if (row->*time) points.push_back(panel.at(static_cast<double>(row->models), *(row->*time) / 1e3));
  return points;
}

// The targets: p50 at 50,000 and p99 at 5,000,000.
void draw_bars(Svg& svg, const Panel& panel) {
  for (const auto& [models, ms, words] :
       {std::tuple{5e4, 0.02, "p50 target, 20 µs"}, std::tuple{5e6, 1.0, "p99 target, 1 ms"}}) {
    const auto [x, y] = panel.at(models, ms);
    svg.line({x - 18, y}, {x + 18, y}, {lab::kRed, 3});
    svg.text({x + 18, y + 16}, words, {Lettering::Anchor::end, 12, lab::kRed});
  }
}

}  // namespace

std::string plot_of(const Measured& all) {
  std::vector<std::string> references;
  std::map<std::string, std::vector<const Row*>> rows;
  for (const Row& row : all.rows) {
    if (!row.p50_us) continue;
    if (rows[row.reference].empty()) references.push_back(row.reference);
    rows[row.reference].push_back(&row);
  }
  constexpr double kLeft = 76, kTop = 44, kWidth = 560, kHeight = 440;
  Svg svg(980, kTop + kHeight + 60, "Query time against models");
  svg.text({kLeft, kTop - 16}, "time of one query, one thread: p50 drawn through, p99 dashed");
  const Panel panel(svg, {kLeft, kTop, kWidth, kHeight}, kModels, kTime);
  draw_bars(svg, panel);
  std::vector<lab::LineEnd> ends;
  for (std::size_t p = 0; p < references.size(); ++p) {
    const char* colour = kColours[p % kColours.size()];
    const auto& of = rows[references[p]];
    const auto p50 = points_of(panel, of, &Row::p50_us);
    svg.polyline(p50, {colour, references[p] == "im2fit" ? 3.5 : 1.8});
    svg.polyline(points_of(panel, of, &Row::p99_us), {colour, 1.2, "5 4"});
    for (const SvgPoint& point : p50) svg.disc(point, 3, colour);
    ends.push_back({p50.back(), references[p], colour});
  }
  name_line_ends(svg, ends, kLeft + kWidth + 24, kTop, kTop + kHeight);
  return svg.file();
}

}  // namespace im2fit::bench
