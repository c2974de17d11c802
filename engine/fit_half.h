// SPDX-License-Identifier: Apache-2.0
// What FIT does with a frame that was sensed: session step, gathering, and the measurement once a session.
#pragma once

#include "engine/engine.h"
#include "engine/frame_pool.h"
#include "engine/frame_stages.h"
#include "engine/session.h"

namespace im2fit {

// No threads of its own; one caller at a time. No allocation.
class FitHalf {
 public:
  FitHalf(const EngineSettings& settings, FrameStages& stages);
  void process(const FrameSlot& slot);
  // The stream has ended: measures when enough is gathered.
  void end(const ArrivalCounts& counts);
  void reset();
  // The session is over: MEASURED; frames change nothing any more.
  bool over() const { return session_.state == SessionState::measured; }
  const EngineResult& result() const { return result_; }

 private:
  bool gather(const FrameSlot& slot);  // true: enough to measure
  void measure();
  void take_counts(const ArrivalCounts& counts);
  void take_guidance(GuidanceSet guidance);

  const Intrinsics intrinsics_;
  const SessionRules rules_;
  FrameStages& stages_;
  Session session_;
  EngineResult result_;
};

}  // namespace im2fit
