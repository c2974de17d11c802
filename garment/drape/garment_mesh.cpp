// SPDX-License-Identifier: Apache-2.0
#include "garment/drape/garment_mesh.h"

#include <algorithm>
#include <cmath>

#include "garment/drape/flat_places.h"
#include "garment/drape/triangulation.h"

namespace im2fit::body {
namespace {

constexpr float kNoRimMm = 1e4F;
constexpr float kLongSleeve = 0.75F;   // of the arm
constexpr float kBelowSleeveMm = 100;  // the underarm, across the sleeve

// Of an edge: what its inner points and ends lie on.
std::uint8_t border_of(EdgeKind kind) {
  if (kind == EdgeKind::seam) return kOnSeam;
  if (kind == EdgeKind::hem) return kOnHem;
  return kind == EdgeKind::opening ? kOnOpening : 0;
}

class Sewing {
 public:
  Sewing(const GarmentPattern& pattern, const CutBody& body, float edge_mm)
      : cut_(cut(pattern, body, edge_mm)), gusset_(pattern.gusset), edge_mm_(edge_mm) {
    mesh_.edge_mm = edge_mm;
    mesh_.hang = pattern.hang;
    mesh_.legs = pattern.legs;
    mesh_.body = body;
    close_with_fold();
  }

  GarmentMesh run() {
    outline_vertices();
    for (const std::uint8_t layer : {kFrontLayer, kBackLayer}) fill(layer);
    mirror();
    compact();
    measure_rims();
    find_underarm();
    let_in_gusset();
    return std::move(mesh_);
  }

 private:
  // An outline that ends elsewhere than it began is closed by the fold along the centre.
  void close_with_fold() {
    CutPattern::Line fold;
    fold.kind = EdgeKind::centre;
    for (const bool back : {false, true}) {
      const Flat from = back ? cut_.lines.back().back.back() : cut_.lines.back().front.back();
      const Flat to = back ? cut_.lines.front().back.front() : cut_.lines.front().front.front();
      const float length = std::fabs(from.y - to.y) + std::fabs(from.x - to.x);
      if (length < 1e-3F) return;
      const int steps = std::max(1, static_cast<int>(std::ceil(length / edge_mm_)));
      for (int i = 0; i <= steps; ++i) {
        const float share = static_cast<float>(i) / static_cast<float>(steps);
        (back ? fold.back : fold.front).push_back({0, from.y + share * (to.y - from.y)});
      }
    }
    cut_.lines.push_back(std::move(fold));
  }

  int add(Flat place, std::uint8_t layer) {
    mesh_.flat.push_back(place);
    mesh_.layer.push_back(layer);
    mesh_.border.push_back(0);
    mesh_.side.push_back(1);
    return static_cast<int>(mesh_.flat.size()) - 1;
  }
  void mark(int vertex, EdgeKind kind) {
    mesh_.border[static_cast<std::size_t>(vertex)] |= border_of(kind);
    if (kind == EdgeKind::centre) mesh_.side[static_cast<std::size_t>(vertex)] = 0;
  }

  void outline_vertices() {
    const std::size_t count = cut_.lines.size();
    // Corners are shared by both layers where a seam begins or ends.
    std::vector<std::array<int, 2>> corner(count);
    for (std::size_t i = 0; i < count; ++i) {
      const CutPattern::Line& before = cut_.lines[(i + count - 1) % count];
      const bool shared = cut_.lines[i].kind == EdgeKind::seam || before.kind == EdgeKind::seam;
      const int front = add(cut_.lines[i].front.front(), shared ? kBothLayers : kFrontLayer);
      corner[i] = {front, shared ? front : add(cut_.lines[i].back.front(), kBackLayer)};
    }
    for (std::size_t i = 0; i < count; ++i) {
      const CutPattern::Line& line = cut_.lines[i];
      const std::size_t next = (i + 1) % count;
      std::vector<int> shared;
      for (const std::uint8_t layer : {kFrontLayer, kBackLayer}) {
        const std::vector<Flat>& places = layer == kBackLayer ? line.back : line.front;
        outline_[layer].push_back(corner[i][layer]);
        for (std::size_t k = 1; k + 1 < places.size(); ++k) {
          const bool seam = line.kind == EdgeKind::seam;
          int vertex = 0;
          if (seam && layer == kBackLayer) {
            vertex = shared[k - 1];
          } else {
            vertex = add(places[k], seam ? kBothLayers : layer);
            shared.push_back(vertex);
          }
          mark(vertex, line.kind);
          outline_[layer].push_back(vertex);
        }
        mark(corner[i][layer], line.kind);
        mark(corner[next][layer], line.kind);
      }
    }
  }

  void fill(std::uint8_t layer) {
    std::vector<Flat> places;
    for (const int v : outline_[layer]) places.push_back(mesh_.flat[static_cast<std::size_t>(v)]);
    const FilledPanel panel = fill_panel(places, edge_mm_);
    std::vector<int> vertex = outline_[layer];
    for (std::size_t i = places.size(); i < panel.points.size(); ++i) vertex.push_back(add(panel.points[i], layer));
    for (const auto& t : panel.triangles) {
      const auto at = [&](std::size_t k) { return vertex[static_cast<std::size_t>(t[k])]; };
      // Seen from outside the back's left half lies on the right.
      mesh_.triangles.push_back(layer == kFrontLayer ? std::array<std::int32_t, 3>{at(0), at(1), at(2)}
                                                     : std::array<std::int32_t, 3>{at(0), at(2), at(1)});
    }
  }

  void mirror() {
    const std::size_t half = mesh_.flat.size();
    std::vector<int> twin(half);
    for (std::size_t v = 0; v < half; ++v) {
      twin[v] = static_cast<int>(v);
      if (mesh_.side[v] == 0) continue;
      twin[v] = add(mesh_.flat[v], mesh_.layer[v]);
      mesh_.side.back() = -1;
      mesh_.border.back() = mesh_.border[v];
    }
    const std::size_t triangles = mesh_.triangles.size();
    for (std::size_t t = 0; t < triangles; ++t) {
      const auto& left = mesh_.triangles[t];
      const auto at = [&](std::size_t k) { return twin[static_cast<std::size_t>(left[k])]; };
      mesh_.triangles.push_back({at(0), at(2), at(1)});
    }
  }

  // A vertex without a triangle has no mass: it would end as not-a-number.
  void compact() {
    std::vector<int> number(mesh_.flat.size(), -1);
    for (const auto& t : mesh_.triangles)
      for (const std::int32_t v : t) number[static_cast<std::size_t>(v)] = 0;
    int used = 0;
    for (std::size_t v = 0; v < number.size(); ++v) {
      if (number[v] < 0) continue;
      const auto to = static_cast<std::size_t>(used);
      mesh_.flat[to] = mesh_.flat[v];
      mesh_.side[to] = mesh_.side[v];
      mesh_.layer[to] = mesh_.layer[v];
      mesh_.border[to] = mesh_.border[v];
      number[v] = used++;
    }
    const auto count = static_cast<std::size_t>(used);
    mesh_.flat.resize(count);
    mesh_.side.resize(count);
    mesh_.layer.resize(count);
    mesh_.border.resize(count);
    for (auto& t : mesh_.triangles)
      for (std::int32_t& v : t) v = number[static_cast<std::size_t>(v)];
  }

  void measure_rims() {
    std::array<FlatPlaces, 3> rims;  // that a layer's vertices share a panel with
    for (std::size_t v = 0; v < mesh_.flat.size(); ++v) {
      if ((mesh_.border[v] & (kOnHem | kOnOpening)) == 0 || mesh_.side[v] < 0) continue;
      for (const std::uint8_t layer : {kFrontLayer, kBackLayer, kBothLayers})
        if (layer == mesh_.layer[v] || layer == kBothLayers || mesh_.layer[v] == kBothLayers)
          rims[layer].add(mesh_.flat[v], v);
    }
    mesh_.rim_mm.reserve(mesh_.flat.size());
    for (std::size_t v = 0; v < mesh_.flat.size(); ++v)
      mesh_.rim_mm.push_back(std::min(kNoRimMm, std::sqrt(rims[mesh_.layer[v]].nearest(mesh_.flat[v]).squared_mm)));
  }

  // Of the seams below the sleeve's middle line what lies farthest in and up.
  void find_underarm() {
    const float shoulder_x = mesh_.body[static_cast<std::size_t>(CutMeasure::shoulder_x)];
    float least = 1e30F;
    for (std::size_t v = 0; v < mesh_.flat.size(); ++v) {
      const Flat f = mesh_.flat[v];
      const bool below = f.y * kSleeveCosine + (f.x - shoulder_x) * kSleeveSine < 0;
      if ((mesh_.border[v] & kOnSeam) == 0 || !below || f.x - f.y >= least) continue;
      least = f.x - f.y;
      mesh_.underarm = f;
    }
  }

  // The square of the remaining share of the reach: the length has no step, and no kink where the reach ends.
  void let_in_gusset() {
    mesh_.longer.assign(mesh_.flat.size(), 1.0F);
    if (gusset_.at < 0) return;
    for (std::size_t v = 0; v < mesh_.flat.size(); ++v) {
      const float dx = mesh_.flat[v].x - cut_.gusset_at.x, dy = mesh_.flat[v].y - cut_.gusset_at.y;
      const float left = std::max(0.0F, 1 - std::sqrt(dx * dx + dy * dy) / gusset_.reach_mm);
      mesh_.longer[v] += gusset_.more * left * left;
    }
  }

  CutPattern cut_;
  Gusset gusset_;
  float edge_mm_;
  GarmentMesh mesh_;
  std::array<std::vector<int>, 2> outline_;  // of the left half, by layer
};

}  // namespace

float GarmentMesh::length_mm(std::size_t a, std::size_t b) const {
  const float dx = flat[a].x - flat[b].x, dy = flat[a].y - flat[b].y;
  return std::sqrt(dx * dx + dy * dy) * ((longer[a] + longer[b]) / 2);
}

bool reaches_hand(const GarmentMesh& mesh) {
  if (mesh.hang != Hang::shoulders) return false;
  const auto of = [&](CutMeasure m) { return mesh.body[static_cast<std::size_t>(m)]; };
  for (const Flat& f : mesh.flat) {
    const float along = (f.x - of(CutMeasure::shoulder_x)) * kSleeveCosine - f.y * kSleeveSine;
    const float above = (f.x - mesh.underarm.x) * kSleeveSine + (f.y - mesh.underarm.y) * kSleeveCosine;
    if (along > kLongSleeve * of(CutMeasure::arm) && above > -kBelowSleeveMm) return true;  // hems lie far below
  }
  return false;
}

void add_seam_distances_mm(const GarmentMesh& mesh, std::vector<float>& out) {
  FlatPlaces seams;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
    if ((mesh.border[v] & kOnSeam) != 0 && mesh.side[v] >= 0) seams.add(mesh.flat[v], v);
  for (const Flat& f : mesh.flat) out.push_back(std::sqrt(seams.nearest(f).squared_mm));
}

GarmentMesh sew(const GarmentPattern& pattern, const CutBody& body, float edge_mm) {
  return Sewing(pattern, body, edge_mm).run();
}

}  // namespace im2fit::body
