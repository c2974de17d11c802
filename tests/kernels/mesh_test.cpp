// SPDX-License-Identifier: Apache-2.0
// Blending shape targets onto vertices, and skinning them.
#include <cmath>

#include "kernels/blend/blend.h"
#include "kernels/skin/skin.h"
#include "tests/kernels/checkasm.h"
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {
namespace {

using checkasm::Buffer;

TEST(Blend, RefMovesTheVerticesOfTheRuns) {
  const BlendRun runs[] = {{1, 0, 1}, {0, 2, 1}};
  const std::int16_t deltas[] = {1, 2, 3, -10, 20, 30};
  float v[9] = {100, 100, 100, 7, 7, 7, 0, 0, 0};
  float w[9] = {};
  const BlendInto into[] = {{0.5F, v}, {-1, w}};
  blend_ref(runs, 2, deltas, into, 2);
  const float expected[9] = {95, 110, 115, 7, 7, 7, 0.5F, 1, 1.5F};
  const float other[9] = {10, -20, -30, 0, 0, 0, -1, -2, -3};
  for (int i = 0; i < 9; ++i) EXPECT_EQ(v[i], expected[i]) << i;
  for (int i = 0; i < 9; ++i) EXPECT_EQ(w[i], other[i]) << i;
}

TEST(Blend, EveryTierGivesTheSameVertices) {
  checkasm::Trial trial;
  for (int longest : checkasm::odd_sizes(45)) {
    for (const float scale : {0.1F, -0.037F, 1.7F, kBlendScaleMin, -kBlendScaleMin}) {
      IM2FIT_CHECK_PARAMETERS(trial, longest << ", scale " << scale);
      // Runs one behind the other, some vertices left between them, the last ending where both buffers end.
      std::vector<BlendRun> runs;
      std::uint32_t vertices = 0, deltas = 0;
      for (int r = 0; r < 4; ++r) {
        const auto count = static_cast<std::uint16_t>(r == 3 ? longest : 1 + trial.rng().index(longest));
        vertices += static_cast<std::uint32_t>(trial.rng().index(3));
        runs.push_back({deltas, static_cast<std::uint16_t>(vertices), count});
        vertices += count;
        deltas += count;
      }
      Buffer<std::int16_t> delta(3 * std::size_t{deltas}, trial.next_end());
      trial.fill(delta.span());
      for (std::int16_t& d : delta.span()) d = trial.rng().index(4) == 0 ? std::int16_t{0} : d;
      Buffer<float> start(3 * std::size_t{vertices}), truth(start.size());
      Buffer<float> want(start.size(), trial.next_end()), got(start.size(), trial.next_end());
      trial.fill(start.span(), -1000, 1000);
      for (float& x : start.span()) x = trial.rng().index(8) == 0 ? -0.0F : x;
      const auto restart = [&](auto& v) { std::copy_n(start.data(), start.size(), v.data()); };
      const auto count = static_cast<int>(runs.size());
      restart(truth);
      const BlendInto into_truth = {scale, truth.data()}, into_want = {scale, want.data()};
      blend_ref(runs.data(), count, delta.data(), &into_truth, 1);
      restart(want);
      blend_portable(runs.data(), count, delta.data(), &into_want, 1);
      for (std::size_t i = 0; i < want.size(); ++i)
        ASSERT_LE(std::fabs(want[i] - truth[i]), (32768 * std::fabs(scale) + std::fabs(want[i])) * 0x1p-23F);
      checkasm::each_simd(kBlendKernels, [&](const auto& variant) {
        restart(got);
        const BlendInto into = {scale, got.data()};
        variant.function(runs.data(), count, delta.data(), &into, 1);
        checkasm::expect_same_bits(want, got);
        // Among others, with another weight each.
        for (int meshes = 2; meshes <= kBlendIntoMax; ++meshes) {
          for (int place = 0; place < meshes; ++place) {
            Buffer<float> others[kBlendIntoMax] = {Buffer<float>(start.size()), Buffer<float>(start.size()),
                                                   Buffer<float>(start.size())};
            BlendInto several[kBlendIntoMax];
            for (int m = 0; m < meshes; ++m) {
              restart(others[m]);
              several[m] = {scale * static_cast<float>(m + 2), others[m].data()};
            }
            restart(got);
            several[place] = into;
            variant.function(runs.data(), count, delta.data(), several, meshes);
            checkasm::expect_same_bits(want, got);
          }
        }
      });
    }
  }
}

SkinMatrix moved_by(float x, float y, float z) {
  return {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {x, y, z, 0}}};
}

TEST(Skin, RefWeighsWhereTheSegmentsTakeAVertex) {
  // A quarter turn about z after which x is y, and a shift.
  const SkinMatrix turned = {{{0, 1, 0, 0}, {-1, 0, 0, 0}, {0, 0, 1, 0}, {0, 0, 5, 0}}};
  const SkinMatrix matrices[] = {moved_by(10, 20, 30), turned};
  const float vertices[] = {1, 2, 3, 1, 2, 3};
  const SkinRecord records[] = {{{1, 0, 0, 0}, {1, 0, 0, 0}}, {{0, 1, 0, 0}, {0.75F, 0.25F, 0, 0}}};
  float out[6];
  skin_ref(vertices, records, 2, matrices, out);
  const float expected[] = {-2, 1, 8, 0.75F * 11 - 0.5F, 0.75F * 22 + 0.25F, 0.75F * 33 + 2};
  for (int i = 0; i < 6; ++i) EXPECT_FLOAT_EQ(out[i], expected[i]) << i;
}

TEST(Skin, EveryTierGivesTheSameVertices) {
  checkasm::Trial trial;
  constexpr std::size_t kSegments = 7;
  for (int count : checkasm::odd_sizes(40)) {
    IM2FIT_CHECK_PARAMETERS(trial, count);
    const auto n = static_cast<std::size_t>(count);
    Buffer<float> vertices(3 * n, trial.next_end());
    Buffer<SkinRecord> records(n, trial.next_end());
    trial.fill(vertices.span(), -2000, 2000);
    for (SkinRecord& r : records.span()) {
      const int used = 1 + trial.rng().index(4);
      for (std::size_t i = 0; i < 4; ++i) {
        r.segment[i] = static_cast<std::uint8_t>(trial.rng().index(kSegments));
        r.weight[i] = static_cast<int>(i) < used ? trial.between(0.01F, 1) : 0;
      }
    }
    alignas(16) SkinMatrix matrices[kSegments];
    for (SkinMatrix& m : matrices) {
      for (auto& c : m.column) {
        for (int j = 0; j < 3; ++j) c[j] = trial.between(-1, 1);
        c[3] = 0;
      }
      for (int j = 0; j < 3; ++j) m.column[3][j] *= 1500;
    }
    Buffer<float> truth(3 * n), want(3 * n, trial.next_end()), got(3 * n, trial.next_end());
    skin_ref(vertices.data(), records.data(), count, matrices, truth.data());
    skin_portable(vertices.data(), records.data(), count, matrices, want.data());
    for (std::size_t i = 0; i < want.size(); ++i)
      ASSERT_LE(std::fabs(want[i] - truth[i]), 12 * 4 * 7500 * 0x1p-24F) << "value " << i;
    checkasm::each_simd(kSkinKernels, [&](const auto& variant) {
      got.refill();
      variant.function(vertices.data(), records.data(), count, matrices, got.data());
      checkasm::expect_same_bits(want, got);
    });
  }
}

}  // namespace
}  // namespace im2fit
