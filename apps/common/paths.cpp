// SPDX-License-Identifier: Apache-2.0
#include "apps/common/paths.h"

#include <cstdlib>
#include <filesystem>
#include <sstream>

namespace im2fit {

std::string environment(const char* name) {
  const char* value = std::getenv(name);  // NOLINT(concurrency-mt-unsafe): no thread sets it
  return value != nullptr ? value : "";
}

namespace {

std::string or_else(const std::string& given, const std::string& other) {
  return given.empty() ? other : given;
}

std::string below_home(const char* variable, const char* folder) {
  const std::string given = environment(variable);
  if (!given.empty()) return given + "/im2fit";
  const std::string home = environment("HOME");
  return (home.empty() ? "." : home + "/" + folder) + "/im2fit";
}

}  // namespace

std::string cache_directory() {
  return below_home("XDG_CACHE_HOME", ".cache");
}

std::string user_data_directory() {
  return below_home("XDG_DATA_HOME", ".local/share");
}

std::vector<std::string> model_directories() {
  std::vector<std::string> all = {user_data_directory(), cache_directory()};
  std::istringstream list(or_else(environment("XDG_DATA_DIRS"), "/usr/local/share:/usr/share"));
  for (std::string directory; std::getline(list, directory, ':');)
    if (!directory.empty()) all.push_back(directory + "/im2fit");
  return all;
}

bool holds_models(const std::string& directory) {
  std::error_code code;
  for (const char* file : {kBodyFile, kTrackerFile, kIndexFile})
    if (!std::filesystem::exists(std::filesystem::path(directory) / file, code)) return false;
  return true;
}

std::string model_directory() {
  for (const std::string& directory : model_directories())
    if (holds_models(directory)) return directory;
  return cache_directory();
}

std::string path_among(const std::string& models, const std::string& file) {
  std::error_code code;
  return std::filesystem::is_directory(models, code) ? models + "/" + file : models;
}

namespace {

std::string default_path(const char* variable, const char* file) {
  const std::string given = environment(variable), models = environment("IM2FIT_MODELS");
  if (!given.empty()) return given;
  return models.empty() ? model_directory() + "/" + file : path_among(models, file);
}

}  // namespace

std::string default_body_path() {
  return default_path("IM2FIT_BODY", kBodyFile);
}
std::string default_tracker_path() {
  return default_path("IM2FIT_TRACKER", kTrackerFile);
}
std::string default_index_path() {
  return default_path("IM2FIT_INDEX", kIndexFile);
}

Status check_named_by_variable(const std::string& path) {
  const std::string models = environment("IM2FIT_MODELS");
  std::error_code code;
  if (models.empty() || std::filesystem::exists(path, code)) return Ok{};
  if (path == models) return Error{ErrorCode::not_found, "IM2FIT_MODELS names " + models + ", which does not exist"};
  for (const char* file : {kBodyFile, kTrackerFile, kIndexFile})
    if (path == models + "/" + file)
      return Error{ErrorCode::not_found, "IM2FIT_MODELS names " + models + ", a directory without " + file};
  return Ok{};
}

std::string made_body_path() {
  return or_else(environment("IM2FIT_BODY"), cache_directory() + "/" + kBodyFile);
}
std::string made_tracker_path() {
  return or_else(environment("IM2FIT_TRACKER"), cache_directory() + "/" + kTrackerFile);
}
std::string made_index_path() {
  return or_else(environment("IM2FIT_INDEX"), cache_directory() + "/" + kIndexFile);
}

}  // namespace im2fit
