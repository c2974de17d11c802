// SPDX-License-Identifier: Apache-2.0
// The body, tracker and index files, where the programs look for them.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

namespace im2fit::test {

inline std::string data_path(const char* variable, const char* name) {
  if (const char* given = std::getenv(variable)) return given;
  const char* cache = std::getenv("XDG_CACHE_HOME");
  const char* home = std::getenv("HOME");
  return (cache != nullptr ? std::string(cache) : std::string(home != nullptr ? home : ".") + "/.cache") +
         "/im2fit/" + name;
}
inline std::string body_path() {
  return data_path("IM2FIT_BODY", "body.i2b");
}
inline std::string tracker_path() {
  return data_path("IM2FIT_TRACKER", "tracker.i2t");
}
inline std::string index_path() {
  return data_path("IM2FIT_INDEX", "index.i2f");
}
inline bool have_tracker() {
  return std::filesystem::exists(body_path()) && std::filesystem::exists(tracker_path());
}
inline bool have_data() {
  return have_tracker() && std::filesystem::exists(index_path());
}

#define IM2FIT_NEED_DATA() \
  if (!test::have_data()) GTEST_SKIP() << "no body, tracker or index file: run im2fit-lab fetch, train and index"

#define IM2FIT_NEED_TRACKER() \
  if (!test::have_tracker()) GTEST_SKIP() << "no body or tracker file: run im2fit-lab fetch and train"

}  // namespace im2fit::test
