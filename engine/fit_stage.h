// SPDX-License-Identifier: Apache-2.0
// What FIT does with a frame that was sensed: session step, accumulation, and the measurement once a session.
#pragma once

#include <optional>

#include "engine/engine.h"
#include "engine/frame_pool.h"
#include "engine/frame_stages.h"
#include "engine/session.h"
#include "perception/observe/chain_filter.h"
#include "perception/observe/joint_filter.h"
#include "perception/observe/motion_filter.h"

namespace im2fit {

// No threads of its own; one caller at a time. No allocation.
class FitStage {
 public:
  FitStage(const EngineSettings& settings, FrameStages& stages);
  void process(const FrameSlot& slot);
  // A frame between two looks at a scene that stands still: it counts as one like the frame before.
  void pass(const FrameSlot& slot);
  // The stream has ended: measures when enough is accumulated.
  void end(const ArrivalCounts& counts);
  void reset();
  void use_intrinsics(const Intrinsics& intrinsics) { intrinsics_ = intrinsics; }  // between sessions
  // After MEASURED: waits for the person to leave, then begins anew. Before: begins anew.
  void next_person();
  // Begins anew at once.
  void begin_next();
  // over(): MEASURED, or a file was found damaged. Frames then change nothing any more. leaving(): the session waits
  // for the person to leave, and frames are still processed.
  bool leaving() const { return leaving_; }
  bool over() const { return fault_ || (session_.state == SessionState::measured && !leaving_); }
  // A session that ends in frames_wanted frames needs at least so many more; 0: it is over. A great number for those
  // that are over by something else than a count: a turn all round, and the person who leaves.
  int frames_to_go_min() const;
  // The damage found in measuring; null: none. Valid until the next session begins.
  const Error* fault() const { return fault_ ? &*fault_ : nullptr; }
  const EngineResult& result() const { return result_; }

 private:
  void end_moment(const FrameSlot& slot);
  void show(const FrameSlot& slot);
  void wait_for_leaving(const FrameSlot& slot);
  bool accumulate(const FrameSlot& slot);  // true: enough to measure
  void follow(const FrameSlot& slot);
  GuidanceSet still_refused(const SessionView& view);
  void measure(bool ended);
  void end_turning(bool with_back, bool ended);
  void forget();
  void count_accumulated();
  void take_counts(const ArrivalCounts& counts);
  void take_guidance(GuidanceSet guidance);

  Intrinsics intrinsics_;
  const ClothingGiven clothing_;
  const std::optional<SiteCorrection> site_;
  const SessionRules rules_;
  FrameStages& stages_;
  Session session_;
  EngineResult result_;
  ChainFilter chain_;
  JointFilter steady_;
  MotionFilter motion_;
  int unfollowed_periods_ = 0;   // since the last picture of a turn
  float turn_deg_a_period_ = 0;  // between the last two
  int front_frames_ = 0;         // accumulated before TURNING; 0 while the front is being accumulated
  int refused_user_ = 0;         // whom EngineResult::plausibility refused
  std::optional<Error> fault_;
  const bool one_after_another_;
  bool leaving_ = false;
  ArrivalCounts before_;  // counted before this session began; 0 unless one session follows another by itself
  struct Absence {
    int frames = 0;
    int periods = 0;
  };
  Absence absence_;  // in a row, of who is waited for to leave
};

}  // namespace im2fit
