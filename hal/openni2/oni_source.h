// SPDX-License-Identifier: Apache-2.0
// A .oni recording, read in a child process with a watchdog: damaged ones crash the OpenNI2 runtime, hang it, or give
// silently wrong pixels (facts of libopenni2 2.2.0.33). The first two become one clear error here.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/frame_path.h"
#include "hal/openni2/child_process.h"
#include "hal/openni2/oni_protocol.h"

namespace im2fit::hal {

struct OniOptions {
  int rotate_deg = 0;
  int stall_ms = 5000;                           // a child silent for so long is ended
  std::optional<Calibration> calibration;        // replaces the recorded field of view; its rotate_deg is ignored
  std::function<Result<ChildProcess>()> reader;  // instead of a process of ours: for tests
  std::string reader_path;                       // im2fit-oni-reader; "": IM2FIT_ONI_READER, else beside the program
};

class OniSource final : public Source {
 public:
  // Errors: not_found, io, corrupt (no recording the runtime accepts, or one it crashes on), invalid_argument.
  static Result<std::unique_ptr<OniSource>> open(const std::string& path, const OniOptions& options);

  const SourceInfo& info() const override { return info_; }
  Status start() override;  // from the first frame, each time
  // Errors, besides those of Source: io once the recording turns out damaged (crash, stall or nonsense): no frame
  // follows. A recording that was never closed gives its frames, then `corrupt` once, then end_of_stream.
  Result<FrameInfo> next(DepthImage depth, int timeout_ms) override;
  void stop() override;
  SourceStats stats() const override { return book_.stats(); }
  pid_t child_pid() const { return child_.pid(); }

 private:
  OniSource() = default;
  Status launch();
  Status describe(const oni::Hello& hello);
  // Receives one whole message into message_. Errors: the reason why none came.
  Result<oni::Header> receive(int timeout_ms);
  Result<FrameInfo> accept_frame(DepthImage depth);
  Error cannot_be_played(const oni::Header& failure);  // in the reader's own words
  Error give_up(const std::string& why);               // ends the child; every later call fails the same

  SourceInfo info_;
  OniOptions options_;
  std::string path_text_;
  UprightPath path_;
  ChildProcess child_;
  std::vector<std::byte> message_;
  std::size_t have_ = 0;  // bytes of the message that have arrived
  int silent_ms_ = 0;     // spent waiting since the last byte
  std::uint64_t frames_ = 0;
  bool fresh_ = false;  // launched and nothing read but the hello
  std::optional<Error> final_;
  SequenceBook book_;
};

}  // namespace im2fit::hal
