// SPDX-License-Identifier: Apache-2.0
// The one loop that pulls frames: measuring, recording, the daemon and the C functions all take their frames here. A
// source writes straight into the sink's place for a frame.
#pragma once

#include <functional>

#include "core/camera.h"
#include "core/status.h"
#include "hal/source.h"

namespace im2fit {

// Where frames go: the engine, or a file. From one thread.
class FrameSink {
 public:
  virtual ~FrameSink() = default;
  // A place for the next frame; the same one until commit(). May wait for it.
  virtual Result<DepthImage> acquire() = 0;
  // The frame is written.
  virtual Status commit(const hal::FrameInfo& info) = 0;
};

enum class Pumped : int {
  frame,    // one was taken
  waiting,  // none came in time: again
  damaged,  // one is left out: again
  end,      // the source has no more frames
};
// Takes at most one frame. Errors: the source's other errors; the sink's; frames of another size than the sink's.
Result<Pumped> pump(hal::Source& source, FrameSink& sink, int timeout_ms);

// From a started source, until its end or until `go_on`, called after every frame, returns false. Errors: as pump();
// timeout when a source that is not lost() gives no frame for kFrameGapMsMax.
inline constexpr int kFrameGapMsMax = 5000;
Status pump_all(hal::Source& source, FrameSink& sink, const std::function<bool()>& go_on);

}  // namespace im2fit
