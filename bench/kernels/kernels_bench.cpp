// SPDX-License-Identifier: Apache-2.0
// Times every case: kernels_bench --benchmark_filter=contour. Rates are per second, floors in microseconds.
#include <benchmark/benchmark.h>

#include "bench/kernels/cases.h"

int main(int argc, char** argv) {
  const im2fit::bench::Cases cases = im2fit::bench::all_cases();
  for (const im2fit::bench::Case& one : cases) {
    const auto run = [&one](benchmark::State& state) {
      for (auto _ : state) one.run();
      state.counters[one.item] = benchmark::Counter(one.items, benchmark::Counter::kIsIterationInvariantRate);
      state.counters["floor_us"] = one.floor.us;
      state.SetLabel(one.floor.why);
    };
    // NOLINTNEXTLINE(clang-analyzer-cplusplus.NewDeleteLeaks): the library keeps it
    benchmark::RegisterBenchmark((one.kernel + ":" + one.variant).c_str(), run)->Unit(benchmark::kMicrosecond);
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
}
