// SPDX-License-Identifier: Apache-2.0
// A rendered person in clothes, measured with and without a word about them.
#include <cmath>

#include "measure_run.h"

namespace im2fit {
namespace {

class InClothes : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (!test::have_data()) return;
    folder_ = new test::TestFolder;
    const test::Run run =
        test::run_program({test::kLab, "render", "--out", clip(), "--seed", "7", "--subject", "1", "--size",
                           "320x240", "--frames", "20", "--clothed", "--body", test::body_path()});
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
    const test::Run run = test::measure(clip(), out, words);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    test::expect_honest(run, out);
    return nlohmann::json::parse(test::read_text(out + "/result.json"), nullptr, false);
  }
  static inline test::TestFolder* folder_ = nullptr;
};

TEST_F(InClothes, TheBodyUnderneathIsMeasuredWhenTold) {
  const auto told = measured({"--clothed", "--frames", "12"});
  const auto untold = measured({"--frames", "12"});
  EXPECT_EQ(told["clothed"], true);
  EXPECT_EQ(untold["clothed"], false);
  const auto truth = nlohmann::json::parse(test::read_text(clip() + "/truth.json"), nullptr, false)["measurements"];
  for (const char* girth : {"chest_girth", "waist_girth", "hip_girth"}) {
    const auto& under = told["measurements"][girth];
    const double cloth = untold["measurements"][girth]["value"].get<double>();
    // Everyday clothes stand off by 4 to 20 mm: some centimetres of girth.
    EXPECT_GT(cloth - under["value"].get<double>(), 15) << girth;
    EXPECT_LT(std::abs(under["value"].get<double>() - truth[girth]["value"].get<double>()), 80) << girth;
    EXPECT_GT(under["interval"][1].get<double>() - under["interval"][0].get<double>(), 60)
        << girth << ": the interval says so";
  }
}

}  // namespace
}  // namespace im2fit
