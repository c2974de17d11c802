// SPDX-License-Identifier: Apache-2.0
// What of a process must not grow, however long it runs and however often its camera goes and comes.
#pragma once

#include <dirent.h>

#include <cstdlib>
#include <fstream>
#include <string>

namespace im2fit::devices {

// -1: there is no such folder.
inline int count_entries(const char* path) {
  int count = -2;  // . and ..
  DIR* folder = ::opendir(path);
  if (folder == nullptr) return -1;
  while (::readdir(folder) != nullptr) ++count;
  ::closedir(folder);
  return count;
}

inline int open_files() {
  return count_entries("/proc/self/fd") - 1;  // the folder itself
}
inline int threads() {
  return count_entries("/proc/self/task");
}

inline long resident_kb() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.rfind("VmRSS:", 0) == 0) return std::strtol(line.c_str() + 6, nullptr, 10);
  return -1;
}

}  // namespace im2fit::devices
