// SPDX-License-Identifier: Apache-2.0
#include "engine/session.h"

#include <gtest/gtest.h>

#include "fake_stages.h"

namespace im2fit {
namespace {

using State = SessionState;
constexpr GuidanceSet kNear = static_cast<GuidanceSet>(Guidance::too_near);
constexpr GuidanceSet kNoPerson = static_cast<GuidanceSet>(Guidance::no_person);
constexpr GuidanceSet kPose = static_cast<GuidanceSet>(Guidance::calibration_pose);
constexpr GuidanceSet kMoving = static_cast<GuidanceSet>(Guidance::moving);

SessionRules rules(bool psi) {
  SessionRules r;
  r.frames_wanted = 10;
  r.frames_min = 3;
  r.calibration_psi = psi;
  r.absent_periods_max = 2;
  r.psi_frames = 2;
  r.psi_wait_periods_max = 4;
  r.rejected_periods_max = 3;
  r.attempts_max = 2;
  return r;
}

struct Transition {
  const char* name;
  bool calibration;
  Session from;
  SessionView view;
  State to;
  GuidanceSet guidance;
  bool forget;
  bool use_frame;
  int attempts;
};

Session at(State state, int absent = 0, int psi = 0, int psi_wait = 0, int attempts = 0) {
  Session s;
  s.state = state;
  s.absent_periods = absent;
  s.psi_frames = psi;
  s.psi_wait_periods = psi_wait;
  s.attempts = attempts;
  return s;
}

constexpr SessionView kAbsent{false, 0, false};
constexpr SessionView kGood{true, 0, false};
constexpr SessionView kTooNear{true, kNear, false};
constexpr SessionView kTooNearToBeFound{false, kNear, false};
constexpr SessionView kPsi{true, 0, true};

const Transition kTransitions[] = {
    // name, calibration, from, view, to, guidance, forget, use, attempts
    {"no person keeps searching", false, at(State::searching), kAbsent, State::searching, kNoPerson, false, false, 0},
    {"too near to be found is a person", false, at(State::searching), kTooNearToBeFound, State::searching, kNear,
     false, false, 0},
    {"comes too near to be found", false, at(State::tracking, 2), kTooNearToBeFound, State::lost, kNear, false, false,
     0},
    {"found but too near", false, at(State::searching), kTooNear, State::user_found, kNear, false, false, 0},
    {"found and fine is tracked at once", false, at(State::searching), kGood, State::tracking, 0, false, true, 0},
    {"found and fine must calibrate", true, at(State::searching), kGood, State::calibrating, kPose, false, false, 0},
    {"user too near stays", false, at(State::user_found), kTooNear, State::user_found, kNear, false, false, 0},
    {"user steps back", false, at(State::user_found), kGood, State::tracking, 0, false, true, 0},
    {"user steps back, calibrates", true, at(State::user_found), kGood, State::calibrating, kPose, false, false, 0},
    {"user flickers", false, at(State::user_found, 1), kAbsent, State::user_found, kNoPerson, false, false, 0},
    {"user leaves", false, at(State::user_found, 2), kAbsent, State::lost, kNoPerson, false, false, 0},
    {"first frame of Psi", true, at(State::calibrating), kPsi, State::calibrating, kPose, false, false, 0},
    {"enough frames of Psi", true, at(State::calibrating, 0, 1), kPsi, State::tracking, 0, false, false, 0},
    {"Psi broken off", true, at(State::calibrating, 0, 1), kGood, State::calibrating, kPose, false, false, 0},
    {"Psi wanted, too near", true, at(State::calibrating), kTooNear, State::calibrating, kPose | kNear, false, false,
     0},
    {"never takes the pose", true, at(State::calibrating, 0, 0, 4), kGood, State::lost, kPose, false, false, 0},
    {"leaves while calibrating", true, at(State::calibrating, 2), kAbsent, State::lost, kNoPerson, false, false, 0},
    {"tracked and fine", false, at(State::tracking), kGood, State::tracking, 0, false, true, 0},
    {"tracked, comes near", false, at(State::tracking), kTooNear, State::tracking, kNear, false, false, 0},
    {"tracked, arms still up", true, at(State::tracking), kPsi, State::tracking, kMoving, false, false, 0},
    {"tracked, arms up unasked", false, at(State::tracking), kPsi, State::tracking, 0, false, true, 0},
    {"tracked, flickers", false, at(State::tracking, 1), kAbsent, State::tracking, kNoPerson, false, false, 0},
    {"tracked, leaves", false, at(State::tracking, 2), kAbsent, State::lost, kNoPerson, false, false, 0},
    {"lost stays lost", false, at(State::lost), kAbsent, State::lost, kNoPerson, false, false, 0},
    {"lost and found", false, at(State::lost), kTooNear, State::user_found, kNear, true, false, 1},
    {"lost and found, fine", false, at(State::lost), kGood, State::tracking, 0, true, true, 1},
    {"lost and found, calibrates", true, at(State::lost, 0, 1, 4), kGood, State::calibrating, kPose, true, false, 1},
    {"lost once too often", false, at(State::lost, 0, 0, 0, 2), kGood, State::lost, 0, false, false, 2},
    {"measured is the end", false, at(State::measured), kGood, State::measured, 0, false, false, 0},
    {"measured, leaves", false, at(State::measured, 2), kAbsent, State::measured, 0, false, false, 0},
};

TEST(Session, EveryTransitionOnADetection) {
  for (const Transition& t : kTransitions) {
    SCOPED_TRACE(t.name);
    const SessionStep step = on_detection(rules(t.calibration), t.from, t.view);
    EXPECT_EQ(step.next.state, t.to);
    EXPECT_EQ(step.guidance, t.guidance);
    EXPECT_EQ(step.forget, t.forget);
    EXPECT_EQ(step.use_frame, t.use_frame);
    EXPECT_EQ(step.next.attempts, t.attempts);
  }
}

Session of_user(State state, int user, int absent = 0) {
  Session s = at(state, absent);
  s.user = user;
  return s;
}
SessionView seen(int user) {
  SessionView view = kGood;
  view.user = user;
  return view;
}

TEST(Session, BelongsToItsUserFromTheFirstGoodFrameOn) {
  const SessionStep found = on_detection(rules(false), {}, seen(3));
  EXPECT_EQ(found.next.state, State::tracking);
  EXPECT_EQ(found.next.user, 3);

  SessionView waiting = kTooNear;
  waiting.user = 4;
  const SessionStep other = on_detection(rules(false), of_user(State::user_found, 3), waiting);
  EXPECT_EQ(other.next.user, 4) << "nothing has begun";
  EXPECT_EQ(other.guidance, kNear);
}

TEST(Session, AnotherUserIsAnAbsence) {
  for (const State state : {State::calibrating, State::tracking}) {
    SessionView other = kTooNear;
    other.user = 4;
    SessionStep step = on_detection(rules(true), of_user(state, 3), other);
    EXPECT_EQ(step.next.state, state);
    EXPECT_EQ(step.next.user, 3);
    EXPECT_EQ(step.next.absent_periods, 1);
    EXPECT_EQ(step.guidance, kNoPerson) << "not what the other should do";
    EXPECT_FALSE(step.use_frame);
    step = on_detection(rules(true), of_user(state, 3, 2), other);
    EXPECT_EQ(step.next.state, State::lost);
    const SessionStep next = on_detection(rules(true), step.next, other);
    EXPECT_EQ(next.next.state, State::user_found);
    EXPECT_EQ(next.next.user, 4);
    EXPECT_TRUE(next.forget);
    EXPECT_EQ(next.next.attempts, 1);
  }
}

TEST(Session, ABackIsAskedToTurnRound) {
  SessionView view = kGood;
  for (const State state : {State::user_found, State::tracking}) {
    view.view = ViewSide::back;
    const SessionStep back = on_detection(rules(false), at(state), view);
    EXPECT_FALSE(back.use_frame);
    EXPECT_EQ(back.guidance, static_cast<GuidanceSet>(Guidance::not_frontal));
    EXPECT_EQ(back.next.state, state);
    view.view = ViewSide::front;
    EXPECT_TRUE(on_detection(rules(false), at(state), view).use_frame);
  }
}

TEST(Session, ThePersonsSideIsNotReportedWhenBentOrWithoutAHead) {
  for (const Guidance wrong : {Guidance::not_upright, Guidance::head_cut}) {
    SessionView view = kGood;
    view.view = ViewSide::back;
    view.guidance = static_cast<GuidanceSet>(wrong);
    const SessionStep step = on_detection(rules(false), at(State::tracking), view);
    EXPECT_EQ(step.guidance, view.guidance);
    EXPECT_FALSE(step.use_frame);
  }
}

TEST(Session, MovementIsNotAccumulatedAndTakesItsFirstFramesWithIt) {
  const SessionRules r = rules(false);
  struct Case {
    float trunk, limb;
    int accumulated;
    bool moving, forget;
  };
  const Case cases[] = {{59, 299, 9, false, false},
                        {61, 0, 0, true, false},
                        {61, 0, 1, true, true},
                        {0, 301, r.unsteady_frames_max, true, true},
                        {61, 301, r.unsteady_frames_max + 1, true, false}};
  for (const Case& c : cases) {
    SCOPED_TRACE(c.trunk);
    SessionView view = kGood;
    view.motion = {c.trunk, c.limb};
    view.frames_accumulated = c.accumulated;
    const SessionStep step = on_detection(r, at(State::tracking), view);
    EXPECT_EQ(step.guidance, c.moving ? kMoving : 0U);
    EXPECT_EQ(step.use_frame, !c.moving);
    EXPECT_EQ(step.forget, c.forget);
    EXPECT_EQ(step.next.state, State::tracking);
  }
}

TEST(Session, MovementIsReportedWhenItCanBeKnown) {
  struct Case {
    Guidance other;
    float body, limb;
    bool moving;
  };
  const Case cases[] = {{Guidance::not_frontal, 151, 0, true},
                        {Guidance::not_frontal, 149, 0, false},  // the middle of a mask that flickers
                        {Guidance::not_frontal, 0, 900, false},  // joints of a person turned aside leap
                        {Guidance::too_near, 0, 900, false},
                        {Guidance::too_noisy, 900, 900, false}};
  for (const Case& c : cases) {
    SessionView view = kGood;
    view.guidance = static_cast<GuidanceSet>(c.other);
    view.motion = {c.body, c.limb};
    const SessionStep step = on_detection(rules(false), at(State::tracking), view);
    EXPECT_EQ(has(step.guidance, Guidance::moving), c.moving) << view.guidance;
    EXPECT_TRUE(has(step.guidance, c.other));
  }
}

TEST(Session, BeingSeenClearsTheAbsence) {
  const SessionStep step = on_detection(rules(false), at(State::tracking, 2), kGood);
  EXPECT_EQ(step.next.absent_periods, 0);
}

TEST(Session, ANewAttemptCalibratesFromTheStart) {
  const SessionStep step = on_detection(rules(true), at(State::lost, 0, 1, 4), kTooNear);
  EXPECT_EQ(step.next.psi_frames, 0);
  EXPECT_EQ(step.next.psi_wait_periods, 0);
}

TEST(Session, WhoKeepsTheCalibrationPoseIsMeasuredInIt) {
  SessionRules r = rules(true);
  r.psi_lower_periods_max = 3;
  SessionView raised = kGood;
  raised.psi = true;
  Session session = at(State::tracking);
  for (int frame = 1; frame <= 5; ++frame) {
    const SessionStep step = on_detection(r, session, raised);
    EXPECT_EQ(has(step.guidance, Guidance::moving), frame <= 3) << frame;
    EXPECT_EQ(step.use_frame, frame > 3) << frame;
    session = step.next;
  }
  // A new attempt asks for the pose again, and waits again for it to be left.
  session.state = State::lost;
  EXPECT_EQ(on_detection(r, session, raised).next.raised_periods, 0);
}

struct Offer {
  const char* name;
  int rejected_before;
  int attempts;
  bool rejected;
  int accumulated;
  bool measure;
  bool forget;
  int rejected_after;
  int attempts_after;
};
constexpr Offer kOffers[] = {
    {"one more", 2, 0, false, 9, false, false, 0, 0},
    {"the last one", 0, 0, false, 10, true, false, 0, 0},
    {"moved once", 0, 0, true, 2, false, false, 1, 0},
    {"moved on with too few", 3, 0, true, 2, false, true, 0, 1},
    {"moved on with enough", 3, 0, true, 3, true, false, 0, 0},
    {"moved on too often", 3, 2, true, 2, false, false, 0, 2},
};

TEST(Session, EveryOutcomeOfAnOffer) {
  for (const Offer& o : kOffers) {
    SCOPED_TRACE(o.name);
    Session session = at(State::tracking, 0, 0, 0, o.attempts);
    session.rejected_periods = o.rejected_before;
    const OfferStep step = after_offer(rules(false), session, o.rejected, o.accumulated);
    EXPECT_EQ(step.measure, o.measure);
    EXPECT_EQ(step.forget, o.forget);
    EXPECT_EQ(step.next.rejected_periods, o.rejected_after);
    EXPECT_EQ(step.next.attempts, o.attempts_after);
    EXPECT_EQ(step.next.state, State::tracking);
  }
}

TEST(Session, MeasuringEndsTheSessionOrStartsAgainABoundedNumberOfTimes) {
  EXPECT_EQ(after_measuring(rules(false), at(State::tracking), true).next.state, State::measured);
  Session session = at(State::tracking);
  for (int i = 0; i < 2; ++i) {
    const MeasuringStep step = after_measuring(rules(false), session, false);
    EXPECT_TRUE(step.forget);
    EXPECT_EQ(step.next.state, State::tracking);
    session = step.next;
  }
  EXPECT_EQ(after_measuring(rules(false), session, false).next.state, State::lost);
}

TEST(Session, TheEndOfTheStreamMeasuresWhatIsEnough) {
  EXPECT_TRUE(measure_at_end(rules(false), at(State::tracking), 3));
  EXPECT_TRUE(measure_at_end(rules(false), at(State::lost), 9));
  EXPECT_FALSE(measure_at_end(rules(false), at(State::tracking), 2));
  EXPECT_FALSE(measure_at_end(rules(false), at(State::measured), 9));
}

constexpr GuidanceSet kTurnRound = static_cast<GuidanceSet>(Guidance::turn_round);
constexpr GuidanceSet kNotFrontal = static_cast<GuidanceSet>(Guidance::not_frontal);

SessionRules turn_rules() {
  SessionRules r = rules(false);
  r.turn = Turn::back;
  r.turn_wait_periods_max = 20;
  r.unsteady_frames_max = 5;
  return r;
}
Session in_turning(bool turned, int turning_periods = 0, int absent = 0) {
  Session s = at(State::turning, absent);
  s.turned = turned;
  s.turning_periods = turning_periods;
  return s;
}
SessionView from(ViewSide side, GuidanceSet guidance = 0, int accumulated = 0, float body_mm_s = 0) {
  SessionView view = kGood;
  view.view = side;
  view.guidance = guidance;
  view.frames_accumulated = accumulated;
  view.motion.body_mm_s = body_mm_s;
  return view;
}

TEST(Turning, FollowsTheFrontWhenRequested) {
  EXPECT_EQ(after_measuring(rules(false), at(State::tracking), true).next.state, State::measured);
  Session session = at(State::tracking);
  session.rejected_periods = 2;
  session.turning_periods = 9;
  session.turned = true;
  const MeasuringStep step = after_measuring(turn_rules(), session, true);
  EXPECT_EQ(step.next.state, State::turning);
  EXPECT_TRUE(step.turn);
  EXPECT_FALSE(step.forget);
  EXPECT_EQ(step.next.rejected_periods, 0);
  EXPECT_EQ(step.next.turning_periods, 0);
  EXPECT_FALSE(step.next.turned);
  const MeasuringStep last = after_measuring(turn_rules(), session, true, true);
  EXPECT_EQ(last.next.state, State::measured) << "at the end of the stream no person turns any more";
  EXPECT_FALSE(last.turn);
  EXPECT_EQ(after_measuring(turn_rules(), at(State::turning), true).next.state, State::measured);
  EXPECT_EQ(after_measuring(turn_rules(), at(State::turning), false).next.state, State::tracking) << "all anew";
  EXPECT_EQ(after_measuring(turn_rules(), at(State::turning, 0, 0, 0, 2), false).next.state, State::lost);
}

TEST(Turning, SaysWhatTheBackNeeds) {
  struct Case {
    const char* name;
    bool turned;
    SessionView view;
    GuidanceSet guidance;
    bool use_frame, forget, turned_after;
  };
  const GuidanceSet bent = static_cast<GuidanceSet>(Guidance::not_upright);
  const Case cases[] = {
      {"still facing", false, from(ViewSide::front), kTurnRound, false, false, false},
      {"facing, too near", false, from(ViewSide::front, kNear), kTurnRound | kNear, false, false, false},
      {"moves, being asked to", false, from(ViewSide::front, 0, 0, 400), kTurnRound, false, false, false},
      {"half turned", false, from(ViewSide::side, kNotFrontal), kTurnRound | kNotFrontal, false, false, false},
      {"side unknown", false, from(ViewSide::unknown, kNotFrontal), kTurnRound | kNotFrontal, false, false, false},
      {"the back", false, from(ViewSide::back), 0, true, false, true},
      {"the back, too near", false, from(ViewSide::back, kNear), kNear, false, false, true},
      {"the back of who bends is a guess", false, from(ViewSide::back, bent), bent, false, false, false},
      {"the back, moving", false, from(ViewSide::back, 0, 0, 61), kMoving, false, false, true},
      {"the back, moving after the first frames", true, from(ViewSide::back, 0, 5, 61), kMoving, false, true, true},
      {"the back, moving later", true, from(ViewSide::back, 0, 6, 61), kMoving, false, false, true},
      {"turned too far", true, from(ViewSide::side, kNotFrontal, 5), kNotFrontal, false, false, true},
      {"it was no back", true, from(ViewSide::front, 0, 5), kTurnRound, false, true, false},
      {"turned to the front again", true, from(ViewSide::front, 0, 6), kTurnRound, false, false, false},
      {"the front of who bends is a guess", true, from(ViewSide::front, bent, 5), bent, false, false, true},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    const SessionStep step = on_detection(turn_rules(), in_turning(c.turned), c.view);
    EXPECT_EQ(step.next.state, State::turning);
    EXPECT_EQ(step.guidance, c.guidance);
    EXPECT_EQ(step.use_frame, c.use_frame);
    EXPECT_EQ(step.forget, c.forget);
    EXPECT_EQ(step.next.turned, c.turned_after);
    EXPECT_EQ(step.next.turning_periods, 1);
    EXPECT_FALSE(step.measure);
  }
}

SessionRules around_rules() {
  SessionRules r = turn_rules();
  r.turn = Turn::around;
  return r;
}
SessionView turned(float deg, GuidanceSet guidance = 0, int periods = 3, float deg_a_period = 0) {
  SessionView view = from(ViewSide::side, guidance);
  view.turned_deg = deg;
  view.turn_deg_a_period = deg_a_period;
  view.periods = periods;
  return view;
}

TEST(TurningAround, AsksForTheTurnUntilItIsWhole) {
  constexpr auto kTurnOn = static_cast<GuidanceSet>(Guidance::turn_on);
  constexpr auto kTurnSlower = static_cast<GuidanceSet>(Guidance::turn_slower);
  constexpr auto kArms = static_cast<GuidanceSet>(Guidance::arms_close);
  struct Case {
    const char* name;
    SessionView view;
    GuidanceSet guidance;
    bool follow, measure;
  };
  const Case cases[] = {
      {"stands", turned(0), kTurnOn, true, false},
      {"turns", turned(15), kTurnOn, true, false},
      {"to the other side", turned(-15), kTurnOn, true, false},
      {"21 degrees in a tenth of a second", turned(21, 0, 3, 7), kTurnSlower, true, false},
      {"as far in two", turned(21, 0, 3, 3.5F), kTurnOn, true, false},
      {"is seen from the side, with the arms at the trunk", turned(15, kNotFrontal | kArms), kTurnOn, true, false},
      {"goes too near", turned(15, kNear), kNear | kTurnOn, false, false},
      {"has turned all round", turned(331, 0, 300), 0, true, true},
      {"to the other side, all round", turned(-331, 0, 300), 0, true, true},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    const SessionStep step = on_detection(around_rules(), in_turning(false), c.view);
    EXPECT_EQ(step.guidance, c.guidance);
    EXPECT_EQ(step.follow, c.follow);
    EXPECT_EQ(step.measure, c.measure);
    EXPECT_FALSE(step.use_frame) << "the turn is followed, not accumulated";
    EXPECT_FALSE(step.drop_back);
  }
}

TEST(TurningAround, WaitsForProgressAndNoLonger) {
  Session session = in_turning(false);
  SessionStep step;
  for (const float deg : {0.0F, 12.0F, 19.0F, 24.0F}) {
    step = on_detection(around_rules(), session, turned(deg, 0, 8));
    session = step.next;
    EXPECT_FALSE(step.measure) << deg;
  }
  EXPECT_EQ(session.turning_periods, 8) << "24 is 12 more than 12";
  step = on_detection(around_rules(), session, turned(25, 0, 12));
  EXPECT_FALSE(step.measure);
  step = on_detection(around_rules(), step.next, turned(26, 0, 1));
  EXPECT_TRUE(step.measure) << "stands for more than turn_wait_periods_max";
}

TEST(TurningAround, AsksForASlowerTurnUntilItIsPlainlySlower) {
  Session session = in_turning(false);
  for (const auto& [speed, slower] :
       {std::pair{6.0F, false}, {7.0F, true}, {6.0F, true}, {3.0F, false}, {6.0F, false}}) {
    const SessionStep step = on_detection(around_rules(), session, turned(90, 0, 3, speed));
    EXPECT_EQ(has(step.guidance, Guidance::turn_slower), slower) << speed;
    EXPECT_EQ(has(step.guidance, Guidance::turn_on), !slower) << speed;
    session = step.next;
  }
}

// Who holds the camera is spoken to.
TEST(TurningAround, ACameraIsAskedToBeCarriedRound) {
  SessionRules rules = around_rules();
  rules.turn = Turn::walk;
  EXPECT_EQ(on_detection(rules, in_turning(false), turned(15)).guidance,
            static_cast<GuidanceSet>(Guidance::walk_round));
  EXPECT_EQ(on_detection(rules, in_turning(false), turned(21, 0, 3, 7)).guidance,
            static_cast<GuidanceSet>(Guidance::turn_slower));
  EXPECT_TRUE(on_detection(rules, in_turning(false), turned(-331)).measure);
}

TEST(TurningAround, EveryTurnIsOfferedAtTheEnd) {
  Session session = in_turning(false);
  session.arms.session = {9, 9};
  EXPECT_TRUE(measure_at_end(around_rules(), session, 1));
}

TEST(TurningAround, WhoLeavesIsMeasuredWithTheTurnSoFar) {
  const SessionStep step = on_detection(around_rules(), in_turning(false, 0, 2), kAbsent);
  EXPECT_TRUE(step.measure);
  EXPECT_FALSE(step.drop_back);
}

TEST(Turning, WhoLeavesIsMeasuredFromTheFront) {
  SessionView other = from(ViewSide::front, kNear, 9);
  other.user = 4;
  for (SessionView gone : {kAbsent, other}) {
    gone.frames_accumulated = 9;
    SessionStep step = on_detection(turn_rules(), in_turning(true, 0, 1), gone);
    EXPECT_FALSE(step.measure) << "a flicker";
    EXPECT_EQ(step.guidance, kNoPerson);
    step = on_detection(turn_rules(), in_turning(true, 0, 2), gone);
    EXPECT_TRUE(step.measure);
    EXPECT_TRUE(step.drop_back);
    EXPECT_FALSE(step.use_frame);
    EXPECT_EQ(step.next.state, State::turning) << "MEASURED comes with the measurement";
  }
  EXPECT_EQ(on_detection(turn_rules(), in_turning(false, 0, 2), from(ViewSide::front)).next.absent_periods, 0);
}

TEST(Turning, IsBoundedWhateverThePersonDoes) {
  struct Case {
    const char* name;
    SessionView view;
    int frames_before;
    bool measure, drop_back;
  };
  SessionView absent = kAbsent;
  const Case cases[] = {
      {"not yet", from(ViewSide::front), 19, false, false},
      {"never turns", from(ViewSide::front), 20, true, true},
      {"comes and goes", absent, 20, true, true},
      {"accumulating is no waiting", from(ViewSide::back, 0, 2), 21, false, false},
      {"too little of the back", from(ViewSide::back, 0, 2), 22, true, true},
      {"a back just rejected", from(ViewSide::back, 0, 4, 61), 24, true, true},
      {"enough of the back", from(ViewSide::side, kNotFrontal, 3), 23, true, false},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    const SessionStep step = on_detection(turn_rules(), in_turning(true, c.frames_before), c.view);
    EXPECT_EQ(step.measure, c.measure);
    EXPECT_EQ(step.drop_back, c.drop_back);
    if (c.measure) {
      EXPECT_FALSE(step.use_frame);
      EXPECT_FALSE(step.forget);
    }
  }
}

TEST(Turning, ABackThatShiftsIsAccumulatedAnewWithoutAnotherAttempt) {
  Session session = in_turning(true);
  session.rejected_periods = 3;
  OfferStep step = after_offer(turn_rules(), session, true, 2);
  EXPECT_TRUE(step.forget);
  EXPECT_FALSE(step.measure);
  EXPECT_EQ(step.next.attempts, 0);
  EXPECT_EQ(step.next.state, State::turning);
  step = after_offer(turn_rules(), session, true, 3);
  EXPECT_TRUE(step.measure) << "enough of it";
  EXPECT_TRUE(after_offer(turn_rules(), session, false, 10).measure);
  EXPECT_TRUE(measure_at_end(turn_rules(), session, 3));
  EXPECT_FALSE(measure_at_end(turn_rules(), session, 2));
}

TEST(Turning, IsRequestedInNoOtherState) {
  for (const Transition& t : kTransitions)
    for (const ViewSide side : {ViewSide::front, ViewSide::back, ViewSide::side, ViewSide::unknown}) {
      SCOPED_TRACE(t.name);
      SessionRules r = turn_rules();
      r.calibration_psi = t.calibration;
      SessionView view = t.view;
      view.view = side;
      EXPECT_FALSE(has(on_detection(r, t.from, view).guidance, Guidance::turn_round));
    }
}

TEST(PsiPose, NeedsHandsUpAndUpperArmsLevel) {
  const Vec3f up{0, -1, 0};
  EXPECT_TRUE(is_psi_pose(test::standing_joints(true), up));
  EXPECT_FALSE(is_psi_pose(test::standing_joints(false), up));
  EXPECT_FALSE(is_psi_pose(test::standing_joints(true), {0, 1, 0})) << "upside down";

  JointSet one_hand = test::standing_joints(true);
  one_hand[Joint::RA] = one_hand[Joint::RE] + Vec3f{0, 200, 0};
  EXPECT_FALSE(is_psi_pose(one_hand, up));

  JointSet arms_up = test::standing_joints(true);  // elbows 45 degrees above the shoulders
  arms_up[Joint::LE] = arms_up[Joint::LS] + Vec3f{200, -200, 0};
  arms_up[Joint::LA] = arms_up[Joint::LE] + Vec3f{0, -250, 0};
  EXPECT_FALSE(is_psi_pose(arms_up, up));

  JointSet unseen = test::standing_joints(true);
  unseen.confidence[joint_index(Joint::LE)] = 0;
  EXPECT_FALSE(is_psi_pose(unseen, up));

  // 25 and 35 degrees: either side of the 30 of the definition. tan: .466, .700
  JointSet bent = test::standing_joints(true);
  bent[Joint::LE] = bent[Joint::LS] + Vec3f{280, -130.5F, 0};
  bent[Joint::LA] = bent[Joint::LE] + Vec3f{0, -250, 0};
  EXPECT_TRUE(is_psi_pose(bent, up));
  bent[Joint::LE] = bent[Joint::LS] + Vec3f{280, -196.0F, 0};
  bent[Joint::LA] = bent[Joint::LE] + Vec3f{0, -250, 0};
  EXPECT_FALSE(is_psi_pose(bent, up));
}

}  // namespace
}  // namespace im2fit
