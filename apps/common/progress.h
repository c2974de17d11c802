// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace im2fit {

// Progress on stderr: rate and time left, rewritten in place. Prints nothing where stderr is not a terminal.
class Progress {
 public:
  // `total` 0: not known.
  Progress(std::string what, std::uint64_t total);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  void update(std::uint64_t done, const std::string& note = "");

 private:
  std::string what_;
  std::uint64_t total_;
  bool terminal_;
  double started_s_;
  double shown_s_ = 0;
};

// A ProgressSink (train/common/parallel.h) that shows a Progress.
std::function<void(std::uint64_t done)> show_progress(const std::string& what, std::uint64_t total);

}  // namespace im2fit
