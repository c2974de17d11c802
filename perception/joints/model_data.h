// SPDX-License-Identifier: Apache-2.0
// What a .i2t file holds, as views into its bytes, and the few lines of arithmetic that run it. The trainer uses the
// same lines, so that it learns on exactly the numbers the device will see. Layout: docs/tracker.md.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "core/camera.h"
#include "core/joints.h"
#include "kernels/anchors/anchors.h"
#include "kernels/trees/trees.h"
#include "perception/joints/tracker.h"
#include "perception/joints/view.h"

namespace im2fit::joints {

inline constexpr std::string_view kTrackerMagic = "I2TR";
inline constexpr std::uint32_t kTrackerVersion = 4;
inline constexpr std::size_t kProvenanceMax = 65536;
inline constexpr int kConfidenceBinCount = 12;
inline constexpr int kPixelCountMax = 1024;
inline constexpr int kClueCount = 48;  // beside the anchors' depths: person_votes.h

struct Meta {
  std::uint32_t forest_tree_count = 0;  // per joint
  std::uint32_t jump_count = 0;
  std::uint32_t level_count = 0;
  std::uint32_t level_tree_count = 0;
  std::uint32_t pixel_count = 0;        // per level
  std::uint32_t side_tree_count = 0;    // for front or back; 0: every person faces the camera
  std::uint32_t person_tree_count = 0;  // for person or object; 0: person_score alone decides
};

// Inner node: depth difference of two probes against `threshold`; children at `left`, `left + 1` of the same tree.
// Leaf (left == 0): the jump in a, b, c, mm.
struct JumpNode {
  std::int16_t a = 0;
  std::int16_t b = 0;
  std::int16_t c = 0;
  std::int16_t d = 0;
  std::int16_t threshold = 0;
  std::uint16_t left = 0;
};
static_assert(sizeof(JumpNode) == 12);

using Basis = std::array<float, static_cast<std::size_t>(kLeafSize* kShapeSize)>;  // mm a unit, by coefficient

struct ConfidenceBin {  // bins in rising order of ensemble spread
  std::uint16_t spread_mm_max = 0;
  std::uint16_t chance = 0;  // of being within 50 mm, of 65535
};
static_assert(sizeof(ConfidenceBin) == 4);

using Shape = std::array<float, static_cast<std::size_t>(kShapeSize)>;  // x, y, z by joint, mm
inline Vec3f joint_of(const Shape& s, int j) {
  const auto i = 3 * static_cast<std::size_t>(j);
  return {s[i], s[i + 1], s[i + 2]};
}
inline void set_joint(Shape& s, int j, Vec3f p) {
  const auto i = 3 * static_cast<std::size_t>(j);
  s[i] = p.x;
  s[i + 1] = p.y;
  s[i + 2] = p.z;
}

inline constexpr float kProbeDepthMinMm = 200.0F;
inline float safe_depth(float z) {
  return z > kProbeDepthMinMm ? z : kProbeDepthMinMm;
}

// Depth d relative to z, within +-1000; nothing there, 0, counts as far behind.
inline int probe_of(int d, float z) {
  if (d == 0) return 1000;
  const int q = d - static_cast<int>(z);
  return q > 1000 ? 1000 : (q < -1000 ? -1000 : q);
}
// Of the metric point (x, y, z).
inline int probe(const View& view, float x, float y, float z, float inverse_z) {
  return probe_of(view.at_ray(x * inverse_z, y * inverse_z), z);
}
inline int jump_feature(const View& view, Vec3f p, const JumpNode& n) {
  const float z = safe_depth(p.z);
  const float inverse_z = 1.0F / z;
  return probe(view, p.x + static_cast<float>(n.a), p.y + static_cast<float>(n.b), z, inverse_z) -
         probe(view, p.x + static_cast<float>(n.c), p.y + static_cast<float>(n.d), z, inverse_z);
}

// Depth under each anchor relative to the torso's, within +-600; `step` places apart.
void read_anchors(std::span<const Anchor> anchors, const View& view, const Shape& shape, std::int16_t* out,
                  std::ptrdiff_t step = 1);
inline int find_leaf(const Split* splits, const std::int16_t* pixels) {
  int i = 0;
  while (i < kSplitCount) i = 2 * i + 1 + (pixels[splits[i].a] - pixels[splits[i].b] > splits[i].threshold ? 1 : 0);
  return i - kSplitCount;
}

// Boosted trees whose leaves are log-odds in 1/256. Splits read the anchors' depths and, in person votes,
// clues.
inline constexpr int kVoteUnit = 256;
struct Votes {
  std::span<const Anchor> anchors;       // pixels
  std::span<const Split> splits;         // trees * 31
  std::span<const std::int16_t> leaves;  // trees * 32
};
inline int count_votes(const Votes& votes, const std::int16_t* values) {
  int sum = 0;
  for (std::size_t t = 0; t * kSplitCount < votes.splits.size(); ++t)
    sum += votes.leaves[t * kLeafCount +
                        static_cast<std::size_t>(find_leaf(votes.splits.data() + t * kSplitCount, values))];
  return sum;
}

// All trees, or every second one: each half of the trees has learnt on a half of the pictures.
struct ForestView {
  std::uint32_t tree_count = 0;  // per joint, of this view
  std::uint32_t jump_count = 0;
  std::span<const std::uint32_t> tree_start;  // joints * trees + 1
  std::span<const JumpNode> nodes;
  std::span<const std::int16_t> bone;  // joints * 3: mean offset from the parent, mm
  std::uint32_t tree_first = 0;
  std::uint32_t tree_step = 1;

  std::span<const JumpNode> tree(int joint, std::uint32_t t) const {
    const std::size_t i =
        (static_cast<std::size_t>(joint) * tree_count + t) * static_cast<std::size_t>(tree_step) + tree_first;
    return nodes.subspan(tree_start[i], tree_start[i + 1] - tree_start[i]);
  }
  ForestView half(std::uint32_t which) const {  // 0 or 1; of an even number of trees
    return {tree_count / 2, jump_count, tree_start, nodes, bone, which, 2};
  }
};
void run_forest(const ForestView& forest, const View& view, Shape& shape);  // in estimate.cpp: several side by side
Vec3f jump_start(const ForestView& forest, int joint, const View& view, const Shape& shape);

}  // namespace im2fit::joints

namespace im2fit {

struct JointModel::Data {
  joints::Meta meta;
  joints::ForestView forest;
  std::span<const joints::Anchor> anchors;      // levels * pixels
  std::span<const joints::Split> splits;        // levels * trees * 31
  std::span<const std::int8_t> leaves;          // levels * trees * 32 * 32, units of the level's basis
  std::span<const joints::Basis> basis;         // levels
  std::span<const joints::ConfidenceBin> bins;  // joints * 12
  joints::Votes side;                           // of a back
  joints::Votes person_votes;
  std::string_view provenance;  // text
  std::uint32_t key = 0;        // CRC-32C of the bytes
};

namespace joints {
// shape += the sum of basis[k] * sum[k], k rising.
void add_sums(const Basis& basis, const std::int32_t* sum, Shape& shape);

struct CascadeRun {
  const View* view = nullptr;
  Shape shape{};  // the start, then the answer
};
inline constexpr std::size_t kCascadeRunsMax = kRunLanes;
void run_cascade(const JointModel::Data& model, std::span<CascadeRun> runs);  // kCascadeRunsMax at most
}  // namespace joints

}  // namespace im2fit
