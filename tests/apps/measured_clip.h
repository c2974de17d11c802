// SPDX-License-Identifier: Apache-2.0
// One clip of a rendered person, made once for a suite's cases and measured by the program with words of theirs.
#pragma once

#include "measure_run.h"

namespace im2fit::test {

class MeasuredClip : public testing::Test {
 protected:
  // `words`: how `im2fit-lab render` is to draw the woman of seed 7. Does nothing without data.
  static void render(const std::vector<std::string>& words) {
    if (!have_data()) return;
    folder_ = new TestFolder;
    std::vector<std::string> call = {kLab,        "render", "--out",  clip(),    "--seed", "7",
                                     "--subject", "1",      "--size", "320x240", "--body", body_path()};
    call.insert(call.end(), words.begin(), words.end());
    const auto run = run_program(call);
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }
  void SetUp() override {
    if (folder_ == nullptr) GTEST_SKIP() << "no body, tracker or index file";
  }
  static std::string clip() { return folder_->path("clip"); }
  static nlohmann::json measured(const std::vector<std::string>& words) {
    const std::string out = folder_->path("out");
    const auto run = measure(clip(), out, words);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    expect_honest(run, out);
    return nlohmann::json::parse(read_text(out + "/result.json"), nullptr, false);
  }

 private:
  static inline TestFolder* folder_ = nullptr;
};

}  // namespace im2fit::test
