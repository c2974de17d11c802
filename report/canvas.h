// SPDX-License-Identifier: Apache-2.0
// A small RGB picture to draw on, written as PNG.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/status.h"

namespace im2fit {

struct Rgb {
  std::uint8_t r = 0, g = 0, b = 0;
};

// `alpha` 0..1 of `above` over `below`.
Rgb mixed(Rgb below, Rgb above, float alpha);

class Canvas {
 public:
  Canvas(int width, int height);
  int width() const { return width_; }
  int height() const { return height_; }
  Rgb at(int x, int y) const;  // inside the picture
  std::span<Rgb> row(int y);   // inside the picture
  // Drawing outside the picture is cut off. `alpha` 0..1 mixes with what is there.
  void set(int x, int y, Rgb colour, float alpha = 1.0F);
  void line(float x0, float y0, float x1, float y1, float thickness, Rgb colour, float alpha = 1.0F);
  void disc(float x, float y, float radius, Rgb colour, float alpha = 1.0F);
  void rectangle(int x, int y, int width, int height, Rgb colour, float alpha = 1.0F);
  // Capital letters, digits and . , - + % / : ( ) in a 5 x 7 raster times `scale`; others are blanks.
  void text(int x, int y, std::string_view words, int scale, Rgb colour);
  static int text_width(std::string_view words, int scale) { return static_cast<int>(words.size()) * 6 * scale; }
  static int text_height(int scale) { return 7 * scale; }

  Result<std::vector<std::byte>> png() const;

 private:
  int width_;
  int height_;
  std::vector<Rgb> pixels_;
};

}  // namespace im2fit
