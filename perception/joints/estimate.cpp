// SPDX-License-Identifier: Apache-2.0
#include "perception/joints/estimate.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <span>

#include "core/joints.h"
#include "perception/joints/model_data.h"

namespace im2fit::joints {
namespace {

// The jump forest, several runs side by side. A walk down a tree is a chain of loads that miss the caches; those of
// all runs and trees are independent, so that their misses overlap.
constexpr std::size_t kForestRunsMax = 6;
struct ForestRun {
  ForestView forest;
  const View* view = nullptr;
  Shape shape{};  // the answer
};

constexpr std::size_t kTreesMax = 16;  // of a joint
constexpr std::size_t kWalksMax = kForestRunsMax * kTreesMax;

// Where a joint is thought to be, and what every probe about it needs.
struct Place {
  const View* view = nullptr;
  Vec3f p;
  float inverse_z = 1;
  int z_mm = 0;
  Vec3f later_sum;  // of the places of the later jumps

  void see(Vec3f at) {
    p = at;
    const float z = safe_depth(p.z);
    inverse_z = 1.0F / z;
    z_mm = static_cast<int>(z);
  }
};

// As probe() of model_data.h, without branches that half of the probes mispredict.
int probe_at(const Place& place, int dx, int dy) {
  const View& view = *place.view;
  const float rx = (place.p.x + static_cast<float>(dx)) * place.inverse_z;
  const float ry = (place.p.y + static_cast<float>(dy)) * place.inverse_z;
  const auto u = static_cast<unsigned>(view.column_of(rx));
  const auto v = static_cast<unsigned>(view.row_of(ry));
  const auto width = static_cast<unsigned>(view.width);
  const bool inside = (u < width) & (v < static_cast<unsigned>(view.height));
  const int d = view.depth[inside ? v * width + u : 0];
  const int away = d - place.z_mm;
  const int near = away > 1000 ? 1000 : (away < -1000 ? -1000 : away);
  return (inside & (d != 0)) ? near : 1000;
}

struct Walk {
  const JumpNode* tree = nullptr;
  const JumpNode* node = nullptr;
  const Place* place = nullptr;
};

// Every walk one node down, again and again, until all are at their leaves.
void walk_down(std::span<Walk> walks) {
  std::array<Walk*, kWalksMax> under_way;
  std::size_t count = 0;
  for (Walk& walk : walks) under_way[count++] = &walk;
  while (count > 0) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < count; ++i) {
      Walk& walk = *under_way[i];
      const JumpNode& n = *walk.node;
      if (n.left == 0) continue;
      const int feature = probe_at(*walk.place, n.a, n.b) - probe_at(*walk.place, n.c, n.d);
      walk.node = walk.tree + n.left + (feature > n.threshold ? 1 : 0);
      __builtin_prefetch(walk.node);
      under_way[kept++] = &walk;
    }
    count = kept;
  }
}

void start_walks(std::span<const ForestRun> runs, std::span<const Place> places, int joint, std::span<Walk> walks) {
  std::size_t w = 0;
  for (std::size_t r = 0; r < runs.size(); ++r)
    for (std::uint32_t t = 0; t < runs[r].forest.tree_count; ++t) {
      const JumpNode* tree = runs[r].forest.tree(joint, t).data();
      walks[w++] = {tree, tree, &places[r]};
    }
}

// kForestRunsMax at most, all of one model: forests differ in their trees alone. Each run's answer is the one it has
// alone. No allocation.
// The mean of the later half of the jumps: single trees hop between two leaves about the joint.
void run_forests(std::span<ForestRun> runs) {
  assert(runs.size() <= kForestRunsMax);
  std::array<Place, kForestRunsMax> places;
  std::array<Walk, kWalksMax> all;
  std::size_t walk_count = 0;
  for (const ForestRun& run : runs) walk_count += run.forest.tree_count;
  const std::span<Walk> walks = std::span(all).first(walk_count);
  const std::uint32_t jump_count = runs[0].forest.jump_count;
  for (const Joint name : kJointOrder) {
    const int joint = static_cast<int>(name);
    for (std::size_t r = 0; r < runs.size(); ++r) {
      places[r] = {runs[r].view, {}, 1, 0, {}};
      places[r].see(jump_start(runs[r].forest, joint, *runs[r].view, runs[r].shape));
    }
    for (std::uint32_t step = 0; step < jump_count; ++step) {
      start_walks(runs, places, joint, walks);
      walk_down(walks);
      const Walk* walk = walks.data();
      for (std::size_t r = 0; r < runs.size(); ++r) {
        const std::uint32_t tree_count = runs[r].forest.tree_count;
        Vec3f jump;
        for (std::uint32_t t = 0; t < tree_count; ++t, ++walk) {
          const JumpNode& leaf = *walk->node;
          jump = jump + Vec3f{static_cast<float>(leaf.a), static_cast<float>(leaf.b), static_cast<float>(leaf.c)};
        }
        Vec3f p = places[r].p + jump * (1.0F / static_cast<float>(tree_count));
        p.z = safe_depth(p.z);
        places[r].see(p);
        if (step >= jump_count / 2) places[r].later_sum = places[r].later_sum + p;
      }
    }
    const std::uint32_t later_count = jump_count - jump_count / 2;
    for (std::size_t r = 0; r < runs.size(); ++r)
      set_joint(runs[r].shape, joint, places[r].later_sum * (1.0F / static_cast<float>(later_count)));
  }
}

constexpr std::size_t kStartCount = 3;
constexpr std::size_t kRunCount = 2 * kStartCount;
static_assert(kRunCount <= kCascadeRunsMax && kRunCount <= kForestRunsMax);

float middle(std::array<float, kRunCount> values) {
  std::sort(values.begin(), values.end());
  return (values[kRunCount / 2 - 1] + values[kRunCount / 2]) * 0.5F;
}

// What the mirror image's joints are in the view itself.
Shape mirrored(const Shape& shape) {
  Shape out{};
  for (int j = 0; j < static_cast<int>(kJointCount); ++j) {
    const Vec3f p = joint_of(shape, j);
    set_joint(out, static_cast<int>(mirror_of(static_cast<Joint>(j))), {-p.x, p.y, p.z});
  }
  return out;
}

}  // namespace

void run_forest(const ForestView& forest, const View& view, Shape& shape) {
  ForestRun run{forest, &view, shape};
  run_forests({&run, 1});
  shape = run.shape;
}

JointEstimate mirrored(const JointEstimate& estimate) {
  JointEstimate out;
  out.shape = mirrored(estimate.shape);
  for (std::size_t j = 0; j < kJointCount; ++j) out.spread_mm[j] = estimate.spread_mm[joint_index(kJointMirror[j])];
  return out;
}

JointEstimate estimate(const JointModel::Data& model, const View& view, const View& mirror_image) {
  const std::array<ForestView, kStartCount> starts = {model.forest, model.forest.half(0), model.forest.half(1)};
  std::array<ForestRun, kRunCount> jumps{};
  for (std::size_t i = 0; i < kRunCount; ++i)
    jumps[i] = {starts[i % kStartCount], i < kStartCount ? &view : &mirror_image, {}};
  run_forests(jumps);
  std::array<CascadeRun, kRunCount> runs{};
  for (std::size_t i = 0; i < kRunCount; ++i) runs[i] = {jumps[i].view, jumps[i].shape};
  run_cascade(model, runs);
  std::array<Shape, kRunCount> seen{};
  for (std::size_t i = 0; i < kRunCount; ++i) seen[i] = i < kStartCount ? runs[i].shape : mirrored(runs[i].shape);
  JointEstimate out;
  for (std::size_t k = 0; k < out.shape.size(); ++k)
    out.shape[k] = middle({seen[0][k], seen[1][k], seen[2][k], seen[3][k], seen[4][k], seen[5][k]});
  for (int j = 0; j < static_cast<int>(kJointCount); ++j) {
    float sum = 0;
    for (const Shape& run : seen) sum += norm(joint_of(run, j) - joint_of(out.shape, j));
    out.spread_mm[static_cast<std::size_t>(j)] = sum * (1.0F / static_cast<float>(kRunCount));
  }
  return out;
}

}  // namespace im2fit::joints
