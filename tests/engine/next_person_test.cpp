// SPDX-License-Identifier: Apache-2.0
// One person after the other: where a session begins, and that it does not depend on threads.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

#include "engine/engine.h"
#include "pipeline_rig.h"

namespace im2fit {
namespace {

using test::FakeStages;
using test::Rig;
using test::Shot;
using test::small_settings;
using test::with;

constexpr GuidanceSet kNear = static_cast<GuidanceSet>(Guidance::too_near);

class NextPerson : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Threads, NextPerson, testing::Values(false, true),
                         [](const auto& info) { return info.param ? "one" : "two"; });

TEST_P(NextPerson, TheNextPersonIsAwaitedOutsideThePicture) {
  Rig rig(with(GetParam()));
  for (int i = 0; i < 12; ++i) rig.push({.value = 2000, .user = 1});
  rig.engine->finish();
  rig.engine->next_person();
  for (int i = 0; i < 50; ++i) rig.push({.value = 3000, .user = 1, .shift_mm = 40});
  for (int i = 0; i < kAbsentPeriodsMax; ++i) rig.push({.found = false});
  for (int i = 0; i < 3; ++i) rig.push({.user = 1});
  rig.engine->finish();
  EngineResult r = rig.engine->result();
  EXPECT_TRUE(r.measured) << "he is still there";
  EXPECT_EQ(r.session, 0U);
  EXPECT_EQ(r.frames_seen, 10U);
  EXPECT_EQ(r.answer.measurements[0].value, 2000.0F * 55 + 2550);

  rig.engine->next_person();
  for (int i = 0; i <= kAbsentPeriodsMax; ++i) rig.push({.found = false});
  rig.push({.found = false});
  rig.engine->finish();
  r = rig.engine->result();
  EXPECT_FALSE(r.measured);
  EXPECT_EQ(r.session, 1U);
  EXPECT_EQ(r.state, SessionState::searching);
  EXPECT_EQ(r.frames_seen, 1U);
  EXPECT_EQ(r.user, 0);

  rig.engine->next_person();
  for (int i = 0; i < 12; ++i) rig.push({.value = 1500, .user = 2});
  rig.engine->finish();
  r = rig.engine->result();
  EXPECT_TRUE(r.measured);
  EXPECT_EQ(r.session, 2U);
  EXPECT_EQ(r.user, 2);
  EXPECT_EQ(r.answer.measurements[0].value, 1500.0F * 55 + 2550);
}

TEST_P(NextPerson, WhoWasMeasuredBeforeAFrameGapHasLeft) {
  Rig rig(with(GetParam()));
  for (int i = 0; i < 10; ++i) rig.push(Shot{});
  rig.engine->finish();
  ASSERT_TRUE(rig.engine->result().measured);
  rig.engine->next_person();
  rig.next += 200;  // frames that pass while the answer is written do not count as a gap
  for (int i = 0; i < 10; ++i) rig.push(Shot{});
  rig.engine->finish();
  EXPECT_EQ(rig.engine->result().session, 0U);
  rig.engine->next_person();
  rig.push(Shot{});
  rig.next += 200;
  for (int i = 0; i < 10; ++i) rig.push(Shot{.value = 3000});
  rig.engine->finish();
  EXPECT_EQ(rig.engine->result().session, 1U);
  EXPECT_TRUE(rig.engine->result().measured);
}

TEST_P(NextPerson, WhoeverWaitsBesideIsMeasuredWhenTheFirstLeaves) {
  Rig rig(with(GetParam()));
  for (int i = 0; i < 12; ++i) rig.push({.user = 1});
  rig.engine->finish();
  rig.engine->next_person();
  for (int i = 0; i <= kAbsentPeriodsMax; ++i) rig.push({.value = 3000, .user = 5});
  for (int i = 0; i < 10; ++i) rig.push({.value = 3000, .user = 5});
  rig.engine->finish();
  const EngineResult r = rig.engine->result();
  EXPECT_TRUE(r.measured);
  EXPECT_EQ(r.session, 1U);
  EXPECT_EQ(r.answer.measurements[0].value, 3000.0F * 55 + 2550);
}

// Who comes second and third is measured from the same frames however far the producer ran ahead: SENSE, whose state
// goes into the joints, sees every frame, and FIT says itself where a session begins.
TEST(Engine, EveryPersonOfARecordingHasTheSameBitsOnOneThreadAndTwo) {
  const auto people = [](bool single_thread, int sense_delay_us, int fit_delay_us) {
    EngineSettings settings = with(single_thread);
    settings.one_after_another = true;
    Rig rig(settings);
    rig.control.sense_delay_us = sense_delay_us;
    rig.control.fit_delay_us = fit_delay_us;
    std::vector<EngineResult> measured;
    bool reported = false;
    std::uint32_t session = 0;
    const auto look = [&] {
      const EngineResult now = rig.engine->result();
      if (now.session != session) reported = false;
      session = now.session;
      if (!now.measured || reported) return;
      reported = true;
      rig.engine->finish();
      measured.push_back(rig.engine->result());
      rig.engine->next_person();
    };
    const auto push = [&](const Shot& shot) {
      rig.push(shot);
      look();
    };
    for (int person = 1; person <= 3; ++person) {
      const auto value = static_cast<std::uint16_t>(1000 * person);
      if (person == 2) ++rig.next;  // a sequence gap of the second's
      for (int i = 0; i < 10 + 4 * person; ++i)
        push({.guidance = i % 5 == 0 ? kNear : 0, .value = value, .user = person});
      for (int i = 0; i < 20 + person; ++i) push({.found = false});
    }
    rig.engine->finish();
    look();
    return measured;
  };
  const std::vector<EngineResult> one = people(true, 0, 0);
  ASSERT_EQ(one.size(), 3U);
  for (const auto& [sense_us, fit_us] : {std::pair{0, 0}, std::pair{0, 300}, std::pair{300, 0}}) {
    const std::vector<EngineResult> two = people(false, sense_us, fit_us);
    ASSERT_EQ(two.size(), 3U) << sense_us << " " << fit_us;
    for (std::size_t i = 0; i < 3; ++i) {
      SCOPED_TRACE(i);
      EXPECT_EQ(two[i].session, one[i].session);
      EXPECT_EQ(two[i].frames_seen, one[i].frames_seen);
      EXPECT_EQ(two[i].frames_used, one[i].frames_used);
      EXPECT_EQ(two[i].guidance_frames, one[i].guidance_frames);
      EXPECT_EQ(two[i].sequence_gaps, one[i].sequence_gaps);
      EXPECT_EQ(two[i].answer.measurements[0].value, one[i].answer.measurements[0].value);
      EXPECT_EQ(two[i].measured_joints[Joint::HE].x, one[i].measured_joints[Joint::HE].x) << "which frame it was";
      EXPECT_EQ(two[i].floor.camera_height_mm, one[i].floor.camera_height_mm);
    }
  }
  EXPECT_EQ(one[0].sequence_gaps, 0U);
  EXPECT_EQ(one[1].sequence_gaps, 1U) << "each session counts its own";
  EXPECT_EQ(one[2].sequence_gaps, 0U);
}

TEST(Engine, APoolDeeperThanAnAnswerStandsIsRefusedWhereSessionsFollowByThemselves) {
  EngineSettings settings = small_settings();
  settings.one_after_another = true;
  settings.pool_frames = kAbsentPeriodsMax + 1;
  FakeStages::Control control;
  const auto engine = create_engine(settings, std::make_unique<FakeStages>(control));
  ASSERT_FALSE(engine);
  EXPECT_THAT(engine.error().message, testing::HasSubstr("pool_frames"));
}

}  // namespace
}  // namespace im2fit
