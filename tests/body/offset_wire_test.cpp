// SPDX-License-Identifier: Apache-2.0
// Offsets of cloth as bytes: back to within half a step, of a size known beforehand, and damaged ones refused.
#include "garment/drape/offset_wire.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/rng.h"

namespace im2fit::body {
namespace {

std::vector<Vec3f> random_offsets(Rng& rng, std::size_t count, float most_mm) {
  std::vector<Vec3f> out(count);
  for (Vec3f& o : out)
    for (float* value : {&o.x, &o.y, &o.z})
      *value = most_mm * (2 * static_cast<float>(rng.uniform()) - 1) * (rng.index(8) == 0 ? 1.0F : 0.1F);
  return out;
}

TEST(OffsetWire, ComesBackToWithinHalfAStep) {
  Rng rng(5);
  for (const float most_mm : {0.0F, 0.05F, 1.0F, 15.8F, 15.9F, 40.0F, 200.0F, 508.0F})
    for (const std::size_t count : {1UL, 15UL, 16UL, 17UL, 1653UL}) {
      const auto offsets = random_offsets(rng, count, most_mm);
      const std::span<const Vec3f> garments[] = {offsets};
      const std::string bytes = cloth_message(7, garments);
      EXPECT_EQ(bytes.size(), 16 + offset_bytes(count));
      const auto message = read_cloth_message(bytes);
      ASSERT_TRUE(message) << message.error().message;
      EXPECT_EQ(message->number, 7U);
      ASSERT_EQ(message->garments.size(), 1U);
      ASSERT_EQ(message->garments[0].size(), count);
      for (std::size_t first = 0; first < count; first += kOffsetBlock) {
        const auto block = std::span(offsets).subspan(first, std::min(kOffsetBlock, count - first));
        const float step = offset_step_mm(block);
        float most = 0;
        for (std::size_t i = 0; i < block.size(); ++i) {
          const Vec3f off = message->garments[0][first + i] - block[i];
          for (const float error : {off.x, off.y, off.z}) EXPECT_LE(std::fabs(error), step / 2 * 1.0001F);
          most = std::max({most, std::fabs(block[i].x), std::fabs(block[i].y), std::fabs(block[i].z)});
        }
        // No coarser than it has to be.
        EXPECT_TRUE(step == kOffsetStepMm || most > 127 * step / 2) << most << " in steps of " << step;
      }
    }
}

TEST(OffsetWire, CutsWhatIsFartherThanAByteHolds) {
  const std::vector<Vec3f> far = {{9000, -9000, 3}};
  const std::span<const Vec3f> garments[] = {far, {}};
  const auto message = read_cloth_message(cloth_message(0, garments));
  ASSERT_TRUE(message);
  ASSERT_EQ(message->garments.size(), 2U);
  EXPECT_EQ(message->garments[0][0].x, 508);
  EXPECT_EQ(message->garments[0][0].y, -508);
  EXPECT_NEAR(message->garments[0][0].z, 3, 2);
  EXPECT_TRUE(message->garments[1].empty());
}

TEST(OffsetWire, RefusesWhatIsDamaged) {
  Rng rng(6);
  const auto offsets = random_offsets(rng, 40, 100);
  const std::span<const Vec3f> garments[] = {offsets, offsets};
  const std::string whole = cloth_message(1, garments);
  ASSERT_TRUE(read_cloth_message(whole));
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_FALSE(read_cloth_message(std::string_view(whole).substr(0, size))) << size;
  EXPECT_FALSE(read_cloth_message(whole + "x"));
  for (const auto& [at, value] : {std::pair{0U, 'I'}, {8U, '\x7F'}, {11U, '\xFF'}, {15U, '\xFF'}, {16U, '\x06'}}) {
    std::string damaged = whole;
    damaged[at] = value;
    EXPECT_FALSE(read_cloth_message(damaged)) << at;
  }
  // Whatever else is wrong with it, it is read to its end and no farther.
  for (int i = 0; i < 2000; ++i) {
    std::string damaged = whole;
    for (int k = 0; k < 3; ++k)
      damaged[static_cast<std::size_t>(rng.index(static_cast<int>(damaged.size())))] =
          static_cast<char>(rng.index(256));
    const auto read = read_cloth_message(damaged);
    if (read) {
      EXPECT_LE(read->garments.size(), 16U);
    }
  }
}

}  // namespace
}  // namespace im2fit::body
