// SPDX-License-Identifier: Apache-2.0
// Descriptors at the fifteen joints: every tier of kernels.inc, on the device's 20 mm grid and on the full picture.
#include <benchmark/benchmark.h>

#include <array>

#include "kernels/fpfh/fpfh.h"
#include "kernels/fuse/decimate.h"
#include "tests/kernels/analytic_figure.h"

namespace {

using namespace im2fit;

test::FigureCloud person(int step) {
  const Intrinsics camera{480, 640, 575.8F, 575.8F, 239.5F, 319.5F};
  return test::render_cloud(test::standing_figure(0, 2300), grid_intrinsics(camera, step), 2.0, 0.05, 0.02, 7);
}

void descriptors(benchmark::State& state, const FpfhKernel& kernel, int step) {
  const test::FigureCloud cloud = person(step);
  FpfhWorkspace work(cloud.intrinsics.width, cloud.intrinsics.height);
  std::array<float, kFpfhSize * kJointCount> out{};
  const auto joints = test::standing_figure(0, 2300).joints.position_mm;
  const OrganisedCloud view{cloud.intrinsics, cloud.x.data(),  cloud.y.data(), cloud.z.data(),
                            cloud.nx.data(),  cloud.ny.data(), cloud.nz.data()};
  for (auto _ : state) {
    kernel.function(view, joints, kFpfhRadiusMm, work, out);
    benchmark::DoNotOptimize(out);
  }
  state.counters["points"] = cloud.valid_count;
}

}  // namespace

int main(int argc, char** argv) {
  for (const im2fit::FpfhKernel& kernel : im2fit::kFpfhKernels) {
    const std::string name = kernel.name;
    benchmark::RegisterBenchmark(("fpfh/grid/" + name).c_str(), descriptors, kernel, 5)
        ->Unit(benchmark::kMillisecond);
    if (kernel.tier != im2fit::Tier::ref)  // the reference takes minutes there
      benchmark::RegisterBenchmark(("fpfh/full/" + name).c_str(), descriptors, kernel, 1)
          ->Unit(benchmark::kMillisecond)
          ->Iterations(1);
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
}
