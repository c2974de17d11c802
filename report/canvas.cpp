// SPDX-License-Identifier: Apache-2.0
#include "report/canvas.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "formats/plain_png.h"

namespace im2fit {
namespace {

struct Glyph {
  char letter;
  std::array<std::uint8_t, 7> rows;  // five bits a row, the left pixel highest
};

constexpr Glyph kFont[] = {
    {'A', {14, 17, 17, 31, 17, 17, 17}}, {'B', {30, 17, 17, 30, 17, 17, 30}}, {'C', {14, 17, 16, 16, 16, 17, 14}},
    {'D', {30, 17, 17, 17, 17, 17, 30}}, {'E', {31, 16, 16, 30, 16, 16, 31}}, {'F', {31, 16, 16, 30, 16, 16, 16}},
    {'G', {14, 17, 16, 23, 17, 17, 14}}, {'H', {17, 17, 17, 31, 17, 17, 17}}, {'I', {14, 4, 4, 4, 4, 4, 14}},
    {'J', {7, 2, 2, 2, 2, 18, 12}},      {'K', {17, 18, 20, 24, 20, 18, 17}}, {'L', {16, 16, 16, 16, 16, 16, 31}},
    {'M', {17, 27, 21, 21, 17, 17, 17}}, {'N', {17, 25, 21, 19, 17, 17, 17}}, {'O', {14, 17, 17, 17, 17, 17, 14}},
    {'P', {30, 17, 17, 30, 16, 16, 16}}, {'Q', {14, 17, 17, 17, 21, 18, 13}}, {'R', {30, 17, 17, 30, 20, 18, 17}},
    {'S', {15, 16, 16, 14, 1, 1, 30}},   {'T', {31, 4, 4, 4, 4, 4, 4}},       {'U', {17, 17, 17, 17, 17, 17, 14}},
    {'V', {17, 17, 17, 17, 17, 10, 4}},  {'W', {17, 17, 17, 21, 21, 27, 17}}, {'X', {17, 17, 10, 4, 10, 17, 17}},
    {'Y', {17, 17, 10, 4, 4, 4, 4}},     {'Z', {31, 1, 2, 4, 8, 16, 31}},     {'0', {14, 17, 19, 21, 25, 17, 14}},
    {'1', {4, 12, 4, 4, 4, 4, 14}},      {'2', {14, 17, 1, 6, 8, 16, 31}},    {'3', {30, 1, 1, 14, 1, 1, 30}},
    {'4', {2, 6, 10, 18, 31, 2, 2}},     {'5', {31, 16, 30, 1, 1, 17, 14}},   {'6', {14, 16, 16, 30, 17, 17, 14}},
    {'7', {31, 1, 2, 4, 8, 8, 8}},       {'8', {14, 17, 17, 14, 17, 17, 14}}, {'9', {14, 17, 17, 15, 1, 1, 14}},
    {'.', {0, 0, 0, 0, 0, 12, 12}},      {',', {0, 0, 0, 0, 12, 4, 8}},       {'-', {0, 0, 0, 14, 0, 0, 0}},
    {'+', {0, 4, 4, 31, 4, 4, 0}},       {'%', {25, 26, 2, 4, 8, 11, 19}},    {'/', {1, 1, 2, 4, 8, 16, 16}},
    {':', {0, 12, 12, 0, 12, 12, 0}},    {'(', {2, 4, 8, 8, 8, 4, 2}},        {')', {8, 4, 2, 2, 2, 4, 8}},
};

const Glyph* glyph_of(char letter) {
  for (const Glyph& glyph : kFont)
    if (glyph.letter == letter) return &glyph;
  return nullptr;
}

std::uint8_t mixed(std::uint8_t below, std::uint8_t above, float alpha) {
  const float value = static_cast<float>(below) + (static_cast<float>(above) - static_cast<float>(below)) * alpha;
  return static_cast<std::uint8_t>(value + 0.5F);  // never below nought
}

// Squared distance of (x, y) from the segment.
float squared_distance(float x, float y, float x0, float y0, float x1, float y1) {
  const float dx = x1 - x0;
  const float dy = y1 - y0;
  const float length2 = dx * dx + dy * dy;
  const float along = length2 > 0 ? std::clamp(((x - x0) * dx + (y - y0) * dy) / length2, 0.0F, 1.0F) : 0.0F;
  const float ex = x - x0 - along * dx;
  const float ey = y - y0 - along * dy;
  return ex * ex + ey * ey;
}

}  // namespace

Rgb mixed(Rgb below, Rgb above, float alpha) {
  if (alpha >= 1) return above;
  return {mixed(below.r, above.r, alpha), mixed(below.g, above.g, alpha), mixed(below.b, above.b, alpha)};
}

Canvas::Canvas(int width, int height)
    : width_(width), height_(height), pixels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {}

Rgb Canvas::at(int x, int y) const {
  return pixels_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)];
}

std::span<Rgb> Canvas::row(int y) {
  return std::span(pixels_).subspan(static_cast<std::size_t>(y) * static_cast<std::size_t>(width_),
                                    static_cast<std::size_t>(width_));
}

void Canvas::set(int x, int y, Rgb colour, float alpha) {
  if (x < 0 || y < 0 || x >= width_ || y >= height_ || alpha <= 0) return;
  Rgb& p = pixels_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)];
  p = mixed(p, colour, alpha);
}

void Canvas::line(float x0, float y0, float x1, float y1, float thickness, Rgb colour, float alpha) {
  if (!std::isfinite(x0 + y0 + x1 + y1)) return;
  const float half = thickness / 2;
  const int left = std::max(0, static_cast<int>(std::max(-1.0F, std::min(x0, x1) - half - 1)));
  const int right = static_cast<int>(std::min(static_cast<float>(width_ - 1), std::max(x0, x1) + half + 1));
  const int top = std::max(0, static_cast<int>(std::max(-1.0F, std::min(y0, y1) - half - 1)));
  const int bottom = static_cast<int>(std::min(static_cast<float>(height_ - 1), std::max(y0, y1) + half + 1));
  const float reach = half + 0.5F;
  for (int y = top; y <= bottom; ++y)
    for (int x = left; x <= right; ++x) {
      const float squared = squared_distance(static_cast<float>(x), static_cast<float>(y), x0, y0, x1, y1);
      if (squared > reach * reach) continue;  // most of the box about a slanted line
      set(x, y, colour, alpha * std::clamp(reach - std::sqrt(squared), 0.0F, 1.0F));
    }
}

void Canvas::disc(float x, float y, float radius, Rgb colour, float alpha) {
  line(x, y, x, y, 2 * radius, colour, alpha);
}

void Canvas::rectangle(int x, int y, int width, int height, Rgb colour, float alpha) {
  const int right = std::min(width_, x + width);
  const int bottom = std::min(height_, y + height);
  if (alpha <= 0) return;
  for (int v = std::max(0, y); v < bottom; ++v) {
    Rgb* row = pixels_.data() + static_cast<std::ptrdiff_t>(v) * width_;
    if (alpha >= 1) {
      std::fill(row + std::max(0, x), row + std::max({0, x, right}), colour);
      continue;
    }
    for (int u = std::max(0, x); u < right; ++u) row[u] = mixed(row[u], colour, alpha);
  }
}

void Canvas::text(int x, int y, std::string_view words, int scale, Rgb colour) {
  for (std::size_t i = 0; i < words.size(); ++i) {
    const Glyph* glyph = glyph_of(words[i]);
    if (glyph == nullptr) continue;
    const int left = x + static_cast<int>(i) * 6 * scale;
    for (int row = 0; row < 7; ++row)
      for (int column = 0; column < 5; ++column)
        if ((glyph->rows[static_cast<std::size_t>(row)] >> (4 - column) & 1) != 0)
          rectangle(left + column * scale, y + row * scale, scale, scale, colour);
  }
}

Result<std::vector<std::byte>> Canvas::png() const {
  static_assert(sizeof(Rgb) == 3);
  return hal::encode_rgb_png(width_, height_, {&pixels_[0].r, 3 * pixels_.size()});
}

}  // namespace im2fit
