// SPDX-License-Identifier: Apache-2.0
// All dimensions of synthetic people beside ANSUR II's, at equal stature, weight and age: the residuals of a
// dimension after ANSUR II's own regression on them must have the same mean, spread and correlations here.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/status.h"
#include "train/population/population.h"
#include "train/population/proportions.h"

namespace im2fit::lab {

// A calliper presses tissue: breadths and depths of hulls are this much larger than ANSUR II's at the same girth. In
// ANSUR II a tape round the waist is 1.057 times the ellipse of its breadth and depth, round the hips 1.093; on
// people here 1.02 and 1.03 (train/population/proportions.cpp, squareness). The tape is trusted, as shops use it, and
// the ratio of breadth to depth, in which a common factor cancels.
inline constexpr double kWaistOverCalliper = 1.037, kHipOverCalliper = 1.060;

// ANSUR II's column of a dimension, and what its values times are a mesh's.
struct AnsurColumn {
  std::string_view name;
  double mesh_factor = 1;
};
const AnsurColumn& ansur_column(body::Dimension dimension);

struct ProportionTolerances {
  double mean_sd = 0.15;       // of a mean, in ANSUR II's standard deviations of the dimension
  double spread = 0.10;        // of the residual standard deviation, relative
  double ratio_mean_sd = 0.2;  // of breadth over depth, in residual standard deviations
  double ratio_spread = 0.15;
  double correlation = 0.15;  // of a residual correlation
};

struct DimensionComparison {
  std::string name;
  double mean_mm = 0, ansur_mean_mm = 0;
  double residual_mean = 0;               // in ANSUR II's standard deviations of the dimension
  std::vector<double> residual_by_third;  // the same, by third of the body mass index
  double spread = 1;                      // residual standard deviation over ANSUR II's
};
struct ProportionComparison {
  struct Sex {
    bool woman = false;
    std::vector<DimensionComparison> dimensions, ratios;
    double correlation_rms = 0, correlation_most = 0;  // difference of residual correlations
    std::string correlation_most_of;
  };
  std::vector<Sex> sexes;           // women, men
  std::vector<std::string> broken;  // tolerances
};

// `dimensions`: of each subject. Errors name the file and the column.
Result<ProportionComparison> compare_proportions(const std::vector<Subject>& subjects,
                                                 const std::vector<body::Dimensions>& dimensions,
                                                 const std::string& ansur_folder,
                                                 const ProportionTolerances& tolerances = {});
std::string text_of(const ProportionComparison& comparison);
// Mean residual of each dimension with its thirds, and its spread.
std::string plot_of(const ProportionComparison& comparison);

}  // namespace im2fit::lab
