// SPDX-License-Identifier: Apache-2.0
#include "report/svg_plot.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace im2fit::lab {
namespace {

constexpr double kWordPx = 6.6;  // a letter of 12 px, on average

std::string dash_of(const Stroke& stroke) {
  return stroke.dash[0] == '\0' ? "" : fmt::format(" stroke-dasharray=\"{}\"", stroke.dash);
}

// Closes an element, with the words of the mouse where there are any.
std::string closing(std::string_view name, std::string_view hover) {
  if (hover.empty()) return "/>\n";
  return fmt::format("><title>{}</title></{}>\n", escaped_for_xml(hover), name);
}

std::vector<std::pair<double, std::string>> ticks_of(const Axis& axis) {
  if (!axis.named_ticks.empty()) return axis.named_ticks;
  std::vector<std::pair<double, std::string>> ticks;
  if (axis.ticks <= 0) return ticks;
  for (const double tick :
       axis.logarithmic ? round_log_ticks(axis.low, axis.high) : round_ticks(axis.low, axis.high, axis.ticks))
    ticks.emplace_back(tick, tick_label(tick));
  return ticks;
}

}  // namespace

std::string escaped_for_xml(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

Svg::Svg(double width, double height, std::string title) : width_(width), height_(height), title_(std::move(title)) {}

void Svg::line(SvgPoint from, SvgPoint to, Stroke stroke) {
  body_ += fmt::format("<path d=\"M{:.1f} {:.1f}L{:.1f} {:.1f}\" stroke=\"{}\" stroke-width=\"{:g}\"{}/>\n",
                       from.first, from.second, to.first, to.second, stroke.colour, stroke.width, dash_of(stroke));
}

void Svg::polyline(const std::vector<SvgPoint>& points, Stroke stroke) {
  std::string path;
  for (const auto& [x, y] : points) path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", x, y);
  if (path.empty()) return;
  body_ += fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{:g}\"{}/>\n", path, stroke.colour,
                       stroke.width, dash_of(stroke));
}

void Svg::rectangle(SvgPoint corner, double width, double height, const char* fill, double opacity,
                    std::string_view hover) {
  body_ += fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"{}\"", corner.first,
                       corner.second, std::max(width, 0.0), std::max(height, 0.0), fill);
  if (opacity < 1) body_ += fmt::format(" fill-opacity=\"{:g}\"", opacity);
  body_ += closing("rect", hover);
}

void Svg::disc(SvgPoint centre, double radius, const char* fill, double opacity, std::string_view hover) {
  body_ += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:g}\" fill=\"{}\"", centre.first, centre.second,
                       radius, fill);
  if (opacity < 1) body_ += fmt::format(" fill-opacity=\"{:g}\"", opacity);
  body_ += closing("circle", hover);
}

void Svg::text(SvgPoint at, std::string_view words, Lettering lettering) {
  constexpr const char* kAnchors[] = {"start", "middle", "end"};
  body_ += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\" fill=\"{}\"", at.first, at.second,
                       kAnchors[static_cast<int>(lettering.anchor)], lettering.colour);
  if (lettering.size_px != 12) body_ += fmt::format(" font-size=\"{:g}\"", lettering.size_px);
  if (lettering.bold) body_ += " font-weight=\"600\"";
  if (lettering.upwards) body_ += fmt::format(" transform=\"rotate(-90 {:.1f} {:.1f})\"", at.first, at.second);
  body_ += ">" + escaped_for_xml(words) + "</text>\n";
}

std::string Svg::embedded() const {
  return fmt::format(
             "<svg viewBox=\"0 0 {0:g} {1:g}\" style=\"max-width:{0:g}px\" font-size=\"12\" "
             "font-family=\"system-ui,sans-serif\" role=\"img\" aria-label=\"{2}\">\n",
             width_, height_, escaped_for_xml(title_)) +
         body_ + "</svg>\n";
}

std::string Svg::file() const {
  return fmt::format(
             "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:g} {1:g}\" width=\"{0:g}\" "
             "height=\"{1:g}\" font-size=\"12\" font-family=\"sans-serif\">\n"
             "<!-- SPDX-License-Identifier: Apache-2.0; written by im2fit-lab -->\n<title>{2}</title>\n"
             "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
             width_, height_, escaped_for_xml(title_)) +
         body_ + "</svg>\n";
}

double Scale::at(double value) const {
  const double share =
      logarithmic ? std::log(std::max(value, low / 1e3) / low) / std::log(high / low) : (value - low) / (high - low);
  return from_px + share * (to_px - from_px);
}

std::vector<double> round_ticks(double low, double high, int wanted) {
  if (wanted <= 0 || !(high > low)) return {};
  const double rough = (high - low) / wanted;
  const double power = std::pow(10, std::floor(std::log10(rough)));
  double step = 10 * power;
  for (const double nice : {1.0, 2.0, 2.5, 5.0})
    if (nice * power >= rough * 0.999) {
      step = nice * power;
      break;
    }
  std::vector<double> ticks;
  const auto first = static_cast<long>(std::ceil(low / step - 1e-9));
  const auto last = static_cast<long>(std::floor(high / step + 1e-9));
  for (long k = first; k <= last; ++k) ticks.push_back(static_cast<double>(k) * step);
  return ticks;
}

std::vector<double> round_log_ticks(double low, double high) {
  std::vector<double> ticks;
  const bool only_tens = high / low > 300;
  const int first = static_cast<int>(std::floor(std::log10(low))),
            last = static_cast<int>(std::ceil(std::log10(high)));
  for (int decade = first; decade <= last; ++decade)
    for (const double nice : {1.0, 2.0, 5.0}) {
      if (only_tens && nice > 1) continue;
      const double tick = nice * std::pow(10, decade);
      if (tick >= low * 0.999 && tick <= high * 1.001) ticks.push_back(tick);
    }
  return ticks;
}

std::string tick_label(double value) {
  std::string text = std::abs(value) < 1e-12 ? "0" : fmt::format("{:.10g}", value);
  const std::size_t end = std::min(text.find('.'), text.size());
  const std::size_t begin = text[0] == '-' ? 1 : 0;
  for (std::size_t i = end; i > begin + 3; i -= 3) text.insert(i - 3, ",");
  return text;
}

Panel::Panel(Svg& svg, const Frame& frame, const Axis& across, const Axis& up)
    : x_{across.low, across.high, frame.x, frame.x + frame.width, across.logarithmic},
      y_{up.low, up.high, frame.y + frame.height, frame.y, up.logarithmic} {
  const double bottom = frame.y + frame.height;
  for (const auto& [tick, label] : ticks_of(across)) {
    svg.line({x(tick), frame.y}, {x(tick), bottom}, {kFaint});
    svg.text({x(tick), bottom + 15}, label, {Lettering::Anchor::middle, 11, kGrey});
  }
  for (const auto& [tick, label] : ticks_of(up)) {
    svg.line({frame.x, y(tick)}, {frame.x + frame.width, y(tick)}, {kFaint});
    svg.text({frame.x - 6, y(tick) + 4}, label, {Lettering::Anchor::end, 11, kGrey});
  }
  svg.line({frame.x, bottom}, {frame.x + frame.width, bottom}, {kGrey});
  if (!across.name.empty())
    svg.text({frame.x + frame.width / 2, bottom + 33}, across.name, {Lettering::Anchor::middle});
  if (!up.name.empty())
    svg.text({frame.x - 40, frame.y + frame.height / 2}, up.name, {Lettering::Anchor::middle, 12, kInk, false, true});
}

void draw_legend(Svg& svg, SvgPoint at, const std::vector<LegendEntry>& entries) {
  double x = at.first;
  for (const LegendEntry& entry : entries) {
    svg.rectangle({x, at.second - 9}, 11, 11, entry.colour);
    svg.text({x + 16, at.second + 1}, entry.words);
    x += 34 + kWordPx * static_cast<double>(entry.words.size());
  }
}

void name_line_ends(Svg& svg, std::vector<LineEnd> ends, double x_px, double top_px, double bottom_px) {
  constexpr double kStepPx = 16;
  std::sort(ends.begin(), ends.end(), [](const LineEnd& a, const LineEnd& b) { return a.end.second < b.end.second; });
  std::vector<double> places;
  places.reserve(ends.size());
  double below = top_px - kStepPx;
  for (const LineEnd& line : ends) places.push_back(below = std::max(line.end.second, below + kStepPx));
  // Those pushed beyond the bottom come back up, and push in turn.
  double above = bottom_px + kStepPx;
  for (std::size_t i = ends.size(); i-- > 0;) {
    above = places[i] = std::min(places[i], above - kStepPx);
    svg.line(ends[i].end, {x_px - 4, places[i]}, {ends[i].colour, 0.6, "1 3"});
    svg.text({x_px, places[i] + 4}, ends[i].words, {Lettering::Anchor::start, 12, ends[i].colour});
  }
}

}  // namespace im2fit::lab
