// SPDX-License-Identifier: Apache-2.0
#include "apps/kiosk/visit_recorder.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "body/export/motion.h"

namespace im2fit::apps {

VisitRecorder::VisitRecorder(sessions::NewSession session, const hal::SourceInfo& source)
    : session_(std::move(session)), source_(source), motion_(std::make_unique<MotionRecording>()) {}

Result<std::unique_ptr<VisitRecorder>> VisitRecorder::begin(const std::string& root, const hal::SourceInfo& source) {
  auto session = sessions::NewSession::begin(root);
  if (!session) return session.error();
  std::unique_ptr<VisitRecorder> recorder(new VisitRecorder(std::move(*session), source));
  recorder->thread_ = std::thread([r = recorder.get()] { r->write_all(); });
  return recorder;
}

VisitRecorder::~VisitRecorder() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = given_up_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void VisitRecorder::begin_anew() {
  {
    const std::lock_guard lock(mutex_);
    if (closed_ || !counts_.error.empty()) return;
    anew_ = true;
    motion_ = std::make_unique<MotionRecording>();
    queue_.clear();
    counts_ = {};
  }
  changed_.notify_all();
}

void VisitRecorder::see(const FrameSeen& frame) {
  std::unique_lock lock(mutex_);
  if (closed_ || !counts_.error.empty() || counts_.full) return;
  if (!source_.live)
    changed_.wait(lock, [&] { return queue_.size() < kQueueMax || closed_ || !counts_.error.empty(); });
  if (closed_ || !counts_.error.empty()) return;
  if (queue_.size() >= kQueueMax) {
    ++counts_.dropped;
    return;
  }
  Frame kept;
  kept.first = std::exchange(anew_, false);
  kept.info = frame.info;
  const auto width = static_cast<std::size_t>(frame.depth.width);
  kept.pixels.resize(width * static_cast<std::size_t>(frame.depth.height));
  for (int v = 0; v < frame.depth.height; ++v)
    std::copy_n(frame.depth.row(v), width, kept.pixels.data() + static_cast<std::size_t>(v) * width);
  queue_.push_back(std::move(kept));
  motion_->see(frame);
  counts_.full = ++counts_.frames >= kFramesMax;
  lock.unlock();
  changed_.notify_all();
}

void VisitRecorder::measured() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
  }
  changed_.notify_all();
}

VisitRecorder::Counts VisitRecorder::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

Status VisitRecorder::begin_folder() {
  writer_.reset();
  const std::string folder = session_.path(sessions::kRecordingFolder);
  std::error_code code;
  std::filesystem::remove_all(folder, code);
  if (code) return Error{ErrorCode::io, "cannot delete " + folder + ": " + code.message()};
  hal::FolderWriter::Options options;
  options.camera_name = source_.name;
  options.origin = source_.intrinsics_origin;
  auto writer = hal::FolderWriter::create(folder, source_.intrinsics, options);
  if (!writer) return writer.error();
  writer_ = std::move(*writer);
  return Ok{};
}

Status VisitRecorder::write(const Frame& frame) {
  if (frame.first || !writer_)
    if (auto begun = begin_folder(); !begun) return begun;
  const Intrinsics& k = source_.intrinsics;
  return writer_->write(DepthView(frame.pixels.data(), k.width, k.height), frame.info);
}

void VisitRecorder::write_all() {
  for (;;) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return closed_ || !queue_.empty(); });
    if (given_up_ || queue_.empty()) return;
    const Frame frame = std::move(queue_.front());
    queue_.pop_front();
    lock.unlock();
    changed_.notify_all();
    if (auto written = write(frame); !written) {
      lock.lock();
      counts_.error = written.error().message;
      queue_.clear();
      lock.unlock();
      changed_.notify_all();
      return;
    }
  }
}

Result<std::string> VisitRecorder::save(const sessions::Record& record, const std::string& result_json) {
  measured();
  if (thread_.joinable()) thread_.join();
  if (const std::string error = counts().error; !error.empty()) return Error{ErrorCode::io, error};
  if (!writer_) return Error{ErrorCode::not_found, "no frame was recorded"};
  if (auto finished = writer_->finish(); !finished) return finished.error();
  if (auto written = session_.write(sessions::kResultFile, result_json); !written) return written.error();
  if (auto written = motion_->write(session_.path(sessions::kJointsFile), {}); !written) return written.error();
  if (auto finished = session_.finish(record); !finished) return finished.error();
  return session_.id();
}

}  // namespace im2fit::apps
