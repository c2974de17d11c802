// SPDX-License-Identifier: Apache-2.0
#include "synth/clones.h"
#include "synth/raw_row_loop.h"

namespace im2fit::synth {

IM2FIT_CLONES void raw_row_avx2(const RawRow& row, int count, std::int32_t* out) {
  raw_row_loop(row, count, out);
}

}  // namespace im2fit::synth
