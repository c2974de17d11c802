// SPDX-License-Identifier: Apache-2.0
// What reads a person's picture row by row or along a line: outline, heights, cuts, geodesics.
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "bench/kernels/cases.h"
#include "kernels/contour/contour.h"
#include "kernels/rayform/ray_form.h"
#include "kernels/section/section.h"
#include "perception/paper/ellipse.h"
#include "perception/paper/plan.h"
#include "perception/profile/crown.h"
#include "tests/kernels/ref/kernel_refs.h"
#include "tests/perception/analytic_figure.h"

namespace im2fit::bench {
namespace {

// A fused portrait picture, 480x640: a person at 2.3 m, 2 mm of noise.
struct FigurePicture {
  Intrinsics camera{480, 640, 575.8F, 575.8F, 239.5F, 319.5F};
  test::Figure figure = test::standing_figure(0, 2300);
  std::vector<std::uint16_t> depth_q4;
  std::vector<std::uint8_t> mask;
  int seen = 0;  // px
  RayTable rays{480, 640};
  RayForm right{480, 640}, down{480, 640}, away{480, 640};

  FigurePicture() {
    const test::FigureCloud cloud = test::render_cloud(figure, camera, 2.0, 0, 0, 7);
    for (const float z : cloud.z) {
      const bool person = !std::isnan(z);
      depth_q4.push_back(person ? static_cast<std::uint16_t>(std::lround(z * 16)) : std::uint16_t{0});
      mask.push_back(person ? 255 : 0);
    }
    seen = cloud.valid_count;
    rays.set(camera);
    right.set(rays, {1, 0, 0});
    down.set(rays, {0, 1, 0});
    away.set(rays, {0, 0, 1});
  }
  ImageView<const std::uint16_t> depths() const { return {depth_q4.data(), camera.width, camera.height}; }
  MaskView masks() const { return {mask.data(), camera.width, camera.height}; }
};

// Instructions at 4 a cycle of 2.5 GHz.
double instructions_us(double count) {
  return count / 1e4;
}

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

// The outline's rows: runs, jumps, sums.
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

// Heights of the lower fifth of a person: shins and feet.
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

// Five cuts through a person, and the sums of one of them.
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

// A line over a round surface: 25 points as between the shoulders, 481 as along a picture's row.
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
