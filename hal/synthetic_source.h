// SPDX-License-Identifier: Apache-2.0
// Frames made by a function: the virtual camera, wrapped by code that may depend on the lab.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "hal/frame_path.h"

namespace im2fit::hal {

class SyntheticSource final : public Source {
 public:
  // Fills frame `index` (0, 1, ...) as the camera delivers it, before rotation; false when there are no more.
  using Generator = std::function<bool(std::uint64_t index, DepthImage out)>;
  // Where the camera was for it, as delivered.
  using Poser = std::function<std::optional<CameraPose>(std::uint64_t index)>;
  static constexpr int kFps = 30;

  // `info`: uri, name, serial, rotate_deg, live, frame_count. Its intrinsics are computed from `camera` and its
  // origin becomes synthetic. A live source keeps to 30 frames a second and, when the reader is late, skips frames as
  // a camera would; others make frames as fast as they are read.
  static Result<std::unique_ptr<SyntheticSource>> create(const Intrinsics& camera, SourceInfo info,
                                                         Generator generator, Poser poser = {});

  const SourceInfo& info() const override { return info_; }
  Status start() override;
  Result<FrameInfo> next(DepthImage depth, int timeout_ms) override;
  void stop() override {}
  SourceStats stats() const override { return book_.stats(); }

 private:
  SyntheticSource(const Intrinsics& camera, SourceInfo info, Generator generator, Poser poser);
  SourceInfo info_;
  UprightPath path_;
  Generator generator_;
  Poser poser_;
  std::uint64_t index_ = 0;
  std::int64_t started_ns_ = 0;
  SequenceBook book_;
};

}  // namespace im2fit::hal
