// SPDX-License-Identifier: Apache-2.0
#include "hal/source.h"

namespace im2fit::hal {
namespace {

constexpr std::uint64_t kDownEvery = 30;  // frames, about a second

}  // namespace

std::optional<Vec3f> down_of(const Source& source, const FrameInfo& frame) {
  if (frame.down || frame.sequence % kDownEvery != 0) return frame.down;
  return source.down();
}

}  // namespace im2fit::hal
