// SPDX-License-Identifier: Apache-2.0
// The session as a pure function of the state, the detection and the counts: it gives the next state and what to do
// with the frame. No clock, no I/O, no memory besides Session: time is counted in periods of 1/30 s, evidence in
// frames.
//
//   SEARCHING -> USER_FOUND -> [CALIBRATING ->] TRACKING -> [TURNING ->] MEASURED
//   LOST from USER_FOUND, CALIBRATING and TRACKING; back to USER_FOUND when a person is found again, at most
//   attempts_max times. MEASURED ends the session.
//
// TURNING, around: the front is measured, the guidance is TURN_ON, or TURN_SLOWER where pictures of the turn are too
// far apart, and ten frames a second are pictures of the turn. walk: the same, but the guidance is WALK_ROUND. It
// ends in MEASURED when the turn is whole, when it has not gone on for turn_wait_periods_max, when the person left,
// or at the end of the stream. Less than half a turn is left out: the front alone is the answer then.
//
// TURNING, back: the front is measured, the guidance is TURN_ROUND, and the back is accumulated. It ends in MEASURED
// whatever the person does: with both sides when frames_wanted frames of the back are accumulated, or frames_min of
// them by the end of the stream or of turn_wait_periods_max; with the front alone when there are fewer, or the person
// left.
//
// Arms that touch the trunk are remembered over frames: arms_memory.h has the rule.
//
// PersonTracker decides in each frame, in SENSE, which user is detected; the session reads that. From CALIBRATING on
// the session belongs to the user it began with: while another is detected, that user is absent.
#pragma once

#include "engine/arms_memory.h"
#include "engine/engine.h"
#include "perception/observe/motion_filter.h"
#include "perception/segment/person_tracker.h"

namespace im2fit {

struct SessionRules {
  int frames_wanted = 30;
  int frames_min = 5;
  bool calibration_psi = false;
  Turn turn = Turn::none;
  int absent_periods_max = kAbsentPeriodsMax;
  int psi_frames = 5;               // in a row
  int psi_wait_periods_max = 300;   // ten seconds to take the pose
  int psi_lower_periods_max = 90;   // three to leave it again; people who stay are measured in it
  int turn_wait_periods_max = 450;  // fifteen seconds in TURNING, but for one a frame accumulated
  int rejected_periods_max = 30;    // a second in a row: the person stands still, but no longer as accumulated
  int unsteady_frames_max = MotionFilter::kFrameCount;  // accumulated before movement shows: part of that movement
  // Of people standing still as instructed, seen at 320x240, the middle sways by up to 20 mm/s and the tracker's
  // hands tremble by 180.
  float body_speed_max_mm_s = 60;
  float limb_speed_max_mm_s = 300;
  float body_speed_plain_mm_s = 150;  // movement that is reported beside other guidance
  float turn_whole_deg = 330;         // people leave out the end
  float turn_progress_deg = 10;       // a person who stands still sways by less
  // Of a period. follow() needs pictures at most 25 degrees apart, ten a second. Once said, until it is plainly
  // slower.
  float turn_slower_deg = 200.0F / 30, turn_slow_deg = 120.0F / 30;
  int attempts_max = 8;  // beginnings after the first, by loss or by a pose that changed
};

struct Session {
  SessionState state = SessionState::searching;
  int absent_periods = 0;    // in a row
  int psi_frames = 0;        // in a row
  int psi_wait_periods = 0;  // in CALIBRATING
  int raised_periods = 0;    // in TRACKING after it: with the arms still raised
  int rejected_periods = 0;  // in a row
  int attempts = 0;
  int turning_periods = 0;  // in TURNING
  bool turned = false;      // in TURNING: the back has been seen, and no front since
  float progress_deg = 0;   // in TURNING, around: turned when turning_periods began anew
  bool turns_fast = false;  // the same
  int user = 0;             // the user of the latest frame that counted, in FIT's time; 0 before USER_FOUND
  ArmsMemory arms;          // of that user, since USER_FOUND; in TURNING: since the back was seen
};

// The part of a Detection the session uses.
struct SessionView {
  bool found = false;
  GuidanceSet guidance = 0;
  bool psi = false;  // is_psi_pose
  int user = 0;
  int periods = 1;  // since the frame before
  ViewSide view = ViewSide::unknown;
  Motion motion = {};
  int frames_accumulated = 0;  // before this frame; in TURNING: of the back
  ArmSet arms_close = 0;
  float turned_deg = 0;         // in TURNING, around: the farthest, signed
  float turn_deg_a_period = 0;  // the same: speed at the last picture followed
};

struct SessionStep {
  Session next;
  GuidanceSet guidance = 0;  // the detection's and the session's own
  ArmSet arms_close = 0;     // which arms arms_close is about
  bool forget = false;       // drop what is accumulated (in TURNING: of the back), before using this frame
  bool use_frame = false;    // offer the frame to the fuser, then call after_offer
  bool follow = false;       // a picture of the turn
  bool measure = false;      // TURNING is over: call after_measuring
  bool drop_back = false;    // before measuring: the front alone
};
SessionStep on_detection(const SessionRules& rules, const Session& session, const SessionView& view);

struct OfferStep {
  Session next;
  bool forget = false;
  bool measure = false;  // then call after_measuring
};
// `rejected`: the fuser's own guidance was not zero. `frames_accumulated`: after the offer. `periods`: as of the
// view.
OfferStep after_offer(const SessionRules& rules, const Session& session, bool rejected, int frames_accumulated,
                      int periods = 1);

struct MeasuringStep {
  Session next;
  bool forget = false;  // all of it
  bool turn = false;    // keep the measured frames as the front and accumulate the back
};
// `succeeded`: the accumulated frames could be described. `ended`: the stream is over, so the person cannot turn
// round any more.
MeasuringStep after_measuring(const SessionRules& rules, const Session& session, bool succeeded, bool ended = false);

// Whether the accumulated frames are enough at the end of the stream. In TURNING: those of the back, for both sides.
bool measure_at_end(const SessionRules& rules, const Session& session, int frames_accumulated);

// The calibration pose of the paper: both hands above the elbows, both upper arms level within 30 degrees, forearms
// upright within 45. `up`: unit, camera axes. False when one of the six joints has no confidence.
bool is_psi_pose(const JointSet& joints, Vec3f up);

}  // namespace im2fit
