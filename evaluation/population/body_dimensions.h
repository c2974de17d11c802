// SPDX-License-Identifier: Apache-2.0
// The dimensions a survey takes, on a rest mesh, with how each grows as vertices move: a solver needs them to make a
// body of given dimensions. Apart from train/population/proportions.h on purpose, which makes training people:
// judging shares no tape with training. The truth of an evaluation is measured by neither but by body/measure.h.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "body/model.h"
#include "evaluation/population/deformation_graph.h"

namespace im2fit::lab {

enum class SurveyDimension : int {
  stature,
  cervicale_height,
  acromial_height,
  chest_height,  // of the nipples
  waist_height,  // of the navel
  buttock_height,
  crotch_height,
  trochanter_height,  // of the hip joint
  knee_height,        // of the knee joint
  chest_breadth,
  chest_depth,
  chest_girth,
  chest_back,  // how far the back lies behind the line of the sides
  waist_breadth,
  waist_depth,
  waist_girth,
  waist_back,
  hip_breadth,
  hip_depth,
  hip_girth,
  hip_back,
  neck_girth,
  thigh_girth,
  lower_thigh_girth,
  calf_girth,
  ankle_girth,
  upper_arm_girth,
  forearm_girth,
  wrist_girth,
  acromion_breadth,
  deltoid_breadth,
  upper_arm_length,  // acromion to elbow
  forearm_length,    // elbow to wrist
  hand_length,
  head_breadth,
  head_length,
  crown_height,  // above the ears
  foot_length,
  foot_breadth,
  weight,  // kg; the others mm
};
inline constexpr std::size_t kSurveyDimensionCount = 40;
constexpr std::size_t dimension_index(SurveyDimension d) {
  return static_cast<std::size_t>(d);
}
using DimensionValues = std::array<double, kSurveyDimensionCount>;

// The name of a dimension in tables, and how far off a body may be (1 SD; the remaining error adds to the energy).
struct DimensionInfo {
  std::string_view name;
  double tolerance;  // mm; kg
};
const std::array<DimensionInfo, kSurveyDimensionCount>& dimension_table();

// What dimensions are taken on: a closed surface, its parts by the body model's segments, its landmarks and joints.
struct DimensionSurface {
  std::int32_t vertex_count = 0;  // of the skin; a mesh may have more behind them
  std::vector<std::array<std::int32_t, 3>> triangles;
  std::vector<std::uint8_t> triangle_is_arm;
  std::vector<body::Segment> segment;   // of each vertex of the skin: the one that moves it most
  std::vector<std::int32_t> landmarks;  // vertices, in the order of body::Landmark
  // A joint is the plain mean of vertices.
  std::array<std::vector<std::int32_t>, body::kSegmentCount> head, tail;
};
DimensionSurface surface_of(const body::BodyModel& model);

// Which triangles a section may cut and where limbs are thickest is decided once, on the mesh all others are
// deformations of. Limbs: the mean of left and right.
class BodyDimensions {
 public:
  BodyDimensions(DimensionSurface surface, std::span<const Vec3f> mean_rest);
  BodyDimensions(BodyDimensions&&) noexcept;
  ~BodyDimensions();

  // `gradients`: null, or kSurveyDimensionCount rows to be filled. Weight by the density law of body/measure.h.
  DimensionValues measure(std::span<const Vec3f> rest, std::vector<PullRow>* gradients = nullptr) const;

  // A row that squares (positive) or rounds (negative) a trunk section without pulling at its sides, front or back:
  // chest, waist, hip.
  std::array<PullRow, 3> squaring_rows(std::span<const Vec3f> rest) const;

  const DimensionSurface& surface() const;

  struct State;

 private:
  std::unique_ptr<State> state_;
};

}  // namespace im2fit::lab
