// SPDX-License-Identifier: Apache-2.0
// Assembles a Kinect's depth packets to whole packed pictures and detects damaged ones.
#pragma once

#include <cstdint>
#include <span>

#include "hal/usb/kinect_protocol.h"

namespace im2fit::hal {

struct PacketStats {
  std::uint64_t packets = 0;     // taken, in their turn
  std::uint64_t lost = 0;        // numbers skipped
  std::uint64_t repeated = 0;    // seen again or too late: left alone
  std::uint64_t foreign = 0;     // no header of this stream
  std::uint64_t wrong_size = 0;  // payload size does not fit its place in the picture
};

// A picture counts only when every one of its packets came, in its turn, with its flag and its size. Numbers have 8
// bits and a picture 242 packets, so a loss of a multiple of 256 packets looks like none: then start and end flags
// come at the wrong place, and where even those fit again (128 pictures, 4.3 s) the time in the headers has jumped.
// Nothing allocates.
class DepthPackets {
 public:
  enum class Outcome { none, frame, damaged };

  // Where the picture being received goes, kinect::kFrameBytes of it. Needed before the first packet and after every
  // Outcome::frame; kept otherwise.
  void fill(std::uint8_t* frame) { frame_ = frame; }
  // Resets the state of the stream; the counters are kept.
  void restart();
  // `frame`: the buffer holds a picture and ticks() is its time. `damaged`: damaged_frames() pictures are lost.
  Outcome packet(std::span<const std::uint8_t> bytes);

  std::uint32_t ticks() const { return ticks_; }
  int damaged_frames() const { return damaged_frames_; }
  // Of the last damaged picture: how many of its packets were taken.
  int packets_received() const { return received_; }
  const PacketStats& stats() const { return stats_; }

 private:
  void begin(std::uint32_t ticks);
  void take(std::uint8_t flag, std::span<const std::uint8_t> payload, std::uint32_t ticks);
  Outcome give_up(int frames);
  Outcome finish();
  bool same_picture(std::uint32_t ticks);

  std::uint8_t* frame_ = nullptr;
  bool synchronised_ = false;  // a start has been seen
  bool in_frame_ = false;
  bool intact_ = false;
  std::uint8_t next_ = 0;  // the number expected
  int place_ = 0;          // of the next packet in its picture
  int crossed_ = 0;        // pictures' borders inside of gaps since the last outcome
  int received_ = 0;
  int taken_ = 0;
  std::uint32_t ticks_ = 0;
  std::uint32_t first_ticks_ = 0;  // the picture's first that is not 0
  int damaged_frames_ = 0;
  PacketStats stats_;
};

}  // namespace im2fit::hal
