// SPDX-License-Identifier: Apache-2.0
#include "garment/drape/moving_clothes.h"

#include <algorithm>
#include <utility>

#include "garment/drape/cloth_part.h"
#include "garment/drape/dressing_pose.h"

namespace im2fit::body {
namespace {

constexpr int kRestFrames = 12;  // of the rough cloth, before its places become the offsets' zero

}  // namespace

MovingClothes::MovingClothes(const BodyModel& model, std::unique_ptr<Outfit> dressed, const Skeleton& rest)
    : outfit_(std::move(dressed)), rest_(rest) {
  std::vector<OffsetClearing> fine;
  for (std::size_t i = 0; i < outfit_->size(); ++i)
    fine.emplace_back(cloth_part(model, *outfit_, i, rest_), outfit_->refinement(i).spots(), outfit_->cloth(i));
  outfit_->keep_moving_alone();
  const Pose pose = outfit_->pose();
  for (int i = 0; i < kRestFrames; ++i) outfit_->frame(pose);
  const Unposing unposing(rest_, outfit_->pose());
  for (std::size_t i = 0; i < outfit_->size(); ++i) {
    ClothPart part = cloth_part(model, *outfit_, i, rest_);
    Bound bound{std::move(part.segments), std::move(part.weights), {}, {}, std::move(fine[i])};
    // Not the part's vertices, which lie under the clothes worn over them.
    bound.rest.resize(bound.segments.size());
    for (std::size_t v = 0; v < bound.rest.size(); ++v)
      unposing.undo(bound.segments[v], bound.weights[v], outfit_->cloth(i).position(v), bound.rest[v]);
    bound.offsets.resize(bound.rest.size());
    bound_.push_back(std::move(bound));
  }
}

// How far the joint that moves most would move.
float MovingClothes::stride_mm(const Pose& pose) const {
  Pose from = outfit_->pose(), to = pose;
  from.translation_mm = to.translation_mm = {};
  const PosedSkeleton a = pose_skeleton(rest_, from), b = pose_skeleton(rest_, to);
  float most = 0;
  for (std::size_t s = 0; s < static_cast<std::size_t>(kSegmentCount); ++s)
    most = std::max({most, norm(b.head[s] - a.head[s]), norm(b.tail[s] - a.tail[s])});
  return most;
}

void MovingClothes::frame(const Pose& pose) {
  const float stride = stride_mm(pose);
  outfit_->frame(stride <= kStrideMm ? pose : between(outfit_->pose(), pose, kStrideMm / stride));
}

void MovingClothes::find_offsets() {
  const Unposing unposing(rest_, outfit_->pose());
  for (std::size_t i = 0; i < bound_.size(); ++i) {
    Bound& bound = bound_[i];
    for (std::size_t v = 0; v < bound.rest.size(); ++v) {
      Vec3f at;
      if (!unposing.undo(bound.segments[v], bound.weights[v], outfit_->cloth(i).position(v), at))
        continue;  // as it was
      const Vec3f offset = at - bound.rest[v];
      const float length = norm(offset);
      bound.offsets[v] = length > kFarthestMm ? offset * (kFarthestMm / length) : offset;
    }
    bound.fine.clear(outfit_->skin(), unposing, bound.offsets);
  }
}

}  // namespace im2fit::body
