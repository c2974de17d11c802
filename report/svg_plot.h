// SPDX-License-Identifier: Apache-2.0
// Pictures of figures as SVG: shapes, axes, legends. A file of its own, or a part of a page.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace im2fit::lab {

// Colours that stay apart for most eyes (Okabe and Ito).
inline constexpr const char *kBlue = "#0072b2", *kSky = "#56b4e9", *kGreen = "#009e73", *kOrange = "#e69f00",
                            *kRed = "#d55e00", *kPink = "#cc79a7", *kGrey = "#8a8f98", *kInk = "#22262b",
                            *kFaint = "#e4e7eb";

std::string escaped_for_xml(std::string_view text);

struct Stroke {
  const char* colour = kInk;
  double width = 1;
  const char* dash = "";  // as SVG has it: "4 3"
};
struct Lettering {
  enum class Anchor { start, middle, end };
  Anchor anchor = Anchor::start;
  double size_px = 12;
  const char* colour = kInk;
  bool bold = false;
  bool upwards = false;  // turned a quarter to the left
};
using SvgPoint = std::pair<double, double>;

class Svg {
 public:
  // `title`: the text for screen readers.
  Svg(double width, double height, std::string title);
  void line(SvgPoint from, SvgPoint to, Stroke stroke);
  void polyline(const std::vector<SvgPoint>& points, Stroke stroke);
  // `hover`: shown under the mouse; none when empty.
  void rectangle(SvgPoint corner, double width, double height, const char* fill, double opacity = 1,
                 std::string_view hover = {});
  void disc(SvgPoint centre, double radius, const char* fill, double opacity = 1, std::string_view hover = {});
  void text(SvgPoint at, std::string_view words, Lettering lettering = {});
  std::string file() const;      // a whole SVG file
  std::string embedded() const;  // for an HTML page; as wide as there is room

 private:
  double width_, height_;
  std::string title_, body_;
};

// From values to pixels; logarithmic ones have both ends above 0.
struct Scale {
  double low = 0, high = 1, from_px = 0, to_px = 1;
  bool logarithmic = false;
  double at(double value) const;
};
// A scale's ends and round values within, about `wanted` of them (logarithmic: 1, 2, 5, 10, ...).
std::vector<double> round_ticks(double low, double high, int wanted);
std::vector<double> round_log_ticks(double low, double high);
// "0.5", "20", "1,000"
std::string tick_label(double value);

struct Frame {
  double x = 0, y = 0, width = 0, height = 0;
};
struct Axis {
  double low = 0, high = 1;
  std::string name;
  bool logarithmic = false;
  int ticks = 5;                                                 // about so many; 0: neither grid nor labels
  std::vector<std::pair<double, std::string>> named_ticks = {};  // instead of round ones
};
// A frame with a grid, tick labels and names of axes; y grows upwards.
class Panel {
 public:
  Panel(Svg& svg, const Frame& frame, const Axis& across, const Axis& up);
  SvgPoint at(double x, double y) const { return {x_.at(x), y_.at(y)}; }
  double x(double value) const { return x_.at(value); }
  double y(double value) const { return y_.at(value); }

 private:
  Scale x_, y_;
};

struct LegendEntry {
  std::string words;
  const char* colour;
};
// Side by side from `at`; entries after each other as wide as their words.
void draw_legend(Svg& svg, SvgPoint at, const std::vector<LegendEntry>& entries);

// A name right of where each line ends, apart enough to be read, tied to it by a dotted line.
struct LineEnd {
  SvgPoint end;
  std::string words;
  const char* colour;
};
void name_line_ends(Svg& svg, std::vector<LineEnd> ends, double x_px, double top_px, double bottom_px);

}  // namespace im2fit::lab
