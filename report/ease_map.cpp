// SPDX-License-Identifier: Apache-2.0
#include "report/ease_map.h"

#include <algorithm>

namespace im2fit {
namespace {

using Colour = std::array<float, 3>;
constexpr Colour kTight = {0.75F, 0.05F, 0.04F}, kGood = {0.12F, 0.50F, 0.16F}, kLoose = {0.05F, 0.18F, 0.70F};
constexpr float kLyingMm = 10;  // off the skin: what lies on it has its own thickness and small folds
constexpr int kSmoothPasses = 4;

Colour mixed(const Colour& a, const Colour& b, float share) {
  Colour c{};
  for (std::size_t i = 0; i < c.size(); ++i) c[i] = a[i] + (b[i] - a[i]) * share;
  return c;
}

}  // namespace

std::vector<Colour> ease_map(const body::Outfit& outfit, std::size_t index) {
  const body::Cloth& cloth = outfit.cloth(index);
  const auto& constraints = cloth.constraints();
  const std::size_t count = cloth.mesh().vertex_count();
  std::vector<float> ease(count, 0), sum(count), edges(count, 0);  // -1 tight, 0, 1 loose
  for (std::size_t e = 0; e < constraints.edges.size(); ++e) {
    const auto a = static_cast<std::size_t>(constraints.edges[e][0]),
               b = static_cast<std::size_t>(constraints.edges[e][1]);
    const float strain = norm(cloth.position(a) - cloth.position(b)) / constraints.edge_mm[e] - 1;
    for (const std::size_t v : {a, b}) {
      ease[v] += strain;
      edges[v] += 1;
    }
  }
  for (std::size_t v = 0; v < count; ++v) {
    const float strain = edges[v] > 0 ? ease[v] / edges[v] : 0;
    const body::SkinPlace& place = cloth.contacts()[v];
    float off = kEaseMapLooseMm;
    if (place.triangle >= 0)
      off = dot(cloth.position(v) - outfit.skin().at(place, true), outfit.skin().facing(place, true));
    ease[v] = std::clamp((off - kLyingMm) / (kEaseMapLooseMm - kLyingMm), 0.0F, 1.0F) -
              std::clamp(strain / kEaseMapTightStrain, 0.0F, 1.0F);
  }
  for (int pass = 0; pass < kSmoothPasses; ++pass) {
    std::fill(sum.begin(), sum.end(), 0.0F);
    for (const auto& edge : constraints.edges) {
      sum[static_cast<std::size_t>(edge[0])] += ease[static_cast<std::size_t>(edge[1])];
      sum[static_cast<std::size_t>(edge[1])] += ease[static_cast<std::size_t>(edge[0])];
    }
    for (std::size_t v = 0; v < count; ++v)
      if (edges[v] > 0) ease[v] = (ease[v] + sum[v] / edges[v]) / 2;
  }
  std::vector<Colour> colours;
  colours.reserve(count);
  for (const float e : ease) colours.push_back(e < 0 ? mixed(kGood, kTight, -e) : mixed(kGood, kLoose, e));
  return colours;
}

}  // namespace im2fit
