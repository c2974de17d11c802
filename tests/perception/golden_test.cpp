// SPDX-License-Identifier: Apache-2.0
// The same bits on every machine: checksums of the portable kernels' output, equal on x86-64, aarch64 and armv7 and
// with any compiler. A change of value here is a change of the contract: the index must be built anew.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <memory>
#include <span>
#include <vector>

#include "core/crc32c.h"
#include "kernels/fpfh/fpfh.h"
#include "kernels/normals/normals.h"
#include "kernels/unproject/unproject.h"
#include "perception/paper/paper.h"
#include "tests/perception/analytic_figure.h"

namespace im2fit {
namespace {

constexpr Intrinsics kGrid = {90, 130, 105, 105, 44.5F, 64.5F};

// NaN has many bit patterns and one meaning.
std::uint32_t checksum(std::span<const float> values, std::uint32_t previous = 0) {
  std::vector<std::uint32_t> bits;
  for (const float v : values) bits.push_back(std::isnan(v) ? 0x7FC00000U : std::bit_cast<std::uint32_t>(v));
  return crc32c(std::as_bytes(std::span(bits)), previous);
}

TEST(Golden, NormalsAndFpfh) {
  const test::Figure figure = test::standing_figure(0, 2300);
  test::FigureCloud c = test::render_cloud(figure, kGrid, 3, 0, 0, 1);
  EXPECT_EQ(checksum(c.x, checksum(c.y, checksum(c.z))), 0x0517F594U) << "the input itself";
  normals_portable(kGrid, c.x.data(), c.y.data(), c.z.data(), 1, 60, c.nx.data(), c.ny.data(), c.nz.data());
  EXPECT_EQ(checksum(c.nx, checksum(c.ny, checksum(c.nz))), 0x0CB6FF35U);
  FpfhWorkspace work(kGrid.width, kGrid.height);
  std::vector<float> out(kJointCount * kFpfhSize);
  fpfh({kGrid, c.x.data(), c.y.data(), c.z.data(), c.nx.data(), c.ny.data(), c.nz.data()}, figure.joints.position_mm,
       kFpfhRadiusMm, work, out);
  EXPECT_EQ(checksum(out), 0xD066F240U);
}

TEST(Golden, UnprojectAndPaper) {
  const Intrinsics k = {180, 260, 210, 210, 89.5F, 129.5F};
  const test::Figure figure = test::standing_figure(0, 2300);
  Rng rng(4);
  std::vector<std::uint16_t> depth;
  std::vector<std::uint8_t> mask;
  for (int v = 0; v < k.height; ++v) {
    for (int u = 0; u < k.width; ++u) {
      const test::Hit hit = figure.cast_ray((u - double{k.cx}) / double{k.fx}, (v - double{k.cy}) / double{k.fy});
      depth.push_back(hit.z > 0 ? static_cast<std::uint16_t>(16 * hit.z + rng.index(64)) : std::uint16_t{0});
      mask.push_back(hit.z > 0 ? 255 : 0);
    }
  }
  const DepthView view(depth.data(), k.width, k.height);
  RayTable rays(k.width, k.height);
  rays.set(k);
  std::vector<float> x(depth.size()), y(depth.size()), z(depth.size());
  unproject_portable(view, 4, rays, x.data(), y.data(), z.data());
  EXPECT_EQ(checksum(x, checksum(y, checksum(z))), 0xE0CFFB87U);

  const auto work = std::make_unique<PaperWorkspace>(k.width, k.height);
  const PaperMeasurements m = measure_paper(view, {mask.data(), k.width, k.height}, k, figure.joints, *work);
  ASSERT_TRUE(m.valid);
  const std::vector<float> values = {m.stature_mm, m.sleeve_mm,         m.leg_mm,         m.shoulder_mm,
                                     m.neck_mm,    m.shoulder_girth_mm, m.chest_mm,       m.waist_mm,
                                     m.hip_mm,     m.chest_ratio,       m.hip_waist_ratio};
  for (const float value : values) EXPECT_FALSE(std::isnan(value));
  EXPECT_EQ(checksum(values), 0xC81722D0U);
}

}  // namespace
}  // namespace im2fit
