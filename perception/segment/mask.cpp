// SPDX-License-Identifier: Apache-2.0
#include "perception/segment/mask.h"

#include <cstring>

#include "kernels/membership/membership.h"
#include "kernels/silhouette/silhouette.h"

namespace im2fit::segment {

MaskRefiner::MaskRefiner(const Grid& grid)
    : stride_(grid.width + 2),
      person_(static_cast<std::size_t>(stride_) * static_cast<std::size_t>(grid.height + 2), kNoSurface),
      other_(person_),
      row_any_(at(grid.width)),
      list_(grid.depth.size()) {}

void MaskRefiner::fill_planes(const Grid& grid, std::span<const std::uint8_t> chosen) {
  for (int r = 0; r < grid.height; ++r) {
    const auto from = at(grid.index(0, r));
    const auto to = static_cast<std::size_t>(r + 1) * static_cast<std::size_t>(stride_) + 1;
    const std::uint16_t* depth = grid.depth.data() + from;
    const std::uint8_t* mine = chosen.data() + from;
    std::uint16_t* person = person_.data() + to;
    std::uint16_t* other = other_.data() + to;
    for (int c = 0; c < grid.width; ++c) {
      const std::uint16_t z = depth[c] == 0 ? kNoSurface : depth[c];
      const auto hide = static_cast<std::uint16_t>(mine[c] != 0 ? 0 : kNoSurface);
      person[c] = z | hide;
      other[c] = static_cast<std::uint16_t>(z | ~hide);
    }
  }
}

// The person's cells and those beside, above and below them.
int MaskRefiner::list_cells(const Grid& grid, std::span<const std::uint8_t> chosen) {
  int count = 0;
  for (int r = 0; r < grid.height; ++r) {
    const std::uint8_t* here = chosen.data() + grid.index(0, r);
    const std::uint8_t* above = r > 0 ? here - grid.width : here;
    const std::uint8_t* below = r + 1 < grid.height ? here + grid.width : here;
    std::uint8_t* __restrict any = row_any_.data();
    const std::size_t last = row_any_.size() - 1;
    any[0] = static_cast<std::uint8_t>(here[0] | above[0] | below[0] | (last > 0 ? here[1] : 0));
    for (std::size_t c = 1; c < last; ++c)
      any[c] = static_cast<std::uint8_t>(here[c] | above[c] | below[c] | here[c - 1] | here[c + 1]);
    if (last > 0) any[last] = static_cast<std::uint8_t>(here[last] | above[last] | below[last] | here[last - 1]);
    for (std::size_t c = 0; c <= last; ++c) {
      if (c % kTogether == 0 && c + kTogether <= last + 1 && none(any + c)) {
        c += kTogether - 1;
        continue;
      }
      list_[at(count)] = static_cast<std::uint32_t>(r) << 16 | static_cast<std::uint32_t>(c);
      count += any[c] != 0 ? 1 : 0;
    }
  }
  return count;
}

void MaskRefiner::run(const Grid& grid, DepthView depth, std::span<const std::uint8_t> chosen, MaskImage mask) {
  for (int v = 0; v < mask.height; ++v) std::memset(mask.row(v), 0, static_cast<std::size_t>(mask.width));
  const int count = list_cells(grid, chosen);
  if (count == 0) return;
  fill_planes(grid, chosen);
  const MembershipCells cells = {
      person_.data() + stride_ + 1, other_.data() + stride_ + 1, stride_, grid.width, grid.height, grid.step};
  membership(depth, cells, list_.data(), count, mask);
}

void describe_mask(const Grid& grid, DepthView depth, MaskView mask, Person& person) {
  const Intrinsics& k = grid.intrinsics;
  Silhouette s;
  silhouette(depth, mask, s);
  person.pixel_count = s.count;
  person.u_min = s.count > 0 ? s.u_min : mask.width;
  person.v_min = s.count > 0 ? s.v_min : mask.height;
  person.u_max = s.u_max;
  person.v_max = s.v_max;
  if (s.count == 0) return;
  const double n = s.count;
  const auto sum_z = static_cast<double>(s.sum_z);
  person.centroid_mm = {static_cast<float>((static_cast<double>(s.sum_uz) - static_cast<double>(k.cx) * sum_z) /
                                           (n * static_cast<double>(k.fx))),
                        static_cast<float>((static_cast<double>(s.sum_vz) - static_cast<double>(k.cy) * sum_z) /
                                           (n * static_cast<double>(k.fy))),
                        static_cast<float>(sum_z / n)};
  person.cut_top = person.v_min <= 1;
  person.cut_bottom = person.v_max >= mask.height - 2;
  person.cut_left = person.u_min <= 1;
  person.cut_right = person.u_max >= mask.width - 2;
}

}  // namespace im2fit::segment
