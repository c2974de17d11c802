// SPDX-License-Identifier: Apache-2.0
// Smooth deformations of one mesh by least energy: an embedded deformation graph (Sumner, Schmid, Pauly 2007) of
// nodes on the skin, each an affine map, that costs energy where neighbouring maps differ. It knows nothing of
// sliders nor of sections: what pulls is a linear row on vertices, and its response is the whole body's least-energy
// answer.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "body/model.h"
#include "core/vec3.h"

namespace im2fit::lab {

// One vertex in a linear row.
struct Pull {
  std::int32_t vertex = 0;
  Vec3f gradient;  // of the row's value, per mm
};
using PullRow = std::vector<Pull>;

class DeformationGraph {
 public:
  // `rest`: all vertices of the model. Helpers (joints, tights, skirt) follow the skin around them.
  DeformationGraph(const body::BodyModel& model, std::span<const Vec3f> rest);
  // A closed surface without helpers, all of one part. `first`: the vertex of the first node.
  DeformationGraph(std::span<const std::array<std::int32_t, 3>> triangles, std::span<const Vec3f> rest,
                   std::int32_t first);
  DeformationGraph(DeformationGraph&&) noexcept;
  ~DeformationGraph();

  // Displacements of all vertices by which the energy grows least while the row's value grows, scaled to an energy of
  // one; an empty row has none.
  std::vector<Vec3f> response(const PullRow& row);
  // The energy's inner product of the responses i and j of this object, in the order of the calls of response().
  double product(std::size_t i, std::size_t j) const;

  int node_count() const;
  // Moves helpers by the displacement of the skin around them.
  void carry_helpers(std::span<Vec3f> displacement) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace im2fit::lab
