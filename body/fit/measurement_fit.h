// SPDX-License-Identifier: Apache-2.0
// One body for one answer: parameters whose mesh measures what was reported (docs/one-body.md).
//
// From the body of a similar person, the smallest change that meets the reported values: Gauss-Newton whose unknowns
// are stature, build and the warp (body/warp.h), whitened by how these go together in people, so that the length of
// the change is a Mahalanobis distance. Only body/measure.h measures the mesh.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <string_view>

#include "body/fit/shape_fitter.h"
#include "body/measure.h"
#include "body/model.h"
#include "core/measurement.h"

namespace im2fit::body {

// A target value of the mesh and its standard deviation, in its unit. Not finite: any value will do.
struct MeasurementGoal {
  float value = 0;
  float sd = 0;
};
using MeasurementGoals = std::array<MeasurementGoal, kMeasurementCount>;

struct MeasurementFit {
  MeasurementValues values{};    // of the fitted mesh
  MeasurementValues residual{};  // values less goals; 0 without a goal
  float distance = 0;            // of the change, in standard deviations of people
  int steps = 0;
};

// A girth residual above this is reported to the user: half of what ISO 20685-1 allows a body scanner for small
// girths. For 400 people measured on 2026-11-26 none was reported, nor would be at 1.6 mm or 2.4 mm: the worst girth
// was 0.2 mm off.
inline constexpr float kResidualToldMm = 2;
// The largest of the girths' absolute residuals, mm.
float girth_residual_mm(const MeasurementValues& residual);

// + - * / and sqrt only: the same bits on every machine. No allocation after construction, but for `params` whose
// list of modifiers is short. Not shareable between threads; the model must outlive it. A few hundredths of a second.
class MeasurementFitter {
 public:
  explicit MeasurementFitter(const BodyModel& model);
  MeasurementFitter(MeasurementFitter&&) noexcept;
  MeasurementFitter& operator=(MeasurementFitter&&) noexcept;
  ~MeasurementFitter();
  // `params`: start of the search, and its result: the best compromise when no body meets all goals. They stay within
  // the limits of bodies.
  // `seen`: the body fitted to depth pictures, which the skin follows where the goals leave it free; null: none.
  MeasurementFit run(Params& params, const MeasurementGoals& goals, const SeenBody* seen = nullptr);
  // Holds the body that was found, measured.
  const Measurer& measured() const;
  const BodyModel& model() const;

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

// The unknowns: height slider, build (the weight slider, fatness beyond its end, slimness below), the warp, and the
// modifier that says how far the crotch lies below the hip joints.
inline constexpr std::size_t kFitParameterCount = 2 + kWarpCount + 1;
inline constexpr std::size_t kCrotchParameter = 2 + kWarpCount;
inline constexpr std::string_view kCrotchModifier = "hip/hip-scale-vert";
using FitParameters = std::array<double, kFitParameterCount>;
// `from` changed by `change`, limited to what bodies are; `out` may not be `from`.
void change_body(const BodyModel& model, const Params& from, const FitParameters& change, Params& out);

// Prior of the unknowns, before the goals are used: their change is centre + factor z, z of unit variance.
struct FitPrior {
  FitParameters centre{};
  std::array<FitParameters, kFitParameterCount> factor{};  // its lower triangle
};

// Statistics of bodies in general, one set for each sex; made by im2fit-lab make measurement-regression.
struct MeasurementRegression {
  // Relative change of each measurement by each unknown: the mean of people.
  std::array<std::array<float, kFitParameterCount>, kMeasurementCount> slopes;
  // The Cholesky factor of the unknowns' covariance, rows of its lower triangle.
  std::array<float, kFitParameterCount*(kFitParameterCount + 1) / 2> spread;
};
const MeasurementRegression& measurement_regression(bool woman);

}  // namespace im2fit::body
