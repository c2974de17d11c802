// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace im2fit::hal {

// Plays `path` through the OpenNI2 runtime into `fd` (oni_protocol.h) and returns the exit code of the process. For a
// process of its own: a damaged recording may crash the runtime, and the runtime is not shut down.
int serve_oni(const std::string& path, int fd);

}  // namespace im2fit::hal
