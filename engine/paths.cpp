// SPDX-License-Identifier: Apache-2.0
#include "engine/paths.h"

#include <cstdlib>

namespace im2fit {

std::string environment(const char* name) {
  const char* value = std::getenv(name);  // NOLINT(concurrency-mt-unsafe): no thread sets it
  return value != nullptr ? value : "";
}

namespace {

std::string data_path(const char* variable, const char* file) {
  const std::string given = environment(variable);
  return given.empty() ? cache_directory() + "/" + file : given;
}

}  // namespace

std::string cache_directory() {
  const std::string xdg = environment("XDG_CACHE_HOME");
  if (!xdg.empty()) return xdg + "/im2fit";
  const std::string home = environment("HOME");
  return (home.empty() ? "." : home + "/.cache") + "/im2fit";
}

std::string default_body_path() {
  return data_path("IM2FIT_BODY", "body.i2b");
}
std::string default_tracker_path() {
  return data_path("IM2FIT_TRACKER", "tracker.i2t");
}
std::string default_index_path() {
  return data_path("IM2FIT_INDEX", "index.i2f");
}

}  // namespace im2fit
