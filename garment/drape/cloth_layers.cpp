// SPDX-License-Identifier: Apache-2.0
#include "garment/drape/cloth_layers.h"

#include <algorithm>
#include <cmath>

#include "garment/drape/flat_places.h"

namespace im2fit::body {
namespace {

constexpr std::size_t kCellsMax = 1U << 18;       // of kGarmentEdgeMm
constexpr std::size_t kRoughCellsMax = 1U << 15;  // half as many each way
constexpr std::size_t kPairsPerVertex = 4;
constexpr float kNoSeamMm2 = 1e4F;
constexpr float kNeighbourEdges = 2.2F;
constexpr float kRub = 0.1F;  // of their relative motion, taken from each

}  // namespace

ClothLayers::ClothLayers(const GarmentMesh& mesh)
    : mesh_(mesh),
      cells_max_(mesh.edge_mm > kGarmentEdgeMm ? kRoughCellsMax : kCellsMax),
      neighbour_mm_(kNeighbourEdges * mesh.edge_mm) {
  const std::size_t count = mesh.vertex_count();
  FlatPlaces seams;
  for (std::size_t v = 0; v < count; ++v)
    if (((mesh.border[v] & kOnSeam) != 0 || mesh.side[v] == 0) && mesh.side[v] >= 0) seams.add(mesh.flat[v], v);
  to_seam_mm_.reserve(count);
  for (const Flat& f : mesh.flat) to_seam_mm_.push_back(std::sqrt(std::min(kNoSeamMm2, seams.nearest(f).squared_mm)));
  pairs_.reserve(kPairsPerVertex * count);
  cell_first_.resize(cells_max_ + 1);
  cell_vertices_.resize(count);
  vertex_cell_.resize(count);
}

bool ClothLayers::neighbours(std::int32_t a, std::int32_t b) const {
  const auto i = static_cast<std::size_t>(a), k = static_cast<std::size_t>(b);
  const bool same_panel =
      (mesh_.layer[i] == mesh_.layer[k] || mesh_.layer[i] == kBothLayers || mesh_.layer[k] == kBothLayers) &&
      mesh_.side[i] * mesh_.side[k] >= 0;
  if (!same_panel) return to_seam_mm_[i] + to_seam_mm_[k] < neighbour_mm_;
  const float dx = mesh_.flat[i].x - mesh_.flat[k].x, dy = mesh_.flat[i].y - mesh_.flat[k].y;
  return dx * dx + dy * dy < neighbour_mm_ * neighbour_mm_;
}

void ClothLayers::find(std::span<const ClothVertex> vertices, std::span<const std::uint8_t> pinched) {
  pairs_.clear();
  const std::size_t count = mesh_.vertex_count();
  Vec3f low = {vertices[0].x, vertices[0].y, vertices[0].z}, high = low;
  for (std::size_t v = 0; v < count; ++v) {
    const ClothVertex& p = vertices[v];
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  const float search = search_mm();
  float cell_mm = search;
  std::array<int, 3> cells{};
  for (;; cell_mm *= 1.25F) {
    const auto size = [&](float from, float to) {
      const float share = (to - from) / cell_mm;
      return share < 1023 ? static_cast<int>(share) + 1 : 1024;
    };
    cells = {size(low.x, high.x), size(low.y, high.y), size(low.z, high.z)};
    if (static_cast<std::size_t>(cells[0]) * static_cast<std::size_t>(cells[1]) *
            static_cast<std::size_t>(cells[2]) <=
        cells_max_)
      break;
  }
  const auto all =
      static_cast<std::size_t>(cells[0]) * static_cast<std::size_t>(cells[1]) * static_cast<std::size_t>(cells[2]);
  std::fill_n(cell_first_.begin(), all + 1, 0);
  const float per_mm = 1 / cell_mm;
  const auto cell = [&](float value, float from, int most) {
    const int i = static_cast<int>((value - from) * per_mm);
    return i < 0 ? 0 : i >= most ? most - 1 : i;
  };
  for (std::size_t v = 0; v < count; ++v) {
    const ClothVertex& p = vertices[v];
    const int at =
        (cell(p.z, low.z, cells[2]) * cells[1] + cell(p.y, low.y, cells[1])) * cells[0] + cell(p.x, low.x, cells[0]);
    vertex_cell_[v] = at;
    ++cell_first_[static_cast<std::size_t>(at)];
  }
  // Ends of cells, which filling them from behind makes their beginnings.
  std::int32_t filled = 0;
  for (std::size_t c = 0; c <= all; ++c) cell_first_[c] = filled += cell_first_[c];
  for (std::size_t v = count; v-- > 0;)
    cell_vertices_[static_cast<std::size_t>(--cell_first_[static_cast<std::size_t>(vertex_cell_[v])])] =
        static_cast<std::int32_t>(v);

  const std::size_t most = kPairsPerVertex * count;
  for (std::size_t v = 0; v < count; ++v) {
    const int x = vertex_cell_[v] % cells[0], y = vertex_cell_[v] / cells[0] % cells[1],
              z = vertex_cell_[v] / (cells[0] * cells[1]);
    for (int dz = std::max(0, z - 1); dz <= std::min(cells[2] - 1, z + 1); ++dz)
      for (int dy = std::max(0, y - 1); dy <= std::min(cells[1] - 1, y + 1); ++dy) {
        const int row = (dz * cells[1] + dy) * cells[0];
        const std::int32_t from = cell_first_[static_cast<std::size_t>(row + std::max(0, x - 1))];
        const std::int32_t to = cell_first_[static_cast<std::size_t>(row + std::min(cells[0] - 1, x + 1) + 1)];
        for (std::int32_t k = from; k < to; ++k) {
          const std::int32_t other = cell_vertices_[static_cast<std::size_t>(k)];
          if (other <= static_cast<std::int32_t>(v)) continue;
          if (pinched[v] != 0 && pinched[static_cast<std::size_t>(other)] != 0) continue;
          const ClothVertex &a = vertices[v], &b = vertices[static_cast<std::size_t>(other)];
          const float ex = a.x - b.x, ey = a.y - b.y, ez = a.z - b.z;
          if (ex * ex + ey * ey + ez * ez > search * search) continue;
          if (neighbours(static_cast<std::int32_t>(v), other)) continue;
          if (pairs_.size() == most) return;
          pairs_.push_back({static_cast<std::int32_t>(v), other});
        }
      }
  }
}

void ClothLayers::solve(std::span<ClothVertex> vertices, std::span<const ClothVertex> before) const {
  const float apart = apart_mm();
  for (const auto& pair : pairs_) {
    ClothVertex &a = vertices[static_cast<std::size_t>(pair[0])], &b = vertices[static_cast<std::size_t>(pair[1])];
    const float dx = a.x - b.x, dy = a.y - b.y, dz = a.z - b.z;
    const float squared = dx * dx + dy * dy + dz * dz;
    if (squared >= apart * apart || squared < 1e-6F) continue;
    const float length = std::sqrt(squared);
    const float push = 0.25F * (apart - length) / length;
    const ClothVertex &was_a = before[static_cast<std::size_t>(pair[0])],
                      &was_b = before[static_cast<std::size_t>(pair[1])];
    const float rx = ((a.x - was_a.x) - (b.x - was_b.x)) * kRub, ry = ((a.y - was_a.y) - (b.y - was_b.y)) * kRub,
                rz = ((a.z - was_a.z) - (b.z - was_b.z)) * kRub;
    a.x += dx * push - rx;
    a.y += dy * push - ry;
    a.z += dz * push - rz;
    b.x -= dx * push - rx;
    b.y -= dy * push - ry;
    b.z -= dz * push - rz;
  }
}

}  // namespace im2fit::body
