// SPDX-License-Identifier: Apache-2.0
// Tiers of a kernel. A kernel's kernels.inc has one row per variant; dispatch, test and bench all include it, so that
// a variant cannot exist untested.
#pragma once

namespace im2fit {

// Later is faster. `ref` is never chosen by dispatch: it is written to be read.
enum class Tier { ref, portable, neon, avx2 };

// Whether this build and this machine can run the tier.
constexpr bool tier_available(Tier tier) {
  return tier == Tier::ref || tier == Tier::portable;
}

}  // namespace im2fit
