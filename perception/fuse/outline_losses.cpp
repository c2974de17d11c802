// SPDX-License-Identifier: Apache-2.0
#include "perception/fuse/outline_losses.h"

#include <algorithm>
#include <limits>

namespace im2fit {
namespace {

constexpr std::uint32_t kPixelsEnough = 3000;
// Beside an outline that jitters by a pixel at 640 across. A shadow is f b (1/z - 1/z of the background) wide: 3 px
// of 640 where the wall is half a metre behind a person 2.3 m away, 15 at most where people are measured.
constexpr int kFirstAcross = 320;  // the first pixel read: this part of the picture's long side
constexpr int kRead = 2;
constexpr int kReachAcross = 40;  // shadows are narrower than this part of the picture's long side

}  // namespace

// A row or column of the picture, those of its pixels between `first` and `last` being in the box.
struct OutlineLosses::Line {
  const std::uint16_t* depth;
  const std::uint8_t* mask;
  std::ptrdiff_t depth_step, mask_step;
  int count, first, last;
  int nearest, reach;  // pixels beside an outline: read from here on; followed by data here at the latest
  bool masked(int i) const { return mask[i * mask_step] == 255; }
  bool seen(int i) const { return depth[i * depth_step] != 0; }
};

void OutlineLosses::reset() {
  sides_ = {};
}

void OutlineLosses::scan(const Line& line, Side& before, Side& after) {
  // From the masked pixel `at` outwards.
  const auto beside = [&](int at, int direction, Side& side) {
    const int end = at + direction * line.reach;
    if (std::min(at, end) < 0 || std::max(at, end) >= line.count) return;
    bool follows = false;
    for (int i = line.nearest + kRead - 1; i <= line.reach && !follows; ++i) follows = line.seen(at + direction * i);
    if (!follows) return;
    for (int i = 1; i < line.nearest + kRead; ++i)
      if (line.masked(at + direction * i)) return;  // a hole in the person, or a limb close by
    for (int i = line.nearest; i < line.nearest + kRead; ++i) {
      ++side.pixels;
      side.lost += line.seen(at + direction * i) ? 0 : 1;
    }
  };
  bool inside = false;
  for (int i = line.first; i <= line.last; ++i) {
    const bool now = line.masked(i);
    if (now && !inside) beside(i, -1, before);
    if (!now && inside) beside(i - 1, 1, after);
    inside = now;
  }
  if (inside) beside(line.last, 1, after);
}

void OutlineLosses::add(DepthView depth, MaskView mask, int u_min, int v_min, int u_max, int v_max) {
  std::uint32_t pixels = 0;
  for (const Side& side : sides_) pixels += side.pixels;
  if (pixels >= kPixelsEnough) return;
  const int left = std::max(0, u_min), right = std::min(depth.width - 1, u_max);
  const int top = std::max(0, v_min), bottom = std::min(depth.height - 1, v_max);
  const int size = std::max(depth.width, depth.height);
  const int nearest = std::max(1, size / kFirstAcross), reach = std::max(nearest + kRead, size / kReachAcross);
  const auto next = [](int i) { return (i + kStep - 1) / kStep * kStep; };
  for (int v = next(top); v <= bottom; v += kStep)
    scan({depth.row(v), mask.row(v), 1, 1, depth.width, left, right, nearest, reach}, sides_[kLeft], sides_[kRight]);
  for (int u = next(left); u <= right; u += kStep)
    scan({depth.pixels + u, mask.pixels + u, depth.stride, mask.stride, depth.height, top, bottom, nearest, reach},
         sides_[kAbove], sides_[kBelow]);
}

float OutlineLosses::lost() const {
  Side all;
  for (const Side& side : sides_) {
    all.pixels += side.pixels;
    all.lost += side.lost;
  }
  if (all.pixels < kPixelsMin) return std::numeric_limits<float>::quiet_NaN();
  return static_cast<float>(all.lost) / static_cast<float>(all.pixels);
}

float OutlineLosses::one_sided() const {
  const auto between = [](const Side& a, const Side& b) {
    if (a.pixels < kPixelsMin || b.pixels < kPixelsMin) return 0.0F;
    const auto share = [](const Side& side) {
      return static_cast<float>(side.lost) / static_cast<float>(side.pixels);
    };
    return share(a) > share(b) ? share(a) - share(b) : share(b) - share(a);
  };
  return std::max(between(sides_[kLeft], sides_[kRight]), between(sides_[kAbove], sides_[kBelow]));
}

}  // namespace im2fit
