// SPDX-License-Identifier: Apache-2.0
// The session as a pure function of state, detection and counts. It returns the next state and what to do with the
// frame. It has no clock, no I/O and no memory except Session. Time is counted in periods of 1/30 s, evidence in
// frames.
//
//   SEARCHING -> USER_FOUND -> [CALIBRATING ->] TRACKING -> [TURNING ->] MEASURED
//   LOST follows USER_FOUND, CALIBRATING and TRACKING. USER_FOUND follows LOST when a person is found again, at most
//   attempts_max times. MEASURED ends the session.
//
// TURNING, around: the front is measured. The guidance is TURN_ON, or TURN_SLOWER if pictures of the turn are too far
// apart. Ten frames per second are used as pictures of the turn. walk: the same with the guidance WALK_ROUND. TURNING
// ends in MEASURED when the turn is complete, after turn_wait_periods_max without progress, when the person leaves,
// or at the end of the stream. With less than half a turn, only the front is used.
//
// TURNING, back: the front is measured, the guidance is TURN_ROUND, and the back is accumulated. TURNING always ends
// in MEASURED. Both sides are used if frames_wanted frames of the back are accumulated, or at least frames_min at the
// end of the stream or after turn_wait_periods_max. Only the front is used if there are fewer, or if the person
// leaves.
//
// arms_memory.h has the rule for arms that touch the trunk.
//
// In each frame, PersonTracker decides in SENSE which user is detected. From CALIBRATING on, the session belongs to
// the user with whom it began. While another user is detected, the session's user is absent.
#pragma once

#include "engine/arms_memory.h"
#include "engine/engine.h"
#include "perception/observe/motion_filter.h"
#include "perception/segment/person_tracker.h"

namespace im2fit {

struct SessionRules {
  int frames_wanted = kFramesWantedDefault;
  int frames_min = 5;
  bool calibration_psi = false;
  Turn turn = Turn::none;
  int absent_periods_max = kAbsentPeriodsMax;
  int psi_frames = 5;               // in a row
  int psi_wait_periods_max = 300;   // ten seconds to take the pose
  int psi_lower_periods_max = 90;   // three seconds to leave the pose; after that it is measured
  int turn_wait_periods_max = 450;  // fifteen seconds in TURNING, plus one for each accumulated frame
  int rejected_periods_max = 30;    // one second in a row: the person stands still in another pose than accumulated
  int unsteady_frames_max = MotionFilter::kFrameCount;  // frames accumulated before a movement is detected
  // When people stand still as instructed, at 320x240, the centre sways by up to 20 mm/s, and the tracked hands move
  // by up to 180 mm/s.
  float body_speed_max_mm_s = 60;
  float limb_speed_max_mm_s = 300;
  float body_speed_plain_mm_s = 150;  // movement that is reported together with other guidance
  float turn_whole_deg = 330;         // people do not complete the turn
  float turn_progress_deg = 10;       // a person who stands still sways by less
  // Per period. follow() needs pictures at most 25 degrees apart, ten per second. TURN_SLOWER is set above the first
  // and cleared below the second.
  float turn_slower_deg = 200.0F / 30, turn_slow_deg = 120.0F / 30;
  int attempts_max = 8;  // restarts after a loss or a changed pose
};

struct Session {
  SessionState state = SessionState::searching;
  int absent_periods = 0;    // in a row
  int psi_frames = 0;        // in a row
  int psi_wait_periods = 0;  // in CALIBRATING
  int raised_periods = 0;    // in TRACKING after CALIBRATING, with arms still raised
  int rejected_periods = 0;  // in a row
  int attempts = 0;
  int turning_periods = 0;  // in TURNING
  bool turned = false;      // in TURNING: the back was seen, and no front after it
  float progress_deg = 0;   // in TURNING, around: angle at the last restart of turning_periods
  bool turns_fast = false;  // the same
  int user = 0;             // the user of the latest frame that was used in FIT; 0 before USER_FOUND
  ArmsMemory arms;          // of that user, since USER_FOUND; in TURNING: since the back was seen
};

// The part of a Detection the session uses.
struct SessionView {
  bool found = false;
  GuidanceSet guidance = 0;
  bool psi = false;  // is_psi_pose
  int user = 0;
  int periods = 1;  // since the previous frame
  ViewSide view = ViewSide::unknown;
  Motion motion = {};
  int frames_accumulated = 0;  // before this frame; in TURNING: of the back
  ArmSet arms_close = 0;
  float turned_deg = 0;         // in TURNING, around: the largest angle so far, signed
  float turn_deg_a_period = 0;  // the same: speed at the last picture of the turn
};

struct SessionStep {
  Session next;
  GuidanceSet guidance = 0;  // of the detection and of the session
  ArmSet arms_close = 0;     // the arms of ARMS_CLOSE
  bool forget = false;       // discard accumulated frames (in TURNING: of the back) before using this frame
  bool use_frame = false;    // offer the frame to the fuser, then call after_offer
  bool follow = false;       // a picture of the turn
  bool measure = false;      // TURNING is over: call after_measuring
  bool drop_back = false;    // before measuring: use only the front
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
  bool forget = false;  // discard all frames
  bool turn = false;    // keep the measured frames as the front and accumulate the back
};
// `succeeded`: a feature was computed from the accumulated frames. `ended`: the stream has ended, so the person can
// no longer turn round.
MeasuringStep after_measuring(const SessionRules& rules, const Session& session, bool succeeded, bool ended = false);

// Whether the accumulated frames are sufficient at the end of the stream. In TURNING: the frames of the back.
bool measure_at_end(const SessionRules& rules, const Session& session, int frames_accumulated);

// The calibration pose of the paper: both hands above the elbows, both upper arms level within 30 degrees, forearms
// upright within 45. `up`: unit, camera axes. False when one of the six joints has no confidence.
bool is_psi_pose(const JointSet& joints, Vec3f up);

}  // namespace im2fit
