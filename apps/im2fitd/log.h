// SPDX-License-Identifier: Apache-2.0
// One line an event on stderr, with the priority journald reads ("<4>text") when no person reads it.
#pragma once

#include <array>
#include <cstdint>
#include <mutex>
#include <string>

namespace im2fit::daemon {

enum class Level : int { error = 3, warning = 4, notice = 5, info = 6 };  // as syslog(3) numbers them

// At most kLinesMax lines a level and period: what clients or a loose plug can cause without end must not fill a
// disk. Further ones are counted. Any thread.
class LogLimit {
 public:
  static constexpr int kLinesMax = 20;
  static constexpr std::int64_t kPeriodNs = 10'000'000'000;
  // Whether a line of that level may be written now. `left_out`: how many before it were not.
  bool admit(Level level, std::int64_t now_ns, std::uint64_t& left_out);

 private:
  struct Count {
    std::int64_t since_ns = 0;
    int lines = 0;
    std::uint64_t left_out = 0;
  };
  std::mutex mutex_;
  std::array<Count, 4> counts_{};
};

// Any thread.
void log(Level level, const std::string& text);

}  // namespace im2fit::daemon
