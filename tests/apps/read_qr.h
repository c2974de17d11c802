// SPDX-License-Identifier: Apache-2.0
// A QR code read back by ZXing, as a phone would.
#pragma once

#if IM2FIT_HAVE_ZXING
#define ZX_USE_UTF8 1  // texts are std::string, as they will be in its next version
#include <ZXing/ReadBarcode.h>
#endif

#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

namespace im2fit::test {

#if IM2FIT_HAVE_ZXING
inline constexpr bool kReadsQr = true;
// In a grey picture; "": there is none.
inline std::string read_qr(const std::vector<std::uint8_t>& grey, int width, int height) {
  const ZXing::Result found = ZXing::ReadBarcode({grey.data(), width, height, ZXing::ImageFormat::Lum},
                                                 ZXing::DecodeHints().setFormats(ZXing::BarcodeFormat::QRCode));
  return found.isValid() ? found.text() : "";
}
#else
inline constexpr bool kReadsQr = false;
inline std::string read_qr(const std::vector<std::uint8_t>& /*grey*/, int /*width*/, int /*height*/) {
  return "";
}
#endif

// Of a code's path (apps/kiosk/hand_over.h), `scale` pixels a module, with its margin.
inline std::string read_qr_path(const std::string& path, int side, int scale = 4) {
  const int margin = 4, width = scale * (side + 2 * margin);
  std::vector<std::uint8_t> grey(static_cast<std::size_t>(width) * static_cast<std::size_t>(width), 255);
  for (std::size_t at = path.find('M'); at != std::string::npos; at = path.find('M', at + 1)) {
    int x = 0, y = 0, run = 0;
    if (std::sscanf(path.c_str() + at, "M%d %dh%dv1", &x, &y, &run) != 3) return "no path of runs";
    for (int v = scale * (y + margin); v < scale * (y + margin + 1); ++v)
      for (int u = scale * (x + margin); u < scale * (x + margin + run); ++u)
        grey.at(static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(u)) = 0;
  }
  return read_qr(grey, width, width);
}

}  // namespace im2fit::test
