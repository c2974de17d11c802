// SPDX-License-Identifier: Apache-2.0
// Query time against models, log-log: one line a peer, p50 drawn through and p99 dashed.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>

#include "bench/index/report.h"

namespace im2fit::bench {
namespace {

constexpr double kLeft = 76, kTop = 44, kWidth = 560, kHeight = 440, kPage = 980;
constexpr double kModelsMin = 800, kModelsMax = 6.5e6, kUsMin = 1, kUsMax = 1e6;
// Colours that stay apart for most eyes (Okabe and Ito), and then some.
constexpr std::array<const char*, 10> kColours = {"#d55e00", "#e69f00", "#a0522d", "#000000", "#7f7f7f",
                                                  "#0072b2", "#56b4e9", "#009e73", "#cc79a7", "#6a3d9a"};

template <class... Values>
std::string format(const char* pattern, Values... values) {
  std::array<char, 512> text{};
  std::snprintf(text.data(), text.size(), pattern, values...);
  return text.data();
}

double x_of(double models) {
  return kLeft + kWidth * std::log10(models / kModelsMin) / std::log10(kModelsMax / kModelsMin);
}

double y_of(double us) {
  return kTop + kHeight * (1 - std::log10(std::clamp(us, kUsMin, kUsMax) / kUsMin) / std::log10(kUsMax / kUsMin));
}

std::string text_at(double x, double y, const char* anchor, const std::string& words, const char* colour = "#333") {
  return format("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"%s\" fill=\"%s\">", x, y, anchor, colour) + words +
         "</text>\n";
}

std::string grid() {
  std::string svg;
  const std::array<const char*, 7> times = {"1 µs", "10 µs", "100 µs", "1 ms", "10 ms", "100 ms", "1 s"};
  for (std::size_t k = 0; k < times.size(); ++k) {
    const double y = y_of(std::pow(10.0, static_cast<double>(k)));
    svg += format("<path d=\"M%.1f %.1fh%.1f\" stroke=\"#ddd\"/>\n", kLeft, y, kWidth) +
           text_at(kLeft - 8, y + 4, "end", times[k]);
  }
  for (const auto& [models, words] : std::map<double, const char*>{
           {1e3, "1,000"}, {1e4, "10,000"}, {5e4, "50,000"}, {5e5, "500,000"}, {5e6, "5,000,000"}})
    svg += format("<path d=\"M%.1f %.1fv%.1f\" stroke=\"#ddd\"/>\n", x_of(models), kTop, kHeight) +
           text_at(x_of(models), kTop + kHeight + 18, "middle", words);
  return svg + text_at(kLeft + kWidth / 2, kTop + kHeight + 40, "middle", "models in the index") +
         text_at(kLeft, kTop - 16, "start", "time of one query, one thread: p50 drawn through, p99 dashed");
}

// The bars: p50 at 50,000 and p99 at 5,000,000.
std::string bars() {
  std::string svg;
  for (const auto& [models, us, words] :
       {std::tuple{5e4, 20.0, "p50 bar, 20 µs"}, std::tuple{5e6, 1000.0, "p99 bar, 1 ms"}})
    svg +=
        format("<path d=\"M%.1f %.1fh36\" stroke=\"#d55e00\" stroke-width=\"3\"/>\n", x_of(models) - 18, y_of(us)) +
        text_at(x_of(models) + 18, y_of(us) + 16, "end", words, "#d55e00");
  return svg;
}

std::string line(const std::vector<const Row*>& rows, std::optional<double> Row::*time, const char* colour,
                 const char* style) {
  std::string path;
  for (const Row* row : rows)
    path += format("%s%.1f %.1f", path.empty() ? "M" : "L", x_of(static_cast<double>(row->models)),
                   y_of((row->*time).value_or(kUsMin)));
  return format("<path d=\"%s\" fill=\"none\" stroke=\"%s\" %s/>\n", path.c_str(), colour, style);
}

}  // namespace

std::string plot_of(const Measured& all) {
  std::vector<std::string> peers;
  std::map<std::string, std::vector<const Row*>> rows;
  for (const Row& row : all.rows) {
    if (!row.p50_us) continue;
    if (rows[row.peer].empty()) peers.push_back(row.peer);
    rows[row.peer].push_back(&row);
  }
  std::string svg = format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %.0f %.0f\" width=\"%.0f\" "
      "height=\"%.0f\" font-family=\"sans-serif\" font-size=\"12\">\n"
      "<!-- SPDX-License-Identifier: Apache-2.0; written by index_peers -->\n"
      "<rect width=\"100%%\" height=\"100%%\" fill=\"#fff\"/>\n",
      kPage, kTop + kHeight + 60, kPage, kTop + kHeight + 60);
  svg += grid() + bars();
  // Names at the right, in the order of the lines' ends, apart enough to be read.
  std::vector<std::pair<double, std::size_t>> ends;
  for (std::size_t p = 0; p < peers.size(); ++p) ends.push_back({y_of(*rows[peers[p]].back()->p50_us), p});
  std::sort(ends.begin(), ends.end());
  double below = kTop - 10;
  for (auto& [y, p] : ends) below = y = std::max(y, below + 17);
  const double over = below - (kTop + kHeight);
  for (const auto& [y, p] : ends) {
    const char* colour = kColours[p % kColours.size()];
    const auto& of = rows[peers[p]];
    const char* width = peers[p] == "im2fit" ? "stroke-width=\"3.5\"" : "stroke-width=\"1.8\"";
    svg += line(of, &Row::p50_us, colour, width) +
           line(of, &Row::p99_us, colour, "stroke-width=\"1.2\" stroke-dasharray=\"5 4\"");
    for (const Row* row : of)
      svg += format("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"3\" fill=\"%s\"/>\n", x_of(static_cast<double>(row->models)),
                    y_of(*row->p50_us), colour);
    const double name_y = y - std::max(over, 0.0), name_x = kLeft + kWidth + 24;
    svg += format("<path d=\"M%.1f %.1fL%.1f %.1f\" stroke=\"%s\" stroke-width=\"0.6\" stroke-dasharray=\"1 3\"/>\n",
                  x_of(static_cast<double>(of.back()->models)) + 5, y_of(*of.back()->p50_us), name_x - 4, name_y,
                  colour) +
           text_at(name_x, name_y + 4, "start", peers[p], colour);
  }
  return svg + "</svg>\n";
}

}  // namespace im2fit::bench
