// SPDX-License-Identifier: Apache-2.0
// A line over a round surface: 25 points as between the shoulders, 481 as along a picture's row.
#include <cmath>
#include <memory>

#include "bench/kernels/cases.h"
#include "bench/kernels/figure_picture.h"
#include "perception/paper/plan.h"

namespace im2fit::bench {

void add_geodesic_cases(Cases& cases) {
  for (const int count : {25, 481}) {
    struct Line {
      std::vector<std::int32_t> x, y, z;
    };
    const auto line = std::make_shared<Line>();
    for (int i = 0; i < count; ++i) {
      const double t = 3.0 * i / (count - 1);
      line->x.push_back(static_cast<std::int32_t>(-20000 * std::cos(t)));
      line->y.push_back(static_cast<std::int32_t>(900 * t));
      line->z.push_back(static_cast<std::int32_t>(290000 - 15000 * std::sin(t)));
    }
    const Floor floor = {instructions_us((count - 1) / 8.0 * 36), "36 instructions for 8 steps"};
    add_plain(cases, "geodesic/" + std::to_string(count), count - 1, "step", floor,
              [line, count] { keep(paper_detail::geodesic(line->x.data(), line->y.data(), line->z.data(), count)); });
  }
}

}  // namespace im2fit::bench
