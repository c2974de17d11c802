// SPDX-License-Identifier: Apache-2.0
#include "perception/observe/hole_filler.h"

#include <algorithm>

namespace im2fit {
namespace {

constexpr int kReachesAcross = 40;  // a hole's data lie within this part of the picture's long side
constexpr int kSamplesAcross = 80;  // of the picture, to decide whether it is riddled
constexpr int kRiddledShare = 6;    // a sixth; of undisturbed scenes 1 to 3 % is

}  // namespace

HoleFiller::HoleFiller(int width, int height)
    : reach_px_(std::max(2, std::max(width, height) / kReachesAcross)),
      out_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)),
      above_row_(static_cast<std::size_t>(width)),
      below_row_(static_cast<std::size_t>(width)) {}

// Counts on a lattice of pixels: lost ones with data near on all four sides against those with data.
bool HoleFiller::riddled(DepthView depth) const {
  const int step = std::max(1, std::max(depth.width, depth.height) / kSamplesAcross);
  const auto near = [&](int u, int v, int du, int dv) {
    for (int i = 1; i <= reach_px_; ++i) {
      const int x = u + i * du, y = v + i * dv;
      if (x < 0 || y < 0 || x >= depth.width || y >= depth.height) return false;
      if (depth.at(x, y) != 0) return true;
    }
    return false;
  };
  int seen = 0, lost = 0;
  for (int v = step / 2; v < depth.height; v += step)
    for (int u = step / 2; u < depth.width; u += step) {
      if (depth.at(u, v) != 0)
        ++seen;
      else if (near(u, v, -1, 0) && near(u, v, 1, 0) && near(u, v, 0, -1) && near(u, v, 0, 1))
        ++lost;
    }
  return lost * kRiddledShare > seen + lost;
}

// Nearest data to the left and above are remembered; those to the right and below are searched once and kept until
// passed, so that a pixel costs the same however large its hole.
void HoleFiller::fill(DepthView depth) {
  constexpr int kNone = -(1 << 20);
  std::fill(above_row_.begin(), above_row_.end(), kNone);
  std::fill(below_row_.begin(), below_row_.end(), 0);
  for (int v = 0; v < depth.height; ++v) {
    const std::uint16_t* row = depth.row(v);
    std::uint16_t* out = out_.data() + static_cast<std::ptrdiff_t>(v) * depth.width;
    int left = kNone, right = 0;
    for (int u = 0; u < depth.width; ++u) {
      const auto column = static_cast<std::size_t>(u);
      out[u] = row[u];
      if (row[u] != 0) {
        left = u;
        above_row_[column] = v;
        continue;
      }
      right = std::max(right, u + 1);
      while (right < depth.width && right - u <= reach_px_ && row[right] == 0) ++right;
      int below = std::max(below_row_[column], v + 1);
      while (below < depth.height && below - v <= reach_px_ && depth.at(u, below) == 0) ++below;
      below_row_[column] = below;
      std::uint16_t nearest = 0xFFFF, second = 0xFFFF;
      int count = 0;
      const auto take = [&](std::uint16_t z) {
        second = std::min(second, std::max(nearest, z));
        nearest = std::min(nearest, z);
        ++count;
      };
      if (u - left <= reach_px_) take(row[left]);
      if (right < depth.width && right - u <= reach_px_) take(row[right]);
      if (v - above_row_[column] <= reach_px_) take(depth.at(u, above_row_[column]));
      if (below < depth.height && below - v <= reach_px_) take(depth.at(u, below));
      if (count < 3) continue;
      out[u] = second;
    }
  }
}

DepthView HoleFiller::run(DepthView depth) {
  filled_ = riddled(depth);
  if (!filled_) return depth;
  fill(depth);
  return {out_.data(), depth.width, depth.height};
}

float drop_lost_pixels(DepthView depth, MaskImage mask) {
  int total = 0, lost = 0;
  for (int v = 0; v < mask.height; ++v) {
    const std::uint16_t* z = depth.row(v);
    std::uint8_t* m = mask.row(v);
    for (int u = 0; u < mask.width; ++u) {
      if (m[u] == 0) continue;
      ++total;
      if (z[u] != 0) continue;
      ++lost;
      m[u] = 0;
    }
  }
  return total > 0 ? static_cast<float>(lost) / static_cast<float>(total) : 0.0F;
}

}  // namespace im2fit
