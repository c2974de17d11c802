// SPDX-License-Identifier: Apache-2.0
// Every frame the engine will ever hold, made at start. Rings carry indices into it; the holder of an index owns that
// slot until it passes the index on.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "core/camera.h"
#include "core/lazy_zeros.h"
#include "hal/source.h"
#include "perception/observe/observe.h"

namespace im2fit {

// What the producer has counted up to and including a frame; travels with it so that results need no second channel.
struct ArrivalCounts {
  std::uint64_t dropped = 0;           // frames given up because the engine was behind (live only)
  std::uint64_t sequence_gaps = 0;     // sequence numbers skipped
  std::uint64_t sequence_repeats = 0;  // frames whose sequence number did not grow
  std::uint64_t time_reversals = 0;    // frames whose host time did not grow
};

struct FrameSlot {
  DepthImage depth;
  MaskImage mask;
  hal::FrameInfo info;
  ArrivalCounts counts;
  float seconds = 0;             // since the frame before that FIT processed
  int periods = 1;               // the same in periods of kFramePeriodS, as limits are counted
  bool after_frame_gap = false;  // more than kFrameGapSecondsMax: the person seen now may be another
  Detection detection;
  bool sensed = false;  // false: passed through unread because the session is over
  bool passed = false;  // at rest (engine/rest.h): counted only
  // Whether the session waited for the measured person to leave, after FIT was done with the frame that had this slot
  // before. Slots come round in order, so unless frames are dropped that is the frame pool_frames before, on one
  // thread and on two.
  bool leaving = false;
};

class FramePool {
 public:
  FramePool(int slot_count, int width, int height)
      : depth_(pixels(width, height) * static_cast<std::size_t>(slot_count)),
        mask_(pixels(width, height) * static_cast<std::size_t>(slot_count)),
        slots_(static_cast<std::size_t>(slot_count)) {
    for (std::size_t i = 0; i < slots_.size(); ++i) {
      slots_[i].depth = DepthImage(depth_.data() + i * pixels(width, height), width, height);
      slots_[i].mask = MaskImage(mask_.data() + i * pixels(width, height), width, height);
    }
  }
  FramePool(const FramePool&) = delete;
  FramePool& operator=(const FramePool&) = delete;

  FrameSlot& operator[](std::uint32_t index) { return slots_[index]; }
  std::uint32_t slot_count() const { return static_cast<std::uint32_t>(slots_.size()); }

 private:
  static std::size_t pixels(int width, int height) {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }
  LazyZeros<std::uint16_t> depth_;
  LazyZeros<std::uint8_t> mask_;
  std::vector<FrameSlot> slots_;
};

// `from` has the size of `to`; strides may differ.
inline void copy_depth(DepthView from, DepthImage to) {
  for (int v = 0; v < to.height; ++v)
    std::memcpy(to.row(v), from.row(v), static_cast<std::size_t>(to.width) * sizeof(std::uint16_t));
}

}  // namespace im2fit
