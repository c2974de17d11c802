// SPDX-License-Identifier: Apache-2.0
// Times the cases of a list (cases.h): bench_time kernels --benchmark_filter=contour. Rates are per second, floors in
// microseconds.
#include <benchmark/benchmark.h>

#include <cstdio>

#include "bench/kernels/cases.h"

int main(int argc, char** argv) {
  const im2fit::bench::CaseList* list = argc > 1 ? im2fit::bench::case_list(argv[1]) : nullptr;
  if (list == nullptr) {
    std::fprintf(stderr, "use: %s LIST [--benchmark_...]; LIST: %s\n", argv[0],
                 im2fit::bench::case_list_names().c_str());
    return 2;
  }
  const im2fit::bench::Cases cases = list->cases({});
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
  // The list's name is not the library's.
  argv[1] = argv[0];
  ++argv;
  --argc;
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
}
