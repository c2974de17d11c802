// SPDX-License-Identifier: Apache-2.0
// What is worked out of a measured body: volume, surface, ratios, body fat.
#include <algorithm>
#include <cmath>

#include "measure_run.h"
#include "person/body_figures.h"
#include "person/builtin_tape.h"
#include "tests/engine/schema.h"
#include "train/population/population.h"

namespace im2fit {
namespace {

constexpr double kMmPerInch = 25.4;

// The same equations as the U.S. Department of Defense prints them, for inches and whole percents (instruction
// 1308.3): another set of coefficients.
double printed_fat(bool woman, double girths_in, double stature_in) {
  return woman ? 163.205 * std::log10(girths_in) - 97.684 * std::log10(stature_in) - 78.387
               : 86.010 * std::log10(girths_in) - 70.041 * std::log10(stature_in) + 36.76;
}

TEST(NavyFat, IsThatOfThePrintedTables) {
  for (const double stature : {62.0, 68.0, 74.0})
    for (const double girths : {14.0, 18.0, 22.0})
      EXPECT_NEAR(navy_fat_percent(false, girths * kMmPerInch, stature * kMmPerInch),
                  printed_fat(false, girths, stature), 1)
          << girths << ' ' << stature;
  for (const double stature : {60.0, 65.0, 70.0})
    for (const double girths : {45.0, 55.0, 65.0})
      EXPECT_NEAR(navy_fat_percent(true, girths * kMmPerInch, stature * kMmPerInch),
                  printed_fat(true, girths, stature), 1)
          << girths << ' ' << stature;
  EXPECT_TRUE(std::isnan(navy_fat_percent(false, 0, 1800)));
  EXPECT_TRUE(std::isnan(navy_fat_percent(false, -20, 1800)));
}

class Figures : public testing::Test {
 protected:
  void SetUp() override {
    IM2FIT_NEED_DATA();
    auto model = body::BodyModel::load(test::body_path());
    ASSERT_TRUE(model) << model.error().message;
    model_.emplace(std::move(*model));
  }
  // A measured man or woman: values of the mesh, intervals of some percents to either side.
  void stand(float gender, float percent = 2) {
    body_.params = {};
    body_.params.gender = gender;
    body::TapeMeasurer tape(*model_);
    values_.resize(builtin_tape().definitions.size());
    tape.measure(builtin_tape(), body_.params, values_);
    const MeasurementValues measured = body::measure_person(*model_, body_.params);
    const float share = percent / 100;
    for (std::size_t i = 0; i < kMeasurementCount; ++i)
      answer_.measurements[i] = {measured[i], measured[i] * (1 - share), measured[i] * (1 + share)};
    answer_.female = 1 - gender;
    intervals_ = tape_intervals(builtin_tape(), values_, answer_);
  }
  BodyFigures figures() const { return body_figures(answer_, body_, *model_, &builtin_tape(), values_, intervals_); }
  float measured(Measurement m) const { return answer_.measurements[measurement_index(m)].value; }
  float taped(const char* id) const {
    return values_[static_cast<std::size_t>(definition_index(builtin_tape(), id))];
  }

  std::optional<body::BodyModel> model_;
  AnsweredBody body_;
  index::Answer answer_{};
  std::vector<float> values_;
  std::vector<TapeInterval> intervals_;
};

TEST_F(Figures, AreThoseOfTheBody) {
  for (const float gender : {0.0F, 1.0F}) {
    stand(gender);
    const BodyFigures f = figures();
    const float metres = measured(Measurement::stature) / 1000, kg = measured(Measurement::weight);
    EXPECT_NEAR(f.body_mass_index.value, kg / (metres * metres), 0.01F);
    EXPECT_NEAR(f.waist_to_hip.value, measured(Measurement::waist_girth) / measured(Measurement::hip_girth), 1e-4F);
    EXPECT_NEAR(f.waist_to_height.value, measured(Measurement::waist_girth) / measured(Measurement::stature), 1e-4F);
    // A body floats, hardly.
    EXPECT_NEAR(kg / f.volume_l.value, 1.01F, 0.02F);
    // Du Bois 1916: m^2 of kg and cm.
    const float du_bois = 0.007184F * std::pow(kg, 0.425F) * std::pow(metres * 100, 0.725F);
    EXPECT_NEAR(f.surface_area_m2.value, du_bois, 0.06F * du_bois);
    for (const auto& e : {f.volume_l, f.surface_area_m2, f.waist_to_hip, f.waist_to_height, f.body_mass_index}) {
      EXPECT_LT(e.low, e.value);
      EXPECT_GT(e.high, e.value);
    }
    // 2 % of each: of a ratio the root of the sum of squares, of a square twice.
    EXPECT_NEAR(f.waist_to_hip.high / f.waist_to_hip.value, 1 + 0.02F * std::sqrt(2.0F), 1e-3F);
    EXPECT_NEAR(f.body_mass_index.low / f.body_mass_index.value, 1 - 0.02F * std::sqrt(5.0F), 1e-3F);
  }
}

TEST_F(Figures, FatIsThatOfTheGirthsOfEachSexWithTheErrorOfItsEquation) {
  stand(1);
  const auto man = figures().fat;
  ASSERT_TRUE(man);
  EXPECT_FALSE(man->woman);
  const auto fat = [](bool woman, float girths, float stature) {
    return static_cast<float>(navy_fat_percent(woman, static_cast<double>(girths), static_cast<double>(stature)));
  };
  EXPECT_NEAR(man->percent.value,
              fat(false, taped("navel_girth") - measured(Measurement::neck_girth), measured(Measurement::stature)),
              0.01F);
  stand(0);
  const auto woman = figures().fat;
  ASSERT_TRUE(woman);
  EXPECT_TRUE(woman->woman);
  const float girths =
      taped("natural_waist_girth") + measured(Measurement::hip_girth) - measured(Measurement::neck_girth);
  EXPECT_NEAR(woman->percent.value, fat(true, girths, measured(Measurement::stature)), 0.01F);
  EXPECT_EQ(woman->standard_error, kNavyErrorWomen);
  EXPECT_GE(woman->percent.high - woman->percent.value, 1.96F * kNavyErrorWomen);
  // Girths that are less sure widen it.
  stand(0, 5);
  EXPECT_GT(figures().fat->percent.high - figures().fat->percent.value, woman->percent.high - woman->percent.value);
}

TEST_F(Figures, FatIsLeftOutWhereTheSexIsNotSureOrThereIsNoTape) {
  stand(1);
  answer_.female = 0.2F;
  EXPECT_FALSE(figures().fat);
  answer_.female = 0.8F;
  EXPECT_FALSE(figures().fat);
  answer_.female = 0.02F;
  EXPECT_TRUE(figures().fat);
  EXPECT_FALSE(body_figures(answer_, body_, *model_, nullptr, {}, {}).fat);
}

TEST(ShoulderTilt, IsThatOfTheLineThroughBothAgainstTheFloor) {
  JointSet joints;
  joints.confidence.fill(0.9F);
  joints[Joint::LS] = {180, -420, 2000};  // y is down
  joints[Joint::RS] = {-180, -400, 2050};
  const FloorPlane floor = {true, {0, -1, 0}, 1000};
  const auto tilt = shoulder_tilt_deg(joints, floor);
  ASSERT_TRUE(tilt);
  EXPECT_NEAR(tilt->value, std::atan2(20.0F, std::hypot(360.0F, 50.0F)) * 57.29578F, 1e-3F);
  EXPECT_FLOAT_EQ(tilt->high - tilt->value, kShoulderTiltErrorDeg);
  // A camera on its side by as much sees none.
  const float angle = std::atan2(20.0F, 360.0F);
  joints[Joint::RS].z = 2000;
  EXPECT_NEAR(shoulder_tilt_deg(joints, {true, {-std::sin(angle), -std::cos(angle), 0}, 1000})->value, 0, 0.01F);
  EXPECT_FALSE(shoulder_tilt_deg(joints, {false, {0, -1, 0}, 1000}));
  joints.confidence[static_cast<std::size_t>(Joint::RS)] = 0.1F;
  EXPECT_FALSE(shoulder_tilt_deg(joints, floor));
}

// The surface that is not of stature, weight and girths.
TEST_F(Figures, OfABodyWithTheRightMeasurementsTheSurfaceIsRight) {
  body::MeasurementFitter fitter(*model_);
  double squares = 0;
  constexpr int kPeople = 16;
  for (std::uint64_t i = 0; i < kPeople; ++i) {
    std::vector<Vec3f> rest(static_cast<std::size_t>(model_->vertex_count()));
    const lab::Subject subject = lab::draw_subject(*model_, lab::Family::held_out, 12, i, rest);
    const double truth = surface_area_m2(*model_, rest);
    body::MeasurementGoals goals;
    for (std::size_t m = 0; m < kMeasurementCount; ++m) goals[m] = {subject.truth[m], 1};
    body::Params params;
    params.gender = subject.woman ? 0 : 1;
    fitter.run(params, goals);
    model_->morph(params, rest);
    const double off = surface_area_m2(*model_, rest) / truth - 1;
    squares += off * off;
  }
  EXPECT_LT(2 * std::sqrt(squares / kPeople), kSurfaceShapeShare);
  EXPECT_GT(2 * std::sqrt(squares / kPeople), 0.3 * kSurfaceShapeShare);
}

TEST(Result, OfTheProgramHasFiguresAndSaysWhatMadeIt) {
  IM2FIT_NEED_DATA();
  const test::TestFolder folder;
  const test::Run run = test::measure("synthetic:7", folder.path("out"), {"--only", "result", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto result = nlohmann::json::parse(run.out, nullptr, false);
  const auto schema = nlohmann::json::parse(test::read_text(IM2FIT_DATA "/../docs/result.schema.json"));
  EXPECT_THAT(test::SchemaCheck(schema).run(result), testing::IsEmpty());
  ASSERT_TRUE(result.contains("figures") && result.contains("made_by"));
  EXPECT_EQ(result["made_by"]["index"].get<std::string>().size(), 8U);
  EXPECT_NE(result["made_by"]["index"], "00000000");
  const auto value = [&](const char* kind, const char* id) { return result[kind][id]["value"].get<double>(); };
  EXPECT_NEAR(value("figures", "waist_to_hip"),
              value("measurements", "waist_girth") / value("measurements", "hip_girth"), 0.001);
  const auto& fat = result["figures"]["body_fat"];
  EXPECT_EQ(fat["method"], "U.S. Navy");
  EXPECT_GT(fat["value"].get<double>(), 2);
  EXPECT_LT(fat["value"].get<double>(), 60);
}

}  // namespace
}  // namespace im2fit
