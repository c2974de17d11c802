// SPDX-License-Identifier: Apache-2.0
// The streaming engine in C++: two threads, lock-free rings over a frame pool that is allocated at start, a session.
// Other languages and other compilers use the C interface, capi/include/im2fit/im2fit.h.
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

// After a longer gap between two frames by the source's clock (an unplugged camera), the scene may have changed. The
// accumulated frames are dropped, the session is LOST, and ids and floor are searched again. TURNING ends with the
// front only, and a measured person counts as having left.
inline constexpr float kFrameGapSecondsMax = 2.0F;

// What the guidance requests after the front is accumulated. back: the person shows the back, and both sides are
// measured. around: one full turn on the spot is measured (estimate/turn_measurement.h). walk: the person stands
// still and the camera is carried round the person; each frame has its pose (hal::FrameInfo).
enum class Turn : int { none, back, around, walk };
constexpr bool is_all_round(Turn turn) {
  return turn == Turn::around || turn == Turn::walk;
}
// The guidance in the state TURNING.
constexpr Guidance turn_guidance(Turn turn) {
  return turn == Turn::back ? Guidance::turn_round : turn == Turn::walk ? Guidance::walk_round : Guidance::turn_on;
}
// Smallest turn that is measured: about half a turn shows the front, a side and the back.
inline constexpr float kTurnEnoughDeg = 150;
inline constexpr std::array<std::string_view, 4> kTurnNames = {"none", "back", "around", "walk"};
// The value of a name; none for any other text.
constexpr Turn turn_of(std::string_view name) {
  for (std::size_t i = 1; i < kTurnNames.size(); ++i)
    if (name == kTurnNames[i]) return static_cast<Turn>(i);
  return Turn::none;
}

// The views used for a measurement.
enum class AnswerViews : int { none, front, front_and_back, around };

struct FrameSeen;
// Called on the thread FIT (with single_thread: that of push()) after each processed frame. The argument is valid
// during the call. It may be slow (frames then wait, or are dropped if live) and must not call the engine.
using FrameWatch = std::function<void(const FrameSeen&)>;

// Ranges of EngineSettings.
inline constexpr int kFramesWantedMax = 1000;
// Mean errors are those of 30 frames to 1.1 mm (docs/performance.md, "How many frames").
inline constexpr int kFramesWantedDefault = 15;
inline constexpr int kPoolFramesMin = 3;  // one for the producer and one for each thread
inline constexpr int kPoolFramesMax = 64;

struct EngineSettings {
  int width = 640, height = 480;  // of upright frames
  Intrinsics intrinsics;
  int frames_wanted = kFramesWantedDefault;  // accepted frames until MEASURED; with Turn::back for each side
  int frames_min = 5;                        // minimum for a measurement, and for each side, at the end of the stream
  bool calibration_psi = false;              // request the Psi pose first, as in the paper
  Turn turn = Turn::none;                    // otherwise TURNING follows the front, see engine/session.h
  // What the person wears. dressed: more than close-fitting clothes. The body under them is measured less accurately;
  // needs an index trained with such people, and `shape_space`. unknown: estimated from the frames if index and shape
  // space support it, and measurements are weighted by the probability; otherwise as bare. bare: if clothes are
  // detected, intervals are wider and CLOTHED is set.
  ClothingGiven clothing = ClothingGiven::unknown;
  // Shape space of the body file that the index was made with (body::BodyModel::shape_space()); it must outlive the
  // engine. A shape is fitted to the accumulated frames and refines the measurements. Null, empty or of another file:
  // measurements use only the features.
  const body::ShapeSpace* shape_space = nullptr;
  // The model of the body file, required with Turn::around and walk; it must outlive the engine.
  const body::BodyModel* body = nullptr;
  SensorKind sensor = SensorKind::unknown;  // set it if known, because smoothing drivers can hide it
  // Correction for the site and its camera. All measurements are corrected before they are used.
  std::optional<SiteCorrection> site;
  int user = 0;  // measure only the user with this id; 0: the first user who stands correctly
  // Measure only people whose feet are within this region of the floor; none: everywhere.
  std::optional<FloorRegion> region = std::nullopt;
  bool live = false;           // true: drop the oldest frame when behind; false: wait (replays never drop)
  bool single_thread = false;  // run both stages in push() on the caller's thread, with the same bits
  // Measures one person after another: after MEASURED the engine waits until the measured person leaves. Then the
  // next session begins automatically. The frames alone determine its start, not the caller's timing, so every person
  // of a recording gets the same bits with one thread and with two. The measurement is kept for at least
  // kAbsentPeriodsMax frames, so a caller that reads result() after every frame sees it. For the same reason
  // pool_frames must not exceed kAbsentPeriodsMax.
  bool one_after_another = false;
  // Idle state for a camera that runs for days: while nothing moves and at most the measured person is in view,
  // five frames per second are passed on with the last detection, and all others are only counted (engine/rest.h).
  // Depends only on the frames and their times. Measurements are unchanged; `watch` is called for fewer frames.
  bool rest = false;
  int pool_frames = 8;  // 3..64 frames of 3 bytes per pixel
  FrameWatch watch;     // none by default
};
// Whether an engine can be created with `settings`. Error: invalid_argument with the setting, its value and range.
Status check_settings(const EngineSettings& settings);
// The same for a region.
Status check_region(const std::optional<FloorRegion>& region);

// Immutable snapshot; plain data, copied without allocation. Nothing changes from MEASURED until reset(), so it does
// not matter how far a producer ran ahead of the measurement: the same frames give the same result.
struct EngineResult {
  std::uint32_t session = 0;  // number of sessions since next_person(), from 0; reset() sets it to 0
  SessionState state = SessionState::searching;
  Turn turn = Turn::none;                                       // as EngineSettings::turn
  GuidanceSet guidance = 0;                                     // of the latest frame
  GuidanceSet guidance_seen = 0;                                // of all frames so far
  std::array<std::uint32_t, kGuidanceCount> guidance_frames{};  // number of frames with each code, in bit order
  ArmSet arms_close = 0;  // the arms of ARMS_CLOSE in the latest frame; 0 without this code
  std::array<std::uint32_t, kArmCount> arms_close_frames{};  // number of frames with ARMS_CLOSE for each arm
  std::uint64_t frames_seen = 0;                             // processed
  std::uint64_t frames_used = 0;                             // accumulated for the measurement (or so far)
  std::uint64_t frames_back = 0;                             // of frames_used: frames of the back or of the turn
  // With Turn::around and walk, from TURNING on: angle that the person has turned relative to the camera, positive to
  // the person's left. A camera that is carried to the person's left turns the person to the right.
  float turned_deg = 0;
  std::uint64_t frames_dropped = 0;         // dropped because the engine was behind (live only)
  std::uint64_t sequence_gaps = 0;          // skipped sequence numbers
  std::uint64_t sequence_repeats = 0;       // frames whose sequence number did not increase
  std::uint64_t time_reversals = 0;         // frames whose host time did not increase
  std::array<User, kUserCountMax> users{};  // all people in view, nearest first; user_count are set
  int user_count = 0;
  int user = 0;                       // the user of joints and guidance; 0: no person in view
  ViewSide view = ViewSide::unknown;  // of the latest frame
  bool has_joints = false;
  JointSet joints;                 // latest; joints of low confidence are inferred (ChainFilter)
  JointFlags joints_inferred = 0;  // the inferred joints
  JointSet display_joints;         // the same, smoothed for display (JointFilter)
  FloorPlane floor;
  bool measured = false;
  // From TURNING on: answer, paper and measured_joints are preliminary and use only the front, until `measured`.
  bool front_measured = false;
  AnswerViews views = AnswerViews::none;  // of the answer
  index::Answer answer;                   // valid when measured or front_measured
  // The measurements before the correction of EngineSettings::site. Valid like `answer`; equal to it without a site.
  std::array<index::IntervalEstimate, kMeasurementCount> uncorrected{};
  AgeAnswer age;  // valid like `answer`
  // The facts about the person (Engine::set_known) and how they were used. `answer` and `age` include them;
  // `unconditioned` has the measurements without facts.
  KnownFacts known;
  KnownOutcome known_outcome;
  std::array<index::IntervalEstimate, kMeasurementCount> unconditioned{};
  body::SeenBody seen;  // valid like `answer`: the body fitted to the pictures
  // For the last frames that were measured or refused: `refused` holds until other frames are measured.
  Plausibility plausibility;
  MeasurementValues paper{};  // NaN where not measured
  JointSet measured_joints;   // robust mean over the frames of the front
};

// Applies facts to a result, also of a past session (a corrected fact needs no new frames). Returns what
// Engine::result() would return with `facts`. `before` must have been read while no fact was set.
inline EngineResult with_known(const EngineResult& before, const KnownFacts& facts) {
  EngineResult result = before;
  result.unconditioned = result.answer.measurements;
  result.known = facts;
  result.known_outcome = {};
  if (result.measured || result.front_measured) result.known_outcome = condition(facts, result.answer, result.age);
  return result;
}

// People in view who are confirmed as people but are not measured.
struct LeftOutUser {
  int user = 0;
  std::string_view reason;  // from kLeftOutNames
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
  // Model and index must outlive the engine. Errors: a setting out of range; an index made with another model.
  static Result<std::unique_ptr<Engine>> create(const EngineSettings& settings, const JointModel& joint_model,
                                                const index::Index& index);
  // Call acquire, commit, push, finish and reset on one producer thread.
  // Returns a buffer of the pool; waits if the pool is full, unless live. Errors: after finish(), fault().
  Result<DepthImage> acquire() override = 0;
  // Passes the frame in the buffer on. Not live: returns when the engine may need another frame, so no unneeded frame
  // is read; with the last frame, this is after the measurement. Live: if two frames wait, drops the oldest one that
  // is not in progress (the new one if all are). Errors: nothing was acquired, fault().
  Status commit(const hal::FrameInfo& info) override = 0;
  // Both, for a frame in another buffer. Further error: another size than in the settings.
  virtual Status push(DepthView depth, const hal::FrameInfo& info) = 0;
  // Sets the intrinsics from the next frame on; same size as in the settings. Waits for frames in the pipeline. Only
  // between sessions, because pictures of different lenses are not accumulated together. Errors: as for create().
  virtual Status use_intrinsics(const Intrinsics& intrinsics) = 0;
  // Waits until all pushed frames are processed; false after `timeout_ms` (negative: no limit).
  virtual bool wait_idle(int timeout_ms) = 0;
  // Ends the stream: waits until both stages are idle, then measures. A second call does nothing.
  virtual void finish() = 0;
  // The error that prevents measuring: a part of the index that was read is damaged. Then nothing is measured until
  // reset(), next_person() or select_user(), after which other parts may be read. Call it on the producer
  // thread.
  virtual Status fault() const = 0;
  // Any thread, any time, never blocks the pipeline.
  virtual EngineResult result() const = 0;
  // Sets the facts that the person of session `session` (EngineResult) reports, before, during or after the frames.
  // They are used in all later results and replace earlier facts of that session. The facts of the latest two
  // sessions are kept, so a measured person keeps theirs while those of the next person are set. A new session has no
  // facts. The cost is some microseconds in result(). Call it on the producer thread; never blocks the pipeline.
  // Error: check_known().
  virtual Status set_known(const KnownFacts& facts, std::uint32_t session) = 0;
  virtual void reset() = 0;  // for a new person, after finish() or between frames. Waits for frames in the pipeline
  // Prepares for the next person. After MEASURED: frames are processed again. The measurement is kept until its
  // person has left the picture (for half a second, and kAbsentPeriodsMax frames). Then a new session begins
  // automatically. Before MEASURED: as reset(), which also drops a preliminary measurement. Floor and ids are kept in
  // both cases. Call it on the producer thread; waits like reset(). With one_after_another it only accepts frames
  // again after finish(), and the waiting session continues.
  virtual void next_person() = 0;
  // From the next frame on, measures only the user with this id; 0: the first user who stands correctly. Another id
  // begins a new session, as next_person() before MEASURED. Call it on the producer thread; waits like reset().
  virtual void select_user(int user) = 0;
  // From the next frame on, measures only people whose feet are within the region; none: everywhere. The session
  // continues; if its person is outside, the person is absent. Call it on the producer thread; waits like reset().
  // Error: invalid_argument for a rectangle that check_region rejects.
  virtual Status set_region(const std::optional<FloorRegion>& region) = 0;
  // For overlays, after finish(): the fused picture of the front. Empty views if there is none.
  virtual ImageView<const std::uint16_t> fused_depth_q4() const = 0;
  virtual MaskView fused_mask() const = 0;
};

// Starts `source`, pulls frames until its end, its loss or `measured`, stops it and finishes the engine. Damaged
// frames are left out. Errors: those of the source (after finishing with the earlier frames); the engine's fault();
// timeout if a source that is not lost() gives no frame for kFrameGapMsMax. The end of a stream is Ok in any case.
Status run(Engine& engine, hal::Source& source, bool stop_when_measured);
// The same, until `go_on` returns false. It is called on this thread after every frame and may call the engine.
Status run(Engine& engine, hal::Source& source, const std::function<bool()>& go_on);

}  // namespace im2fit
