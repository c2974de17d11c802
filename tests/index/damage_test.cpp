// SPDX-License-Identifier: Apache-2.0
// A hundred thousand damaged index files: each is refused with an error or answers as the sound one does.
#include "tests/fuzz/damage.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "tests/fuzz/index_use.h"

namespace im2fit::fuzz {
namespace {

// Member by member: what lies between them is not part of an answer. Unknown is NaN, so bits are compared.
bool same_bits(const index::Answer& a, const index::Answer& b) {
  const auto alike = [](const auto& x, const auto& y) { return std::memcmp(&x, &y, sizeof x) == 0; };
  return alike(a.measurements, b.measurements) && alike(a.female, b.female) && a.from == b.from &&
         a.clothed == b.clothed && alike(a.clothing, b.clothing) && a.nearest == b.nearest &&
         alike(a.nearest_distance, b.nearest_distance) && alike(a.nearest_values, b.nearest_values);
}

bool same(const Answers& a, const Answers& b) {
  for (std::size_t i = 0; i < std::min(a.answers.size(), b.answers.size()); ++i)
    if (!same_bits(a.answers[i], b.answers[i])) return false;
  return a.answers.size() == b.answers.size();
}

TEST(DamagedIndex, EveryByteFlippedIsNoticedOrHarmless) {
  const Bytes good = small_index();
  const auto truth = use_index(good);
  ASSERT_TRUE(truth && truth->sane && truth->verified);
  int noticed = 0;
  for (std::size_t at = 0; at < good.size(); ++at) {
    Bytes bytes = good;
    bytes[at] ^= std::byte{0x11};
    const auto found = use_index(bytes);
    noticed += found && found->verified ? 0 : 1;
    if (found) {
      ASSERT_TRUE(same(*found, *truth)) << "byte " << at;
    }
  }
  EXPECT_GT(noticed, static_cast<int>(good.size() * 3 / 4));  // the rest is padding
}

TEST(DamagedIndex, EveryTruncationIsRefused) {
  const Bytes good = small_index();
  for (std::size_t size = 0; size < good.size(); ++size)
    ASSERT_FALSE(use_index({good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size)})) << size;
}

TEST(DamagedIndex, AccidentsAreNoticedOrHarmless) {
  const Bytes good = small_index();
  const auto truth = use_index(good);
  ASSERT_TRUE(truth);
  Rng rng(20261);
  for (int i = 0; i < trials(60000); ++i) {
    const auto found = use_index(damaged(good, rng));
    if (found) {
      ASSERT_TRUE(same(*found, *truth)) << "accident " << i;
    }
  }
}

// Behind right checksums anything may stand: an accepted index must still answer with numbers.
TEST(DamagedIndex, AttacksAreRefusedOrAnsweredWithNumbers) {
  const Bytes good = small_index();
  Rng rng(20262);
  int accepted = 0;
  for (int i = 0; i < trials(60000); ++i) {
    Bytes bytes = damaged(good, rng);
    mend_checksums(bytes);
    const auto found = use_index(std::move(bytes));
    if (!found) continue;
    ++accepted;
    ASSERT_TRUE(found->sane) << "attack " << i;
  }
  EXPECT_GT(accepted, trials(6000));  // else the checksums still refused it
}

}  // namespace
}  // namespace im2fit::fuzz
