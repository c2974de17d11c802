// SPDX-License-Identifier: Apache-2.0
// A lens of 12 % at the picture's edge. `table` looks each pixel up, which is what runs replace.
#include "bench/kernels/cases.h"
#include "bench/kernels/room_picture.h"
#include "hal/undistort.h"

namespace im2fit::bench {

void add_undistort_cases(Cases& cases) {
  struct Data {
    std::shared_ptr<const RoomPicture> room = room_picture(640, 480);
    std::vector<std::int32_t> table;
    std::vector<hal::UndistortRun> runs;
    std::vector<std::uint16_t> out = std::vector<std::uint16_t>(room->depth.size());
  };
  const auto data = std::make_shared<Data>();
  const Intrinsics& k = data->room->intrinsics;
  for (int v = 0; v < 480; ++v) {
    for (int u = 0; u < 640; ++u) {
      const float x = (static_cast<float>(u) - k.cx) / k.fx, y = (static_cast<float>(v) - k.cy) / k.fy;
      const float r2 = x * x + y * y, radial = 1 + r2 * (0.25F - 0.1F * r2);
      const float column = x * radial * k.fx + k.cx + 0.5F, row = y * radial * k.fy + k.cy + 0.5F;
      const bool inside = column >= 0 && row >= 0 && column < 640 && row < 480;
      data->table.push_back(inside ? static_cast<int>(row) * 640 + static_cast<int>(column) : -1);
    }
  }
  data->runs = hal::undistort_runs(data->table);
  const double pixels = 640.0 * 480;
  const Floor floor = {pixels * 4 / 11.6e3, "2 bytes read and 2 written a pixel at 11.6 GB/s"};
  add_plain(cases, "undistort/640x480", pixels, "px", floor, [data] {
    hal::undistort(data->room->depth.data(), 640 * 480, data->runs, data->out.data());
    keep(data->out[0]);
  });
  Case table;
  table.kernel = "undistort/640x480";
  table.variant = "table";
  table.items = pixels;
  table.item = "px";
  table.floor = floor;
  table.run = [data] {
    const std::uint16_t* in = data->room->depth.data();
    for (std::size_t i = 0; i < data->out.size(); ++i)
      data->out[i] = data->table[i] < 0 ? std::uint16_t{0} : in[data->table[i]];
    keep(data->out[0]);
  };
  cases.push_back(table);
}

}  // namespace im2fit::bench
