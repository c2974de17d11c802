// SPDX-License-Identifier: Apache-2.0
// Heights of the lower fifth of a person: shins and feet.
#include <memory>

#include "bench/kernels/cases.h"
#include "bench/kernels/figure_picture.h"
#include "perception/profile/crown.h"

namespace im2fit::bench {

void add_height_cases(Cases& cases) {
  struct Data : FigurePicture {
    std::vector<std::uint64_t> squares = std::vector<std::uint64_t>(profile::kHeightBins);
    profile::HeightScan scan{};
    int counted = 0;
  };
  const auto data = std::make_shared<Data>();
  constexpr int kFirst = 470, kRows = 100;
  const std::ptrdiff_t first = std::ptrdiff_t{kFirst} * data->camera.width;
  data->scan = {{data->depth_q4.data() + first, data->camera.width, kRows},
                {data->mask.data() + first, data->camera.width, kRows},
                data->down.columns(),
                data->down.rows() + kFirst,
                data->right.columns(),
                data->right.rows() + kFirst,
                form_offset(0),
                form_offset(0),
                form_offset(1000)};
  for (std::ptrdiff_t i = first; i < first + kRows * data->camera.width; ++i)
    data->counted += data->mask[static_cast<std::size_t>(i)] != 0 ? 1 : 0;
  const Floor floor = {instructions_us(kRows * 60 * 4 + data->counted * (3.0 + 45.0 / 8)),
                       "3 instructions a pixel to add, 45 for 8 pixels' heights and sides, 4 to skip 8"};
  add_plain(cases, "height/480x100", data->counted, "px", floor,
            [data] { keep(profile::sum_by_height(data->scan, data->squares.data())); });
}

}  // namespace im2fit::bench
