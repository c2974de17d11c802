// SPDX-License-Identifier: Apache-2.0
// The parametric human: the contents of a .i2b file, and parameters -> mesh. Axes of every mesh here: y up, +z out of
// the face, +x the person's left; mm. Immutable after loading; shareable between threads.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "body/warp.h"
#include "core/joints.h"
#include "core/status.h"
#include "core/vec3.h"

namespace im2fit::body {

inline constexpr int kSegmentCount = 19;  // docs/makehuman.md: enough for every pose we make
enum class Segment : std::uint8_t {
  pelvis,
  abdomen,
  chest,
  neck,
  head,
  left_shoulder,
  left_upper_arm,
  left_lower_arm,
  left_hand,
  right_shoulder,
  right_upper_arm,
  right_lower_arm,
  right_hand,
  left_upper_leg,
  left_lower_leg,
  left_foot,
  right_upper_leg,
  right_lower_leg,
  right_foot,
};
extern const std::array<std::int8_t, kSegmentCount> kSegmentParent;  // -1 for the pelvis; parents come first
extern const std::array<std::string_view, kSegmentCount> kSegmentNames;

// Sliders as MakeHuman's (docs/makehuman.md), all 0..1 except age and the local modifiers (-1..1, limited to +-2).
// Values out of range are limited; not-a-number counts as the low end.
struct Params {
  float gender = 0.5F;      // 0 woman, 1 man
  float age_years = 25.0F;  // 18..90
  float muscle = 0.5F;
  float weight = 0.5F;
  float height = 0.5F;
  float proportions = 0.5F;
  float cup = 0.5F;
  float firmness = 0.5F;
  std::array<float, 3> race = {1.0F / 3, 1.0F / 3, 1.0F / 3};  // african, asian, caucasian; sums to 1
  std::vector<float> modifiers;  // in BodyModel::modifier_names() order; shorter means zeros
  Warp warp;                     // of the mesh the sliders make
};

struct ShapeSpace;   // body/shape_space.h
struct StartBodies;  // body/start_bodies.h

class BodyModel {
 public:
  static Result<BodyModel> load(const std::string& path);  // .i2b, mapped
  static Result<BodyModel> parse(std::vector<std::byte> bytes, const std::string& what);
  BodyModel(BodyModel&&) noexcept;
  BodyModel& operator=(BodyModel&&) noexcept;
  ~BodyModel();

  // Vertices: the body first (0 .. body_vertex_count), then helpers kept for joints, tights and skirt. Joint cubes
  // and ground cubes are needed for joints; hair is dropped.
  int vertex_count() const;
  int body_vertex_count() const;  // 13380
  std::span<const std::array<std::int32_t, 4>> body_quads() const;
  std::span<const std::array<std::int32_t, 3>> body_triangles()
      const;                                            // the quads split, consistently oriented outwards
  std::span<const std::string> modifier_names() const;  // local modifiers, "group/name"; see docs/makehuman.md
  int modifier_index(std::string_view name) const;      // -1 when absent

  // Rest-pose mesh of `params`; out has vertex_count() places. No allocation.
  void morph(const Params& params, std::span<Vec3f> out) const;
  // For solvers: the body's vertices of several meshes at once; the helpers' vertices get unspecified values. Without
  // `from`, out becomes the mesh of `to`, the bits of morph(); else share times the difference of `to` from `from` is
  // added to it, at the cost of only the parameters that differ. 1 to kBodyMovesMax. No allocation.
  struct BodyMove {
    const Params* from;
    const Params* to;
    float share;
    std::span<Vec3f> out;
  };
  static constexpr std::size_t kBodyMovesMax = 3;
  void move_bodies(std::span<const BodyMove> moves) const;

  // What fits to depth pictures search; point_count 0 when the file has none: im2fit-lab fetch adds it,
  // im2fit-pack-body alone does not.
  const ShapeSpace& shape_space() const;
  // Where fits to measurements begin; none when the file has none, as above.
  const StartBodies& start_bodies() const;

  struct Data;
  const Data& data() const { return *data_; }

 private:
  BodyModel();
  std::unique_ptr<Data> data_;
};

}  // namespace im2fit::body
