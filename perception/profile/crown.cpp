// SPDX-License-Identifier: Apache-2.0
#include "perception/profile/crown.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

namespace im2fit::profile {
namespace {

using L = ProfileLayout;

constexpr int kHeightBinShift = CoordinateMm::kFractionBits + 2;
static_assert(kHeightBinMm << CoordinateMm::kFractionBits == 1 << kHeightBinShift);

struct HeightRow {
  const std::uint16_t* depth;
  const std::uint8_t* mask;
  std::int32_t up_row, side_row;
};

std::int32_t scan_pixels(const HeightScan& s, const HeightRow& row, int begin, int end, std::int32_t lowest,
                         std::uint64_t* squares) {
  for (int u = begin; u < end; ++u) {
    const std::uint16_t depth = row.depth[u];
    if (row.mask[u] == 0 || depth == 0) continue;
    const std::int32_t side = form_product(s.side_columns[u] + row.side_row, depth) + s.side_offset;
    if (side >= s.side_max || side <= -s.side_max) continue;
    const std::int32_t height = form_product(s.up_columns[u] + row.up_row, depth) + s.up_offset;
    if (height < lowest) lowest = height;
    const std::int32_t bin = (height - kHeightMinMm * (1 << CoordinateMm::kFractionBits)) >> kHeightBinShift;
    if (bin >= 0 && bin < kHeightBins) squares[bin] += std::uint32_t{depth} * std::uint32_t{depth};
  }
  return lowest;
}

// Heights below (from the top) or above (from the bottom) which the areas lie, rising ones; NaN where there is less.
void heights_at_areas(std::span<const std::uint64_t> squares, double mm2_per_square, bool from_top,
                      std::span<const float> areas_mm2, std::span<float> out) {
  std::size_t next = 0;
  double sum = 0;
  const int n = static_cast<int>(squares.size());
  for (int i = 0; i < n && next < areas_mm2.size(); ++i) {
    const int bin = from_top ? n - 1 - i : i;
    const std::uint64_t square = squares[static_cast<std::size_t>(bin)];
    if (square == 0) continue;
    const double here = static_cast<double>(square) * mm2_per_square;
    while (next < areas_mm2.size() && sum + here >= double{areas_mm2[next]}) {
      const double part = (double{areas_mm2[next]} - sum) / here;
      const double edge = from_top ? bin + 1 - part : bin + part;
      out[next++] = static_cast<float>(kHeightMinMm + kHeightBinMm * edge);
    }
    sum += here;
  }
  std::fill(out.begin() + static_cast<std::ptrdiff_t>(next), out.end(), kNaN);
}

// Rows begin .. end - 1 of the picture; points further than side_max_mm from side_mm do not count.
HeightScan scan_of(const Scene& s, const ProfileWorkspace& work, int begin, int end, float side_mm,
                   std::int32_t side_max) {
  begin = std::max(begin, 0);
  const ImageView<const std::uint16_t> depth = {s.depth.row(begin), s.depth.width, end - begin, s.depth.stride};
  const MaskView mask = {s.mask.row(begin), s.mask.width, end - begin, s.mask.stride};
  const double side_offset = -double{dot(s.frame.right, s.frame.origin_mm)} - double{side_mm};
  return {depth,
          mask,
          work.up.columns(),
          work.up.rows() + begin,
          work.side.columns(),
          work.side.rows() + begin,
          form_offset(double{s.frame.camera_height_mm}),
          form_offset(side_offset),
          side_max};
}

}  // namespace

std::int32_t sum_by_height(const HeightScan& s, std::uint64_t* squares) {
  std::memset(squares, 0, kHeightBins * sizeof *squares);
  std::int32_t lowest = kHeightNone;
  const int width = s.depth_q4.width;
  for (int v = 0; v < s.depth_q4.height; ++v) {
    const HeightRow row = {s.depth_q4.row(v), s.mask.row(v), s.up_rows[v], s.side_rows[v]};
    int u = 0;
    for (; u + 8 <= width; u += 8) {
      std::uint64_t masks;
      std::memcpy(&masks, row.mask + u, 8);
      if (masks != 0) lowest = scan_pixels(s, row, u, u + 8, lowest, squares);
    }
    lowest = scan_pixels(s, row, u, width, lowest, squares);
  }
  return lowest;
}

void crown_and_soles(Scene& s, bool floor_known, ProfileWorkspace& work, std::span<float> crown,
                     std::span<float> soles) {
  constexpr std::int32_t kAnySide = std::numeric_limits<std::int32_t>::max();
  constexpr double kHeadHalfMm = 140;
  constexpr float kFarthestMm = 100000.0F;
  int first = 0;
  int last = s.mask.height - 1;
  const auto empty = [&](int v) { return work.outline[static_cast<std::size_t>(v)].count == 0; };
  while (first < last && empty(first)) ++first;
  while (last > first && empty(last)) --last;
  const int span = last - first + 1;
  if (!floor_known) {
    const std::int32_t lowest =
        sum_by_height(scan_of(s, work, last - span / 8, last + 1, 0, kAnySide), work.squares.data());
    if (lowest != kHeightNone) s.frame.camera_height_mm -= static_cast<float>(CoordinateMm::from_raw(lowest).real());
  }

  const double mm2_per_square = 1.0 / (256.0 * double{s.k.fx} * double{s.k.fy});
  const float head_side = s.frame.side(s.joint(Joint::HE));
  if (!(std::abs(head_side) < kFarthestMm)) return;  // nowhere, so that nothing is at the head
  sum_by_height(scan_of(s, work, first, first + span / 5, head_side, form_offset(kHeadHalfMm)), work.squares.data());
  constexpr std::array<float, L::kCrownValues> kCrownAreas = {150.0F, 500.0F, 1500.0F, 4000.0F, 9000.0F};
  heights_at_areas(work.squares, mm2_per_square, true, kCrownAreas, crown);

  sum_by_height(scan_of(s, work, last - span / 5, last + 1, 0, kAnySide), work.squares.data());
  constexpr std::array<float, L::kSoleValues> kSoleAreas = {400.0F, 1500.0F, 5000.0F, 12000.0F};
  heights_at_areas(work.squares, mm2_per_square, false, kSoleAreas, soles);
}

}  // namespace im2fit::profile
