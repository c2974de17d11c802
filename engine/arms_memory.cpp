// SPDX-License-Identifier: Apache-2.0
#include "engine/arms_memory.h"

#include <bit>

// The thresholds of this file: how long arms that touched the trunk are remembered. Sources:
//   [real]  330 starts of eight real people with hanging arms, each held for 45 frames, 0 to 2 px eroded: all of the
//           14,039 frames in which they are found are close; of 3,455 frames of the recordings played, arms moving,
//           3,419 are
//   [eval]  100 people of im2fit-lab eval, arms 12 to 25 degrees off the body, 30 frames each: 95 are never close,
//           four in 1 to 4 frames, one, whose arm does touch, in 27
namespace im2fit::arms_limits {

// Remembered frames with evidence about the arms: a quarter of a second. A longer window delays people who lift their
// arms; a shorter one accepts flickering sleeves.
constexpr int kWindow = 8;
// Close frames among these: from so many on ARMS_CLOSE is held, ...
constexpr int kHeldFrom = 4;  // [real]: 8 of 8; [eval]: 2 at most where the arms are apart
// ... until so few are left.
constexpr int kHeldUntil = 1;
// A capture is measured when at least one of so many of its frames is free of ARMS_CLOSE.
constexpr int kCaptureShare = 2;

}  // namespace im2fit::arms_limits

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
