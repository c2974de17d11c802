// SPDX-License-Identifier: Apache-2.0
#include "train/population/surface_smoother.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "body/model_data.h"

namespace im2fit::lab {
namespace {

// Every second pass goes back, a little farther (Taubin 1995, pass band 0.1): broad shapes keep their size, or grow
// a little: 100 passes add 5 % to a body's volume. Dimensions are fitted anew afterwards.
constexpr float kPassShare = 0.5F, kBackShare = -0.526F;
constexpr float kHeadShare = 0.15F;  // of the trunk's: faces are narrow things

// Of a vertex' skin, by how much smoothing it takes.
float smoothed_share(const SkinRecord& skin) {
  float share = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    using body::Segment;
    switch (static_cast<Segment>(skin.segment[i])) {
      case Segment::left_hand:
      case Segment::right_hand:
      case Segment::left_foot:
      case Segment::right_foot:
        break;
      case Segment::head:
        share += kHeadShare * skin.weight[i];
        break;
      default:
        share += skin.weight[i];
    }
  }
  return share;
}

}  // namespace

SurfaceSmoother::SurfaceSmoother(const body::BodyModel& model) {
  const auto count = static_cast<std::size_t>(model.body_vertex_count());
  std::vector<std::pair<std::int32_t, std::int32_t>> edges;  // both directions
  for (const auto& quad : model.body_quads())
    for (std::size_t i = 0; i < 4; ++i) {
      edges.emplace_back(quad[i], quad[(i + 1) % 4]);
      edges.emplace_back(quad[(i + 1) % 4], quad[i]);
    }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  first_.assign(count + 1, 0);
  for (const auto& [from, to] : edges) {
    ++first_[static_cast<std::size_t>(from) + 1];
    neighbours_.push_back(to);
  }
  for (std::size_t v = 0; v < count; ++v) {
    first_[v + 1] += first_[v];
    share_.push_back(smoothed_share(model.data().skin[v]));
  }
}

void SurfaceSmoother::run(std::span<Vec3f> rest, int passes) const {
  std::vector<Vec3f> before(share_.size());
  for (int pass = 0; pass < 2 * passes; ++pass) {
    const float by = pass % 2 == 0 ? kPassShare : kBackShare;
    std::copy_n(rest.begin(), before.size(), before.begin());
    for (std::size_t v = 0; v < before.size(); ++v) {
      Vec3f sum;
      for (std::int32_t i = first_[v]; i < first_[v + 1]; ++i)
        sum = sum + before[static_cast<std::size_t>(neighbours_[static_cast<std::size_t>(i)])];
      const auto neighbour_count = static_cast<float>(first_[v + 1] - first_[v]);
      if (neighbour_count > 0) rest[v] = before[v] + (sum * (1 / neighbour_count) - before[v]) * (by * share_[v]);
    }
  }
}

}  // namespace im2fit::lab
