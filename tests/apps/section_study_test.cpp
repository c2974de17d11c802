// SPDX-License-Identifier: Apache-2.0
// Girths from breadth and depth: perimeters known in closed form, and people made of them.
#include "lab/evaluation/section_study.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/rng.h"
#include "depth_folder.h"
#include "measure_run.h"
#include "well_formed.h"

namespace im2fit::lab {
namespace {

TEST(EllipseGirth, IsKnownForCircleLineAndTwoToOne) {
  EXPECT_NEAR(ellipse_girth_mm(300, 300), 300 * std::numbers::pi, 1e-9);
  EXPECT_NEAR(ellipse_girth_mm(300, 0), 600, 1e-9);
  // Half axes 2 and 1: 8 E(3/4) = 9.688448220547676 (Abramowitz and Stegun's table of E has 1.2110560275684594).
  EXPECT_NEAR(ellipse_girth_mm(4, 2), 9.688448220547676, 1e-11);
  EXPECT_NEAR(ellipse_girth_mm(2, 4), 9.688448220547676, 1e-11);
}

TEST(SuperellipseGirth, GoesFromDiamondOverEllipseToRectangle) {
  EXPECT_NEAR(superellipse_girth_mm(300, 400, 1), 2 * std::hypot(300, 400), 1e-9);
  EXPECT_NEAR(superellipse_girth_mm(340, 230, 2), ellipse_girth_mm(340, 230), 0.01);
  EXPECT_NEAR(superellipse_girth_mm(300, 200, 200), 1000, 5);
  EXPECT_LT(superellipse_girth_mm(340, 230, 2), superellipse_girth_mm(340, 230, 3));
}

// People whose girths are superellipses of exponent 2.6, women 8 mm more than that.
SectionPeople made_people() {
  SectionPeople people;
  for (std::size_t s = 0; s < 2; ++s)
    for (std::uint64_t i = 0; i < 200; ++i) {
      Rng rng = Rng::for_item(5, s, i);
      SectionPerson& p = people[s].emplace_back();
      p.stature_mm = rng.uniform(1500, 1900);
      p.weight_kg = rng.uniform(50, 100);
      for (std::size_t g = 0; g < kTrunkGirths; ++g) {
        p.breadth_mm[g] = rng.uniform(260, 400);
        p.depth_mm[g] = rng.uniform(180, 300);
        p.girth_mm[g] = superellipse_girth_mm(p.breadth_mm[g], p.depth_mm[g], 2.6) + (s == 0 ? 8 : 0);
      }
    }
  return people;
}

const ErrorStatistics& errors_of(const SectionStudy& study, SectionEstimator estimator, bool woman,
                                 TrunkGirth girth) {
  return study.errors[static_cast<std::size_t>(estimator)][woman ? 0 : 1][static_cast<std::size_t>(girth)];
}

TEST(SectionStudy, FindsTheShapeItsPeopleWereMadeOf) {
  const SectionPeople people = made_people();
  const SectionStudy study = study_sections(people, {}, 0);
  EXPECT_NEAR(study.exponent[1][0], 2.6, 0.01);
  EXPECT_LT(errors_of(study, SectionEstimator::superellipse, false, TrunkGirth::hip).mae, 0.2);
  EXPECT_LT(errors_of(study, SectionEstimator::ellipse, false, TrunkGirth::chest).bias, -20);
  EXPECT_EQ(errors_of(study, SectionEstimator::ellipse, false, TrunkGirth::chest).count, 200);
  EXPECT_NEAR(errors_of(study, SectionEstimator::scaled, false, TrunkGirth::chest).bias, 0, 0.5);
  EXPECT_LT(errors_of(study, SectionEstimator::quadratic, true, TrunkGirth::waist).mae, 0.3);
  EXPECT_EQ(errors_of(study, SectionEstimator::synthetic, true, TrunkGirth::waist).count, 0);
}

TEST(SectionStudy, WhatWasFittedToOthersKeepsTheirBias) {
  const SectionPeople people = made_people();
  // Men of the study estimated by women's fit: 8 mm too much.
  const SectionStudy study = study_sections({people[1], people[1]}, {people[0], people[1]}, 0);
  EXPECT_NEAR(errors_of(study, SectionEstimator::synthetic, true, TrunkGirth::chest).bias, 8, 0.3);
  EXPECT_NEAR(errors_of(study, SectionEstimator::synthetic, false, TrunkGirth::chest).bias, 0, 0.3);
}

TEST(SectionStudy, NoiseCostsWhatItAdds) {
  const SectionPeople people = made_people();
  const double quiet =
      errors_of(study_sections(people, {}, 0), SectionEstimator::quadratic, false, TrunkGirth::chest).sd;
  const double noisy =
      errors_of(study_sections(people, {}, 10), SectionEstimator::quadratic, false, TrunkGirth::chest).sd;
  EXPECT_LT(quiet, 1);
  // The girth grows by 1.5 to 1.9 mm with each mm of breadth and of depth.
  EXPECT_GT(noisy, 15);
  EXPECT_LT(noisy, 30);
}

TEST(SectionStudy, PictureIsWellFormed) {
  const SectionStudy study = study_sections(made_people(), {}, 0);
  EXPECT_EQ(test::xml_fault(picture_of(study).file()), "");
}

TEST(Ellipse, ReportsWhatIsMissing) {
  const test::TestFolder folder;
  const test::Run run = test::run_program({test::kLab, "ellipse", "--ansur", folder.path()});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_EQ(run.out, "");
  EXPECT_TRUE(test::is_one_line_of(run.err, "im2fit-lab")) << run.err;
  EXPECT_NE(run.err.find("ANSUR_II_FEMALE_Public.csv"), std::string::npos);
}

TEST(Ellipse, ReadsTheSurveysColumns) {
  const test::TestFolder folder;
  for (const char* name : {"ANSUR_II_MALE_Public.csv", "ANSUR_II_FEMALE_Public.csv"}) {
    std::ofstream file(folder.path(name));
    file << "subjectid,Weightkg,stature,hipbreadth,buttockdepth,buttockcircumference,chestbreadth,chestdepth,"
            "chestcircumference,waistbreadth,waistdepth,waistcircumference\r\n";
    for (int i = 0; i < 120; ++i) {
      const int breadth = 300 + i, depth = 250 + 7 * (i % 11);
      const auto girth = std::lround(ellipse_girth_mm(breadth, depth)) + 5;
      file << i << ",800," << 1700 + i % 13;
      for (int g = 0; g < 3; ++g) file << ',' << breadth << ',' << depth << ',' << girth;
      file << "\r\n";
    }
  }
  const test::Run run = test::run_program(
      {test::kLab, "ellipse", "--ansur", folder.path(), "--synthetic", "0", "--noise", "0", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto json = nlohmann::json::parse(run.out, nullptr, false);
  ASSERT_TRUE(json.is_object());
  const auto& plain = json.at("men").at("hip").at("estimators").at("ellipse (paper)");
  EXPECT_EQ(plain.at("people"), 120);
  EXPECT_NEAR(plain.at("bias").get<double>(), -5, 0.1);
}

}  // namespace
}  // namespace im2fit::lab
