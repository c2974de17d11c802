// SPDX-License-Identifier: Apache-2.0
#include "engine/fit_stage.h"

#include <algorithm>
#include <limits>

#include "index/clothing_estimate.h"

namespace im2fit {
namespace {

SessionRules rules_of(const EngineSettings& settings) {
  SessionRules rules;
  rules.frames_wanted = settings.frames_wanted;
  rules.frames_min = settings.frames_min;
  rules.calibration_psi = settings.calibration_psi;
  rules.turn = settings.turn;
  return rules;
}

constexpr int kFollowPeriods = 3;  // ten pictures a second of a person who turns

EngineResult empty_result(Turn turn) {
  EngineResult result;
  result.turn = turn;
  result.paper.fill(std::numeric_limits<float>::quiet_NaN());
  return result;
}

}  // namespace

FitStage::FitStage(const EngineSettings& settings, FrameStages& stages)
    : intrinsics_(settings.intrinsics),
      clothing_(settings.clothing),
      site_(settings.site),
      rules_(rules_of(settings)),
      stages_(stages),
      result_(empty_result(settings.turn)),
      one_after_another_(settings.one_after_another) {}

// What callers and overlays see of the latest frame, whatever the session makes of it.
void FitStage::show(const FrameSlot& slot) {
  const Detection& detection = slot.detection;
  const int user = detection.person.found ? detection.person.id : 0;
  if (!detection.person.found || user != result_.user) {
    chain_.reset();
    steady_.reset();
    motion_.reset();
  }
  result_.user = user;
  result_.users = detection.users;
  result_.user_count = detection.user_count;
  result_.view = detection.person.found ? detection.view : ViewSide::unknown;
  result_.has_joints = detection.person.found;
  // The floor of the answer stands with it.
  if (detection.person.floor.known && !leaving_) result_.floor = detection.person.floor;
  if (!detection.person.found) return;
  const ChainedJoints chained = chain_.step(detection.joints, slot.seconds);
  result_.joints = chained.joints;
  result_.joints_inferred = chained.inferred;
  result_.display_joints = steady_.step(chained.joints, slot.seconds);
}

void FitStage::wait_for_leaving(const FrameSlot& slot) {
  const Person& person = slot.detection.person;
  if (person.found && person.id == session_.user)
    absence_ = {};
  else
    absence_ = {absence_.frames + 1, absence_.periods + slot.periods};
  // Of slow cameras, too, the answer stands for the frames that EngineSettings::one_after_another promises.
  if (absence_.frames <= kAbsentPeriodsMax || absence_.periods <= rules_.absent_periods_max) return;
  begin_next();
  if (one_after_another_) before_ = slot.counts;
}

void FitStage::begin_next() {
  const std::uint32_t session = result_.session + 1;
  reset();
  result_.session = session;
}

// After a frame gap the person seen may be another.
void FitStage::end_moment(const FrameSlot& slot) {
  chain_.reset();
  steady_.reset();
  motion_.reset();
  result_.floor = {};
  if (leaving_) {
    begin_next();
    if (one_after_another_) before_ = slot.counts;
  } else if (session_.state == SessionState::turning) {
    end_turning(is_all_round(rules_.turn), false);
    result_.state = session_.state;
    count_accumulated();
  } else if (session_.state != SessionState::searching) {
    stages_.reset_fit();
    session_ = {};
    session_.state = SessionState::lost;
  }
}

void FitStage::process(const FrameSlot& slot) {
  if (slot.after_frame_gap) end_moment(slot);
  if (over()) return;
  show(slot);
  if (leaving_) {
    wait_for_leaving(slot);
    return;
  }
  const Detection& detection = slot.detection;
  const FloorPlane& floor = detection.person.floor;
  SessionView view;
  view.found = detection.person.found;
  view.guidance = detection.guidance;
  view.user = detection.person.id;
  view.periods = slot.periods;
  view.view = detection.view;
  view.arms_close = detection.arms_close;
  view.frames_accumulated = stages_.frame_count();
  view.turned_deg = stages_.turned_deg();
  view.turn_deg_a_period = turn_deg_a_period_;
  if (view.found) view.motion = motion_.step(detection.person.centroid_mm, detection.joints, slot.seconds);
  view.psi = rules_.calibration_psi && view.found && is_psi_pose(detection.joints, floor.up);

  const SessionStep step = on_detection(rules_, session_, view);
  session_ = step.next;
  if (step.forget) forget();

  ++result_.frames_seen;
  take_counts(slot.counts);
  result_.guidance = step.guidance | still_refused(view);
  result_.arms_close = step.arms_close;
  if (has(detection.guidance, Guidance::out_of_population))
    result_.plausibility.seen_stature_mm = detection.height_mm;
  unfollowed_periods_ += slot.periods;
  if (step.follow && unfollowed_periods_ >= kFollowPeriods) follow(slot);
  const bool enough = step.use_frame && accumulate(slot);
  take_guidance(result_.guidance);
  if (step.measure) {
    end_turning(!step.drop_back, false);
  } else if (enough) {
    measure(false);
  }
  result_.state = session_.state;
  count_accumulated();
  leaving_ = leaving_ || (one_after_another_ && session_.state == SessionState::measured);
}

// What a measurement was refused for is said until the same person is measured again; of another it says nothing.
GuidanceSet FitStage::still_refused(const SessionView& view) {
  if (result_.plausibility.refused == 0 || !view.found) return 0;
  if (view.user != refused_user_) result_.plausibility = {};
  return result_.plausibility.refused;
}

void FitStage::pass(const FrameSlot& slot) {
  if (over() || leaving_) return;
  ++result_.frames_seen;
  take_counts(slot.counts);
  take_guidance(result_.guidance);
}

// While turning: of the back; the front is kept.
void FitStage::forget() {
  if (session_.state == SessionState::turning) {
    stages_.drop_back();
    stages_.turn();
    return;
  }
  stages_.reset_fit();
  front_frames_ = 0;
}

bool FitStage::accumulate(const FrameSlot& slot) {
  const GuidanceSet refusal = stages_.add(slot.depth, slot.mask, intrinsics_, slot.detection);
  if (refusal == 0) stages_.set_pose(slot.info.pose);
  result_.guidance |= refusal;
  const OfferStep offer = after_offer(rules_, session_, refusal != 0, stages_.frame_count(), slot.periods);
  session_ = offer.next;
  if (offer.forget) forget();
  return offer.measure;
}

// One that cannot be followed is tried again with the next frame: the person turns on meanwhile.
void FitStage::follow(const FrameSlot& slot) {
  if (!stages_.follow({slot.depth, slot.mask, intrinsics_, slot.info.pose, slot.detection.person.floor})) return;
  const float turned_deg = stages_.turned_deg();
  turn_deg_a_period_ = std::fabs(turned_deg - result_.turned_deg) / static_cast<float>(unfollowed_periods_);
  result_.turned_deg = turned_deg;
  unfollowed_periods_ = 0;
}

void FitStage::end_turning(bool with_back, bool ended) {
  if (!with_back) {
    stages_.drop_back();
    front_frames_ = 0;
  }
  measure(ended);
}

void FitStage::measure(bool ended) {
  MeasuredPerson person;
  bool succeeded = stages_.measure(person);
  if (!succeeded && stages_.fault() == nullptr &&
      front_frames_ > 0) {  // the back cannot be described; the front could
    stages_.drop_back();
    front_frames_ = 0;
    succeeded = stages_.measure(person);
  }
  if (const Error* fault = stages_.fault(); !succeeded && fault != nullptr) {
    fault_ = *fault;
    return;
  }
  const GuidanceSet refused = succeeded ? person.plausibility.refused : 0;
  succeeded = succeeded && refused == 0;
  MeasuringStep step = after_measuring(rules_, session_, succeeded, ended);
  const int front_frames = stages_.frame_count();
  if (step.turn && !stages_.turn()) {
    step.turn = false;
    step.next.state = SessionState::measured;
  }
  session_ = step.next;
  if (step.forget) forget();
  result_.measured = succeeded && !step.turn;
  result_.front_measured = succeeded && (step.turn || result_.front_measured);
  if (!succeeded) {
    result_.views = AnswerViews::none;
    result_.answer = {};
    result_.uncorrected = {};
    result_.age = {};
    result_.seen = {};
    result_.paper.fill(std::numeric_limits<float>::quiet_NaN());
    result_.plausibility = person.plausibility;
    refused_user_ = session_.user;
    result_.guidance = refused != 0 ? refused : static_cast<GuidanceSet>(Guidance::too_noisy);
    result_.arms_close = 0;
    take_guidance(result_.guidance);
    return;
  }
  const bool of_back = rules_.turn == Turn::back && front_frames_ > 0;
  result_.views = person.around ? AnswerViews::around : of_back ? AnswerViews::front_and_back : AnswerViews::front;
  result_.answer = person.answer;
  result_.uncorrected = person.answer.measurements;
  // A site's correction was learned on fronts (docs/calibration.md).
  if (site_ && !person.around) site_->apply(result_.answer);
  result_.age = person.age;
  result_.seen = person.seen;
  result_.paper = person.paper;
  result_.measured_joints = person.joints;
  if (person.floor.known) result_.floor = person.floor;
  result_.plausibility = person.plausibility;
  // No guidance is left, but what stands beside an answer: also CLOTHED for a person specified as bare.
  result_.guidance = person.plausibility.beside;
  if (clothing_ == ClothingGiven::bare && index::looks_dressed(person.answer, clothing_))
    result_.guidance |= static_cast<GuidanceSet>(Guidance::clothed);
  result_.arms_close = 0;
  if (step.turn) {
    front_frames_ = front_frames;
    unfollowed_periods_ = 0;
    turn_deg_a_period_ = 0;
    result_.guidance |= static_cast<GuidanceSet>(turn_guidance(rules_.turn));
  } else if (front_frames_ > 0 && !person.around && !of_back) {  // a turn that was not used: the front's frames alone
    stages_.drop_back();
    front_frames_ = 0;
  }
  take_guidance(result_.guidance);
}

void FitStage::count_accumulated() {
  const int accumulated = stages_.frame_count();
  result_.frames_used = static_cast<std::uint64_t>(front_frames_ + accumulated);
  result_.frames_back = front_frames_ > 0 ? static_cast<std::uint64_t>(accumulated) : 0;
}

void FitStage::end(const ArrivalCounts& counts) {
  if (fault_ || session_.state == SessionState::measured) return;
  take_counts(counts);
  const bool enough = measure_at_end(rules_, session_, stages_.frame_count());
  if (session_.state == SessionState::turning)
    end_turning(enough, true);
  else if (enough)
    measure(true);
  result_.state = session_.state;
  count_accumulated();
}

int FitStage::frames_to_go_min() const {
  if (over()) return 0;
  if (one_after_another_ || leaving_ || is_all_round(rules_.turn)) return std::numeric_limits<int>::max();
  const int of_side = std::max(1, rules_.frames_wanted - stages_.frame_count());
  return rules_.turn == Turn::back && front_frames_ == 0 ? of_side + rules_.frames_wanted : of_side;
}

void FitStage::reset() {
  stages_.reset_fit();
  front_frames_ = 0;
  unfollowed_periods_ = 0;
  turn_deg_a_period_ = 0;
  session_ = {};
  result_ = empty_result(result_.turn);
  chain_.reset();
  steady_.reset();
  motion_.reset();
  fault_.reset();
  leaving_ = false;
  absence_ = {};
  before_ = {};
}

void FitStage::next_person() {
  if (session_.state != SessionState::measured)
    begin_next();
  else
    leaving_ = true;
}

void FitStage::take_counts(const ArrivalCounts& counts) {
  result_.frames_dropped = counts.dropped - before_.dropped;
  result_.sequence_gaps = counts.sequence_gaps - before_.sequence_gaps;
  result_.sequence_repeats = counts.sequence_repeats - before_.sequence_repeats;
  result_.time_reversals = counts.time_reversals - before_.time_reversals;
}

void FitStage::take_guidance(GuidanceSet guidance) {
  result_.guidance_seen |= guidance;
  for (std::size_t i = 0; i < kGuidanceCount; ++i)
    if ((guidance >> i & 1U) != 0) ++result_.guidance_frames[i];
  if (!has(guidance, Guidance::arms_close)) return;
  for (std::size_t arm = 0; arm < kArmCount; ++arm)
    if ((result_.arms_close >> arm & 1U) != 0) ++result_.arms_close_frames[arm];
}

}  // namespace im2fit
