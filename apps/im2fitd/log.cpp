// SPDX-License-Identifier: Apache-2.0
#include "apps/im2fitd/log.h"

#include <unistd.h>

#include "core/text.h"
#include "hal/frame_path.h"

namespace im2fit::daemon {
namespace {

void write_line(Level level, const std::string& text) {
  std::string line = ::isatty(STDERR_FILENO) == 1 ? "im2fitd: " : "<" + std::to_string(static_cast<int>(level)) + ">";
  line += printable(text) + "\n";
  // One call, so that lines of several threads do not mix. That a journal takes none cannot be reported anywhere.
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, line.data(), line.size());
}

}  // namespace

bool LogLimit::admit(Level level, std::int64_t now_ns, std::uint64_t& left_out) {
  const std::lock_guard lock(mutex_);
  Count& count = counts_[static_cast<std::size_t>(level) - static_cast<std::size_t>(Level::error)];
  left_out = 0;
  if (count.lines == 0 || now_ns - count.since_ns >= kPeriodNs) {
    left_out = count.left_out;
    count = {now_ns, 0, 0};
  }
  if (count.lines == kLinesMax) {
    ++count.left_out;
    return false;
  }
  ++count.lines;
  return true;
}

void log(Level level, const std::string& text) {
  static LogLimit limit;
  std::uint64_t left_out = 0;
  if (!limit.admit(level, hal::monotonic_ns(), left_out)) return;
  if (left_out > 0) write_line(level, std::to_string(left_out) + " further lines were left out");
  write_line(level, text);
}

}  // namespace im2fit::daemon
