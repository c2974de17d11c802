// SPDX-License-Identifier: Apache-2.0
// A result that waits for one phone, which shows a token for it, and the code that the phone reads it from. No clock
// of its own and no thread.
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <string_view>

#include "apps/kiosk/board.h"
#include "core/status.h"

namespace im2fit::apps {

// Enough to take a phone out of a pocket and unlock it.
inline constexpr std::chrono::milliseconds kHandOverMax{120'000};

class HandOver {
 public:
  using Time = std::chrono::steady_clock::time_point;
  explicit HandOver(std::chrono::milliseconds wait_max) : wait_max_(wait_max) {}

  // The token for it, of 128 bits that cannot be guessed; the one before is worth nothing any more.
  std::string offer(std::shared_ptr<const PageFile> result, Time now);
  // Null: not its token, or it is over. Given once; a wrong token changes nothing.
  std::shared_ptr<const PageFile> take(std::string_view token, Time now);
  void forget();

 private:
  const std::chrono::milliseconds wait_max_;
  std::string token_;
  std::shared_ptr<const PageFile> result_;  // null: nothing waits
  Time offered_{};
};

// A text as a QR code (ISO/IEC 18004), for a page to draw.
struct QrCode {
  int side = 0;      // modules, without the margin of four that belongs around it
  std::string path;  // of an SVG <path>: the dark modules, a unit each, from 0, 0
};

// With error correction of level M: 15 % of it may be hidden by a reflection. Error: invalid_argument, the text is
// empty or longer than a code holds (2331 bytes).
Result<QrCode> qr_code(const std::string& text);

}  // namespace im2fit::apps
