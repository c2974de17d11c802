// SPDX-License-Identifier: Apache-2.0
// One line an event on stderr, with the priority journald reads ("<4>text") when no person reads it.
#pragma once

#include <string>

namespace im2fit::daemon {

enum class Level : int { error = 3, warning = 4, notice = 5, info = 6 };  // as syslog(3) numbers them

void log(Level level, const std::string& text);

}  // namespace im2fit::daemon
