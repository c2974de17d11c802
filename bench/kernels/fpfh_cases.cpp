// SPDX-License-Identifier: Apache-2.0
// Descriptors at the fifteen joints: on the device's 20 mm grid and exact on the full picture.
#include <array>
#include <memory>

#include "bench/kernels/cases.h"
#include "kernels/fpfh/fpfh.h"
#include "perception/fuse/decimate.h"
#include "tests/kernels/ref/kernel_refs.h"
#include "tests/perception/analytic_figure.h"

namespace im2fit::bench {
namespace {

// Points closer than the radius of which a keypoint needs at least one, each pair once: counted by brute force, once,
// for the scene is seeded.
struct Size {
  const char* name;
  int step;
  double pair_count;
  bool with_ref;
};
constexpr Size kSizes[] = {
    {"fpfh/grid", 5, 135'304, true}, {"fpfh/320x240", 2, 5'163'000, false}, {"fpfh/640x480", 1, 82'481'439, false}};

// Eight pairs with AVX2: 6 loads, 34 operations for the distance and the four products, 20 for the bins of f1, 50 for
// the swap, the roots and the other bins: 110; to count a pair 5 more each: 150 of which four start in a cycle.
constexpr double kPairUs = 150.0 / 8 / 4 / 2500;

struct Scene {
  explicit Scene(int step)
      : figure(test::standing_figure(0, 2300)),
        cloud(test::render_cloud(figure, grid_intrinsics({480, 640, 575.8F, 575.8F, 239.5F, 319.5F}, step), 2.0, 0.05,
                                 0.02, 7)),
        work(cloud.intrinsics.width, cloud.intrinsics.height) {}

  test::Figure figure;
  test::FigureCloud cloud;
  FpfhWorkspace work;
  std::array<float, kFpfhSize * kJointCount> out{};
};

void add(Cases& cases, const Size& size) {
  const auto scene = std::make_shared<Scene>(size.step);
  const Floor floor = {size.pair_count * kPairUs, "19 vector operations a pair, four a cycle"};
  add_variants(cases, size.name, kFpfhWithRef, size.pair_count, "pair", floor, size.with_ref, [&](auto* function) {
    return [scene, function] {
      const test::FigureCloud& c = scene->cloud;
      function({c.intrinsics, c.x.data(), c.y.data(), c.z.data(), c.nx.data(), c.ny.data(), c.nz.data()},
               scene->figure.joints.position_mm, kFpfhRadiusMm, scene->work, scene->out);
      keep(scene->out);
    };
  });
}

}  // namespace

void add_fpfh_cases(Cases& cases) {
  for (const Size& size : kSizes) add(cases, size);
}

}  // namespace im2fit::bench
