// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstdlib>

#include "allocations.h"
#include "fake_stages.h"

namespace im2fit::test {
namespace {

TEST(Allocations, TheHookCounts) {
  arm_allocation_count();
  ::operator delete(::operator new(16));  // unlike a new-expression, never optimised away
  EXPECT_EQ(disarm_allocation_count(), 1);
}

TEST(Allocations, NoneAfterStartOver300Frames) {
  for (const bool single : {false, true})
    for (const bool live : {false, true}) {
      FakeStages::Control control;
      EngineSettings settings = small_settings();
      settings.single_thread = single;
      settings.live = live;
      settings.frames_wanted = 290;
      auto engine = create_engine(settings, std::make_unique<FakeStages>(control));
      ASSERT_TRUE(engine);
      const FramePixels near(Shot{true, static_cast<GuidanceSet>(Guidance::too_near)});
      const FramePixels good(Shot{});
      hal::FrameInfo info;
      arm_allocation_count();
      for (int i = 0; i < 300; ++i) {
        info.sequence = static_cast<std::uint64_t>(i);
        info.host_ns = i + 1;
        const bool pushed = static_cast<bool>((*engine)->push(i < 10 ? near.view() : good.view(), info));
        if (!pushed) std::abort();
        if ((*engine)->result().frames_seen > 300) std::abort();
      }
      (*engine)->finish();
      const bool measured = (*engine)->result().measured;
      (*engine)->reset();
      EXPECT_EQ(disarm_allocation_count(), 0) << "single " << single << " live " << live;
      if (!live) {
        EXPECT_TRUE(measured);
      }
    }
}

}  // namespace
}  // namespace im2fit::test
