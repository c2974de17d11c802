// SPDX-License-Identifier: Apache-2.0
// From the breadth and depth of a section to its girth by tape: the paper's ellipse and what could take its
// place, on real people (ANSUR II), whose breadths, depths and girths were all measured by hand.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "body/model.h"
#include "lab/evaluation/ansur.h"
#include "lab/evaluation/error_statistics.h"
#include "lab/report/svg_plot.h"

namespace im2fit::lab {

// Perimeters, mm, of breadth x depth. The ellipse by the arithmetic-geometric mean, to rounding; the superellipse
// |x/a|^n + |y/b|^n = 1 as a polygon of 4 x 256 corners (to 1e-5 for n of 1.5 to 8).
double ellipse_girth_mm(double breadth_mm, double depth_mm);
double superellipse_girth_mm(double breadth_mm, double depth_mm, double exponent);

enum class TrunkGirth : int { chest, waist, hip };
inline constexpr std::size_t kTrunkGirths = 3;
inline constexpr std::array<std::string_view, kTrunkGirths> kTrunkGirthNames = {"chest", "waist", "hip"};

struct SectionPerson {
  double stature_mm = 0, weight_kg = 0;
  std::array<double, kTrunkGirths> breadth_mm{}, depth_mm{}, girth_mm{};
};
using SectionPeople = std::array<std::vector<SectionPerson>, 2>;  // women, men

// Errors: those of read_ansur_columns.
Result<SectionPeople> read_section_people(const std::string& ansur_folder);
// People of the index' family, sections of their meshes in the relaxed pose.
SectionPeople synthetic_section_people(const body::BodyModel& model, int count, int threads);

// Estimators of a girth from a section, all but the first and `synthetic` fitted to nine tenths of the people and
// tested on the tenth, sex by sex.
enum class SectionEstimator : int {
  ellipse,       // as the paper does
  scaled,        // ellipse times a factor
  superellipse,  // one exponent
  quadratic,     // of breadth and depth
  synthetic,     // the same fitted to synthetic people: no real one had a part in it
  front,         // linear in all three breadths and stature: what one view shows
  all_round,     // with the three depths
  all_weighed,   // with the weight from a scale
};
inline constexpr std::size_t kSectionEstimatorCount = 8;
inline constexpr std::array<std::string_view, kSectionEstimatorCount> kSectionEstimatorNames = {
    "ellipse (paper)",           "ellipse x factor",     "superellipse", "quadratic",
    "quadratic, from synthetic", "breadths and stature", "and depths",   "and weight"};

struct SectionStudy {
  // By estimator, sex (women first) and girth; count 0: not tested.
  std::array<std::array<std::array<ErrorStatistics, kTrunkGirths>, 2>, kSectionEstimatorCount> errors;
  std::array<std::array<double, kTrunkGirths>, 2> factor{}, exponent{};  // fitted to all people
};
inline constexpr double kBreadthNoiseMm = 4;  // of every breadth and depth, as a sensor would add
// `synthetic`: may be empty. `noise_mm`: SD added to breadths and depths; seeded.
SectionStudy study_sections(const SectionPeople& people, const SectionPeople& synthetic, double noise_mm);

std::string text_of(const SectionStudy& study);
std::string json_of(const SectionStudy& study, double noise_mm);
Svg picture_of(const SectionStudy& study);

}  // namespace im2fit::lab
