// SPDX-License-Identifier: Apache-2.0
#include "apps/im2fit/terminal_view.h"

#include <fmt/core.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <string_view>

namespace im2fit::apps {
namespace {

constexpr std::string_view kEnterScreen = "\033[?1049h\033[?25l";
constexpr std::string_view kLeaveScreen = "\033[?25h\033[?1049l";
constexpr std::string_view kHome = "\033[H";
constexpr std::string_view kClearLine = "\033[K";
constexpr std::string_view kClearBelow = "\033[J";

bool has_true_colour() {
  const char* word = std::getenv("COLORTERM");
  return word != nullptr && (std::string_view(word) == "truecolor" || std::string_view(word) == "24bit");
}

// The 6 x 6 x 6 cube of 256-colour terminals: levels 0, 95, 135, 175, 215, 255.
int cube_level(int value) {
  return value < 48 ? 0 : value < 115 ? 1 : (value - 35) / 40;
}

void append_colour(std::string& out, int ground, Rgb c, bool true_colour) {
  if (true_colour)
    out += fmt::format("\033[{};2;{};{};{}m", ground, c.r, c.g, c.b);
  else
    out += fmt::format("\033[{};5;{}m", ground, 16 + 36 * cube_level(c.r) + 6 * cube_level(c.g) + cube_level(c.b));
}

bool same(Rgb a, Rgb b) {
  return a.r == b.r && a.g == b.g && a.b == b.b;
}

}  // namespace

TerminalSize terminal_size() {
  winsize window{};
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &window) != 0 || window.ws_col == 0 || window.ws_row == 0) return {};
  return {window.ws_col, window.ws_row};
}

std::string half_blocks(const Canvas& picture, bool true_colour) {
  std::string out;
  for (int y = 0; y < picture.height(); y += 2) {
    Rgb upper_shown;
    Rgb lower_shown;
    for (int x = 0; x < picture.width(); ++x) {
      const Rgb upper = picture.at(x, y);
      const Rgb lower = y + 1 < picture.height() ? picture.at(x, y + 1) : Rgb{};
      if (x == 0 || !same(upper, upper_shown)) append_colour(out, 38, upper, true_colour);
      if (x == 0 || !same(lower, lower_shown)) append_colour(out, 48, lower, true_colour);
      upper_shown = upper;
      lower_shown = lower;
      out += "\u2580";
    }
    out += "\033[0m\n";
  }
  return out;
}

TerminalView::TerminalView() : true_colour_(has_true_colour()) {
  fmt::print(stderr, "{}", kEnterScreen);
}

TerminalView::~TerminalView() {
  fmt::print(stderr, "{}", kLeaveScreen);
  std::fflush(stderr);
}

int TerminalView::picture_height(int width, int height, int line_count) const {
  const TerminalSize size = terminal_size();
  const int by_rows = 2 * std::max(1, size.rows - line_count - 1);
  const int by_columns = size.columns * height / std::max(1, width);
  return std::max(2, std::min(by_rows, by_columns));
}

void TerminalView::show(const Canvas& picture, const std::vector<std::string>& lines) const {
  const auto columns = static_cast<std::size_t>(terminal_size().columns);
  std::string out(kHome);
  for (const char c : half_blocks(picture, true_colour_)) {
    if (c == '\n') out += kClearLine;
    out += c;
  }
  for (const std::string& line : lines) {
    out += line.substr(0, columns);
    out += kClearLine;
    out += '\n';
  }
  out += kClearBelow;
  fmt::print(stderr, "{}", out);
  std::fflush(stderr);
}

}  // namespace im2fit::apps
