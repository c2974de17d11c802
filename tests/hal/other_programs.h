// SPDX-License-Identifier: Apache-2.0
// Programs of others that write recordings for tests.
#pragma once

#include <cstdlib>
#include <fstream>
#include <span>
#include <string>

#include "core/camera.h"

namespace im2fit::hal {

inline bool have_program(const std::string& name) {
  return std::system(("command -v " + name + " >/dev/null 2>&1").c_str()) == 0;
}

// In `folder`; what it prints is kept in `folder`/log.
inline bool run_in(const std::string& folder, const std::string& command) {
  return std::system(("cd '" + folder + "' && { " + command + "; } >log 2>&1").c_str()) == 0;
}

inline void append_big_endian(std::ofstream& file, DepthView picture) {
  for (int v = 0; v < picture.height; ++v)
    for (int u = 0; u < picture.width; ++u) {
      const std::uint16_t mm = picture.row(v)[u];
      file.put(static_cast<char>(mm >> 8)).put(static_cast<char>(mm & 0xFF));
    }
}

}  // namespace im2fit::hal
