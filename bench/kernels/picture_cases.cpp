// SPDX-License-Identifier: Apache-2.0
// Whole pictures: read for the outline, sampled, unpacked.
#include <memory>

#include "bench/kernels/cases.h"
#include "bench/kernels/room_picture.h"
#include "kernels/sample/sample.h"
#include "kernels/silhouette/silhouette.h"
#include "kernels/unpack11/shift_table.h"
#include "kernels/unpack11/unpack11.h"
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit::bench {

void add_silhouette_cases(Cases& cases) {
  const auto data = room_picture(640, 480);
  const double pixels = 640.0 * 480;
  const Floor floor = {pixels / 11.6e3, "one byte of mask a pixel at 11.6 GB/s; depth only where it is set"};
  add_variants(cases, "silhouette/640x480", kSilhouetteWithRef, pixels, "px", floor, true, [&](auto* function) {
    return [data, function] {
      Silhouette s;
      function(data->view(), data->mask_view(), s);
      keep(s);
    };
  });
}

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
