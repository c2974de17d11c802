// SPDX-License-Identifier: Apache-2.0
// Arms that touch the trunk in some frames and not in others.
#include "engine/arms_memory.h"

#include <gtest/gtest.h>

#include <string_view>

#include "engine/session.h"

namespace im2fit {
namespace {

constexpr GuidanceSet kClose = static_cast<GuidanceSet>(Guidance::arms_close);
constexpr GuidanceSet kAside = static_cast<GuidanceSet>(Guidance::not_frontal);
constexpr ArmSet kBoth = kLeftArm | kRightArm;

// A story, a letter a frame: '.' apart, 'b' both arms close, 'l' and 'r' one of them, '?' another code alone.
ArmSet after(ArmsMemory& memory, std::string_view story) {
  ArmSet close = 0;
  for (const char c : story) {
    const ArmSet arms = c == 'b' ? kBoth : c == 'l' ? kLeftArm : c == 'r' ? kRightArm : 0;
    close = remember_arms(memory, arms != 0 ? kClose : c == '?' ? kAside : 0, arms, 1);
  }
  return close;
}

TEST(ArmsMemory, OneCloseFrameIsNotHeld) {
  ArmsMemory memory;
  EXPECT_EQ(after(memory, "b"), kBoth) << "but says so itself";
  EXPECT_EQ(after(memory, "."), 0U);
}

TEST(ArmsMemory, FourOfEightAreHeldUntilOneIsLeft) {
  ArmsMemory memory;
  EXPECT_EQ(after(memory, "bbbb"), kBoth);
  EXPECT_EQ(after(memory, "......"), kBoth) << "two of the last eight were close";
  EXPECT_EQ(after(memory, "."), 0U);
}

TEST(ArmsMemory, ItFlickersWithoutEverBeingLetGo) {
  ArmsMemory memory;
  after(memory, "bbbbbbbb");
  for (int i = 0; i < 20; ++i) EXPECT_NE(after(memory, "b..."), 0U) << "three frames of four are lucky";
}

TEST(ArmsMemory, EachArmIsRememberedByItself) {
  ArmsMemory memory;
  EXPECT_EQ(after(memory, "llll"), kLeftArm);
  EXPECT_EQ(after(memory, "r"), kBoth);
  EXPECT_EQ(after(memory, "."), kLeftArm);
}

TEST(ArmsMemory, FramesWithOtherCodesSayNothing) {
  ArmsMemory memory;
  after(memory, "bbbb????????????");
  EXPECT_EQ(memory.held, kBoth);
  EXPECT_EQ(memory.session.said, 4);
}

TEST(ArmsMemory, ACodeThatNamesNoArmIsAboutBoth) {
  ArmsMemory memory;
  for (int i = 0; i < 4; ++i) remember_arms(memory, kClose, 0, 1);
  EXPECT_EQ(memory.held, kBoth);
}

TEST(ArmsMemory, MoreThanHalfIsMostly) {
  EXPECT_FALSE(mostly_close({}));
  EXPECT_FALSE(mostly_close({10, 5}));
  EXPECT_TRUE(mostly_close({11, 6}));
}

// A session of ten frames wanted, three at least. Returns the frames accumulated when it is measured, else 0.
struct Played {
  int measured_with = 0;
  int accumulated = 0;
  int forgotten = 0;
  Session session;
  bool at_end = false;
};
Played play(std::string_view story) {
  SessionRules rules;
  rules.frames_wanted = 10;
  rules.frames_min = 3;
  Played out;
  for (const char c : story) {
    SessionView view;
    view.found = true;
    view.user = 1;
    view.view = ViewSide::front;
    view.frames_accumulated = out.accumulated;
    view.arms_close = c == 'b' ? kBoth : 0;
    view.guidance = c == 'b' ? kClose : 0;
    const SessionStep step = on_detection(rules, out.session, view);
    out.session = step.next;
    EXPECT_EQ(has(step.guidance, Guidance::arms_close), step.arms_close != 0);
    if (step.forget) out.accumulated = 0;
    if (!step.use_frame) continue;
    const OfferStep offer = after_offer(rules, out.session, false, ++out.accumulated);
    out.session = offer.next;
    if (offer.measure) {
      out.measured_with = out.accumulated;
      return out;
    }
    if (offer.forget) out.accumulated = 0, ++out.forgotten;
  }
  out.at_end = measure_at_end(rules, out.session, out.accumulated);
  return out;
}

TEST(SessionArms, WhoLiftsTheArmsIsMeasured) {
  EXPECT_EQ(play("bbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbb......................").measured_with, 10);
}

TEST(SessionArms, AnOddCloseFrameCostsThatFrameAlone) {
  const Played p = play("...b....b....");
  EXPECT_EQ(p.measured_with, 10);
}

TEST(SessionArms, LuckyFramesAreNotMeasured) {
  for (const std::string_view story :
       {".....bbbbbbbbbbbbbbbbbbbbbbbbb", "bbbbbbbbbbbbb.....bbbbbbbbbbbbb", "bbbbbbbbbbbbbbbbbbbbbbbb.....",
        "b.b.b.b.b.b.b.b.b.b.b.b.b.b.b.", ".bb..bb..bb..bb..bb..bb..bb..bb..bb."}) {
    const Played p = play(story);
    EXPECT_EQ(p.measured_with, 0) << story;
    EXPECT_FALSE(p.at_end) << story;
  }
}

TEST(SessionArms, ACaptureMostlyCloseIsForgotten) {
  // Seven good ones, then arms on the body for long, then good ones again.
  const Played p = play(".......bbbbbbbbbbbbbbbbbbbb..........");
  EXPECT_EQ(p.forgotten, 1);
  EXPECT_EQ(p.measured_with, 0);
}

TEST(SessionArms, AnotherPersonBeginsAnew) {
  SessionRules rules;
  SessionView view;
  view.found = true;
  view.user = 1;
  view.view = ViewSide::front;
  view.guidance = kClose;
  view.arms_close = kBoth;
  Session session;
  for (int i = 0; i < 8; ++i) session = on_detection(rules, session, view).next;
  EXPECT_EQ(session.arms.held, kBoth);
  view.user = 2;
  view.guidance = 0;
  view.arms_close = 0;
  EXPECT_TRUE(on_detection(rules, session, view).use_frame);
}

}  // namespace
}  // namespace im2fit
