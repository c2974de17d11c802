// SPDX-License-Identifier: Apache-2.0
#include "apps/kiosk/qr_code.h"

#include <qrencode.h>

#include <cerrno>
#include <cstddef>
#include <cstring>
#include <memory>

namespace im2fit::apps {

Result<QrCode> qr_code(const std::string& text) {
  struct Free {
    void operator()(QRcode* code) const { QRcode_free(code); }
  };
  const std::unique_ptr<QRcode, Free> made(QRcode_encodeData(static_cast<int>(text.size()),
                                                             reinterpret_cast<const unsigned char*>(text.data()),
                                                             0 /* the smallest that holds it */, QR_ECLEVEL_M));
  if (!made)
    return Error{ErrorCode::invalid_argument,
                 "a QR code cannot hold " + std::to_string(text.size()) + " bytes: " + std::strerror(errno)};
  QrCode code;
  code.side = made->width;
  const auto side = static_cast<std::size_t>(code.side);
  const auto is_dark = [&](std::size_t x, std::size_t y) { return (made->data[y * side + x] & 1U) != 0; };
  for (std::size_t y = 0; y < side; ++y)
    for (std::size_t x = 0; x < side;) {
      std::size_t end = x;
      while (end < side && is_dark(end, y)) ++end;
      const std::string run = std::to_string(end - x);
      if (end > x) code.path += "M" + std::to_string(x) + " " + std::to_string(y) + "h" + run + "v1h-" + run + "z";
      x = end + 1;
    }
  return code;
}

}  // namespace im2fit::apps
