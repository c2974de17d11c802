// SPDX-License-Identifier: Apache-2.0
// The prior that the body seen in a depth picture (body/fit) gives for the unknowns of a measurement fit, before any
// measurement is used: the least squares of distances between two skins, along the normals of the seen one, with
// people's covariance as prior. With x = x0 + L z of body/fit/measurement_fit.h and the distance r_i of the seen skin
// from the skin of x0,
//     z ~ N(m, P),   P = (I + sum w_i a_i a_i')^-1,   m = P sum w_i a_i r_i,   a_i = L' dp_i/dx n_i.
// So a fit that takes the least change from x0 + L m in the metric of P meets its goals, and follows the seen skin in
// everything the goals leave open.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "body/fit/shape_fitter.h"
#include "body/model.h"

namespace im2fit::body {

struct FitPrior;  // body/fit/measurement_fit.h

// + - * / and sqrt only; no allocation after construction. Not shareable between threads; the model must outlive it.
class SeenPrior {
 public:
  explicit SeenPrior(const BodyModel& model);
  SeenPrior(SeenPrior&&) noexcept;
  SeenPrior& operator=(SeenPrior&&) noexcept;
  ~SeenPrior();
  // `prior`: on input that of people round `from`, on output the posterior given `seen`. Unchanged if the body file
  // has no shape space of its mesh. `sd_mm`: of a point's distance.
  void see(const Params& from, const SeenBody& seen, double sd_mm, FitPrior& prior);

 private:
  struct Work;
  std::unique_ptr<Work> work_;
};

}  // namespace im2fit::body
