// SPDX-License-Identifier: Apache-2.0
// One frame into the mean of thirty, and the mean taken; the person covers a tenth of the picture.
#include "bench/kernels/cases.h"
#include "bench/kernels/room_picture.h"
#include "kernels/average/average.h"
#include "kernels/blocks/blocks.h"
#include "kernels/mean/mean.h"
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit::bench {

void add_fuse_cases(Cases& cases) {
  constexpr int kPixels = 640 * 480;
  struct Data {
    std::shared_ptr<const RoomPicture> room = room_picture(640, 480);
    std::vector<std::uint32_t> sum = std::vector<std::uint32_t>(kPixels);
    std::vector<std::uint16_t> seen = std::vector<std::uint16_t>(kPixels), depth = seen;
    std::vector<std::uint8_t> mask = std::vector<std::uint8_t>(kPixels);
    int frames = 0;
  };
  const auto data = std::make_shared<Data>();
  for (std::size_t i = 0; i < kPixels; ++i) {
    if (data->room->mask[i] == 0) continue;
    data->seen[i] = 30;
    data->sum[i] = 30U * data->room->depth[i] + static_cast<std::uint32_t>(i % 40);
  }
  const Floor into = {kPixels * (1 + 0.1 * 14) / 11.6e3,
                      "one byte of mask a pixel, of the person's 2 + 12 bytes more, at 11.6 GB/s"};
  add_variants(cases, "fuse.average/640x480", kAverageWithRef, kPixels, "px", into, true, [&](auto* function) {
    return [data, function] {
      // At most 1000 frames: then the sums begin again.
      if (++data->frames % 1000 == 0) {
        for (std::size_t i = 0; i < kPixels; ++i) data->sum[i] = data->seen[i] = 0;
      }
      for (int v = 0; v < 480; ++v)
        function(data->room->depth.data() + v * 640, data->room->mask.data() + v * 640, 640,
                 data->sum.data() + v * 640, data->seen.data() + v * 640);
      keep(data->sum[0]);
    };
  });
  const Floor out = {kPixels * 9 / 11.6e3, "6 bytes read and 3 written a pixel at 11.6 GB/s"};
  add_variants(cases, "fuse.mean/640x480", kMeanWithRef, kPixels, "px", out, true, [&](auto* function) {
    return [data, function] {
      function(data->sum.data(), data->seen.data(), kPixels, 15, data->depth.data(), data->mask.data());
      keep(data->depth[0]);
    };
  });
  for (std::size_t i = 0; i < kPixels; ++i) data->depth[i] = static_cast<std::uint16_t>(16 * data->room->depth[i]);
  const Floor grid = {kPixels * (1 + 0.1 * 4) / 11.6e3, "one byte of mask a pixel, of the person's depth twice"};
  add_variants(cases, "fuse.blocks/640x480", kBlocksWithRef, kPixels, "px", grid, true, [&](auto* function) {
    return [data, function] {
      function({data->depth.data(), 640, 480}, data->room->mask_view(), {5, 128, 96}, data->sum.data(),
               data->seen.data());
      keep(data->sum[0]);
    };
  });
}

}  // namespace im2fit::bench
