// SPDX-License-Identifier: Apache-2.0
#include "bench/kernels/cases.h"
#include "bench/kernels/room_picture.h"
#include "kernels/sample/sample.h"
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit::bench {

void add_sample_cases(Cases& cases) {
  for (const auto& [width, height, step] : {std::array{640, 480, 4}, {320, 240, 2}}) {
    const auto data = room_picture(width, height);
    const auto out = std::make_shared<std::vector<std::uint16_t>>(data->depth.size());
    const double rows_read = step == 4 ? 0.75 : 1;
    const double pixels = double(width) * height;
    const int step_px = step;  // a binding cannot be captured in C++20 by every compiler
    const Floor floor = {
        pixels * 2 * rows_read / 11.6e3,
        step == 4 ? "three rows in four read, 2 bytes a pixel, at 11.6 GB/s" : "2 bytes a pixel at 11.6 GB/s"};
    add_variants(cases, "sample/" + std::to_string(width) + "x" + std::to_string(height), kSampleWithRef, pixels,
                 "px", floor, true, [&](auto* function) {
                   return [data, out, function, step_px] {
                     function(data->view(), step_px, out->data());
                     keep((*out)[0]);
                   };
                 });
  }
}

}  // namespace im2fit::bench
