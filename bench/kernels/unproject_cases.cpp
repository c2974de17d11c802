// SPDX-License-Identifier: Apache-2.0
#include <cstdint>
#include <memory>
#include <vector>

#include "bench/kernels/cases.h"
#include "kernels/unproject/unproject.h"

namespace im2fit::bench {

void add_unproject_cases(Cases& cases) {
  constexpr int kWidth = 640, kHeight = 480, kPixels = kWidth * kHeight;
  struct Data {
    std::vector<std::uint16_t> depth = std::vector<std::uint16_t>(kPixels);
    std::vector<float> x = std::vector<float>(kPixels), y = x, z = x;
    RayTable rays{kWidth, kHeight};
  };
  const auto data = std::make_shared<Data>();
  data->rays.set({kWidth, kHeight, 575.8F, 575.8F, 319.5F, 239.5F});
  // Eight rows in nine are seen.
  for (int i = 0; i < kPixels; ++i)
    data->depth[static_cast<std::size_t>(i)] = static_cast<std::uint16_t>((i / kWidth) % 9 == 0 ? 0 : 1800 + i % 700);
  const Floor floor = {kPixels * 14.0 / 11.6e3, "2 bytes read and 12 written a pixel at 11.6 GB/s"};
  add_variants(cases, "unproject/640x480", kUnprojectKernels, kPixels, "px", floor, true, [&](auto* function) {
    return [data, function] {
      function({data->depth.data(), kWidth, kHeight}, 0, data->rays, data->x.data(), data->y.data(), data->z.data());
      keep(data->x[0]);
    };
  });
}

}  // namespace im2fit::bench
