// SPDX-License-Identifier: Apache-2.0
#include "train/render/raw_row_loop.h"

namespace im2fit::lab {

void raw_row_portable(const RawRow& row, int count, std::int32_t* out) {
  raw_row_loop(row, count, out);
}

RawRowFunction* fastest_raw_row() {
#if IM2FIT_HAVE_AVX2
  if (tier_available(Tier::avx2)) return raw_row_avx2;
#endif
  return raw_row_portable;
}

}  // namespace im2fit::lab
