// SPDX-License-Identifier: Apache-2.0
// The depth of one visit, written while it goes on into a session that is not complete yet: nothing of it is left
// unless save() is called.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "apps/sessions/store.h"
#include "engine/engine.h"
#include "hal/folder/depth_folder.h"
#include "report/motion_recording.h"

namespace im2fit::apps {

class VisitRecorder {
 public:
  static constexpr int kFramesMax = 1800;       // a minute at 30 Hz, some 200 MB on the disk
  static constexpr std::size_t kQueueMax = 32;  // frames in memory: 20 MB of 640 x 480

  // Begins a session below `root` (sessions::NewSession).
  static Result<std::unique_ptr<VisitRecorder>> begin(const std::string& root, const hal::SourceInfo& source);
  ~VisitRecorder();  // deletes an unsaved recording
  VisitRecorder(const VisitRecorder&) = delete;
  VisitRecorder& operator=(const VisitRecorder&) = delete;

  // What was recorded goes: the engine has begun anew. On the thread that feeds it, between frames.
  void begin_anew();
  // On the engine's thread: every frame it worked on since then, so that measuring the recording gives the same bits.
  // A camera's frame is left out, and counted, when the disk is too slow; a recording waits.
  void see(const FrameSeen& frame);
  // No frame after this is recorded.
  void measured();
  struct Counts {
    int frames = 0;   // on the disk or on the way there
    int dropped = 0;  // the disk was too slow
    bool full = false;
    std::string error;  // of writing; nothing is recorded after it
  };
  Counts counts() const;
  // Waits until all is written. Errors: of writing, as NewSession::finish. `record` without an id; the session's id.
  Result<std::string> save(const sessions::Record& record, const std::string& result_json);

 private:
  struct Frame {
    bool first = false;  // since begin_anew()
    std::vector<std::uint16_t> pixels;
    hal::FrameInfo info;
  };
  VisitRecorder(sessions::NewSession session, const hal::SourceInfo& source);
  void write_all();
  Status write(const Frame& frame);
  Status begin_folder();

  sessions::NewSession session_;
  const hal::SourceInfo source_;
  std::unique_ptr<hal::FolderWriter> writer_;  // of the thread, and of save() when that has ended
  mutable std::mutex mutex_;                   // of all below
  std::condition_variable changed_;
  std::deque<Frame> queue_;
  std::unique_ptr<MotionRecording> motion_;
  bool anew_ = true;  // the next frame is the first
  Counts counts_;
  bool closed_ = false;    // no more frames
  bool given_up_ = false;  // those that wait are not written
  std::thread thread_;
};

}  // namespace im2fit::apps
