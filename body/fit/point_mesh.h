// SPDX-License-Identifier: Apache-2.0
// The whole mesh of a body of which the points of the shape space are known: the model's mesh of some parameters,
// moved so that its skin passes through the points. Between points the move is smooth; hands, eyes and helpers go
// with the nearest points.
#pragma once

#include <span>
#include <vector>

#include "body/fit/shape_points.h"
#include "body/model.h"
#include "body/skeleton.h"

namespace im2fit::body {

// Not shareable between threads; the model must outlive it. No allocation after construction.
class PointMesh {
 public:
  // Of a model with a shape space of its own mesh. Without one valid() is false and run() changes nothing.
  explicit PointMesh(const BodyModel& model);
  bool valid() const { return !quads_.empty(); }
  // `points`: of the shape space, at rest; `bones`: at rest. `mesh`: on input the rest mesh of parameters near the
  // person's, on output the person's; all of the model's vertices.
  void run(std::span<const Vec3f> points, const Skeleton& bones, std::span<Vec3f> mesh);

 private:
  static constexpr std::size_t kEach = 6;
  struct Pull {
    std::uint32_t point = 0;
    float weight = 0;
  };
  const BodyModel& model_;
  std::vector<Quad> quads_;
  std::vector<Pull> pulls_;  // vertex x kEach; weights sum to 1
  std::vector<Vec3f> off_;   // of each point
};

}  // namespace im2fit::body
