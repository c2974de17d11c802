// SPDX-License-Identifier: Apache-2.0
// Where libdeflate is missing: libpng reads everything.
#include "hal/folder/plain_png.h"

namespace im2fit::hal {

void PlainPngDecoder::Free::operator()(libdeflate_decompressor* /*decompressor*/) const {}

bool PlainPngDecoder::decode(std::span<const std::byte> /*bytes*/, DepthImage /*out*/) {
  return false;
}

}  // namespace im2fit::hal
