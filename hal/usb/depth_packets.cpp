// SPDX-License-Identifier: Apache-2.0
#include "hal/usb/depth_packets.h"

#include <cstring>

namespace im2fit::hal {
namespace {

using namespace kinect;

constexpr int kLateMax = 8;                           // USB does not reorder: a larger step back is a loss forward
constexpr std::uint32_t kFrameTicksMax = 60'000'000;  // a picture takes 1/30 s; a second apart is another one

std::uint32_t ticks_of(std::span<const std::uint8_t> header) {
  return static_cast<std::uint32_t>(header[8]) | static_cast<std::uint32_t>(header[9]) << 8 |
         static_cast<std::uint32_t>(header[10]) << 16 | static_cast<std::uint32_t>(header[11]) << 24;
}

std::size_t payload_bytes(int place) {
  return place == kPacketsPerFrame - 1 ? kLastPayloadBytes : kPacketPayloadBytes;
}

std::uint8_t flag_at(int place) {
  if (place == 0) return kStart;
  return place == kPacketsPerFrame - 1 ? kEnd : kMiddle;
}

}  // namespace

void DepthPackets::restart() {
  synchronised_ = false;
  in_frame_ = false;
}

void DepthPackets::begin(std::uint32_t ticks) {
  in_frame_ = true;
  intact_ = true;
  place_ = 0;
  crossed_ = 0;
  taken_ = 0;
  ticks_ = 0;
  first_ticks_ = ticks;
}

DepthPackets::Outcome DepthPackets::give_up(int frames) {
  in_frame_ = false;
  received_ = taken_;
  damaged_frames_ = frames;
  return Outcome::damaged;
}

// Some packets (the first, on some cameras) have time 0, which carries no information.
bool DepthPackets::same_picture(std::uint32_t ticks) {
  if (ticks == 0) return true;
  if (first_ticks_ == 0) first_ticks_ = ticks;
  return ticks - first_ticks_ <= kFrameTicksMax;
}

void DepthPackets::take(std::uint8_t flag, std::span<const std::uint8_t> payload, std::uint32_t ticks) {
  const bool fits = place_ < kPacketsPerFrame && payload.size() == payload_bytes(place_);
  if (!fits) ++stats_.wrong_size;
  if (!fits || flag != flag_at(place_) || !same_picture(ticks)) intact_ = false;
  if (intact_)
    std::memcpy(frame_ + static_cast<std::size_t>(place_) * kPacketPayloadBytes, payload.data(), payload.size());
  if (place_ < kPacketsPerFrame) ++place_;
  ++taken_;
  if (ticks != 0) ticks_ = ticks;
}

// The flag of an end fits at the last place alone: what is intact is complete.
DepthPackets::Outcome DepthPackets::finish() {
  if (!intact_) return give_up(1 + crossed_);
  in_frame_ = false;
  return Outcome::frame;
}

DepthPackets::Outcome DepthPackets::packet(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < kPacketHeaderBytes || bytes[0] != kReplyMagic[0] || bytes[1] != kReplyMagic[1]) {
    ++stats_.foreign;  // the packet it stands for will be missed by its number
    return Outcome::none;
  }
  const std::uint8_t flag = bytes[3];
  const std::uint8_t number = bytes[5];
  const std::uint32_t ticks = ticks_of(bytes);
  const auto payload = bytes.subspan(kPacketHeaderBytes);
  if (!synchronised_ && flag != kStart) return Outcome::none;  // joined in the middle of a picture
  const auto ahead = static_cast<std::uint8_t>(number - next_);
  if (synchronised_ && ahead >= 256 - kLateMax) {
    ++stats_.repeated;
    return Outcome::none;
  }
  const int lost = synchronised_ ? ahead : 0;
  synchronised_ = true;
  stats_.lost += static_cast<std::uint64_t>(lost);
  ++stats_.packets;
  next_ = static_cast<std::uint8_t>(number + 1);

  if (flag == kStart) {
    const bool cut_off = in_frame_;
    if (cut_off) give_up(1 + crossed_);
    begin(ticks);
    take(flag, payload, ticks);
    return cut_off ? Outcome::damaged : Outcome::none;
  }
  if (!in_frame_ || lost > 0) {
    if (!in_frame_) begin(ticks);  // its start is what was lost
    intact_ = false;
    place_ += lost;
    crossed_ += place_ / kPacketsPerFrame;
    place_ %= kPacketsPerFrame;
  }
  take(flag, payload, ticks);
  return flag == kEnd ? finish() : Outcome::none;
}

}  // namespace im2fit::hal
