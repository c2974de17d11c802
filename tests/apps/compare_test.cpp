// SPDX-License-Identifier: Apache-2.0
// Two captures of one person: im2fit compare, and the rules behind it.
#include <cmath>

#include "measure_run.h"
#include "person/comparison.h"

namespace im2fit {
namespace {

constexpr std::size_t kWaist = measurement_index(Measurement::waist_girth);
constexpr std::size_t kStature = measurement_index(Measurement::stature);

Capture capture_of(float waist_mm, float stature_mm = 1780, const std::string& views = "around") {
  Capture c;
  c.path = "a";
  for (std::size_t i = 0; i < kMeasurementCount; ++i) c.measurements[i] = {900, 880, 920};
  c.measurements[kStature] = {stature_mm, stature_mm - 10, stature_mm + 10};
  c.measurements[kWaist] = {waist_mm, waist_mm - 20, waist_mm + 20};
  c.views = views;
  c.answered_as = "bare";
  c.program = "1.0.0";
  c.index = "0123abcd";
  return c;
}

TEST(Compare, OfOnePersonRestsOnHowCapturesRepeat) {
  for (const char* views : {"front", "around"}) {
    const double tem = repeat_error(Measurement::waist_girth, views);
    ASSERT_GT(tem, 0) << views;
    const Comparison same = compare(capture_of(800, 1780, views), capture_of(802, 1780, views));
    EXPECT_TRUE(same.wider.empty());
    EXPECT_FALSE(same.two_people);
    EXPECT_FLOAT_EQ(same.changes[kWaist].difference, 2);
    EXPECT_NEAR(same.changes[kWaist].half, kComparisonSds * std::sqrt(2.0) * tem, 0.01) << views;
    EXPECT_FALSE(same.changes[kWaist].changed());
    const float beyond = 1.05F * same.changes[kWaist].half;
    EXPECT_TRUE(
        compare(capture_of(800, 1780, views), capture_of(800 + beyond, 1780, views)).changes[kWaist].changed());
    EXPECT_TRUE(
        compare(capture_of(800 + beyond, 1780, views), capture_of(800, 1780, views)).changes[kWaist].changed());
  }
}

TEST(Compare, OfUnlikeCapturesTakesTheirErrorsAsIndependentAndSaysWhy) {
  const Capture before = capture_of(800);
  const double independent = kComparisonSds / 1.96 * std::sqrt(2.0) * 20;
  const auto expect_wider = [&](void (*change)(Capture&), const std::string& word) {
    Capture after = before;
    change(after);
    const Comparison all = compare(before, after);
    ASSERT_EQ(all.wider.size(), 1U) << word;
    EXPECT_THAT(all.wider[0], testing::HasSubstr(word));
    EXPECT_NEAR(all.changes[kWaist].half, independent, 0.01) << word;
  };
  expect_wider([](Capture& c) { c.views = "front"; }, "views: around and front");
  expect_wider([](Capture& c) { c.index = "ffffffff"; }, "index 0123abcd and ffffffff");
  expect_wider([](Capture& c) { c.index = ""; }, "do not both name");
  expect_wider([](Capture& c) { c.program = "1.1.0"; }, "program: 1.0.0 and 1.1.0");
  expect_wider([](Capture& c) { c.answered_as = "dressed"; }, "clothing: bare and dressed");
  expect_wider([](Capture& c) { c.site = "00112233"; }, "site calibration");
  expect_wider([](Capture& c) { c.known = "{\"weight\":{}}"; }, "facts");
  const Capture both = capture_of(800, 1780, "front+back");
  EXPECT_THAT(compare(both, both).wider, testing::ElementsAre(testing::HasSubstr("views front+back")));
  Capture dressed = before;
  dressed.answered_as = "dressed";
  EXPECT_EQ(compare(dressed, dressed).wider.size(), 1U);
  Capture looks_dressed = before;
  looks_dressed.looks_dressed = true;
  EXPECT_THAT(compare(before, looks_dressed).wider, testing::ElementsAre(testing::HasSubstr("dressed people")));
}

TEST(Compare, StaturesApartAreTwoPeople) {
  EXPECT_FALSE(compare(capture_of(800, 1780), capture_of(800, 1813)).two_people);
  EXPECT_TRUE(compare(capture_of(800, 1780), capture_of(800, 1816)).two_people);
  EXPECT_TRUE(compare(capture_of(800, 1816), capture_of(800, 1780)).two_people);
}

class CompareCommand : public testing::Test {
 protected:
  std::string write(const std::string& name, double waist_mm, double stature_mm = 1780,
                    const std::string& views = "around") {
    nlohmann::json measurements;
    for (const MeasurementInfo& info : kMeasurementTable) {
      const double value = info.id == "waist_girth" ? waist_mm : info.id == "stature" ? stature_mm : 900;
      measurements[std::string(info.id)] = {
          {"value", value}, {"unit", info.unit}, {"interval", {value - 10, value + 10}}, {"iso", nullptr}};
    }
    const nlohmann::json result = {{"schema", "im2fit.result/1"},
                                   {"views", views},
                                   {"clothing", {{"answered_as", "bare"}, {"probability", clothed_}}},
                                   {"measurements", measurements},
                                   {"made_by", {{"im2fit", "1.0.0"}, {"index", "0123abcd"}}}};
    return write_text(name, result.dump());
  }
  std::string write_text(const std::string& name, const std::string& text) {
    std::filesystem::create_directories(folder_.path(name));
    const std::string path = folder_.path(name) + "/result.json";
    std::ofstream(path) << text;
    return path;
  }
  static test::Run compare(const std::vector<std::string>& words) {
    std::vector<std::string> command = {test::kProgram, "compare"};
    command.insert(command.end(), words.begin(), words.end());
    return test::run_program(command);
  }
  test::TestFolder folder_;
  nlohmann::json clothed_;  // null: not estimated
};

TEST_F(CompareCommand, NamesWhatHasChangedAndWhatHasNot) {
  const std::string before = write("may", 900);
  write("june", 840);
  const test::Run run = compare({before, folder_.path("june"), "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto json = nlohmann::json::parse(run.out, nullptr, false);
  EXPECT_EQ(json["schema"], "im2fit.comparison/1");
  EXPECT_EQ(json["two_people"], false);
  EXPECT_EQ(json["rests_on"], "repeated captures");
  EXPECT_EQ(json["differences"].size(), kMeasurementCount);
  const auto& waist = json["differences"]["waist_girth"];
  EXPECT_EQ(waist["difference"], -60);
  EXPECT_EQ(waist["verdict"], "changed");
  EXPECT_LT(waist["interval"][1], 0);
  EXPECT_EQ(json["differences"]["hip_girth"]["verdict"], "no change");
  const test::Run text = compare({folder_.path("may"), folder_.path("june")});
  EXPECT_EQ(text.exit_code, 0) << text.err;
  EXPECT_THAT(text.out, testing::ContainsRegex("waist_girth mm +900 +840 +-60 +[0-9]+ +changed"));
  EXPECT_THAT(text.out, testing::ContainsRegex("hip_girth mm +900 +900 +[+]0 +[0-9]+ +no change"));
}

TEST_F(CompareCommand, SaysWhyItIsWiderAndWhereTwoPeopleStood) {
  const std::string around = write("around", 900), front = write("front", 900, 1780, "front");
  const test::Run wider = compare({around, front});
  EXPECT_EQ(wider.exit_code, 0) << wider.err;
  EXPECT_THAT(wider.out, testing::HasSubstr("Wider intervals: views: around and front\n"));
  clothed_ = 0.93;
  const test::Run cloth = compare({around, write("clothed", 900)});
  EXPECT_EQ(cloth.exit_code, 0) << cloth.err;
  EXPECT_THAT(cloth.out, testing::HasSubstr("repeatability is not known for dressed people"));
  const test::Run two = compare({around, write("other", 700, 1690)});
  EXPECT_EQ(two.exit_code, 0) << two.err;
  EXPECT_THAT(two.out, testing::HasSubstr("Two people: "));
  EXPECT_THAT(two.out, testing::Not(testing::HasSubstr(" changed")));
}

TEST_F(CompareCommand, RefusesWhatIsNoCapture) {
  const std::string good = write("good", 900);
  const std::pair<std::string, std::string> table[] = {
      {write_text("nobody", R"({"schema":"im2fit.result/1","measurements":{}})"), "nobody was measured"},
      {write_text("session", R"({"schema":"im2fit.session/1"})"), "expected a result.json"},
      {write_text("cut", "{"), "not JSON"},
      {write_text("half", R"({"schema":"im2fit.result/1","measurements":{"stature":{"value":1700}}})"),
       "measurements/stature"},
      {write_text("none", R"({"schema":"im2fit.result/1","measurements":{"stature":{"value":null}}})"),
       "measurements/stature"},
      {folder_.path("missing"), "missing"}};
  for (const auto& [path, words] : table)
    for (const bool first : {true, false}) {
      const test::Run run = first ? compare({path, good}) : compare({good, path});
      EXPECT_EQ(run.exit_code, 1) << path;
      EXPECT_EQ(run.out, "") << path;
      EXPECT_TRUE(test::is_one_line_of(run.err, "im2fit")) << run.err;
      EXPECT_THAT(run.err, testing::HasSubstr(words));
    }
}

}  // namespace
}  // namespace im2fit
