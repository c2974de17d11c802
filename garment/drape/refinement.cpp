// SPDX-License-Identifier: Apache-2.0
#include "garment/drape/refinement.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace im2fit::body {
namespace {

constexpr float kCurved = 0.75F;   // between the flat triangle and its tangent planes, as the paper's authors have it
constexpr float kBeyond = -0.25F;  // an outline's arc bulges so far out of a rough triangle at most
constexpr std::size_t kPanels = 4;  // front and back, left and right

// In the pattern, which lays all panels over one another.
std::size_t panel_of(const GarmentMesh& mesh, const std::array<std::int32_t, 3>& t) {
  const auto flat = [&](std::size_t k) { return mesh.flat[static_cast<std::size_t>(t[k])]; };
  const Flat a = flat(0), b = flat(1), c = flat(2);
  const bool anticlockwise = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x) > 0;
  bool left = true;
  for (const std::int32_t v : t) left = left && mesh.side[static_cast<std::size_t>(v)] >= 0;
  return (anticlockwise == left ? 0U : 1U) + (left ? 0U : 2U);
}

// Triangles of the rough mesh by the panel and the cell of the pattern they reach into.
class Cells {
 public:
  explicit Cells(const GarmentMesh& mesh) : mesh_(mesh) {
    low_ = high_ = mesh.flat[0];
    for (const Flat& f : mesh.flat) {
      low_ = {std::min(low_.x, f.x), std::min(low_.y, f.y)};
      high_ = {std::max(high_.x, f.x), std::max(high_.y, f.y)};
    }
    columns_ = column(high_.x) + 1;
    rows_ = row(high_.y) + 1;
    of_.resize(kPanels * static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const auto& corners = mesh.triangles[t];
      const auto flat = [&](std::size_t k) { return mesh.flat[static_cast<std::size_t>(corners[k])]; };
      const auto [x0, x1] = std::minmax({flat(0).x, flat(1).x, flat(2).x});
      const auto [y0, y1] = std::minmax({flat(0).y, flat(1).y, flat(2).y});
      for (int r = row(y0); r <= row(y1); ++r)
        for (int c = column(x0); c <= column(x1); ++c) of_[cell(panel_of(mesh, corners), c, r)].push_back(t);
    }
  }

  // The triangle that a place lies in, or least far out of, among those of its cell and the cells about it.
  void find(std::size_t panel, Flat f, std::array<std::int32_t, 3>& corner, std::array<float, 3>& share) const {
    float best = -1e30F;
    const auto look_at = [&](int c, int r) {
      for (const std::size_t t : of_[cell(panel, c, r)]) {
        const auto s = shares(mesh_.triangles[t], f);
        const float least = std::min({s[0], s[1], s[2]});
        if (least <= best) continue;
        best = least;
        corner = mesh_.triangles[t];
        share = s;
      }
    };
    const int column_of = column(f.x), row_of = row(f.y);
    look_at(column_of, row_of);
    if (best > 0) return;  // within it, so within no other
    best = -1e30F;
    for (int r = std::max(0, row_of - 1); r <= std::min(rows_ - 1, row_of + 1); ++r)
      for (int c = std::max(0, column_of - 1); c <= std::min(columns_ - 1, column_of + 1); ++c) look_at(c, r);
  }

 private:
  int column(float x) const { return std::clamp(static_cast<int>((x - low_.x) / mesh_.edge_mm), 0, kMost); }
  int row(float y) const { return std::clamp(static_cast<int>((y - low_.y) / mesh_.edge_mm), 0, kMost); }
  std::size_t cell(std::size_t panel, int c, int r) const {
    return (panel * static_cast<std::size_t>(rows_) + static_cast<std::size_t>(r)) *
               static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(c);
  }
  std::array<float, 3> shares(const std::array<std::int32_t, 3>& t, Flat f) const {
    const auto flat = [&](std::size_t k) { return mesh_.flat[static_cast<std::size_t>(t[k])]; };
    const Flat a = flat(0), b = flat(1), c = flat(2);
    const float area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
    const float s = ((f.x - a.x) * (c.y - a.y) - (c.x - a.x) * (f.y - a.y)) / area;
    const float u = ((b.x - a.x) * (f.y - a.y) - (f.x - a.x) * (b.y - a.y)) / area;
    return {1 - s - u, s, u};
  }

  static constexpr int kMost = 1023;
  const GarmentMesh& mesh_;
  Flat low_, high_;
  int columns_ = 0, rows_ = 0;
  std::vector<std::vector<std::size_t>> of_;
};

}  // namespace

Refinement::Refinement(const GarmentMesh& rough, const GarmentMesh& fine) : spots_(fine.vertex_count()) {
  const Cells cells(rough);
  for (std::size_t v = 0; v < spots_.size(); ++v) {
    const std::size_t panel = (fine.layer[v] == kBackLayer ? 1U : 0U) + (fine.side[v] < 0 ? 2U : 0U);
    Spot& spot = spots_[v];
    cells.find(panel, fine.flat[v], spot.corner, spot.share);
    float sum = 0;
    for (float& s : spot.share) sum += s = std::max(s, kBeyond);
    for (float& s : spot.share) s /= sum;
  }
}

void Refinement::places(const Cloth& rough, std::span<Vec3f> out) const {
  assert(out.size() >= spots_.size());
  for (std::size_t v = 0; v < spots_.size(); ++v) {
    const Spot& spot = spots_[v];
    Vec3f flat{}, curved{};
    for (std::size_t k = 0; k < 3; ++k)
      flat = flat + rough.position(static_cast<std::size_t>(spot.corner[k])) * spot.share[k];
    for (std::size_t k = 0; k < 3; ++k) {
      const auto corner = static_cast<std::size_t>(spot.corner[k]);
      const Vec3f n = rough.normals()[corner];
      curved = curved + (flat - n * dot(n, flat - rough.position(corner))) * spot.share[k];
    }
    out[v] = flat + (curved - flat) * kCurved;
  }
}

}  // namespace im2fit::body
