// SPDX-License-Identifier: Apache-2.0
// One person after the other before a camera: what `live` and `serve` share.
#pragma once

#include <string>

#include "apps/common/cli.h"
#include "apps/common/events.h"
#include "apps/common/operator_region.h"
#include "apps/common/reported_facts.h"
#include "apps/im2fit/preview_renderer.h"
#include "apps/im2fit/session.h"

namespace im2fit::apps {

struct LiveOptions {
  SessionOptions session;
  PreviewRendererOptions preview_renderer;
  int count = 0;              // 0: until Ctrl-C or the end
  bool print_results = true;  // false: values go to files, --json and the listener only
  // The frames behind an answer are recorded, and nothing outside the recording may influence it. No frame is skipped
  // while nothing moves. After a person is given up, the engine begins as a new one does, floor and ids included.
  bool recorded = false;
};
void add_live_options(cli::App& sub, LiveOptions& options);

// Follows a run beside the terminal. A recording then runs at the speed it was made.
class LiveListener {
 public:
  virtual ~LiveListener() = default;
  virtual void begin(const SessionOutcome& session) = 0;  // before the first frame
  // The number of the person who may be measured now, another for each person; 0 while nobody may. Frames are left
  // out then, and nothing seen under another number is used. Called often, on the thread of the run.
  virtual std::uint64_t permit() { return 1; }
  // The engine starts a new session with the next frame, for the person with this number. It has processed all
  // earlier frames (see()) and uses nothing of them. On the thread of the run.
  virtual void begin_person(std::uint64_t /*permit*/) {}
  // The facts that the person of this number reported last. They change the answer, also after it was given. `count`
  // differs after each report; it is 0 without facts and after the person's visit. Called often, on the run's thread.
  virtual ReportedFacts reported(std::uint64_t /*permit*/) { return {}; }
  // Where people are to be measured from now on, in place of the options' region. Called often, on the run's thread.
  virtual OperatorRegion region() { return {}; }
  virtual void see(const FrameSeen& frame) = 0;                // on the engine's thread
  virtual void publish(const Json& event) = 0;                 // apps/common/events.h
  virtual Status measured(const SessionOutcome& session) = 0;  // a person, or a corrected one; before the event
};

// Until Ctrl-C, the source's end or `count`; the exit code. `listener` may be null.
Result<int> run_live(const LiveOptions& options, LiveListener* listener);

}  // namespace im2fit::apps
