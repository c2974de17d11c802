// SPDX-License-Identifier: Apache-2.0
// A body from parameters, on random targets with the shape of the real ones: 17,774 vertices, 100 targets at work.
#include <cstdint>
#include <memory>
#include <vector>

#include "bench/kernels/cases.h"
#include "core/rng.h"
#include "kernels/blend/blend.h"
#include "kernels/skin/skin.h"
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit::bench {
namespace {

constexpr int kVertices = 17774;

}  // namespace

// Half of the runs are short and cost their own overhead: of the real ones three in ten are a single vertex, a tenth
// each two and three, then up to 8, 16, 64 and several hundred. The compiler vectorises portable (4 lanes on x86 and
// NEON), so that NEON, as wide, gains on the rests and the short runs only.
void add_blend_cases(Cases& cases) {
  constexpr int kTargets = 100, kRuns = 65;
  struct Data {
    std::vector<BlendRun> runs;
    std::vector<std::int16_t> deltas;
    std::vector<float> vertices = std::vector<float>(3 * kVertices, 100.0F);
  };
  const auto data = std::make_shared<Data>();
  Rng rng(6);
  std::uint32_t deltas = 0;
  for (int i = 0; i < kTargets * kRuns; ++i) {
    const int longest[] = {1, 1, 1, 2, 3, 7, 7, 15, 63, 1000};
    const int top = longest[rng.index(10)];
    const auto count = static_cast<std::uint16_t>(top <= 3 ? top : top / 2 + rng.index(top / 2 + 1));
    data->runs.push_back({deltas, static_cast<std::uint16_t>(rng.index(kVertices - count)), count});
    deltas += count;
  }
  data->deltas.resize(3 * std::size_t{deltas});
  for (std::int16_t& d : data->deltas) d = static_cast<std::int16_t>(rng.index(201) - 100);
  const double values = 3.0 * deltas;
  const Floor floor = {values / 8 / 2500, "a store of 8 values a cycle"};
  add_variants(cases, "blend/100_targets", kBlendWithRef, values, "value", floor, true, [&](auto* function) {
    return [data, function] {
      for (std::size_t t = 0; t < kTargets; ++t) {
        const BlendInto into = {t % 2 == 0 ? 0.01F : -0.01F, data->vertices.data()};
        function(data->runs.data() + t * kRuns, kRuns, data->deltas.data(), &into, 1);
      }
      keep(data->vertices[0]);
    };
  });
}

// Weights as they lie in the real mesh: in patches. The compiler makes four-lane vectors of portable's three
// coordinates at -O3, so AVX2 (two vertices a vector, where they follow one segment) and NEON gain less than two.
void add_skin_cases(Cases& cases) {
  constexpr int kSegments = 19;
  struct Data {
    std::vector<float> vertices = std::vector<float>(3 * kVertices), out = vertices;
    std::vector<SkinRecord> records = std::vector<SkinRecord>(kVertices);
    std::vector<SkinMatrix> matrices = std::vector<SkinMatrix>(kSegments);
  };
  const auto data = std::make_shared<Data>();
  Rng rng(7);
  for (float& v : data->vertices) v = static_cast<float>(rng.uniform(-1000, 1000));
  for (SkinMatrix& m : data->matrices)
    for (auto& column : m.column)
      for (float& v : column) v = static_cast<float>(rng.uniform(-1, 1));
  double terms = 0;
  for (std::size_t v = 0; v < kVertices; ++v) {
    const std::size_t patch = v / 20 % 20;
    const int used = patch < 13 ? 1 : patch < 18 ? 2 : 3;
    for (int i = 0; i < used; ++i) {
      data->records[v].segment[static_cast<std::size_t>(i)] =
          static_cast<std::uint8_t>((patch + static_cast<std::size_t>(i)) % kSegments);
      data->records[v].weight[static_cast<std::size_t>(i)] = 1.0F / static_cast<float>(used);
    }
    terms += used;
  }
  const Floor floor = {terms * 8 / 2 / 2500, "eight multiplications and additions a vertex and segment, two a cycle"};
  add_variants(cases, "skin/17774", kSkinWithRef, kVertices, "vertex", floor, true, [&](auto* function) {
    return [data, function] {
      function(data->vertices.data(), data->records.data(), kVertices, data->matrices.data(), data->out.data());
      keep(data->out[0]);
    };
  });
}

}  // namespace im2fit::bench
