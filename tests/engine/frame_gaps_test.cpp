// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "engine/engine.h"
#include "pipeline_rig.h"

namespace im2fit {
namespace {

using test::FramePixels;
using test::Rig;
using test::Shot;
using test::Threading;
using test::with;

// The camera was away: the person there after it is not taken for the person before.
TEST_P(Threading, AFrameGapOfSecondsEndsWhatWasAccumulated) {
  Rig rig(with(GetParam()));
  for (int i = 0; i < 9; ++i) rig.push(Shot{.value = 2000});
  rig.next += 62;  // 2.07 s at 30 Hz
  for (int i = 0; i < 9; ++i) rig.push(Shot{.value = 1000});
  rig.engine->finish();
  EXPECT_TRUE(rig.engine->result().measured);
  EXPECT_EQ(rig.engine->result().frames_used, 9U);
  EXPECT_EQ(rig.engine->result().answer.measurements[0].value, 45 * 1000 + 9 * 255) << "of the second alone";
}

TEST_P(Threading, AShortFrameGapEndsNothing) {
  Rig rig(with(GetParam()));
  for (int i = 0; i < 9; ++i) rig.push(Shot{});
  rig.next += 58;  // 1.97 s
  rig.push(Shot{});
  rig.engine->finish();
  EXPECT_EQ(rig.engine->result().frames_used, 10U);
}

TEST_P(Threading, AfterAFrameGapWithoutAPersonWhoWasThereFindsTheSessionLost) {
  Rig rig(with(GetParam()));
  for (int i = 0; i < 5; ++i) rig.push(Shot{});
  rig.next += 100;
  rig.push(Shot{.found = false});
  rig.engine->finish();
  EXPECT_EQ(rig.engine->result().state, SessionState::lost);
  EXPECT_FALSE(rig.engine->result().measured);
}

TEST_P(Threading, FrameGapsAreNoAttempts) {
  Rig rig(with(GetParam()));
  for (int loss = 0; loss < 30; ++loss) {
    for (int i = 0; i < 4; ++i) rig.push(Shot{});
    rig.next += 100;
  }
  for (int i = 0; i < 10; ++i) rig.push(Shot{});
  rig.engine->finish();
  EXPECT_TRUE(rig.engine->result().measured);
}

// A clock that is set: back is a frame's time like any other, forward a gap, however far.
TEST_P(Threading, AClockMayJumpAnywhere) {
  constexpr std::int64_t kFirst = std::numeric_limits<std::int64_t>::min();
  constexpr std::int64_t kLast = std::numeric_limits<std::int64_t>::max();
  constexpr std::int64_t kDay_ns = 86'400'000'000'000;
  Rig rig(with(GetParam()));
  const FramePixels frame(Shot{});
  std::uint64_t sequence = 0;
  const auto push_from = [&](std::int64_t host_ns, int frames) {
    for (int i = 0; i < frames; ++i) {
      hal::FrameInfo info;
      info.sequence = sequence++;
      info.host_ns = host_ns + i * 1000;
      EXPECT_TRUE(rig.engine->push(frame.view(), info));
    }
    EXPECT_TRUE(rig.engine->wait_idle(-1));
    return rig.engine->result().frames_used;
  };
  EXPECT_EQ(push_from(kDay_ns, 4), 4U);
  EXPECT_EQ(push_from(1, 3), 7U) << "a day back";
  EXPECT_EQ(push_from(kDay_ns, 2), 2U) << "a day forward";
  EXPECT_EQ(push_from(kFirst, 3), 5U) << "as far back as there is";
  EXPECT_EQ(push_from(kLast - 10'000, 4), 4U) << "as far forward as there is";
  EXPECT_EQ(push_from(kFirst, 6), 10U);
  rig.engine->finish();
  EXPECT_TRUE(rig.engine->result().measured);
  EXPECT_EQ(rig.engine->result().time_reversals, 3U);
}

TEST_P(Threading, OddArrivalsAreCounted) {
  Rig rig(with(GetParam()));
  const FramePixels frame(Shot{.found = false});
  const std::pair<std::uint64_t, std::int64_t> arrivals[] = {{10, 100}, {11, 200}, {15, 150}, {15, 150}, {14, 300}};
  for (const auto& [sequence, ns] : arrivals) {
    hal::FrameInfo info;
    info.sequence = sequence;
    info.host_ns = ns;
    ASSERT_TRUE(rig.engine->push(frame.view(), info));
  }
  rig.engine->finish();
  const EngineResult r = rig.engine->result();
  EXPECT_EQ(r.sequence_gaps, 3U);
  EXPECT_EQ(r.sequence_repeats, 2U);
  EXPECT_EQ(r.time_reversals, 2U);
  EXPECT_EQ(r.frames_seen, 5U);
}

TEST_P(Threading, StridesAreHonoured) {
  Rig rig(with(GetParam()));
  std::vector<std::uint16_t> wide(static_cast<std::size_t>(test::kHeight) * 40, 9);
  const FramePixels frame(Shot{.value = 1500});
  for (int v = 0; v < test::kHeight; ++v)
    std::memcpy(&wide[static_cast<std::size_t>(v) * 40], frame.view().row(v), test::kWidth * 2);
  ASSERT_TRUE(rig.engine->push(DepthView(wide.data(), test::kWidth, test::kHeight, 40), {}));
  rig.engine->finish();
  EXPECT_EQ(rig.engine->result().joints[Joint::HE].z, 1500.0F);
}

}  // namespace
}  // namespace im2fit
