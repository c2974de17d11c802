// SPDX-License-Identifier: Apache-2.0
#include <cstddef>

#include "kernels/fpfh/fpfh.h"

namespace im2fit {

FpfhWorkspace::FpfhWorkspace(int width, int height) {
  const std::size_t count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  for (std::vector<float>* v : {&x, &y, &z, &nx, &ny, &nz}) v->resize(count);
  row_table.resize(static_cast<std::size_t>(width + 1) * static_cast<std::size_t>(height));
  has_normal.resize(count);
  needed.resize(count);
  counts = std::make_unique_for_overwrite<std::int32_t[]>(count * kFpfhSize);
  neighbour_count.resize(count);
  near_list.resize(count + 64);  // the slack lets a block of pairs be padded in place
  blank_list.resize(count + 64);
}

void fpfh(const OrganisedCloud& cloud, std::span<const Vec3f> keypoints, float radius_mm, FpfhWorkspace& work,
          std::span<float> out) {
  IM2FIT_CHOSEN_ONCE best = fastest(kFpfhKernels);
  best(cloud, keypoints, radius_mm, work, out);
}

}  // namespace im2fit
