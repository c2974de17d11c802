// SPDX-License-Identifier: Apache-2.0
#include "train/common/simd_clones.h"
#include "train/render/raw_row_loop.h"

namespace im2fit::lab {

IM2FIT_SIMD_CLONES void raw_row_avx2(const RawRow& row, int count, std::int32_t* out) {
  raw_row_loop(row, count, out);
}

}  // namespace im2fit::lab
