// SPDX-License-Identifier: Apache-2.0
// The record structure of a .oni file, walked without the OpenNI2 runtime: headers only, no pixel is decoded.
#pragma once

#include <cstdint>
#include <string>

#include "base/status.h"

namespace im2fit::hal {

struct OniContents {
  std::uint64_t frames = 0;
  std::uint64_t size_bytes = 0;  // up to the end of the last record
  bool closed = false;           // the recorder's last record is there
};

// Errors: io; corrupt, when a record does not lie where the one before it ends. `path` names the file in errors.
Result<OniContents> inspect_oni(const std::string& path);

}  // namespace im2fit::hal
