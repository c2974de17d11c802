// SPDX-License-Identifier: Apache-2.0
// Runs of very many frames: how long, and that the process does not grow meanwhile.
#pragma once

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>

#include "tests/devices/process_state.h"

namespace im2fit::hal {

// Frames to test: `variable` of the environment (100000 is the long run, of some minutes), else `usual`.
inline int frames_to_test(const char* variable, int usual = 200) {
  const char* text = std::getenv(variable);
  return text != nullptr ? std::atoi(text) : usual;
}

// Memory at the end against memory after a tenth of the frames, within 1 MB. Short runs are not judged: buffers
// and tables still fill.
class Growth {
 public:
  explicit Growth(int frames) : frames_(frames) {}
  void saw(int frame) {
    if (frame == frames_ / 10) early_kb_ = devices::resident_kb();
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
  int frames_;
  long early_kb_ = 0;
};

}  // namespace im2fit::hal
