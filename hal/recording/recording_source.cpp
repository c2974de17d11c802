// SPDX-License-Identifier: Apache-2.0
#include "hal/recording/recording_source.h"

#include <utility>

namespace im2fit::hal {
namespace {

class RecordingSource final : public Source {
 public:
  RecordingSource(SourceInfo info, UprightPath path, std::unique_ptr<FrameReader> reader)
      : info_(std::move(info)), path_(std::move(path)), reader_(std::move(reader)) {}

  const SourceInfo& info() const override { return info_; }
  Status start() override {
    book_.reset();
    return reader_->rewind();
  }
  Result<FrameInfo> next(DepthImage depth, int /*timeout_ms*/) override {
    if (auto ok = path_.check(depth, info_.name); !ok) return ok.error();
    auto frame = reader_->next(path_.camera_image());
    if (!frame) {
      if (frame.error().code == ErrorCode::corrupt) book_.damaged();
      return frame;
    }
    path_.deliver(depth);
    if (frame->down) frame->down = rotate_upright(*frame->down, info_.rotate_deg);
    book_.saw(frame->sequence);
    return frame;
  }
  void stop() override {}
  SourceStats stats() const override { return book_.stats(); }

 private:
  SourceInfo info_;
  UprightPath path_;
  std::unique_ptr<FrameReader> reader_;
  SequenceBook book_;
};

}  // namespace

Result<std::unique_ptr<Source>> recording_source(const RecordingAbout& about, const RecordingOptions& options,
                                                 std::unique_ptr<FrameReader> reader) {
  SourceInfo info;
  info.uri = about.path;
  info.name = about.path;
  info.rotate_deg = options.rotate_deg.value_or(about.calibration.rotate_deg.value_or(0));
  auto path = UprightPath::make(about.calibration, info.rotate_deg, about.calibration_path);
  if (!path) return path.error();
  info.intrinsics = path->upright();
  info.intrinsics_origin = about.calibration.origin;
  info.sensor = about.sensor;
  info.frame_count = about.frame_count;
  return std::unique_ptr<Source>(new RecordingSource(std::move(info), std::move(*path), std::move(reader)));
}

}  // namespace im2fit::hal
