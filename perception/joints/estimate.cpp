// SPDX-License-Identifier: Apache-2.0
#include "perception/joints/estimate.h"

#include <algorithm>

#include "core/joints.h"
#include "perception/joints/forest.h"

namespace im2fit::joints {
namespace {

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
