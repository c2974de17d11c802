// SPDX-License-Identifier: Apache-2.0
// im2fit-lab make measurement-regression BODY.i2b > body/fit/measurement_regression.inc
// How measurements follow the unknowns of body/fit/measurement_fit.h, and how those go together in people of ANSUR
// II's proportions. A minute.
#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cstdio>
#include <string_view>

#include "apps/im2fit-lab/make/make.h"
#include "body/fatness.h"
#include "body/fit/measurement_fit.h"
#include "body/measure.h"
#include "train/population/drawn_people.h"
#include "train/population/shape_spread.h"
#include "train/population/solve.h"

namespace {

using namespace im2fit;
using namespace im2fit::body;

// Of the crotch below the hip joints, which the proportions do not vary: 4 mm.
constexpr double kCrotchSd = 0.15;
constexpr int kSpreadPeople = 1500, kSlopePeople = 60;
constexpr auto kCount = static_cast<Eigen::Index>(kFitParameterCount);

// A person with nothing but stature, weight, age and sex to tell them from others, and measured people's proportions.
bool draw(const BodyModel& model, bool woman, std::uint64_t number, Params& p) {
  Rng rng = Rng::for_item(0x6C6177, woman ? 1 : 0, number);
  const Build build = draw_build(Family::training, woman, rng.next());
  const double metres = build.stature_mm / 1000, mass_index = build.weight_kg / (metres * metres);
  p = {};
  p.gender = woman ? 0.025F : 0.975F;
  p.age_years = static_cast<float>(build.age_years);
  p.race = {0.24F, 0.19F, 0.57F};
  p.muscle = static_cast<float>(std::clamp((woman ? 0.42 : 0.48) - 0.025 * (mass_index - 24), 0.05, 0.9));
  p.proportions = p.firmness = 0.55F;
  p.modifiers.assign(model.modifier_names().size(), 0.0F);
  for (const ModifierSpread& row : modifier_spreads())
    if (const int index = model.modifier_index(row.name); index >= 0)
      p.modifiers[static_cast<std::size_t>(index)] = woman ? row.woman_mean : row.man_mean;
  if (!solve_stature_and_weight(model, p, build.stature_mm, build.weight_kg)) return false;
  std::vector<Vec3f> rest(static_cast<std::size_t>(model.vertex_count()));
  model.morph(p, rest);
  p.warp = draw_warp(model, woman, build, rng, rest);
  return true;
}

Eigen::VectorXd unknowns_of(const BodyModel& model, const Params& p) {
  Eigen::VectorXd x(kCount);
  // Of the fatness set a modifier that has no mean of its own.
  const auto pregnant = static_cast<std::size_t>(model.modifier_index("stomach/stomach-pregnant"));
  x[0] = static_cast<double>(p.height);
  x[1] = static_cast<double>(p.weight + p.modifiers[pregnant] / 0.3F);
  for (std::size_t i = 0; i < kWarpCount; ++i)
    x[static_cast<Eigen::Index>(2 + i)] = static_cast<double>(p.warp.values[i]);
  x[static_cast<Eigen::Index>(kCrotchParameter)] = 0;
  return x;
}

void add_slopes(const BodyModel& model, const Params& p, Eigen::MatrixXd& slopes) {
  Measurer measurer(model);
  Params moved;
  const MeasurementValues own = measurer.measure(p);
  for (std::size_t i = 0; i < kFitParameterCount; ++i) {
    const bool rise = i >= 2 && i <= 2 + static_cast<std::size_t>(WarpValue::head_rise);
    const double step = rise ? 0.004 : 0.02;
    std::array<MeasurementValues, 2> at{};
    for (const std::size_t side : {0U, 1U}) {
      FitParameters change{};
      change[i] = side == 0 ? -step : step;
      change_body(model, p, change, moved);
      at[side] = measurer.measure(moved);
    }
    for (std::size_t r = 0; r < kMeasurementCount; ++r)
      slopes(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(i)) +=
          static_cast<double>(at[1][r] - at[0][r]) / (2 * step * static_cast<double>(own[r]));
  }
}

void print_regression(const BodyModel& model, bool woman) {
  Eigen::MatrixXd slopes = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(kMeasurementCount), kCount);
  Eigen::MatrixXd squares = Eigen::MatrixXd::Zero(kCount, kCount);
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(kCount);
  int people = 0;
  Params p;
  for (std::uint64_t number = 0; people < kSpreadPeople; ++number) {
    if (!draw(model, woman, number, p)) continue;
    const Eigen::VectorXd x = unknowns_of(model, p);
    sum += x;
    squares += x * x.transpose();
    if (people++ < kSlopePeople) add_slopes(model, p, slopes);
  }
  slopes /= kSlopePeople;
  const Eigen::VectorXd mean = sum / people;
  Eigen::MatrixXd covariance = squares / people - mean * mean.transpose();
  for (Eigen::Index i = 0; i < kCount; ++i) covariance(i, i) = covariance(i, i) * 1.01 + 1e-8;
  covariance(kCount - 1, kCount - 1) = kCrotchSd * kCrotchSd;
  const Eigen::MatrixXd factor = covariance.llt().matrixL();
  std::printf("// %s: %d people, slopes of %d. A measurement a row; then the factor, an unknown a row.\n{{{\n",
              woman ? "Women" : "Men", people, kSlopePeople);
  for (Eigen::Index r = 0; r < slopes.rows(); ++r) {
    std::printf("    {");
    for (Eigen::Index i = 0; i < kCount; ++i) std::printf("%s%.4fF", i > 0 ? ", " : "", slopes(r, i));
    std::printf("},  // %s\n", std::string(kMeasurementTable[static_cast<std::size_t>(r)].id).c_str());
  }
  std::printf("}},\n{\n");
  for (Eigen::Index i = 0; i < kCount; ++i) {
    std::printf("   ");
    for (Eigen::Index j = 0; j <= i; ++j) std::printf(" %.5fF,", factor(i, j));
    std::printf("\n");
  }
  std::printf("}},\n");
}

}  // namespace

namespace im2fit::apps {

int make_measurement_regression(int argc, char** argv) {
  if (argc != 2 || std::string_view(argv[1]) == "--help") {
    std::fprintf(stderr, "im2fit-lab make measurement-regression BODY.i2b > body/fit/measurement_regression.inc\n");
    return 2;
  }
  const auto model = BodyModel::load(argv[1]);
  if (!model) {
    std::fprintf(stderr, "%s\n", model.error().message.c_str());
    return 1;
  }
  std::printf(
      "// SPDX-License-Identifier: Apache-2.0\n// Made by im2fit-lab make measurement-regression "
      "(train/population).\n");
  std::printf("// clang-format off\n");
  for (const bool woman : {true, false}) print_regression(*model, woman);
  return 0;
}

}  // namespace im2fit::apps
