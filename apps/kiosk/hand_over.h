// SPDX-License-Identifier: Apache-2.0
// A result that waits for one phone, which shows a token for it. No clock of its own and no thread.
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <string_view>

#include "apps/kiosk/board.h"

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

}  // namespace im2fit::apps
