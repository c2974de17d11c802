// SPDX-License-Identifier: Apache-2.0
// A rendered person in clothes, measured with and without a word about them.
#include <cmath>

#include "measured_clip.h"

namespace im2fit {
namespace {

class InClothes : public test::MeasuredClip {
 protected:
  static void SetUpTestSuite() { render({"--frames", "20", "--clothed"}); }
};

TEST_F(InClothes, TheBodyUnderneathIsMeasuredWithTheOption) {
  const auto with_option = measured({"--clothing", "dressed", "--frames", "12"});
  const auto without_option = measured({"--clothing", "bare", "--frames", "12"});
  EXPECT_EQ(with_option["clothing"]["answered_as"], "dressed");
  const auto truth = nlohmann::json::parse(test::read_text(clip() + "/truth.json"), nullptr, false)["measurements"];
  for (const char* girth : {"chest_girth", "waist_girth", "hip_girth"}) {
    const auto& under = with_option["measurements"][girth];
    const double cloth = without_option["measurements"][girth]["value"].get<double>();
    // Everyday clothes stand off by 4 to 20 mm: some centimetres of girth.
    EXPECT_GT(cloth - under["value"].get<double>(), 15) << girth;
    EXPECT_LT(std::abs(under["value"].get<double>() - truth[girth]["value"].get<double>()), 80) << girth;
    EXPECT_GT(under["interval"][1].get<double>() - under["interval"][0].get<double>(), 60)
        << girth << ": the interval says so";
  }
}

}  // namespace
}  // namespace im2fit
