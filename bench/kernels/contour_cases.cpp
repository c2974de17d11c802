// SPDX-License-Identifier: Apache-2.0
// The outline's rows: runs, jumps, sums.
#include <memory>

#include "bench/kernels/cases.h"
#include "bench/kernels/figure_picture.h"
#include "kernels/contour/contour.h"
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit::bench {

void add_contour_cases(Cases& cases) {
  struct Data : FigurePicture {
    std::vector<ContourRow> rows{640};
    std::vector<std::uint64_t> seen_words = std::vector<std::uint64_t>(640 * contour_words(480)), steps = seen_words;
  };
  const auto data = std::make_shared<Data>();
  const int pixels = data->camera.width * data->camera.height;
  const Floor floor = {instructions_us(pixels / 64.0 * 6 + 2.5 * data->seen / 16.0 * 22),
                       "a test for each 64 masks; 22 instructions for 16 pixels where 2 in 5 show the person"};
  add_variants(cases, "contour/480x640", kContourWithRef, pixels, "px", floor, true, [&](auto* function) {
    return [data, function] {
      function(data->depths(), data->masks(), data->rows.data(), data->seen_words.data(), data->steps.data());
      keep(data->rows[0]);
    };
  });
}

}  // namespace im2fit::bench
