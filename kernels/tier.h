// SPDX-License-Identifier: Apache-2.0
// Tiers of a kernel, and which one runs.
//
// A kernel's header has its table of variants, slowest first. Dispatch, tests and benchmarks all walk that table, so
// that a variant cannot exist untested. Tests and benchmarks put the kernel's reference before it
// (tests/kernels/ref).
//
// Which variant runs: on a target whose instruction set is fixed when it is compiled (ARM with NEON; x86-64 built for
// AVX2) and in every build without IM2FIT_TIER_SWITCH the choice is a constant and the call direct. Plain x86-64
// queries the processor, once. Test builds (IM2FIT_TIER_SWITCH) obey the environment: IM2FIT_DISABLE_TIERS=avx2,neon.
#pragma once

#include <cstddef>

#if defined(__x86_64__) && !defined(IM2FIT_PORTABLE_ONLY)
#define IM2FIT_HAVE_AVX2 1
#else
#define IM2FIT_HAVE_AVX2 0
#endif
#if defined(__ARM_NEON) && !defined(IM2FIT_PORTABLE_ONLY)
#define IM2FIT_HAVE_NEON 1
#else
#define IM2FIT_HAVE_NEON 0
#endif

// Rows of a table: IM2FIT_NEON(contour) is the function contour_neon where this build has it, and otherwise nothing.
#define IM2FIT_KERNEL(kernel, tier) {#tier, kernel##_##tier, ::im2fit::Tier::tier},
#define IM2FIT_PORTABLE(kernel) IM2FIT_KERNEL(kernel, portable)
#if IM2FIT_HAVE_NEON
#define IM2FIT_NEON(kernel) IM2FIT_KERNEL(kernel, neon)
#else
#define IM2FIT_NEON(kernel)
#endif
#if IM2FIT_HAVE_NEON && defined(__aarch64__)
#define IM2FIT_NEON64(kernel) IM2FIT_KERNEL(kernel, neon)  // not on ARMv7
#else
#define IM2FIT_NEON64(kernel)
#endif
#if IM2FIT_HAVE_AVX2
#define IM2FIT_AVX2(kernel) IM2FIT_KERNEL(kernel, avx2)
#else
#define IM2FIT_AVX2(kernel)
#endif

// Declares a variant chosen by dispatch: `IM2FIT_CHOSEN_ONCE best = fastest(kContourKernels);`
#if defined(IM2FIT_TIER_SWITCH) || (IM2FIT_HAVE_AVX2 && !defined(__AVX2__))
#define IM2FIT_TIER_AT_RUN_TIME 1
#define IM2FIT_CHOSEN_ONCE static const auto
#else
#define IM2FIT_TIER_AT_RUN_TIME 0
#define IM2FIT_CHOSEN_ONCE static constexpr auto
#endif

namespace im2fit {

// `ref` is a reference that tests and benchmarks add to a table. `neon` serves AArch64 and ARMv7.
enum class Tier { ref, portable, neon, avx2 };

// Whether this build on this machine can run the tier and it is not disabled. ref and portable always can.
#if IM2FIT_TIER_AT_RUN_TIME
bool tier_available(Tier tier);
#else
constexpr bool tier_available(Tier tier) {
  return tier == Tier::ref || tier == Tier::portable || (tier == Tier::neon && IM2FIT_HAVE_NEON) ||
         (tier == Tier::avx2 && IM2FIT_HAVE_AVX2);
}
#endif

template <class Function>
struct KernelVariant {
  const char* name;  // the tier's
  Function* function;
  Tier tier;
};

// The last variant that can run here. Tables begin with portable, which always can.
template <class Function, std::size_t kCount>
constexpr Function* fastest(const KernelVariant<Function> (&variants)[kCount]) {
  Function* best = variants[0].function;
  for (const auto& variant : variants) {
    if (tier_available(variant.tier)) best = variant.function;
  }
  return best;
}

}  // namespace im2fit
