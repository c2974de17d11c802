// SPDX-License-Identifier: Apache-2.0
// The read permissions of the files that a program has left in a folder.
#pragma once

#include <sys/stat.h>

#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace im2fit::test {

// 022, as systems come, of this process and of those it starts, while this lives.
class UsualUmask {
 public:
  UsualUmask() : before_(::umask(022)) {}
  ~UsualUmask() { ::umask(before_); }
  UsualUmask(const UsualUmask&) = delete;
  UsualUmask& operator=(const UsualUmask&) = delete;

 private:
  mode_t before_;
};

// Regular files at any depth, by their path within the folder.
inline std::set<std::string> all_files_in(const std::string& folder) {
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) names.insert(std::filesystem::relative(entry.path(), folder).string());
  return names;
}

// Those among them that the group or others may read, write or run. A camera's calibration is of no person.
inline std::vector<std::string> readable_by_others(const std::string& folder) {
  constexpr auto kOthers = std::filesystem::perms::group_all | std::filesystem::perms::others_all;
  std::vector<std::string> names;
  for (const std::string& name : all_files_in(folder))
    if (std::filesystem::path(name).filename() != "camera.yaml" &&
        (std::filesystem::status(std::filesystem::path(folder) / name).permissions() & kOthers) !=
            std::filesystem::perms::none)
      names.push_back(name);
  return names;
}

}  // namespace im2fit::test
