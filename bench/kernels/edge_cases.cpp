// SPDX-License-Identifier: Apache-2.0
#include "bench/kernels/cases.h"
#include "bench/kernels/room_picture.h"
#include "kernels/edge/edge.h"

namespace im2fit::bench {

void add_edge_cases(Cases& cases) {
  const auto data = room_picture(640, 480);
  const auto mask = std::make_shared<std::vector<std::uint8_t>>(data->depth.size());
  const double pixels = 640.0 * 480;
  const Floor floor = {pixels / 16 * 60 / 3 / 2.5e3, "60 vector operations for 16 pixels, three a cycle"};
  add_variants(cases, "edge/640x480", kEdgeKernels, pixels, "px", floor, true, [&](auto* function) {
    return [data, mask, function] {
      function(data->view(), {mask->data(), 640, 480});
      keep((*mask)[0]);
    };
  });
}

}  // namespace im2fit::bench
