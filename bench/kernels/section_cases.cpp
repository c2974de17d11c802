// SPDX-License-Identifier: Apache-2.0
// Five cuts through a person, and the sums of one of them.
#include <array>
#include <memory>

#include "bench/kernels/cases.h"
#include "bench/kernels/figure_picture.h"
#include "kernels/section/section.h"
#include "perception/paper/ellipse.h"
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit::bench {
namespace {

struct Cuts : FigurePicture {
  static constexpr int kCapacity = 32767;
  std::array<SectionCut, 5> cuts;
  std::array<int, 5> counts{};
  std::vector<SectionPoint> points = std::vector<SectionPoint>(5 * (kCapacity + kSectionSlack));
  SectionScan scan{};
  Cuts() {
    // Neck, shoulders, chest, waist, hips.
    constexpr std::array<double, 5> kDown = {-630, -560, -390, -240, 60};
    for (std::size_t i = 0; i < cuts.size(); ++i) cuts[i] = {form_offset(kDown[i]), 0, form_offset(2300)};
    scan = {depths(),     masks(),        down.columns(), down.rows(), right.columns(),
            right.rows(), away.columns(), away.rows(),    cuts.data(), static_cast<int>(cuts.size())};
    section(scan, points.data(), kCapacity, counts.data());
  }
};

}  // namespace

void add_section_cases(Cases& cases) {
  const auto data = std::make_shared<Cuts>();
  const int pixels = data->camera.width * data->camera.height;
  const Floor floor = {instructions_us(pixels / 8.0 * 3 + 1.2 * data->seen / 8.0 * (22 + 5 * 6 + 0.5 * 40)),
                       "3 instructions to skip 8 pixels; of those seen 22 for 8 heights, 6 a cut, 40 where a cut is "
                       "near, at every other"};
  add_variants(cases, "section/480x640", kSectionWithRef, data->seen, "px", floor, false, [&](auto* function) {
    return [data, function] {
      function(data->scan, data->points.data(), Cuts::kCapacity, data->counts.data());
      keep(data->counts);
    };
  });
}

void add_moments_cases(Cases& cases) {
  const auto data = std::make_shared<Cuts>();
  const SectionPoint* points = data->points.data() + 3 * (Cuts::kCapacity + kSectionSlack);
  const int count = data->counts[3];
  const Floor floor = {instructions_us(count / 8.0 * 57),
                       "57 instructions for 8 points: two groups of 9 sums of 64 bits"};
  add_plain(cases, "moments/waist", count, "point", floor, [data, points, count] {
    std::array<std::int64_t, kMomentCount> sums;
    moments(points, count, -1400, 1400, sums.data());
    keep(sums);
  });
}

}  // namespace im2fit::bench
