// SPDX-License-Identifier: Apache-2.0
// The OpenNI2 runtime, begun by its first user in the process and ended by its last. Beginning takes 0.4 s and every
// end leaves some 50 kB behind in the drivers: a program that opens cameras again and again holds one of these
// meanwhile.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/status.h"

namespace im2fit::hal {

class OpenNi2Runtime {
 public:
  // Error: unsupported, when the runtime finds no driver or cannot start.
  static Result<std::shared_ptr<OpenNi2Runtime>> get();
  ~OpenNi2Runtime();
  OpenNi2Runtime(const OpenNi2Runtime&) = delete;
  OpenNi2Runtime& operator=(const OpenNi2Runtime&) = delete;
  OpenNi2Runtime() = default;  // for get()
};

// What the runtime last complained of, on one line.
std::string openni2_complaint();

struct OpenNi2Device {
  std::string uri;
  std::string name;  // vendor and model
};
Result<std::vector<OpenNi2Device>> list_openni2_devices();

}  // namespace im2fit::hal
