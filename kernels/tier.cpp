// SPDX-License-Identifier: Apache-2.0
#include "kernels/tier.h"

#if IM2FIT_TIER_AT_RUN_TIME

#include <cstdlib>
#include <cstring>

namespace im2fit {
namespace {

bool processor_has([[maybe_unused]] Tier tier) {
#if IM2FIT_HAVE_AVX2
  if (tier == Tier::avx2) return __builtin_cpu_supports("avx2") != 0;
#endif
  return tier == Tier::neon && IM2FIT_HAVE_NEON;
}

// IM2FIT_DISABLE_TIERS names the tier, between commas.
bool disabled([[maybe_unused]] const char* name) {
#ifdef IM2FIT_TIER_SWITCH
  const char* at = std::getenv("IM2FIT_DISABLE_TIERS");
  for (const std::size_t length = std::strlen(name); at != nullptr && *at != '\0';) {
    const std::size_t word = std::strcspn(at, ",");
    if (word == length && std::strncmp(at, name, length) == 0) return true;
    at += word + (at[word] == ',' ? 1 : 0);
  }
#endif
  return false;
}

}  // namespace

bool tier_available(Tier tier) {
  switch (tier) {
    case Tier::ref:
    case Tier::portable:
      return true;
    case Tier::neon:
      return processor_has(tier) && !disabled("neon");
    case Tier::avx2:
      return processor_has(tier) && !disabled("avx2");
  }
  return false;
}

}  // namespace im2fit

#endif
