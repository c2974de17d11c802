// SPDX-License-Identifier: Apache-2.0
#include "kernels/profile/crown.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace im2fit::profile {
namespace {

using L = ProfileLayout;
constexpr float kHeightBinMm = 4.0F;
constexpr float kHeightMinMm = -100.0F;

// Height below (from the top) or above (from the bottom) which `area_mm2` of the histogram lies.
float height_at_area(std::span<const float> histogram, float area_mm2, bool from_top) {
  float sum = 0;
  const int n = static_cast<int>(histogram.size());
  for (int i = 0; i < n; ++i) {
    const int bin = from_top ? n - 1 - i : i;
    const float here = histogram[static_cast<std::size_t>(bin)];
    if (here > 0 && sum + here >= area_mm2) {
      const float part = (area_mm2 - sum) / here;
      const float edge = from_top ? static_cast<float>(bin + 1) - part : static_cast<float>(bin) + part;
      return kHeightMinMm + kHeightBinMm * edge;
    }
    sum += here;
  }
  return kNaN;
}

// Area by height, of head pixels (from the top) or of all (from the bottom).
template <class Keep>
void height_histogram(const Scene& s, int row_begin, int row_end, ProfileWorkspace& work, Keep keep) {
  std::fill(work.height_area.begin(), work.height_area.end(), 0.0F);
  const float scale = 1.0F / (s.k.fx * s.k.fy);
  for (int v = row_begin; v < row_end; ++v) {
    for (int u = 0; u < s.mask.width; ++u) {
      const float z = s.z(u, v);
      if (z <= 0) continue;
      const Vec3f p = s.point(static_cast<float>(u), v, z);
      if (!keep(p)) continue;
      const int bin = static_cast<int>((s.frame.height(p) - kHeightMinMm) / kHeightBinMm);
      if (bin >= 0 && bin < kHeightBins) work.height_area[static_cast<std::size_t>(bin)] += z * z * scale;
    }
  }
}

float lowest_height(const Scene& s, int row_begin, int row_last) {
  float lowest = std::numeric_limits<float>::max();
  for (int v = std::max(0, row_begin); v <= row_last; ++v)
    for (int u = 0; u < s.mask.width; ++u)
      if (const float z = s.z(u, v); z > 0)
        lowest = std::min(lowest, s.frame.height(s.point(static_cast<float>(u), v, z)));
  return lowest < std::numeric_limits<float>::max() ? lowest : 0.0F;
}

}  // namespace

void crown_and_soles(Scene& s, bool floor_known, ProfileWorkspace& work, std::span<float> crown,
                     std::span<float> soles) {
  int first = 0;
  int last = s.mask.height - 1;
  const auto empty = [&](int v) {
    for (int u = 0; u < s.mask.width; ++u)
      if (s.mask.at(u, v) != 0) return false;
    return true;
  };
  while (first < last && empty(first)) ++first;
  while (last > first && empty(last)) --last;
  const int span = last - first + 1;
  if (!floor_known) s.frame.camera_height_mm -= lowest_height(s, last - span / 8, last);

  const float head_side = s.frame.side(s.joint(Joint::HE));
  height_histogram(s, first, first + span / 5, work,
                   [&](Vec3f p) { return std::abs(s.frame.side(p) - head_side) < 140.0F; });
  constexpr std::array<float, L::kCrownValues> kCrownAreas = {150.0F, 500.0F, 1500.0F, 4000.0F, 9000.0F};
  for (std::size_t i = 0; i < crown.size(); ++i) crown[i] = height_at_area(work.height_area, kCrownAreas[i], true);

  height_histogram(s, last - span / 5, last + 1, work, [](Vec3f) { return true; });
  constexpr std::array<float, L::kSoleValues> kSoleAreas = {400.0F, 1500.0F, 5000.0F, 12000.0F};
  for (std::size_t i = 0; i < soles.size(); ++i) soles[i] = height_at_area(work.height_area, kSoleAreas[i], false);
}

}  // namespace im2fit::profile
