// SPDX-License-Identifier: Apache-2.0
// Runs of very many frames: how long, and that the process does not grow meanwhile.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "tests/devices/process_state.h"

namespace im2fit::hal {

// Frames to test: `variable` of the environment (100000 is the long run, of some minutes), else `usual`.
inline int frames_to_test(const char* variable, int usual = 200) {
  const char* text = std::getenv(variable);
  return text != nullptr ? std::atoi(text) : usual;
}

// Memory at the end against memory after a tenth of the frames, within 1 MB. Short runs are not judged: buffers
// and tables still fill. With IM2FIT_GROWTH_LOG fifty lines "frame kB" go into that file, which bench/report draws.
class Growth {
 public:
  explicit Growth(int frames) : frames_(frames) {
    if (const char* path = std::getenv("IM2FIT_GROWTH_LOG")) log_.reset(std::fopen(path, "w"));
  }
  void saw(int frame) {
    if (frame == frames_ / 10) early_kb_ = devices::resident_kb();
    if (log_ != nullptr && frame % std::max(1, frames_ / kLines) == 0)
      std::fprintf(log_.get(), "%d %ld\n", frame, devices::resident_kb());
  }
  void expect_none() const {
    if (frames_ < 10'000) return;
    const long last_kb = devices::resident_kb();
    EXPECT_GT(early_kb_, 0);
    EXPECT_LE(last_kb, early_kb_ + 1024) << "grown in " << frames_ << " frames";
    testing::Test::RecordProperty("early_kb", static_cast<int>(early_kb_));
    testing::Test::RecordProperty("last_kb", static_cast<int>(last_kb));
    std::printf("%d frames: %ld kB after a tenth, %ld kB at the end\n", frames_, early_kb_, last_kb);
  }

 private:
  static constexpr int kLines = 50;
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  int frames_;
  long early_kb_ = 0;
  std::unique_ptr<std::FILE, Close> log_;
};

}  // namespace im2fit::hal
