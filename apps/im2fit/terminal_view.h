// SPDX-License-Identifier: Apache-2.0
// A picture in a terminal: each character cell shows two pixels, the upper as foreground of a half block, the lower
// as background. Needs UTF-8 and 256 colours; takes 24-bit colour where COLORTERM promises it.
#pragma once

#include <string>
#include <vector>

#include "report/canvas.h"

namespace im2fit::apps {

struct TerminalSize {
  int columns = 80;
  int rows = 24;
};
// Of the terminal behind stderr; 80 x 24 where there is none.
TerminalSize terminal_size();

// One line of text for every two rows of pixels, each ending in a colour reset and a line end.
std::string half_blocks(const Canvas& picture, bool true_colour);

// On stderr, in the terminal's second screen, so that what stood there comes back when this is destroyed.
class TerminalView {
 public:
  TerminalView();
  ~TerminalView();
  TerminalView(const TerminalView&) = delete;
  TerminalView& operator=(const TerminalView&) = delete;
  // Height in pixels of a picture as wide as `width` / `height` that leaves `line_count` lines free below it.
  int picture_height(int width, int height, int line_count) const;
  // Draws over the drawing before; lines longer than the terminal is wide are cut.
  void show(const Canvas& picture, const std::vector<std::string>& lines) const;

 private:
  bool true_colour_;
};

}  // namespace im2fit::apps
