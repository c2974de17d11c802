// SPDX-License-Identifier: Apache-2.0
#include "kernels/membership/membership.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/kernels/checkasm.h"
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {
namespace {

// Planes with a border, and the list of all cells.
struct Cells {
  int width, height, step, stride;
  std::vector<std::uint16_t> person, other;
  std::vector<std::uint32_t> list;

  Cells(int w, int h, int s)
      : width(w),
        height(h),
        step(s),
        stride(w + 2),
        person(static_cast<std::size_t>(stride * (h + 2)), kNoSurface),
        other(person) {
    for (int r = 0; r < h; ++r)
      for (int c = 0; c < w; ++c) list.push_back(static_cast<std::uint32_t>(r << 16 | c));
  }
  std::size_t at(int c, int r) const { return static_cast<std::size_t>((r + 1) * stride + c + 1); }
  MembershipCells view() const {
    return {person.data() + stride + 1, other.data() + stride + 1, stride, width, height, step};
  }
};

class Membership : public testing::TestWithParam<MembershipKernel> {};
INSTANTIATE_TEST_SUITE_P(Tiers, Membership, testing::ValuesIn(kMembershipWithRef),
                         [](const auto& p) { return std::string(p.param.name); });

// The person's cell at 2000 mm beside one of another thing at 2030: the limit there is 40 + 1.5 x 11.4 = 57.1 mm.
TEST_P(Membership, NearestSurfaceWithinTheLimit) {
  if (!tier_available(GetParam().tier)) GTEST_SKIP() << "not on this machine";
  struct Sample {
    std::uint16_t z;
    bool alone, beside;
  };
  const std::vector<Sample> samples = {{0, false, false},    {1944, true, true},   {1943, false, false},
                                       {2000, true, true},   {2015, true, true},   {2016, true, false},
                                       {2039, true, false},  {2057, true, false},  {2058, true, false},
                                       {2059, false, false}, {10001, false, false}};
  for (const Sample& sample : samples) {
    for (const bool beside : {false, true}) {
      Cells cells(2, 1, 4);
      cells.person[cells.at(0, 0)] = 2000;
      if (beside) cells.other[cells.at(1, 0)] = 2030;
      const std::vector<std::uint16_t> depth(8 * 4, sample.z);
      std::vector<std::uint8_t> mask(depth.size(), 7);
      GetParam().function({depth.data(), 8, 4}, cells.view(), cells.list.data(), 2, {mask.data(), 8, 4});
      for (const std::uint8_t m : mask)
        ASSERT_EQ(m, (beside ? sample.beside : sample.alone) ? 255 : 0) << sample.z << ' ' << beside;
    }
  }
}

TEST(MembershipCheck, EveryTierGivesTheSameBits) {
  checkasm::Trial trial;
  for (const int step : {1, 2, 3, 4, 5, 13}) {
    for (int repeat = 0; repeat < 12; ++repeat) {
      const int w = 1 + trial.rng().index(9), h = 1 + trial.rng().index(5);
      const int width = w * step + trial.rng().index(step), height = h * step + trial.rng().index(step);
      const int z_stride = width + trial.rng().index(3), m_stride = width + trial.rng().index(3);
      IM2FIT_CHECK_PARAMETERS(trial, step << ", repeat " << repeat << ", size " << width << 'x' << height);
      Cells cells(w, h, step);
      const auto low = static_cast<std::uint16_t>(500 + trial.rng().index(9000));
      const auto high = static_cast<std::uint16_t>(low + 60 + trial.rng().index(400));
      const int kind = trial.rng().index(3);  // all the person's, mixed, also holes
      for (int r = 0; r < h; ++r) {
        for (int c = 0; c < w; ++c) {
          const int draw = trial.rng().index(8);
          auto& plane = kind == 0 || draw < 4 ? cells.person : cells.other;
          if (kind < 2 || draw > 0) plane[cells.at(c, r)] = trial.biased(low, high);
        }
      }
      checkasm::Buffer<std::uint16_t> z(static_cast<std::size_t>((height - 1) * z_stride + width), trial.next_end());
      trial.fill(z.span(), static_cast<std::uint16_t>(low - 100), static_cast<std::uint16_t>(high + 100));
      for (int i = 0; i < 5; ++i) {
        const std::uint16_t odd[] = {0, 1, 10000, 10001, 65535};
        z[static_cast<std::size_t>(trial.rng().index(static_cast<int>(z.size())))] = odd[i];
      }
      const auto size = static_cast<std::size_t>((height - 1) * m_stride + width);
      checkasm::Buffer<std::uint8_t> want(size, trial.next_end()), got(size, trial.next_end());
      const DepthView depth(z.data(), width, height, z_stride);
      const auto run = [&](const auto& function, checkasm::Buffer<std::uint8_t>& out) {
        out.refill();
        function(depth, cells.view(), cells.list.data(), w * h, MaskImage(out.data(), width, height, m_stride));
      };
      run(membership_portable, want);
      // ref works in doubles: its limit differs from the float one only where a whole distance equals it, and
      // 4.275e-6 z z is not a whole number for any depth up to 10000 (855 z z / 2 x 10^8).
      run(membership_ref, got);
      checkasm::expect_same_bits(want, got);
      checkasm::each_simd(kMembershipKernels, [&](const auto& variant) {
        run(variant.function, got);
        checkasm::expect_same_bits(want, got);
      });
    }
  }
}

}  // namespace
}  // namespace im2fit
