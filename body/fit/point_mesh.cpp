// SPDX-License-Identifier: Apache-2.0
#include "body/fit/point_mesh.h"

#include <algorithm>
#include <array>

#include "body/model_data.h"
#include "body/shape_space.h"

namespace im2fit::body {
namespace {

constexpr int kRounds = 4;         // a smooth move passes the points by a few per cent of itself in the first
constexpr float kFarthest = 1.6F;  // of the distance to the last of a vertex's points: its weight's reach
constexpr float kSameSide = 0.1F;  // cosine between normals

Vec3f middle(std::span<const Vec3f> mesh, const Quad& quad) {
  Vec3f sum{};
  for (const std::int32_t v : quad) sum = sum + mesh[static_cast<std::size_t>(v)];
  return sum * 0.25F;
}

Vec3f normal(std::span<const Vec3f> mesh, const Quad& quad) {
  const auto at = [&](std::size_t i) { return mesh[static_cast<std::size_t>(quad[i])]; };
  return normalized(cross(at(2) - at(0), at(3) - at(1)));
}

// Whether a move of one may be taken for a move of the other: of one segment or of neighbours.
bool joined(std::uint8_t a, std::uint8_t b) {
  return a == b || kSegmentParent[a] == static_cast<std::int8_t>(b) ||
         kSegmentParent[b] == static_cast<std::int8_t>(a);
}

}  // namespace

PointMesh::PointMesh(const BodyModel& model) : model_(model), quads_(quads_of_shape_space(model)) {
  if (quads_.empty()) return;
  const auto count = static_cast<std::size_t>(model.vertex_count());
  std::vector<Vec3f> mesh(count), normals(count);
  model.morph({}, mesh);
  for (const Quad& quad : model.body_quads())
    for (const std::int32_t v : quad) {
      Vec3f& n = normals[static_cast<std::size_t>(v)];
      n = n + normal(mesh, quad);
    }
  std::vector<Vec3f> middles, facing;
  for (const Quad& quad : quads_) {
    middles.push_back(middle(mesh, quad));
    facing.push_back(normal(mesh, quad));
  }
  const auto& skin = model.data().skin;
  const auto body = static_cast<std::size_t>(model.body_vertex_count());
  pulls_.resize(count * kEach);
  off_.resize(quads_.size());
  for (std::size_t v = 0; v < count; ++v) {
    std::array<std::pair<float, std::uint32_t>, kEach> near;
    near.fill({1e30F, 0});
    for (std::uint32_t i = 0; i < quads_.size(); ++i) {
      const Vec3f d = middles[i] - mesh[v];
      const float square = dot(d, d);
      if (square >= near.back().first) continue;
      if (v < body && (dot(facing[i], normals[v]) < kSameSide * norm(normals[v]) ||
                       !joined(skin[v].segment[0], model.shape_space().skin[i].segment[0])))
        continue;
      near.back() = {square, i};
      std::sort(near.begin(), near.end());
    }
    // A vertex that no point is like goes with whatever is nearest.
    if (near.front().first >= 1e30F)
      for (std::uint32_t i = 0; i < quads_.size(); ++i) {
        const Vec3f d = middles[i] - mesh[v];
        if (dot(d, d) < near.front().first) near.front() = {dot(d, d), i};
      }
    float reach = 1;
    for (const auto& [square, i] : near)
      if (square < 1e30F) reach = std::max(reach, square * kFarthest);
    float sum = 0;
    Pull* pull = pulls_.data() + v * kEach;
    for (std::size_t k = 0; k < kEach; ++k) {
      const float weight = near[k].first < 1e30F ? (1 / (near[k].first + 1)) - (1 / (reach + 1)) : 0.0F;
      pull[k] = {near[k].second, weight};
      sum += weight;
    }
    for (std::size_t k = 0; k < kEach; ++k) pull[k].weight /= sum;
  }
}

void PointMesh::run(std::span<const Vec3f> points, const Skeleton& bones, std::span<Vec3f> mesh) {
  if (!valid()) return;
  for (int round = 0; round < kRounds; ++round) {
    for (std::size_t i = 0; i < quads_.size(); ++i) off_[i] = points[i] - middle(mesh, quads_[i]);
    for (std::size_t v = 0; v < mesh.size(); ++v) {
      const Pull* pull = pulls_.data() + v * kEach;
      Vec3f move{};
      for (std::size_t k = 0; k < kEach; ++k) move = move + off_[pull[k].point] * pull[k].weight;
      mesh[v] = mesh[v] + move;
    }
  }
  // Joints are means of vertices, of which helpers make most: they move to where the bones are. Some are of several
  // joints, so each move begins with where the one before left them.
  const auto body = static_cast<std::size_t>(model_.body_vertex_count());
  const auto move = [&](std::size_t list, Vec3f to) {
    const Vec3f by = to - mean_of_list(model_.data(), list, mesh);
    const ListRecord& record = model_.data().lists[list];
    for (std::uint32_t i = record.first; i < record.first + record.count; ++i) {
      const auto v = static_cast<std::size_t>(model_.data().list_vertices[i]);
      if (v >= body) mesh[v] = mesh[v] + by;
    }
  };
  for (std::size_t s = 0; s < static_cast<std::size_t>(kSegmentCount); ++s) {
    move(kTailLists + s, bones.tail[s]);
    move(kHeadLists + s, bones.head[s]);
  }
}

}  // namespace im2fit::body
