// SPDX-License-Identifier: Apache-2.0
#include "body/fit/rows_loop.h"

namespace im2fit::body {
namespace {

#ifdef __arm__  // has no vectors of IEEE numbers: lanes of no use would cost what others do
using Native = float;
#else
using Native = Four;
#endif

}  // namespace

const FitLoops kFitLoopsPortable = {sum_rows_loop<Native>, add_slopes_loop, add_shapes_loop, take_pivots_loop};

const FitLoops& fit_loops() {
#if IM2FIT_HAVE_AVX2
  if (tier_available(Tier::avx2)) return kFitLoopsAvx2;
#endif
  return kFitLoopsPortable;
}

}  // namespace im2fit::body
