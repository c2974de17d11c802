// SPDX-License-Identifier: Apache-2.0
// Normals of a standing figure: on the device's 20 mm grid with the nearest neighbours, and on the full picture with
// windows of 3 cm each way.
#include <memory>

#include "bench/kernels/cases.h"
#include "kernels/normals/normals.h"
#include "perception/fuse/decimate.h"
#include "tests/kernels/ref/kernel_refs.h"
#include "tests/perception/analytic_figure.h"

namespace im2fit::bench {
namespace {

struct Scene {
  explicit Scene(int step)
      : cloud(test::render_cloud(test::standing_figure(0, 2300),
                                 grid_intrinsics({480, 640, 575.8F, 575.8F, 239.5F, 319.5F}, step), 2.0, 0.05, 0.02,
                                 7)),
        nx(cloud.x.size()),
        ny(nx),
        nz(nx) {}
  test::FigureCloud cloud;
  std::vector<float> nx, ny, nz;
};

void add(Cases& cases, const char* name, int step, int radius, bool with_ref) {
  const auto scene = std::make_shared<Scene>(step);
  // A point of the window: 3 loads and 23 operations; the eigenvector: 250 operations. Vectors of eight, four
  // operations a cycle.
  const double window = (2.0 * radius + 1) * (2.0 * radius + 1);
  const double points = scene->cloud.valid_count;
  const Floor floor = {points * (window * 26 + 250) / 8 / 4 / 2500, "26 operations a window point, 250 a normal"};
  add_variants(cases, name, kNormalsWithRef, points, "point", floor, with_ref, [&](auto* function) {
    return [scene, function, radius] {
      const test::FigureCloud& c = scene->cloud;
      function(c.intrinsics, c.x.data(), c.y.data(), c.z.data(), radius, 60, scene->nx.data(), scene->ny.data(),
               scene->nz.data());
      keep(scene->nx[0]);
    };
  });
}

}  // namespace

void add_normals_cases(Cases& cases) {
  add(cases, "normals/grid", 5, 1, true);
  add(cases, "normals/640x480", 1, 7, false);
}

}  // namespace im2fit::bench
