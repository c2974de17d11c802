// SPDX-License-Identifier: Apache-2.0
#include "engine/arms_memory.h"

#include <bit>

#include "engine/arms_limits.h"

namespace im2fit {

using namespace arms_limits;

namespace {

void count(ArmsMemory::Share& share, bool close) {
  ++share.said;
  share.close += close ? 1 : 0;
}

}  // namespace

ArmSet remember_arms(ArmsMemory& memory, GuidanceSet guidance, ArmSet close, int accumulated) {
  if (accumulated == 0) memory.capture = {};
  const bool says_close = has(guidance, Guidance::arms_close);
  if (!says_close && guidance != 0) return memory.held;
  constexpr std::uint32_t kRemembered = (1U << kWindow) - 1;
  for (std::size_t arm = 0; arm < kArmCount; ++arm) {
    const ArmSet bit = 1U << arm;
    std::uint32_t& history = memory.history[arm];
    // A code that names no arm is about both.
    const bool named = says_close && (close == 0 || (close & bit) != 0);
    history = (history << 1 | (named ? 1U : 0U)) & kRemembered;
    const int frames = std::popcount(history);
    if (frames >= kHeldFrom) memory.held |= bit;
    if (frames <= kHeldUntil) memory.held &= ~bit;
  }
  const bool counts_as_close = says_close || memory.held != 0;
  count(memory.session, counts_as_close);
  count(memory.capture, counts_as_close);
  return (says_close ? close : 0) | memory.held;
}

bool mostly_close(const ArmsMemory::Share& share) {
  return share.close * kCaptureShare > share.said;
}

}  // namespace im2fit
