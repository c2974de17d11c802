// SPDX-License-Identifier: Apache-2.0
// What the body seen in a depth picture (body/fit) says of the unknowns of a measurement fit, before any measurement
// is looked at: the least squares of distances between two skins, along the normals of the one seen, with people's
// covariance as prior. In numbers, with x = x0 + L z of body/fit/measurement_fit.h and the seen skin's distance r_i
// from that of x0,
//     z ~ N(m, P),   P = (I + sum w_i a_i a_i')^-1,   m = P sum w_i a_i r_i,   a_i = L' dp_i/dx n_i.
// So a fit that takes the least change from x0 + L m in the metric of P meets its goals, and follows what was seen in
// all that the goals leave open.
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
  // `prior`: of people round `from`; becomes what is known once `seen` was seen. Nothing is changed where the body
  // file has no shape space of its mesh.
  void see(const Params& from, const SeenBody& seen, FitPrior& prior);

 private:
  struct Work;
  std::unique_ptr<Work> work_;
};

}  // namespace im2fit::body
