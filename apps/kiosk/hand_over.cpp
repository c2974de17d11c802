// SPDX-License-Identifier: Apache-2.0
#include "apps/kiosk/hand_over.h"

#include <qrencode.h>

#include <cerrno>
#include <cstddef>
#include <cstring>
#include <memory>
#include <utility>

#include "apps/kiosk/operator_gate.h"
#include "apps/kiosk/visit.h"

namespace im2fit::apps {

std::string HandOver::offer(std::shared_ptr<const PageFile> result, Time now) {
  token_ = random_id();
  result_ = std::move(result);
  offered_ = now;
  return token_;
}

std::shared_ptr<const PageFile> HandOver::take(std::string_view token, Time now) {
  if (result_ && now - offered_ >= wait_max_) forget();
  if (!result_ || !same_secret(token_, token)) return nullptr;
  std::shared_ptr<const PageFile> given = result_;
  forget();
  return given;
}

void HandOver::forget() {
  token_.clear();
  result_.reset();
}

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
