// SPDX-License-Identifier: Apache-2.0
#include "bench/kernels/cases.h"
#include "bench/kernels/room_picture.h"
#include "kernels/silhouette/silhouette.h"
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

}  // namespace im2fit::bench
