// SPDX-License-Identifier: Apache-2.0
// OpenNI2's depth codec "16zT", written so that its decoder gives back every pixel.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/camera.h"

namespace im2fit::hal {

// A picture is a table of the values that occur in it, ascending, and then the places of its pixels in that table,
// row after row: the first as it is, each other one as a difference to the one before.
//
//   u16 count, u16 values[count], u16 first, then bytes:
//   ab        a, b = 0..12: two differences, 6 - a and 6 - b
//   aD        one difference: a last pixel that has no partner
//   aF e      a difference, then an escaped pixel
//   FF e      an escaped pixel
//   En        n = 1..15: 2 n pixels like the one before
//   e         192 - d for a difference of d = -63..63; else 15 bits of place, high byte first
//
// Places beyond 15 bits do not fit, so a picture may hold 32768 different values; which ones is all the same, up to
// 65535. The runtime's own encoder mixes up the order of an open half byte and an open run at a picture's end, and
// its table leaves out values from the stream's largest depth on.
class OniEncoder {
 public:
  static constexpr std::size_t kValuesMax = 32768;
  // Never more bytes than this come of a picture.
  static constexpr std::size_t encoded_bytes_max(std::size_t pixel_count) {
    return 2 + 2 * kValuesMax + 2 + 3 * pixel_count;
  }

  OniEncoder() : places_(65536) {}
  // Appends the picture to `out`. False, with `out` as it was, when the picture is empty or holds more different
  // values than kValuesMax. Allocates only in `out`.
  bool encode(DepthView picture, std::vector<std::byte>& out);

 private:
  bool write_table(DepthView picture, std::vector<std::byte>& out);
  std::vector<std::uint16_t> places_;  // of a value in the table
};

}  // namespace im2fit::hal
