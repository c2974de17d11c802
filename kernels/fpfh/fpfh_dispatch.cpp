// SPDX-License-Identifier: Apache-2.0
#include <cstddef>

#include "kernels/fpfh/fpfh.h"
#include "kernels/fpfh/fpfh_blocks.h"

namespace im2fit {

FpfhWorkspace::FpfhWorkspace(int width, int height) {
  const std::size_t count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  constexpr std::size_t kSlack = 64;  // the slack lets a block of pairs be read past the end or padded in place
  for (LazyZeros<float>* v : {&x, &y, &z, &nx, &ny, &nz}) *v = LazyZeros<float>(count + kSlack);
  row_table = LazyZeros<std::int32_t>(static_cast<std::size_t>(width + 1) * static_cast<std::size_t>(height));
  has_normal = LazyZeros<std::uint8_t>(count);
  needed = LazyZeros<std::uint8_t>(count + kSlack);
  // Left as they come: nothing is read before it is written. (libc++ 14 has no make_unique_for_overwrite.)
  counts.reset(new std::int32_t[count * kFpfhSize]);
  count_bytes.reset(new std::uint8_t[(count + kSlack) * fpfh_detail::kCountBytes]);
  const auto rows = static_cast<std::size_t>(height);
  for (std::vector<float>* v : {&row_slope, &row_norm, &row_inverse_norm}) v->resize(rows);
  for (std::vector<std::int32_t>* v : {&columns_low, &columns_high}) v->resize(rows);
  ranges.resize(2 * rows);
  near_list = LazyZeros<std::int32_t>(count + kSlack);
  blank_list = LazyZeros<std::int32_t>(count + kSlack);
}

void fpfh(const OrganisedCloud& cloud, std::span<const Vec3f> keypoints, float radius_mm, FpfhWorkspace& work,
          std::span<float> out) {
  IM2FIT_CHOSEN_ONCE best = fastest(kFpfhKernels);
  best(cloud, keypoints, radius_mm, work, out);
}

}  // namespace im2fit
