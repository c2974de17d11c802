// SPDX-License-Identifier: Apache-2.0
#include "hal/usb/kinect_receiver.h"

#include "hal/frame_path.h"

namespace im2fit::hal {
namespace {

constexpr std::uint32_t kTicksPerFrame = 1'000'000 / kinect::kFps * kinect::kTicksPerUs;
// A longer frame gap is a clock that was set anew, not frames that were missed.
constexpr std::uint32_t kFrameGapMax_ticks = 20U * 1'000'000U * kinect::kTicksPerUs;

}  // namespace

void KinectReceiver::reset() {
  exchange_.reset();
  packets_.restart();
  packets_.fill(exchange_.filling());
  number_ = 0;
  has_ticks_ = false;
  ticks_ = 0;
  damaged_since_ = 0;
  const std::lock_guard lock(mutex_);
  missed_ = 0;
}

void KinectReceiver::frame_ended(std::uint32_t ticks) {
  if (!has_ticks_) {
    ticks_ = ticks;
  } else {
    const std::uint32_t step = ticks - last_ticks_;
    ticks_ += step;
    const std::uint64_t frames = (std::uint64_t{step} + kTicksPerFrame / 2) / kTicksPerFrame;
    if (step <= kFrameGapMax_ticks && frames > 1 + damaged_since_) {
      const std::uint64_t missed = frames - 1 - damaged_since_;
      number_ += missed;
      const std::lock_guard lock(mutex_);
      missed_ += missed;
    }
  }
  has_ticks_ = true;
  last_ticks_ = ticks;
  damaged_since_ = 0;
}

void KinectReceiver::packet(std::span<const std::uint8_t> bytes) {
  const auto outcome = packets_.packet(bytes);
  if (outcome == DepthPackets::Outcome::none) return;
  FrameExchange::Entry entry;
  entry.host_ns = monotonic_ns();
  if (outcome == DepthPackets::Outcome::frame) {
    frame_ended(packets_.ticks());
    entry.number = number_++;
    entry.device_us = static_cast<std::int64_t>(ticks_ / kinect::kTicksPerUs);
    exchange_.publish(entry);
    packets_.fill(exchange_.filling());
  } else {
    entry.packets_received = packets_.packets_received();
    for (int i = 0; i < packets_.damaged_frames(); ++i) {
      entry.number = number_++;
      ++damaged_since_;
      exchange_.publish_damaged(entry);
    }
  }
  const std::lock_guard lock(mutex_);
  packet_stats_ = packets_.stats();
}

void KinectReceiver::ended(const Error& why) {
  exchange_.end(why);
}

std::uint64_t KinectReceiver::missed() const {
  const std::lock_guard lock(mutex_);
  return missed_;
}

PacketStats KinectReceiver::packet_stats() const {
  const std::lock_guard lock(mutex_);
  return packet_stats_;
}

}  // namespace im2fit::hal
