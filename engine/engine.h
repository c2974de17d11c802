// SPDX-License-Identifier: Apache-2.0
// The streaming engine in C++: two threads, lock-free rings over a frame pool made at start, session states.
// Other languages and other compilers use include/im2fit/im2fit.h, which wraps this.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "body/fit/shape_fitter.h"
#include "body/model.h"
#include "core/clothing.h"
#include "core/floor_region.h"
#include "core/guidance.h"
#include "core/joints.h"
#include "core/status.h"
#include "engine/pump.h"
#include "estimate/age.h"
#include "estimate/known_facts.h"
#include "estimate/plausibility.h"
#include "estimate/site_calibration.h"
#include "hal/source.h"
#include "index/index.h"
#include "perception/observe/chain_filter.h"
#include "perception/observe/observe.h"

namespace im2fit {

enum class SessionState : int { searching, user_found, calibrating, tracking, measured, lost, turning };

// After a longer gap between two frames by the source's clock (a camera that was unplugged) the scene may be another:
// the accumulated frames are dropped, the session is LOST, and ids and floor are found again. TURNING ends with the
// front alone, and the person measured before counts as having left.
inline constexpr float kFrameGapSecondsMax = 2.0F;

// What the guidance requests once the front is accumulated. back: that the person shows the back, so that both sides
// are measured. around: one turn on the spot, all of which is measured (estimate/turn_measurement.h). walk: the same,
// but the person stands still and the camera is carried round, each frame with its pose (hal::FrameInfo).
enum class Turn : int { none, back, around, walk };
constexpr bool is_all_round(Turn turn) {
  return turn == Turn::around || turn == Turn::walk;
}
// The guidance of the state TURNING.
constexpr Guidance turn_guidance(Turn turn) {
  return turn == Turn::back ? Guidance::turn_round : turn == Turn::walk ? Guidance::walk_round : Guidance::turn_on;
}
// Least turn that is measured: half of one shows front, a side and the back.
inline constexpr float kTurnEnoughDeg = 150;
inline constexpr std::array<std::string_view, 4> kTurnNames = {"none", "back", "around", "walk"};
// Of its name; any other word: none.
constexpr Turn turn_of(std::string_view name) {
  for (std::size_t i = 1; i < kTurnNames.size(); ++i)
    if (name == kTurnNames[i]) return static_cast<Turn>(i);
  return Turn::none;
}

// What an answer rests on.
enum class AnswerViews : int { none, front, front_and_back, around };

struct FrameSeen;
// Called on the thread of FIT (push()'s with single_thread) after each frame processed. Its argument is valid during
// the call. It may be slow (frames wait, or drop when live) and must not call the engine.
using FrameWatch = std::function<void(const FrameSeen&)>;

// Ranges of EngineSettings.
inline constexpr int kFramesWantedMax = 1000;
inline constexpr int kPoolFramesMin = 3;  // one in each hand
inline constexpr int kPoolFramesMax = 64;

struct EngineSettings {
  int width = 640, height = 480;  // of upright frames
  Intrinsics intrinsics;
  int frames_wanted = 30;        // accepted frames until MEASURED; of each side with Turn::back
  int frames_min = 5;            // fewest a measurement, and each of its sides, may rest on when the stream ends
  bool calibration_psi = false;  // ask for the Psi pose first, as the paper does
  Turn turn = Turn::none;        // else TURNING follows the front, see engine/session.h
  // What the person wears. dressed: more than close-fitting clothes; the body is estimated through them, less well,
  // by an index that has learned such people; needs `shape_space`. unknown: estimated from the frames where index and
  // shape space allow it, and the answer weighted by its probability; else as bare. bare: a person nevertheless seen
  // dressed gets wider intervals and CLOTHED.
  ClothingGiven clothing = ClothingGiven::unknown;
  // Of the body file the index was made with (body::BodyModel::shape_space()); it must outlive the engine. The shape
  // is fitted to the accumulated frames and refines the answer. Null, empty or of another file: the answer rests on
  // the features alone.
  const body::ShapeSpace* shape_space = nullptr;
  // The body file's model, needed with Turn::around and walk; it must outlive the engine.
  const body::BodyModel* body = nullptr;
  SensorKind sensor = SensorKind::unknown;  // where it is known: a driver may smooth away what shows it
  // Of the site and its camera: every answer is corrected before it is shown or used.
  std::optional<SiteCorrection> site;
  int user = 0;  // measure the user of this id only; 0: the first who stands correctly
  // Measure only people whose feet are within, on the floor; none: everywhere.
  std::optional<FloorRegion> region = std::nullopt;
  bool live = false;           // live: drop the oldest frame when behind; else wait (replay never drops)
  bool single_thread = false;  // both stages on the caller's thread in push(): same bits
  // One person after the other: from the frame after MEASURED on the engine waits until the measured person leaves,
  // and the next session begins by itself. So the frames alone determine where a session begins, not the caller's
  // timing, and every person of a recording gets the same bits on one thread and on two. The answer is kept for at
  // least kAbsentPeriodsMax frames, so that a caller that reads result() after every frame sees it. For the same
  // reason pool_frames must not exceed kAbsentPeriodsMax.
  bool one_after_another = false;
  // For a camera that runs for days: while nothing moves and the picture is empty or the measured person is still in
  // view, five frames a second are passed on with the last detection, and the rest are only counted: engine/rest.h.
  // Decided by the frames and their times. Measurements are unchanged; `watch` sees fewer frames.
  bool rest = false;
  int pool_frames = 8;  // 3..64 frames of 3 bytes a pixel
  FrameWatch watch;     // none by default
};
// Whether an engine can be made with `settings`. Error: invalid_argument with the setting, its value and its range.
Status check_settings(const EngineSettings& settings);
// The same of its region.
Status check_region(const std::optional<FloorRegion>& region);

// Immutable snapshot; plain data, no allocation to copy. Everything stands still from MEASURED until reset(), so that
// how far a producer ran ahead of the measurement leaves no trace: the same frames give the same result.
struct EngineResult {
  std::uint32_t session = 0;  // counts the sessions that followed next_person(), from 0; reset() begins at 0 again
  SessionState state = SessionState::searching;
  Turn turn = Turn::none;                                       // as EngineSettings::turn
  GuidanceSet guidance = 0;                                     // of the latest frame
  GuidanceSet guidance_seen = 0;                                // of all frames so far
  std::array<std::uint32_t, kGuidanceCount> guidance_frames{};  // frames that carried each code, in bit order
  ArmSet arms_close = 0;  // which arms ARMS_CLOSE is about, of the latest frame; 0 without that code
  std::array<std::uint32_t, kArmCount> arms_close_frames{};  // frames in which it was about each
  std::uint64_t frames_seen = 0;                             // processed
  std::uint64_t frames_used = 0;                             // accumulated behind the answer (or so far)
  std::uint64_t frames_back = 0;                             // of frames_used: those of the back or of the turn
  // With Turn::around and walk, from TURNING on: how far the person has turned, + to the own left, as the camera sees
  // it. A camera that is carried round to the person's left turns the person to the right.
  float turned_deg = 0;
  std::uint64_t frames_dropped = 0;         // given up unread because the engine was behind (live only)
  std::uint64_t sequence_gaps = 0;          // sequence numbers skipped
  std::uint64_t sequence_repeats = 0;       // frames whose sequence number did not grow
  std::uint64_t time_reversals = 0;         // frames whose host time did not grow
  std::array<User, kUserCountMax> users{};  // all people in view, nearest first; user_count are set
  int user_count = 0;
  int user = 0;                       // whose joints and guidance these are; 0: no person is in view
  ViewSide view = ViewSide::unknown;  // of the latest frame
  bool has_joints = false;
  JointSet joints;                 // latest; those of little confidence held by the skeleton (ChainFilter)
  JointFlags joints_inferred = 0;  // which those are
  JointSet display_joints;         // the same, smoothed for display (JointFilter)
  FloorPlane floor;
  bool measured = false;
  // From TURNING on: answer, paper and measured_joints are of the front alone, preliminary until `measured`.
  bool front_measured = false;
  AnswerViews views = AnswerViews::none;  // of the answer
  index::Answer answer;                   // valid when measured or front_measured
  // The measurements before the correction of EngineSettings::site; valid as `answer`, the same without a correction.
  std::array<index::IntervalEstimate, kMeasurementCount> uncorrected{};
  AgeAnswer age;  // as the answer
  // What was known of the person (Engine::set_known): given, and what became of it. `answer` and `age` rest on it;
  // `unconditioned` is the answer without.
  KnownFacts known;
  KnownOutcome known_outcome;
  std::array<index::IntervalEstimate, kMeasurementCount> unconditioned{};
  body::SeenBody seen;  // as the answer: the body fitted to the pictures behind it
  // Of the last frames that were to be measured, also of those refused: `refused` holds until others are measured.
  Plausibility plausibility;
  MeasurementValues paper{};  // NaN where not measured
  JointSet measured_joints;   // robust mean behind the answer: the front's
};

// Known facts in a result, also of a session that is over (a corrected fact needs no new frames): what
// Engine::result() gives when the person of `before` reports `facts`. `before`: read while no fact was known.
inline EngineResult with_known(const EngineResult& before, const KnownFacts& facts) {
  EngineResult result = before;
  result.unconditioned = result.answer.measurements;
  result.known = facts;
  result.known_outcome = {};
  if (result.measured || result.front_measured) result.known_outcome = condition(facts, result.answer, result.age);
  return result;
}

// Of the people in view, those who count as people but are not measured.
struct LeftOutUser {
  int user = 0;
  std::string_view reason;  // of kLeftOutNames
};
inline std::vector<LeftOutUser> left_out_of(const EngineResult& result) {
  std::vector<LeftOutUser> list;
  for (std::size_t i = 0; i < static_cast<std::size_t>(result.user_count); ++i) {
    const User& user = result.users[i];
    if (user.confirmed && user.left_out != LeftOut::no)
      list.push_back({user.id, kLeftOutNames[static_cast<std::size_t>(user.left_out)]});
  }
  return list;
}

struct FrameSeen {
  DepthView depth;
  MaskView mask;
  hal::FrameInfo info;
  std::span<const User> users;  // all people in view
  const EngineResult& result;
};

class Engine : public FrameSink {
 public:
  // The model and index must outlive the engine. Errors: settings out of range; an index made with another model.
  static Result<std::unique_ptr<Engine>> create(const EngineSettings& settings, const JointModel& joint_model,
                                                const index::Index& index);
  // acquire, commit, push, finish and reset: from one producer thread.
  // A place in the pool; waits when it is full unless live. Errors: after finish(), fault().
  Result<DepthImage> acquire() override = 0;
  // Hands the place's frame on. Not live: returns when the engine may need another frame, so that none is read in
  // vain; with the last one that is after measuring. Live: gives up the oldest frame not yet begun when two wait (the
  // new one when all are begun). Errors: nothing was acquired, fault().
  Status commit(const hal::FrameInfo& info) override = 0;
  // Both, for a frame that lies elsewhere. Error besides: another size than the settings'.
  virtual Status push(DepthView depth, const hal::FrameInfo& info) = 0;
  // Of the frames from the next one on, same size as the settings'. Waits for frames in the pipeline; between
  // sessions only, as pictures taken through different lenses are not accumulated together. Errors: as of create().
  virtual Status use_intrinsics(const Intrinsics& intrinsics) = 0;
  // Waits until all frames pushed came through; false when they have not within `timeout_ms` (negative: no limit).
  virtual bool wait_idle(int timeout_ms) = 0;
  // No more frames: waits until both stages are idle and measures with the frames so far. A second call does nothing.
  virtual void finish() = 0;
  // The error that keeps the engine from measuring: the index is damaged where it was read. Nothing is measured then
  // until reset(), next_person() or select_user(), after which other parts of it may be read. From the producer
  // thread.
  virtual Status fault() const = 0;
  // Any thread, any time, never blocks the pipeline.
  virtual EngineResult result() const = 0;
  // What the person of session `session` (EngineResult) knows of themselves: evidence in the answer from now on,
  // before, during and after the frames; it replaces what was set before of that session. Facts of two sessions are
  // kept, the latest: a measured person keeps theirs while the next person's are set. A session without facts has
  // none. Costs nothing until result() is read, and some microseconds there. From the producer thread; never blocks
  // the pipeline. Error: check_known().
  virtual Status set_known(const KnownFacts& facts, std::uint32_t session) = 0;
  virtual void reset() = 0;  // a new person; after finish() or between frames. Waits for frames in the pipeline
  // The next person, after MEASURED: frames are processed again. The answer is kept until the measured person left
  // the picture (for half a second, and kAbsentPeriodsMax frames), then a new session begins by itself. The floor and
  // the ids are kept. Before MEASURED: the same as reset() (drops a preliminary answer too), but keeps floor and ids.
  // From the producer thread; waits as reset() does. With one_after_another it only lets frames in again after
  // finish(): the waiting session continues.
  virtual void next_person() = 0;
  // From the next frame on measures only the user of this id; 0: the first user who stands correctly. A changed id
  // begins anew, as next_person() before MEASURED does. From the producer thread; waits as reset() does.
  virtual void select_user(int user) = 0;
  // From the next frame on measures only people whose feet are within; none: everywhere. The session goes on; who
  // held it and is outside is absent. From the producer thread; waits as reset() does.
  // Error: invalid_argument, for a rectangle that check_region refuses.
  virtual Status set_region(const std::optional<FloorRegion>& region) = 0;
  // For overlays, after finish(): the fused picture of the front. Empty views when there is none.
  virtual ImageView<const std::uint16_t> fused_depth_q4() const = 0;
  virtual MaskView fused_mask() const = 0;
};

// Starts `source`, pulls from it until its end, its loss or `measured`, stops it and finishes the engine. Damaged
// frames are left out. Errors: the source's (after finishing with what came before); the engine's fault(); timeout
// when a source that is not lost() gives no frame for kFrameGapMsMax. The end of a stream is Ok, measured or not.
Status run(Engine& engine, hal::Source& source, bool stop_when_measured);
// The same, until `go_on`, called on this thread after every frame pushed, returns false; it may call the engine.
Status run(Engine& engine, hal::Source& source, const std::function<bool()>& go_on);

}  // namespace im2fit
