// SPDX-License-Identifier: Apache-2.0
// What fusing, gridding and cutting one 640x480 portrait frame costs.
#include <benchmark/benchmark.h>

#include <cmath>
#include <vector>

#include "kernels/fuse/decimate.h"
#include "kernels/fuse/depth_fusion.h"
#include "kernels/profile/profile.h"
#include "tests/kernels/analytic_figure.h"

namespace {

using namespace im2fit;

const Intrinsics kCamera{480, 640, 575.8F, 575.8F, 239.5F, 319.5F};

struct Frame {
  std::vector<std::uint16_t> depth_mm, depth_q4;
  std::vector<std::uint8_t> mask;
  JointSet joints;
};

const Frame& frame() {
  static const Frame made = [] {
    const test::Figure figure = test::standing_figure(0, 2300);
    const test::FigureCloud cloud = test::render_cloud(figure, kCamera, 2.0, 0, 0, 7);
    Frame f;
    f.joints = figure.joints;
    for (const float z : cloud.z) {
      const bool person = !std::isnan(z);
      f.depth_mm.push_back(person ? static_cast<std::uint16_t>(std::lround(z)) : std::uint16_t{0});
      f.depth_q4.push_back(static_cast<std::uint16_t>(f.depth_mm.back() * 16));
      f.mask.push_back(person ? 255 : 0);
    }
    return f;
  }();
  return made;
}

void fuse(benchmark::State& state) {
  DepthFusion fusion(kCamera.width, kCamera.height);
  for (auto _ : state) {
    if (fusion.frame_count() >= 1000) fusion.reset();
    fusion.add({frame().depth_mm.data(), kCamera.width, kCamera.height},
               {frame().mask.data(), kCamera.width, kCamera.height}, 0, 0, kCamera.width - 1, kCamera.height - 1);
  }
}
BENCHMARK(fuse)->Unit(benchmark::kMicrosecond);

void grid(benchmark::State& state) {
  const int step = grid_step_px(kCamera, 2300);
  const Intrinsics k = grid_intrinsics(kCamera, step);
  const auto size = static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height);
  std::vector<float> x(size), y(size), z(size);
  for (auto _ : state) {
    decimate({frame().depth_q4.data(), kCamera.width, kCamera.height},
             {frame().mask.data(), kCamera.width, kCamera.height}, k, step, x, y, z);
    benchmark::DoNotOptimize(z.data());
  }
}
BENCHMARK(grid)->Unit(benchmark::kMicrosecond);

void profile(benchmark::State& state) {
  ProfileWorkspace work;
  std::vector<float> out(ProfileLayout::kSize);
  for (auto _ : state) {
    section_profile({frame().depth_q4.data(), kCamera.width, kCamera.height},
                    {frame().mask.data(), kCamera.width, kCamera.height}, kCamera, frame().joints, {}, work, out);
    benchmark::DoNotOptimize(out.data());
  }
}
BENCHMARK(profile)->Unit(benchmark::kMicrosecond);

}  // namespace

BENCHMARK_MAIN();
