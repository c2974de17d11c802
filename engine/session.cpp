// SPDX-License-Identifier: Apache-2.0
#include "engine/session.h"

namespace im2fit {
namespace {

constexpr GuidanceSet bit(Guidance g) {
  return static_cast<GuidanceSet>(g);
}

// An absent person: flicker is waited for, a loss ends the attempt. What is accumulated is kept until a person
// is found again, so that a stream that ends with an empty room still measures who stood there.
SessionStep on_absence(const SessionRules& rules, SessionStep step, int periods) {
  Session& next = step.next;
  // A person who is there but cannot be found is not an absent one.
  if ((step.guidance & kThereButNotFound) == 0) step.guidance |= bit(Guidance::no_person);
  if (next.state == SessionState::searching || next.state == SessionState::lost) return step;
  next.psi_frames = 0;
  next.absent_periods += periods;
  if (next.absent_periods <= rules.absent_periods_max) return step;
  if (next.state == SessionState::turning) {
    step.measure = true;
    step.drop_back = !is_all_round(rules.turn);
  } else {
    next.state = SessionState::lost;
  }
  return step;
}

void begin_attempt(Session& next, int user) {
  next.state = SessionState::user_found;
  next.arms = {};
  next.user = user;
  next.psi_frames = 0;
  next.psi_wait_periods = 0;
  next.raised_periods = 0;
  next.rejected_periods = 0;
}

// Arms held close keep their code until they have been apart for some frames.
void add_arms(SessionStep& step, const SessionView& view) {
  step.arms_close = remember_arms(step.next.arms, view.guidance, view.arms_close, view.frames_accumulated);
  if (step.arms_close != 0) step.guidance |= bit(Guidance::arms_close);
}

// Limbs count when nothing else is wrong: the joints of a person who is turned, bent or cut off jump by themselves.
// So does the centroid, a little: beside other guidance only plain movement is reported. In a picture that is mostly
// holes even the centroid means nothing.
bool is_moving(const SessionRules& rules, const SessionView& view) {
  if (has(view.guidance, Guidance::too_noisy)) return false;
  if (view.guidance != 0) return view.motion.body_mm_s > rules.body_speed_plain_mm_s;
  return view.motion.body_mm_s > rules.body_speed_max_mm_s || view.motion.limb_mm_s > rules.limb_speed_max_mm_s;
}

SessionStep on_calibrating(const SessionRules& rules, SessionStep step, const SessionView& view) {
  Session& next = step.next;
  next.psi_frames = view.psi ? next.psi_frames + 1 : 0;
  if (next.psi_frames >= rules.psi_frames) {
    next.state = SessionState::tracking;
    return step;
  }
  step.guidance |= bit(Guidance::calibration_pose);
  next.psi_wait_periods += view.periods;
  if (next.psi_wait_periods > rules.psi_wait_periods_max) next.state = SessionState::lost;
  return step;
}

// What the back needs. Until it is seen the person is still turning: neither movement nor the side is rejected.
SessionStep on_turning(const SessionRules& rules, SessionStep step, const SessionView& view, bool guessed) {
  Session& next = step.next;
  const bool back = view.view == ViewSide::back;
  const bool front = view.view == ViewSide::front && !guessed;
  if (back && !guessed && !next.turned) {
    next.turned = true;
    next.arms = {};
  }
  if (front) next.turned = false;
  if (!next.turned && !back) step.guidance |= bit(Guidance::turn_round);
  if (next.turned && is_moving(rules, view)) step.guidance |= bit(Guidance::moving);
  if (next.turned) add_arms(step, view);
  // A back seen for a moment before a front was no back, or was moving.
  const bool unsteady = front || has(step.guidance, Guidance::moving);
  if (unsteady && view.frames_accumulated > 0 && view.frames_accumulated <= rules.unsteady_frames_max)
    step.forget = true;
  step.use_frame = back && step.guidance == 0;
  return step;
}

// What a person who turns can do something about. The side seen, arms and movement are those of the turn.
constexpr GuidanceSet kWhileTurning = bit(Guidance::too_near) | bit(Guidance::too_far) | bit(Guidance::feet_cut) |
                                      bit(Guidance::head_cut) | bit(Guidance::several_people) |
                                      bit(Guidance::too_noisy) | bit(Guidance::step_to_the_middle);

SessionStep on_turning_round(const SessionRules& rules, SessionStep step, const SessionView& view) {
  Session& next = step.next;
  step.guidance &= kWhileTurning;
  step.follow = step.guidance == 0;
  const float turned = view.turned_deg < 0 ? -view.turned_deg : view.turned_deg;
  next.turns_fast = view.turn_deg_a_period > (next.turns_fast ? rules.turn_slow_deg : rules.turn_slower_deg);
  if (turned >= next.progress_deg + rules.turn_progress_deg) {
    next.progress_deg = turned;
    next.turning_periods = 0;
  }
  step.measure = turned >= rules.turn_whole_deg;
  if (!step.measure) step.guidance |= bit(next.turns_fast ? Guidance::turn_slower : turn_guidance(rules.turn));
  return step;
}

// Every frame of TURNING counts, also those without the person.
void bound_turning(const SessionRules& rules, SessionStep& step, const SessionView& view) {
  step.next.turning_periods += view.periods;
  if (is_all_round(rules.turn)) {
    step.measure = step.measure || step.next.turning_periods > rules.turn_wait_periods_max;
    return;
  }
  if (step.next.turning_periods - view.frames_accumulated <= rules.turn_wait_periods_max || step.measure) return;
  step.use_frame = false;
  step.measure = true;
  step.drop_back = step.forget || view.frames_accumulated < rules.frames_min;
  step.forget = false;
}

SessionStep step_of(const SessionRules& rules, const Session& session, const SessionView& view) {
  SessionStep step;
  step.next = session;
  step.guidance = view.guidance;
  if (session.state == SessionState::measured) return step;
  const bool begun = session.state == SessionState::calibrating || session.state == SessionState::tracking ||
                     session.state == SessionState::turning;
  if (!view.found) return on_absence(rules, step, view.periods);
  if (begun && view.user != session.user) {
    step.guidance = 0;  // the other's
    return on_absence(rules, step, view.periods);
  }

  Session& next = step.next;
  next.absent_periods = 0;
  if (next.state == SessionState::searching) {
    begin_attempt(next, view.user);
  } else if (next.state == SessionState::lost) {
    if (next.attempts >= rules.attempts_max) return step;
    ++next.attempts;
    step.forget = true;
    begin_attempt(next, view.user);
  }
  if (next.user != view.user) next.arms = {};
  next.user = view.user;
  // The side seen is a guess while the person is bent or the head is outside the picture.
  const bool guessed = has(view.guidance, Guidance::not_upright) || has(view.guidance, Guidance::head_cut);
  if (next.state == SessionState::turning && is_all_round(rules.turn)) return on_turning_round(rules, step, view);
  if (next.state == SessionState::turning) return on_turning(rules, step, view, guessed);
  add_arms(step, view);
  if (is_moving(rules, view)) {
    step.guidance |= bit(Guidance::moving);
    if (view.frames_accumulated > 0 && view.frames_accumulated <= rules.unsteady_frames_max) step.forget = true;
  }
  if (view.view == ViewSide::back && !guessed) step.guidance |= bit(Guidance::not_frontal);
  if (next.state == SessionState::user_found && step.guidance == 0)
    next.state = rules.calibration_psi ? SessionState::calibrating : SessionState::tracking;
  if (next.state == SessionState::calibrating) return on_calibrating(rules, step, view);
  // Arms still raised after calibration: the person is lowering them, or is a recording of nothing else.
  if (next.state == SessionState::tracking && rules.calibration_psi && view.psi &&
      next.raised_periods < rules.psi_lower_periods_max) {
    next.raised_periods += view.periods;
    step.guidance |= bit(Guidance::moving);
  }
  step.use_frame = next.state == SessionState::tracking && step.guidance == 0;
  return step;
}

}  // namespace

SessionStep on_detection(const SessionRules& rules, const Session& session, const SessionView& view) {
  SessionStep step = step_of(rules, session, view);
  if (session.state == SessionState::turning) bound_turning(rules, step, view);
  return step;
}

namespace {

void give_up_close_arms(OfferStep& step) {
  if (!step.measure || !mostly_close(step.next.arms.capture)) return;
  step.measure = false;
  step.forget = true;
}

}  // namespace

OfferStep after_offer(const SessionRules& rules, const Session& session, bool rejected, int frames_accumulated,
                      int periods) {
  OfferStep step;
  step.next = session;
  if (!rejected) {
    step.next.rejected_periods = 0;
    step.measure = frames_accumulated >= rules.frames_wanted;
    give_up_close_arms(step);
    return step;
  }
  step.next.rejected_periods += periods;
  if (step.next.rejected_periods <= rules.rejected_periods_max) return step;
  // Standing still, but not as before. Enough frames are measured now (waiting for the old pose may last for ever);
  // too few are given up for the new pose.
  step.next.rejected_periods = 0;
  if (frames_accumulated >= rules.frames_min) {
    step.measure = true;
    give_up_close_arms(step);
  } else if (session.state == SessionState::turning) {
    step.forget = true;  // TURNING has a bound of its own
  } else if (step.next.attempts < rules.attempts_max) {
    ++step.next.attempts;
    step.forget = true;
  }
  return step;
}

MeasuringStep after_measuring(const SessionRules& rules, const Session& session, bool succeeded, bool ended) {
  MeasuringStep step;
  step.next = session;
  if (succeeded) {
    step.turn = rules.turn != Turn::none && !ended && session.state == SessionState::tracking;
    step.next.state = step.turn ? SessionState::turning : SessionState::measured;
    step.next.rejected_periods = 0;
    step.next.turning_periods = 0;
    step.next.turned = false;
    step.next.progress_deg = 0;
    step.next.turns_fast = false;
    return step;
  }
  step.forget = true;
  if (session.state == SessionState::turning) step.next.state = SessionState::tracking;
  if (step.next.attempts < rules.attempts_max)
    ++step.next.attempts;
  else
    step.next.state = SessionState::lost;
  return step;
}

bool measure_at_end(const SessionRules& rules, const Session& session, int frames_accumulated) {
  // Whether the turn so far is enough is the stages' to say.
  if (session.state == SessionState::turning && is_all_round(rules.turn)) return true;
  return session.state != SessionState::measured && frames_accumulated > 0 &&
         frames_accumulated >= rules.frames_min && !mostly_close(session.arms.session);
}

bool is_psi_pose(const JointSet& joints, Vec3f up) {
  constexpr Joint kArms[2][3] = {{Joint::LS, Joint::LE, Joint::LA}, {Joint::RS, Joint::RE, Joint::RA}};
  for (const auto& arm : kArms) {
    for (const Joint joint : arm)
      if (!(joints.confidence[joint_index(joint)] > 0)) return false;
    const Vec3f upper = joints[arm[1]] - joints[arm[0]];
    const Vec3f fore = joints[arm[2]] - joints[arm[1]];
    const float rise = dot(upper, up);
    const float lift = dot(fore, up);
    if (!(rise * rise <= 0.25F * dot(upper, upper))) return false;           // sin 30 deg = 1/2
    if (!(lift > 0 && lift * lift >= 0.5F * dot(fore, fore))) return false;  // cos 45 deg = sqrt(1/2)
  }
  return true;
}

}  // namespace im2fit
