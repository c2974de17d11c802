// SPDX-License-Identifier: Apache-2.0
// A rendered person in clothes, measured with a word about them, without one, and with a wrong one.
#include <cmath>

#include "measured_clip.h"

namespace im2fit {
namespace {

class InClothes : public test::MeasuredClip {
 protected:
  static void SetUpTestSuite() { render({"--frames", "20", "--clothed"}); }
};

TEST_F(InClothes, TheBodyUnderneathIsMeasuredWhateverIsSaid) {
  const auto told = measured({"--clothing", "dressed", "--frames", "12"});
  const auto untold = measured({"--frames", "12"});
  const auto denied = measured({"--clothing", "bare", "--frames", "12"});
  const auto truth = nlohmann::json::parse(test::read_text(clip() + "/truth.json"), nullptr, false)["measurements"];
  for (const auto& result : {told, untold, denied}) {
    EXPECT_GT(result["clothing"]["probability"].get<double>(), 0.9);
    // Everyday clothes stand off by 4 to 20 mm.
    EXPECT_GT(result["clothing"]["ease_mm"].get<double>(), 2);
    EXPECT_LT(result["clothing"]["ease_mm"].get<double>(), 30);
    EXPECT_EQ(result["clothing"]["answered_as"], "dressed");
    for (const char* girth : {"chest_girth", "waist_girth", "hip_girth"}) {
      const auto& under = result["measurements"][girth];
      EXPECT_LT(std::abs(under["value"].get<double>() - truth[girth]["value"].get<double>()), 80) << girth;
      EXPECT_GT(under["interval"][1].get<double>() - under["interval"][0].get<double>(), 60)
          << girth << ": the interval says so";
    }
  }
  EXPECT_TRUE(told["guidance"].empty());
  EXPECT_TRUE(untold["guidance"].empty());
  EXPECT_EQ(denied["guidance"], nlohmann::json::array({"CLOTHED"})) << "said to be bare, and seen dressed";
}

}  // namespace
}  // namespace im2fit
