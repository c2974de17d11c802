// SPDX-License-Identifier: Apache-2.0
// The synthetic population beside real people: ANSUR II (US Army 2012, measured) and NHANES (US adults).
//
// NHANES is what stature and weight are drawn from, so those are compared as they are. ANSUR II's soldiers are leaner
// than the country: girths are compared at equal stature and weight, each synthetic person weighing in by how much
// more often such a stature and weight is met among soldiers than here (ratio of two normal densities in stature and
// the logarithm of weight).
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "core/status.h"
#include "train/population/population.h"
#include "train/population/proportions.h"

namespace im2fit::lab {

inline constexpr std::size_t kComparedCount = 5;
struct Compared {
  std::string_view name, unit;
  std::string_view ansur;  // column
  double ansur_unit;       // of a column's value
};
inline constexpr std::array<Compared, kComparedCount> kCompared = {{
    {"stature", "mm", "stature", 1},
    {"weight", "kg", "weightkg", 0.1},
    {"chest", "mm", "chestcircumference", 1},
    {"waist", "mm", "waistcircumference", 1},  // at the navel, unlike waist_girth
    {"hip", "mm", "buttockcircumference", 1},
}};
using ComparedRow = std::array<double, kComparedCount>;

struct PeopleMoments {
  double people = 0;  // with weights: Kish's effective number
  ComparedRow mean{}, sd{};
  std::array<ComparedRow, kComparedCount> correlation{};
};
// `weights`: one a row, or none.
PeopleMoments moments_of(const std::vector<ComparedRow>& rows, const std::vector<double>& weights);

// ANSUR_II_FEMALE_Public.csv or ANSUR_II_MALE_Public.csv of the folder. Errors name the file and the column.
Result<std::vector<ComparedRow>> read_ansur(const std::string& folder, bool woman);

// What the program promises of its population; the reasons are in docs/dataset.md.
struct PopulationTolerances {
  double nhanes_stature_mm = 10, nhanes_weight_kg = 3;  // of a mean
  double nhanes_sd = 0.10;                              // relative
  double ansur_mean = 0.025, ansur_sd = 0.15;           // relative
  double ansur_correlation = 0.15;
};

struct PopulationComparison {
  struct Sex {
    bool woman = false;
    std::vector<ComparedRow> rows, ansur_rows;
    std::vector<double> weights;  // of rows
    PeopleMoments drawn, like_ansur, ansur;
  };
  std::array<Sex, 2> sexes;         // women, men
  std::vector<std::string> broken;  // tolerances, a line each
};
// `dimensions`: of each subject.
Result<PopulationComparison> compare_population(const std::vector<Subject>& subjects,
                                                const std::vector<body::Dimensions>& dimensions,
                                                const std::string& ansur_folder,
                                                const PopulationTolerances& tolerances = {});
std::string text_of(const PopulationComparison& comparison);
// Weight against stature and girths against weight, by sex: synthetic people as dots, both populations' ellipses of
// one and two standard deviations, at equal stature and weight.
Result<std::vector<std::byte>> plot_of(const PopulationComparison& comparison);

}  // namespace im2fit::lab
