// SPDX-License-Identifier: Apache-2.0
// Takes the details off a mesh, so that bodies of the same dimensions do not share a surface.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "body/model.h"

namespace im2fit::lab {

// Moves each vertex towards the mean of its neighbours and a little farther back, again and again (Taubin 1995):
// details go, girths and volumes nearly stay. Hands and feet stay, heads take a part. Shareable between threads.
class SurfaceSmoother {
 public:
  explicit SurfaceSmoother(const body::BodyModel& model);
  // `rest`: all vertices of the model; helpers stay. 100 passes flatten shapes narrower than some 60 mm.
  void run(std::span<Vec3f> rest, int passes) const;

 private:
  std::vector<std::int32_t> first_, neighbours_;  // of vertex v: neighbours_[first_[v]] up to first_[v + 1]
  std::vector<float> share_;                      // of the way to the neighbours' mean
};

}  // namespace im2fit::lab
