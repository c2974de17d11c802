// SPDX-License-Identifier: Apache-2.0
// A folder that goes away with its test, and when samples are the same.
#pragma once

#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "train/index/sample.h"

namespace im2fit::lab {

class TemporaryFolder {
 public:
  TemporaryFolder() : path_(std::filesystem::temp_directory_path() / ("im2fit_dataset_" + std::to_string(getpid()))) {
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }
  std::string str() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

// NaN features are equal when their bits are.
inline bool same(const index::Sample& a, const index::Sample& b) {
  return a.subject == b.subject && a.woman == b.woman && a.calibrate_only == b.calibrate_only &&
         a.clothed == b.clothed && a.clothes_kind == b.clothes_kind && a.again == b.again &&
         a.frame_count == b.frame_count && a.back_frame_count == b.back_frame_count &&
         a.distance_mm == b.distance_mm && a.back_distance_mm == b.back_distance_mm && a.truth == b.truth &&
         a.body == b.body && a.feature.size() == b.feature.size() &&
         std::memcmp(a.feature.data(), b.feature.data(), a.feature.size() * sizeof(float)) == 0;
}
inline bool same(const std::vector<index::Sample>& a, const std::vector<index::Sample>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const index::Sample& x, const index::Sample& y) { return same(x, y); });
}

}  // namespace im2fit::lab
