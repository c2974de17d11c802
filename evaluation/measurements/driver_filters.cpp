// SPDX-License-Identifier: Apache-2.0
#include "evaluation/measurements/driver_filters.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "kernels/average/average.h"

namespace im2fit::lab {
namespace {

constexpr int kReachMaxPx = 2;
constexpr double kGaussSdPx = 1.2, kBilateralSdPx = 1.5;

struct Weighted {
  double sum_mm = 0, weight = 0;
  void add(std::uint16_t mm, double w) {
    if (mm == 0) return;
    sum_mm += w * mm;
    weight += w;
  }
  std::uint16_t mean_mm() const { return static_cast<std::uint16_t>(weight > 0 ? std::lround(sum_mm / weight) : 0); }
};

struct Window {
  int reach_px;
  double sd_px;     // 0: all weigh the same
  double range_mm;  // 0: whatever the depth
};

Window window_of(EdgeBlend blend) {
  switch (blend) {
    case EdgeBlend::mean3:
      return {1, 0, 0};
    case EdgeBlend::mean5:
      return {2, 0, 0};
    case EdgeBlend::gauss5:
      return {2, kGaussSdPx, 0};
    case EdgeBlend::bilateral5:
      return {2, kBilateralSdPx, static_cast<double>(EdgeFilter::kRangeSdMm)};
    case EdgeBlend::none:
    case EdgeBlend::bilinear2:
      break;
  }
  return {0, 0, 0};
}

double normal(double x, double sd) {
  return std::exp(-x * x / (2 * sd * sd));
}

template <class F>
void for_each_near(DepthView image, int u, int v, int reach_px, F&& f) {
  for (int y = std::max(0, v - reach_px); y <= std::min(image.height - 1, v + reach_px); ++y)
    for (int x = std::max(0, u - reach_px); x <= std::min(image.width - 1, u + reach_px); ++x)
      f(x, y, image.at(x, y));
}

void blend_window(DepthView from, const Window& window, DepthImage to) {
  std::array<double, kReachMaxPx + 1> by_offset{};
  for (int i = 0; i <= window.reach_px; ++i)
    by_offset[static_cast<std::size_t>(i)] = window.sd_px > 0 ? normal(i, window.sd_px) : 1;
  const auto weight = [&](int offset) { return by_offset[static_cast<std::size_t>(std::abs(offset))]; };
  for (int v = 0; v < to.height; ++v)
    for (int u = 0; u < to.width; ++u) {
      const std::uint16_t own = from.at(u, v);
      if (own == 0) continue;
      Weighted sum;
      for_each_near(from, u, v, window.reach_px, [&](int x, int y, std::uint16_t mm) {
        const double alike = window.range_mm > 0 ? normal(static_cast<double>(mm) - own, window.range_mm) : 1;
        sum.add(mm, weight(x - u) * weight(y - v) * alike);
      });
      to.at(u, v) = sum.mean_mm();
    }
}

// Samples (2i, 2j); between them by the distance, of those with data.
void blend_bilinear(DepthView from, DepthImage to) {
  const auto last = [](int count) { return (count - 1) / 2 * 2; };
  for (int v = 0; v < to.height; ++v)
    for (int u = 0; u < to.width; ++u) {
      const int left = u / 2 * 2, top = v / 2 * 2;
      const int right = std::min(left + 2, last(to.width)), bottom = std::min(top + 2, last(to.height));
      const double x = 0.5 * (u - left), y = 0.5 * (v - top);
      Weighted sum;
      sum.add(from.at(left, top), (1 - x) * (1 - y));
      sum.add(from.at(right, top), x * (1 - y));
      sum.add(from.at(left, bottom), (1 - x) * y);
      sum.add(from.at(right, bottom), x * y);
      to.at(u, v) = sum.mean_mm();
    }
}

void drop_edges(DepthView from, DepthImage to) {
  for (int v = 0; v < to.height; ++v)
    for (int u = 0; u < to.width; ++u) {
      std::uint16_t nearest = std::numeric_limits<std::uint16_t>::max(), farthest = 0;
      for_each_near(from, u, v, 1, [&](int, int, std::uint16_t mm) {
        if (mm == 0) return;
        nearest = std::min(nearest, mm);
        farthest = std::max(farthest, mm);
      });
      const float step_mm = static_cast<float>(farthest) - static_cast<float>(nearest);
      if (farthest != 0 && step_mm > EdgeFilter::kDropStep * static_cast<float>(nearest)) to.at(u, v) = 0;
    }
}

}  // namespace

void EdgeFilter::run(DepthImage frame) {
  const auto keep = [&] {
    before_.resize(static_cast<std::size_t>(frame.width) * static_cast<std::size_t>(frame.height));
    const DepthImage before(before_.data(), frame.width, frame.height);
    for (int v = 0; v < frame.height; ++v) std::copy_n(frame.row(v), frame.width, before.row(v));
    return before;
  };
  if (options_.blend == EdgeBlend::bilinear2)
    blend_bilinear(keep(), frame);
  else if (options_.blend != EdgeBlend::none)
    blend_window(keep(), window_of(options_.blend), frame);
  if (options_.drop) drop_edges(keep(), frame);
}

void TemporalSmoothing::run(DepthImage frame) {
  const auto width = static_cast<std::size_t>(frame.width);
  smooth_mm_.resize(width * static_cast<std::size_t>(frame.height));
  for (int v = 0; v < frame.height; ++v) {
    std::uint16_t* row = frame.row(v);
    float* smooth = smooth_mm_.data() + static_cast<std::size_t>(v) * width;
    for (std::size_t u = 0; u < width; ++u) {
      const auto now = static_cast<float>(row[u]);
      const float step = now - smooth[u];
      const bool same = row[u] != 0 && smooth[u] > 0 && std::fabs(step) <= static_cast<float>(kOutlierMm);
      smooth[u] = same ? smooth[u] + kShare * step : now;
      row[u] = static_cast<std::uint16_t>(std::lround(smooth[u]));
    }
  }
}

}  // namespace im2fit::lab
