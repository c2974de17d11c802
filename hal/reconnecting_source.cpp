// SPDX-License-Identifier: Apache-2.0
#include "hal/reconnecting_source.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <thread>
#include <utility>

#include "hal/frame_path.h"

namespace im2fit::hal {
namespace {

constexpr std::int64_t kNsPerMs = 1'000'000;
constexpr std::int64_t kFrameNs = 33'333'333;  // put between two frames whose clock stepped back

std::string describe(const SourceInfo& info) {
  return info.name + " (" + (info.serial.empty() ? info.uri : "serial " + info.serial) + ")";
}

bool same(const Intrinsics& a, const Intrinsics& b) {
  return a.width == b.width && a.height == b.height && a.fx == b.fx && a.fy == b.fy && a.cx == b.cx && a.cy == b.cy;
}

}  // namespace

RetryClock system_retry_clock() {
  return {monotonic_ns, [](std::int64_t ns) { std::this_thread::sleep_for(std::chrono::nanoseconds(ns)); }};
}

Result<std::unique_ptr<ReconnectingSource>> ReconnectingSource::open(Opener open, ReconnectOptions options) {
  std::unique_ptr<ReconnectingSource> made(new ReconnectingSource(std::move(open), std::move(options)));
  auto source = made->open_(nullptr);
  if (!source) return source.error();
  made->source_ = std::move(*source);
  made->info_ = made->source_->info();
  return made;
}

ReconnectingSource::ReconnectingSource(Opener open, ReconnectOptions options)
    : open_(std::move(open)), options_(std::move(options)) {
  options_.wait_first_ms = std::max(1, options_.wait_first_ms);
  options_.wait_max_ms = std::max(options_.wait_first_ms, options_.wait_max_ms);
}

Status ReconnectingSource::start() {
  if (started_) return Ok{};
  if (source_ != nullptr) {
    auto begun = source_->start();
    if (!begun && begun.error().code != ErrorCode::no_device) return begun;
    heard_ns_ = options_.clock.now_ns();
    if (!begun) lose(begun.error().message);
  } else {  // lost before stop(): the patience begins anew
    about_.presence = Presence::lost;
    lost_since_ns_ = attempt_ns_ = options_.clock.now_ns();
    wait_ms_ = options_.wait_first_ms;
  }
  started_ = true;
  fresh_ = true;
  last_.reset();
  sequence_shift_ = 0;
  host_shift_ns_ = device_shift_us_ = 0;
  closed_stats_ = {};
  return Ok{};
}

Result<FrameInfo> ReconnectingSource::next(DepthImage depth, int timeout_ms) {
  if (!started_) return Error{ErrorCode::invalid_argument, info_.name + " is not started; call start() first"};
  const std::int64_t deadline_ns = options_.clock.now_ns() + kNsPerMs * std::max(0, timeout_ms);
  for (;;) {
    if (about_.presence == Presence::given_up) return give_up();
    const std::int64_t now_ns = options_.clock.now_ns();
    if (source_ != nullptr) {
      if (auto answer = try_next(depth, std::max<std::int64_t>(0, deadline_ns - now_ns))) return *std::move(answer);
      continue;
    }
    const std::int64_t patience_ns = options_.give_up_ms < 0 ? std::numeric_limits<std::int64_t>::max()
                                                             : lost_since_ns_ + kNsPerMs * options_.give_up_ms;
    if (now_ns >= patience_ns) return give_up();
    if (now_ns >= attempt_ns_) {
      attempt();
      continue;
    }
    if (now_ns >= deadline_ns)
      return Error{ErrorCode::timeout,
                   describe(info_) + " is away; no frame within " + std::to_string(timeout_ms) + " ms"};
    options_.clock.sleep_for(std::min({attempt_ns_, deadline_ns, patience_ns}) - now_ns);
  }
}

// None: call again, or the camera is lost now.
std::optional<Result<FrameInfo>> ReconnectingSource::try_next(DepthImage depth, std::int64_t left_ns) {
  auto frame = source_->next(depth, static_cast<int>(left_ns / kNsPerMs));
  if (frame) return Result<FrameInfo>(accept(*frame));
  const ErrorCode code = frame.error().code;
  const std::int64_t now_ns = options_.clock.now_ns();
  if (code == ErrorCode::no_device || (code == ErrorCode::io && ++io_errors_ >= options_.io_errors_max)) {
    lose(frame.error().message);
    return std::nullopt;
  }
  if (code == ErrorCode::io && left_ns > 0) {  // it may come back at once: no spinning
    options_.clock.sleep_for(std::min(left_ns, kNsPerMs * options_.wait_first_ms));
    return std::nullopt;
  }
  if (code == ErrorCode::timeout && now_ns - heard_ns_ >= kNsPerMs * options_.frame_gap_ms) {
    lose(info_.name + " delivered no frame for " + std::to_string(options_.frame_gap_ms) + " ms");
    return std::nullopt;
  }
  if (code == ErrorCode::io) return Result<FrameInfo>(Error{ErrorCode::timeout, frame.error().message});
  if (code == ErrorCode::corrupt) heard_ns_ = now_ns;
  return frame;
}

FrameInfo ReconnectingSource::accept(const FrameInfo& frame) {
  FrameInfo out = frame;
  if (fresh_ && last_) {
    sequence_shift_ = last_->sequence + 2 - frame.sequence;
    host_shift_ns_ = frame.host_ns > last_->host_ns ? 0 : last_->host_ns + kFrameNs - frame.host_ns;
    const std::int64_t passed_us = (frame.host_ns + host_shift_ns_ - last_->host_ns) / 1000;
    device_shift_us_ =
        frame.device_us >= 0 && last_->device_us >= 0 ? last_->device_us + passed_us - frame.device_us : 0;
  }
  out.sequence += sequence_shift_;
  out.host_ns += host_shift_ns_;
  if (out.device_us >= 0) out.device_us += device_shift_us_;
  last_ = out;
  fresh_ = false;
  io_errors_ = 0;
  heard_ns_ = options_.clock.now_ns();
  if (about_.presence == Presence::lost) {
    about_.presence = Presence::present;
    about_.lost_ns = heard_ns_ - lost_since_ns_;
    ++about_.recovered;
    ++closed_stats_.gaps;
    notify();
  }
  return out;
}

void ReconnectingSource::close() {
  if (source_ == nullptr) return;
  const SourceStats was = source_->stats();
  closed_stats_.delivered += was.delivered;
  closed_stats_.gaps += was.gaps;
  closed_stats_.repeats += was.repeats;
  closed_stats_.damaged += was.damaged;
  source_.reset();
}

// Also when a reopened camera never delivered its first frame: then the loss continues, with its growing pauses.
void ReconnectingSource::lose(const std::string& why) {
  close();
  fresh_ = true;
  io_errors_ = 0;
  about_.last_error = why;
  const std::int64_t now_ns = options_.clock.now_ns();
  if (about_.presence != Presence::lost) {
    about_.presence = Presence::lost;
    ++about_.lost;
    lost_since_ns_ = now_ns;
    wait_ms_ = options_.wait_first_ms;
    about_.lost_ns = 0;
    notify();
  }
  attempt_ns_ = now_ns + kNsPerMs * wait_ms_;
}

std::optional<Error> ReconnectingSource::objection(const Source& candidate) const {
  const SourceInfo& other = candidate.info();
  const bool known = !info_.serial.empty();
  if (known ? other.serial != info_.serial : other.uri != info_.uri)
    return Error{ErrorCode::no_device, describe(other) + " is another camera than the one that went away, " +
                                           describe(info_) + "; plug that one in, or start again"};
  if (!same(other.intrinsics, info_.intrinsics) || other.rotate_deg != info_.rotate_deg)
    return Error{ErrorCode::unsupported,
                 describe(info_) + " came back with other pictures than before (" +
                     std::to_string(other.intrinsics.width) + "x" + std::to_string(other.intrinsics.height) +
                     ", before " + std::to_string(info_.intrinsics.width) + "x" +
                     std::to_string(info_.intrinsics.height) + ", or another calibration)" + "; start again"};
  return std::nullopt;
}

void ReconnectingSource::attempt() {
  ++about_.attempts;
  wait_ms_ = std::min(2 * wait_ms_, options_.wait_max_ms);
  auto opened = open_(&info_);
  std::optional<Error> wrong;
  if (opened) wrong = objection(**opened);
  const bool refused = wrong.has_value();
  if (!opened) wrong = opened.error();
  if (!wrong) {
    if (auto begun = (*opened)->start(); !begun) wrong = begun.error();
  }
  const std::int64_t now_ns = options_.clock.now_ns();
  if (!wrong) {
    source_ = std::move(*opened);
    heard_ns_ = now_ns;
    return;
  }
  attempt_ns_ = now_ns + kNsPerMs * wait_ms_;
  const bool news = refused && about_.last_error != wrong->message;
  about_.refused += refused ? 1 : 0;
  about_.last_error = wrong->message;
  about_.lost_ns = now_ns - lost_since_ns_;
  if (news) notify();
}

Error ReconnectingSource::give_up() {
  if (about_.presence != Presence::given_up) {
    about_.presence = Presence::given_up;
    about_.lost_ns = options_.clock.now_ns() - lost_since_ns_;
    notify();
  }
  return {ErrorCode::no_device, describe(info_) + " went away and did not come back within " +
                                    std::to_string(options_.give_up_ms / 1000) + " s (" + about_.last_error +
                                    "); plug it in and start again"};
}

void ReconnectingSource::stop() {
  if (source_ != nullptr) source_->stop();
  started_ = false;
}

SourceStats ReconnectingSource::stats() const {
  SourceStats sum = closed_stats_;
  if (source_ == nullptr) return sum;
  const SourceStats now = source_->stats();
  sum.delivered += now.delivered;
  sum.gaps += now.gaps;
  sum.repeats += now.repeats;
  sum.damaged += now.damaged;
  return sum;
}

std::optional<Vec3f> ReconnectingSource::down() const {
  return source_ != nullptr ? source_->down() : std::nullopt;
}

void ReconnectingSource::notify() const {
  if (options_.changed) options_.changed(about_);
}

}  // namespace im2fit::hal
