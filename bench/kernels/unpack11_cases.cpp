// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include "bench/kernels/cases.h"
#include "kernels/unpack11/shift_table.h"
#include "kernels/unpack11/unpack11.h"
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit::bench {

void add_unpack11_cases(Cases& cases) {
  struct Data {
    std::vector<std::uint8_t> packed = std::vector<std::uint8_t>(unpack11_bytes(640 * 480));
    std::vector<std::uint16_t> out = std::vector<std::uint16_t>(640 * 480);
    ShiftTable table = shift_table({});
  };
  const auto data = std::make_shared<Data>();
  for (std::size_t i = 0; i < data->packed.size(); ++i) data->packed[i] = static_cast<std::uint8_t>(i * 197 >> 3);
  const double pixels = 640.0 * 480;
  const Floor floor = {pixels * 2 / 32 / 2.5e3, "2 bytes written a pixel, 32 a cycle, into the second cache"};
  add_variants(cases, "unpack11/640x480", kUnpack11WithRef, pixels, "px", floor, true, [&](auto* function) {
    return [data, function] {
      function(data->packed.data(), 640 * 480, data->out.data());
      keep(data->out[0]);
    };
  });
  Case frame;
  frame.kernel = "unpack11/640x480";
  frame.variant = "to_mm";
  frame.items = pixels;
  frame.item = "px";
  frame.floor = floor;
  frame.run = [data] {
    shifts_to_mm(data->packed.data(), 640 * 480, data->table, data->out.data());
    keep(data->out[0]);
  };
  cases.push_back(frame);
}

}  // namespace im2fit::bench
