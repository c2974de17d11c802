// SPDX-License-Identifier: Apache-2.0
#include "body/fit/rows_loop.h"

namespace im2fit::body {

const FitLoops kFitLoopsAvx2 = {sum_rows_loop<Eight>, add_slopes_loop, add_shapes_loop, take_pivots_loop};

}  // namespace im2fit::body
