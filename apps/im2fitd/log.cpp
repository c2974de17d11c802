// SPDX-License-Identifier: Apache-2.0
#include "apps/im2fitd/log.h"

#include <unistd.h>

#include <algorithm>

namespace im2fit::daemon {

void log(Level level, const std::string& text) {
  std::string line = ::isatty(STDERR_FILENO) == 1 ? "im2fitd: " : "<" + std::to_string(static_cast<int>(level)) + ">";
  line += text;
  std::replace(line.begin(), line.end(), '\n', ' ');
  line += '\n';
  // One call, so that lines of several threads do not mix. That a journal takes none cannot be reported anywhere.
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, line.data(), line.size());
}

}  // namespace im2fit::daemon
