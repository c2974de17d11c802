// SPDX-License-Identifier: Apache-2.0
// From the packets of a running Kinect to numbered frames.
#pragma once

#include <cstdint>
#include <mutex>

#include "hal/usb/depth_packets.h"
#include "hal/usb/frame_exchange.h"
#include "hal/usb/usb_transport.h"

namespace im2fit::hal {

// packet() and ended() come from the transport's thread, the rest from the one that reads frames.
class KinectReceiver final : public UsbPacketSink {
 public:
  KinectReceiver() : exchange_(kinect::kFrameBytes) {}

  void reset();  // while nothing streams
  void packet(std::span<const std::uint8_t> bytes) override;
  void ended(const Error& why) override;

  FrameExchange& exchange() { return exchange_; }
  const FrameExchange& exchange() const { return exchange_; }
  // Frames of which not one packet is known, by the camera's clock.
  std::uint64_t missed() const;
  PacketStats packet_stats() const;  // as of the last frame that ended

 private:
  void frame_ended(std::uint32_t ticks);

  DepthPackets packets_;
  FrameExchange exchange_;
  std::uint64_t number_ = 0;  // of the next frame: damaged and missed ones have theirs
  bool has_ticks_ = false;
  std::uint32_t last_ticks_ = 0;
  std::uint64_t ticks_ = 0;          // without the wrap of the camera's 32 bits, 71.6 s
  std::uint64_t damaged_since_ = 0;  // after the last good frame
  mutable std::mutex mutex_;         // of what follows
  std::uint64_t missed_ = 0;
  PacketStats packet_stats_;
};

}  // namespace im2fit::hal
