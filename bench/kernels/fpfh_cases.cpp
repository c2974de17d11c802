// SPDX-License-Identifier: Apache-2.0
// Descriptors at the fifteen joints: on the device's 20 mm grid and exact on the full picture.
#include <array>
#include <memory>

#include "bench/kernels/cases.h"
#include "kernels/fpfh/fpfh.h"
#include "kernels/fuse/decimate.h"
#include "tests/kernels/analytic_figure.h"

namespace im2fit::bench {
namespace {

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

void add(Cases& cases, const char* name, int step, bool with_ref) {
  const auto scene = std::make_shared<Scene>(step);
  add_variants(cases, name, kFpfhKernels, scene->cloud.valid_count, "point", {}, with_ref, [&](auto* function) {
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
  add(cases, "fpfh/grid", 5, true);
  add(cases, "fpfh/320x240", 2, false);
  add(cases, "fpfh/640x480", 1, false);
}

}  // namespace im2fit::bench
