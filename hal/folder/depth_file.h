// SPDX-License-Identifier: Apache-2.0
// One depth picture as a file: 16-bit grey PNG or binary PGM (P5, maxval above 255), millimetres, 0 = no data.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/status.h"
#include "formats/plain_png.h"

namespace im2fit::hal {

enum class DepthFormat { png, pgm };

struct DepthHeader {
  DepthFormat format = DepthFormat::png;
  int width = 0;
  int height = 0;
};

// `what` names the file in errors (corrupt: damaged; unsupported: 8 bits, colour, too large). The header needs the
// file's first kilobyte only.
inline constexpr std::size_t kHeaderBytes = 1024;
Result<DepthHeader> parse_depth_header(std::span<const std::byte> bytes, const std::string& what);
// `out` has the size the header gives.
Status decode_depth(std::span<const std::byte> bytes, const std::string& what, DepthImage out);
// The same of many pictures, with memory for the work kept from one to the next.
class DepthDecoder {
 public:
  Status decode(std::span<const std::byte> bytes, const std::string& what, DepthImage out);

 private:
  PlainPngDecoder plain_;
};
// How sure the camera was of each pixel: an 8-bit grey PNG. `out` gets width x height values.
Status decode_confidence(std::span<const std::byte> bytes, const std::string& what, int width, int height,
                         std::vector<std::uint8_t>& out);
Result<std::vector<std::byte>> encode_depth(DepthView image, DepthFormat format);

}  // namespace im2fit::hal
