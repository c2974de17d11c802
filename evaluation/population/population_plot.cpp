// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "evaluation/population/population_check.h"
#include "report/canvas.h"

namespace im2fit::lab {
namespace {

constexpr int kPanelWidth = 330, kPanelHeight = 300, kLeft = 56, kTop = 64, kGap = 22;
constexpr Rgb kInk{40, 40, 40}, kGrid{225, 225, 225}, kDrawn{64, 128, 200}, kReal{210, 70, 40};
constexpr float kDotRadiusPx = 1.1F;
constexpr std::size_t kDotsMost = 1500;  // more would be a blot

struct Axis {
  double low, high, step;
  std::size_t column;
  const char* name;
};
constexpr Axis kStature{1400, 2000, 100, 0, "STATURE MM"}, kWeight{40, 140, 20, 1, "WEIGHT KG"};
constexpr Axis kGirths[] = {
    {700, 1400, 100, 2, "CHEST MM"}, {550, 1400, 100, 3, "WAIST MM"}, {750, 1450, 100, 4, "HIP MM"}};

class Panel {
 public:
  Panel(Canvas& canvas, int x, int y, const Axis& across, const Axis& up)
      : canvas_(canvas), x_(x), y_(y), across_(across), up_(up) {
    canvas_.rectangle(x, y, kPanelWidth, kPanelHeight, {250, 250, 250});
    for (double v = across.low; v <= across.high; v += across.step) {
      canvas_.line(u(v), static_cast<float>(y), u(v), static_cast<float>(y + kPanelHeight), 1, kGrid);
      const std::string label = std::to_string(static_cast<int>(v));
      canvas_.text(static_cast<int>(u(v)) - Canvas::text_width(label, 1) / 2, y + kPanelHeight + 5, label, 1, kInk);
    }
    for (double v = std::ceil(up.low / up.step) * up.step; v <= up.high; v += up.step) {
      canvas_.line(static_cast<float>(x), w(v), static_cast<float>(x + kPanelWidth), w(v), 1, kGrid);
      const std::string label = std::to_string(static_cast<int>(v));
      canvas_.text(x - 4 - Canvas::text_width(label, 1), static_cast<int>(w(v)) - 3, label, 1, kInk);
    }
    canvas_.text(x + kPanelWidth - Canvas::text_width(across.name, 1) - 4, y + kPanelHeight - 12, across.name, 1,
                 kInk);
    canvas_.text(x + 5, y + 5, up.name, 1, kInk);
  }

  void dot(const ComparedRow& row, float alpha) {
    const float px = u(row[across_.column]), py = w(row[up_.column]);
    if (inside(px, py)) canvas_.disc(px, py, kDotRadiusPx, kDrawn, alpha);
  }

  // Where a normal of these moments is `sds` standard deviations away.
  void ellipse(const PeopleMoments& m, double sds, Rgb colour) {
    constexpr int kSides = 96;
    const double r = m.correlation[up_.column][across_.column];
    float before_x = 0, before_y = 0;
    for (int i = 0; i <= kSides; ++i) {
      const double t = 2 * std::numbers::pi * i / kSides;
      const double a = std::cos(t), b = r * std::cos(t) + std::sqrt(1 - r * r) * std::sin(t);
      const float px = u(m.mean[across_.column] + sds * m.sd[across_.column] * a);
      const float py = w(m.mean[up_.column] + sds * m.sd[up_.column] * b);
      if (i > 0 && inside(px, py) && inside(before_x, before_y)) canvas_.line(before_x, before_y, px, py, 2, colour);
      before_x = px;
      before_y = py;
    }
  }

 private:
  float u(double v) const {
    return static_cast<float>(x_ + kPanelWidth * (v - across_.low) / (across_.high - across_.low));
  }
  float w(double v) const {
    return static_cast<float>(y_ + kPanelHeight - kPanelHeight * (v - up_.low) / (up_.high - up_.low));
  }
  bool inside(float px, float py) const {
    return px >= static_cast<float>(x_) && px <= static_cast<float>(x_ + kPanelWidth) &&
           py >= static_cast<float>(y_) && py <= static_cast<float>(y_ + kPanelHeight);
  }
  Canvas& canvas_;
  int x_, y_;
  const Axis &across_, &up_;
};

}  // namespace

Result<std::vector<std::byte>> plot_of(const PopulationComparison& comparison) {
  constexpr int kColumns = 4;
  Canvas canvas(kLeft + kColumns * (kPanelWidth + kLeft) + kGap, kTop + 2 * (kPanelHeight + kLeft) + kGap);
  canvas.rectangle(0, 0, canvas.width(), canvas.height(), {255, 255, 255});
  canvas.text(kLeft, 14, "SYNTHETIC PEOPLE AT THE STATURE AND WEIGHT OF ANSUR II (DOTS, ELLIPSES OF 1 AND 2 SD)", 2,
              kDrawn);
  canvas.text(kLeft, 36, "ANSUR II, 1986 WOMEN AND 4082 MEN (ELLIPSES OF 1 AND 2 SD)", 2, kReal);
  for (std::size_t s = 0; s < comparison.sexes.size(); ++s) {
    const auto& sex = comparison.sexes[s];
    const int top = kTop + static_cast<int>(s) * (kPanelHeight + kLeft);
    for (int c = 0; c < kColumns; ++c) {
      const Axis& across = c == 0 ? kStature : kWeight;
      const Axis& up = c == 0 ? kWeight : kGirths[c - 1];
      Panel panel(canvas, kLeft + c * (kPanelWidth + kLeft), top, across, up);
      const double most = *std::max_element(sex.weights.begin(), sex.weights.end());
      for (std::size_t i = 0; i < std::min(kDotsMost, sex.rows.size()); ++i)
        panel.dot(sex.rows[i], static_cast<float>(sex.weights[i] / most));
      for (const double sds : {1.0, 2.0}) {
        panel.ellipse(sex.like_ansur, sds, kDrawn);
        panel.ellipse(sex.ansur, sds, kReal);
      }
    }
    canvas.text(6, top + 18, sex.woman ? "WOMEN" : "MEN", 1, kInk);
  }
  return canvas.png();
}

}  // namespace im2fit::lab
