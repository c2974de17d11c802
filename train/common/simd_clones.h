// SPDX-License-Identifier: Apache-2.0
// Loops over pixels and vertices that the vectoriser makes twice as fast with wider vectors: the compiler makes a
// copy for each instruction set and the loader takes the best. Nothing fuses (-ffp-contract=off) and nothing is
// reordered, so that all copies give the same bits. Workstation code: the device's kernels have tiers
// (kernels/tier.h).
#pragma once

#include "kernels/tier.h"

#if IM2FIT_HAVE_AVX2 && defined(__GLIBC__) && defined(__OPTIMIZE__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__) && !defined(__clang__)
#define IM2FIT_SIMD_CLONES __attribute__((target_clones("arch=x86-64-v4", "avx2", "default")))
#else
#define IM2FIT_SIMD_CLONES
#endif
