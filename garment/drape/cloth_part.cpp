// SPDX-License-Identifier: Apache-2.0
#include "garment/drape/cloth_part.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "body/model_data.h"

namespace im2fit::body {
namespace {

using Shares = std::array<float, kSegmentCount>;
constexpr int kSmoothings = 8;   // neighbours' weights are mixed, so that no fold is torn where limbs meet
constexpr float kSmoothMm = 12;  // edges that are smoothed so often; what is mixed reaches as far over longer ones
constexpr float kLeastVolume = 0.1F;  // that mixed rotations leave of a cube
constexpr float kReachMm = 200;       // of skin below

// Of the skin nearest to each vertex of the cloth.
std::vector<Shares> skin_below(const BodyModel& model, const Outfit& outfit, const Cloth& cloth) {
  const auto& records = model.data().skin;
  std::vector<Shares> all(cloth.mesh().vertex_count());
  std::int32_t hint = -1;  // vertices that follow one another lie near each other
  for (std::size_t v = 0; v < all.size(); ++v) {
    SkinPlace place;
    bool found = false;
    for (const float cosine : {0.0F, -2.0F})
      found =
          found || outfit.skin().nearest(cloth.position(v), cloth.normals()[v], cosine, 0xFF, kReachMm, hint, place);
    Shares& shares = all[v];
    shares = {};
    if (!found) {
      shares[static_cast<std::size_t>(Segment::pelvis)] = 1;
      continue;
    }
    const auto& corners = outfit.skin().triangles()[static_cast<std::size_t>(place.triangle)];
    for (std::size_t k = 0; k < 3; ++k) {
      const SkinRecord& record = records[static_cast<std::size_t>(corners[k])];
      for (std::size_t i = 0; i < 4; ++i) shares[record.segment[i]] += place.share[k] * record.weight[i];
    }
  }
  return all;
}

// Those that any vertex follows: of the others there is nothing to mix.
std::vector<std::size_t> followed_segments(const std::vector<Shares>& all) {
  std::array<bool, kSegmentCount> followed{};
  for (const Shares& shares : all)
    for (std::size_t s = 0; s < shares.size(); ++s) followed[s] = followed[s] || shares[s] != 0;
  std::vector<std::size_t> segments;
  for (std::size_t s = 0; s < followed.size(); ++s)
    if (followed[s]) segments.push_back(s);
  return segments;
}

// Each vertex's neighbours, in the order of the edges.
struct Neighbours {
  explicit Neighbours(const Cloth& cloth) : first(cloth.mesh().vertex_count() + 1, 0) {
    const auto& edges = cloth.constraints().edges;
    for (const auto& e : edges)
      for (const std::int32_t v : e) ++first[static_cast<std::size_t>(v) + 1];
    for (std::size_t v = 1; v < first.size(); ++v) first[v] += first[v - 1];
    std::vector<std::size_t> end(first.begin(), first.end() - 1);
    vertices.resize(first.back());
    for (const auto& e : edges)
      for (std::size_t k = 0; k < 2; ++k) vertices[end[static_cast<std::size_t>(e[k])]++] = e[1 - k];
  }
  std::vector<std::size_t> first;  // where those of a vertex begin, and an end
  std::vector<std::int32_t> vertices;
};

// In rows of four segments: sums are those of one segment after another, to the bit.
void smooth(const Cloth& cloth, std::vector<Shares>& all) {
  const std::vector<std::size_t> segments = followed_segments(all);
  const Neighbours neighbours(cloth);
  const float edge = cloth.mesh().edge_mm / kSmoothMm;
  const int passes = std::max(1, static_cast<int>(static_cast<float>(kSmoothings) / (edge * edge)));
  using Row = std::array<float, 4>;
  constexpr auto load_row = [](const Row& row) {
    Float4 four;
    std::memcpy(&four, row.data(), sizeof four);
    return four;
  };
  std::vector<Row> rows(all.size()), sums(all.size());
  for (std::size_t from = 0; from < segments.size(); from += 4) {
    const std::size_t width = std::min<std::size_t>(4, segments.size() - from);
    for (std::size_t v = 0; v < all.size(); ++v)
      for (std::size_t k = 0; k < width; ++k) rows[v][k] = all[v][segments[from + k]];
    for (int pass = 0; pass < passes; ++pass) {
      for (std::size_t v = 0; v < rows.size(); ++v) {
        Float4 sum = load_row(rows[v]);
        const std::size_t end = neighbours.first[v + 1];
        for (std::size_t i = neighbours.first[v]; i < end; ++i)
          sum += load_row(rows[static_cast<std::size_t>(neighbours.vertices[i])]);
        sum /= all_of(1 + static_cast<float>(end - neighbours.first[v]));
        std::memcpy(sums[v].data(), &sum, sizeof sum);
      }
      rows.swap(sums);
    }
    for (std::size_t v = 0; v < all.size(); ++v)
      for (std::size_t k = 0; k < width; ++k) all[v][segments[from + k]] = rows[v][k];
  }
}

MixedMotion mixed(std::span<const Mat3f> rotation, std::span<const Vec3f> shift,
                  const std::array<std::uint8_t, 4>& segments, const std::array<float, 4>& weights) {
  MixedMotion affine;
  for (std::size_t k = 0; k < 4; ++k) {
    const std::size_t s = segments[k];
    for (std::size_t i = 0; i < 9; ++i) affine.m[i] += weights[k] * rotation[s].m[i];
    affine.shift = affine.shift + shift[s] * weights[k];
  }
  return affine;
}

std::array<Vec3f, kSegmentCount> shifts(const Skeleton& rest, const Pose& pose) {
  const PosedSkeleton posed = pose_skeleton(rest, pose);
  std::array<Vec3f, kSegmentCount> out;
  for (std::size_t s = 0; s < out.size(); ++s) out[s] = posed.head[s] - pose.rotation[s] * rest.head[s];
  return out;
}

bool undone(const MixedMotion& a, Vec3f posed, Vec3f& at_rest) {
  const auto& m = a.m;
  const Vec3f r0 = {m[0], m[1], m[2]}, r1 = {m[3], m[4], m[5]}, r2 = {m[6], m[7], m[8]};
  const Vec3f c0 = cross(r1, r2), c1 = cross(r2, r0), c2 = cross(r0, r1);
  const float determinant = dot(r0, c0);
  if (determinant < kLeastVolume) return false;
  const Vec3f p = posed - a.shift;
  at_rest = (c0 * p.x + c1 * p.y + c2 * p.z) * (1 / determinant);
  return true;
}

}  // namespace

Vec3f MixedMotion::of(Vec3f p) const {
  return {m[0] * p.x + m[1] * p.y + m[2] * p.z + shift.x, m[3] * p.x + m[4] * p.y + m[5] * p.z + shift.y,
          m[6] * p.x + m[7] * p.y + m[8] * p.z + shift.z};
}

Vec3f MixedMotion::transposed(Vec3f n) const {
  return {m[0] * n.x + m[3] * n.y + m[6] * n.z, m[1] * n.x + m[4] * n.y + m[7] * n.z,
          m[2] * n.x + m[5] * n.y + m[8] * n.z};
}

Unposing::Unposing(const Skeleton& rest, const Pose& pose) : rotation_(pose.rotation), shift_(shifts(rest, pose)) {}

MixedMotion Unposing::motion(const std::array<std::uint8_t, 4>& segments, const std::array<float, 4>& weights) const {
  return mixed(rotation_, shift_, segments, weights);
}

bool Unposing::undo(const std::array<std::uint8_t, 4>& segments, const std::array<float, 4>& weights, Vec3f posed,
                    Vec3f& at_rest) const {
  return undone(mixed(rotation_, shift_, segments, weights), posed, at_rest);
}

ClothPart cloth_part(const BodyModel& model, const Outfit& outfit, std::size_t index, const Skeleton& rest) {
  const Cloth& cloth = outfit.cloth(index);
  std::vector<Shares> all = skin_below(model, outfit, cloth);
  smooth(cloth, all);
  const std::array<Vec3f, kSegmentCount> shift = shifts(rest, outfit.pose());
  ClothPart part;
  std::vector<Vec3f> shown(all.size());
  outfit.shown(index, shown);
  for (std::size_t v = 0; v < all.size(); ++v) {
    std::array<std::uint8_t, 4> order{};  // the four that weigh most, of equals the first
    std::size_t found = 0;
    for (std::size_t i = 0; i < kSegmentCount; ++i) {
      std::size_t at = found;
      while (at > 0 && all[v][order[at - 1]] < all[v][i]) --at;
      if (at >= order.size()) continue;
      found = std::min(found + 1, order.size());
      for (std::size_t k = found - 1; k > at; --k) order[k] = order[k - 1];
      order[at] = static_cast<std::uint8_t>(i);
    }
    std::array<std::uint8_t, 4> segments{};
    std::array<float, 4> weights{};
    float sum = 0;
    for (std::size_t k = 0; k < 4; ++k) sum += all[v][order[k]];
    for (std::size_t k = 0; k < 4; ++k) {
      weights[k] = all[v][order[k]] / sum;
      segments[k] = weights[k] > 0 ? order[k] : std::uint8_t{0};
    }
    const MixedMotion affine = mixed(outfit.pose().rotation, shift, segments, weights);
    Vec3f at_rest = shown[v];
    undone(affine, shown[v], at_rest);
    part.rest.push_back(at_rest);
    const Vec3f n = cloth.normals()[v];
    part.normals.push_back(normalized(affine.transposed(n)));
    part.texture.push_back({cloth.mesh().flat[v].x * 1e-3F, -cloth.mesh().flat[v].y * 1e-3F});
    part.segments.push_back(segments);
    part.weights.push_back(weights);
  }
  return part;
}

}  // namespace im2fit::body
