// SPDX-License-Identifier: Apache-2.0
// PNGs coded at once instead of row by row: 16-bit grey ones as cameras' programs write them, two fifths of libpng's
// work to read one; and pictures to look at.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/camera.h"
#include "core/status.h"

struct libdeflate_decompressor;

namespace im2fit::hal {

// Of many pictures, with memory for the work kept from one to the next. Not shareable between threads.
class PlainPngDecoder {
 public:
  // False, and `out` undefined, for anything but a whole, undamaged, not interlaced 16-bit grey PNG of the size of
  // `out`: libpng then decodes or reports the error. Pixels in the file's byte order (most significant byte first).
  bool decode(std::span<const std::byte> bytes, DepthImage out);

 private:
  struct Free {
    void operator()(libdeflate_decompressor* decompressor) const;
  };
  bool inflate_rows(std::span<const std::byte> bytes, DepthView image, std::span<std::uint8_t> rows);
  bool inflate(std::span<const std::byte> stream, std::span<std::uint8_t> rows);

  std::unique_ptr<libdeflate_decompressor, Free> decompressor_;  // made for the first picture
  std::vector<std::byte> stream_;                                // of a picture in several pieces
  std::vector<std::uint8_t> rows_;
};

inline constexpr std::byte kPngSignature[8] = {std::byte{0x89}, std::byte{'P'},  std::byte{'N'},  std::byte{'G'},
                                               std::byte{'\r'}, std::byte{'\n'}, std::byte{0x1A}, std::byte{'\n'}};

enum class RowFilter : std::uint8_t { none = 0, up = 2 };  // the standard's numbers

// Every row is written with that filter: its pixels as they are, or each byte less the one above it.
Result<std::vector<std::byte>> encode_plain_png(DepthView image, RowFilter filter);

// Red, green, blue, 8 bits each, rows from the top: 3 * width * height bytes.
Result<std::vector<std::byte>> encode_rgb_png(int width, int height, std::span<const std::uint8_t> pixels);

}  // namespace im2fit::hal
