// SPDX-License-Identifier: Apache-2.0
#include "body/garment/cloth_constraints.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <utility>

namespace im2fit::body {
namespace {

constexpr float kBandShare = 0.95F;  // a band's own length of the edge it holds
constexpr float kBandStiffness = 3;  // ribs and hems are of several layers
constexpr float kHemBending = 4;
constexpr float kSeamBending = 2;
constexpr float kHemMass = 1.6F;
constexpr int kColoursMax = 64;

struct Edge {
  std::int32_t a, b;
  float length, compliance;
  bool band;
};
struct Hinge {
  std::array<std::int32_t, 4> vertex;  // the edge's ends, then the two opposite
  std::array<float, 4> factor;
  float compliance;
};

class Builder {
 public:
  Builder(const GarmentMesh& mesh, const Fabric& fabric) : mesh_(mesh), fabric_(fabric) {}

  ClothConstraints run() {
    weigh();
    collect();
    ClothConstraints out;
    out.stretch_colours = sort_by_colour(edges_, [](const Edge& e) { return std::array{e.a, e.b}; });
    out.bend_colours = sort_by_colour(hinges_, [](const Hinge& h) { return h.vertex; });
    for (const Edge& e : edges_) {
      out.edges.push_back({e.a, e.b});
      out.edge_mm.push_back(e.length);
    }
    pack(out);
    out.mass_kg = std::move(mass_);
    return out;
  }

 private:
  Flat flat(std::int32_t v) const { return mesh_.flat[static_cast<std::size_t>(v)]; }
  float distance(std::int32_t a, std::int32_t b) const {
    const float dx = flat(a).x - flat(b).x, dy = flat(a).y - flat(b).y;
    return std::sqrt(dx * dx + dy * dy);
  }
  bool on(std::int32_t v, std::uint8_t border) const {
    return (mesh_.border[static_cast<std::size_t>(v)] & border) != 0;
  }

  void weigh() {
    mass_.assign(mesh_.vertex_count(), 0);
    const float kg_per_mm2 = fabric_.weight_g_m2 * 1e-9F;
    for (const auto& t : mesh_.triangles) {
      const Flat a = flat(t[0]), b = flat(t[1]), c = flat(t[2]);
      const float area = std::fabs((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)) / 2;
      for (const std::int32_t v : t) mass_[static_cast<std::size_t>(v)] += kg_per_mm2 * area / 3;
    }
    for (std::size_t v = 0; v < mass_.size(); ++v)
      if ((mesh_.border[v] & (kOnHem | kOnOpening)) != 0) mass_[v] *= kHemMass;
  }

  void collect() {
    // Ends in ascending order -> the vertices opposite.
    std::map<std::pair<std::int32_t, std::int32_t>, std::array<std::int32_t, 2>> found;
    for (const auto& t : mesh_.triangles)
      for (std::size_t k = 0; k < 3; ++k) {
        const std::int32_t a = t[k], b = t[(k + 1) % 3], opposite = t[(k + 2) % 3];
        const auto [at, is_new] =
            found.insert({{std::min(a, b), std::max(a, b)}, std::array<std::int32_t, 2>{opposite, -1}});
        if (!is_new && at->second[1] < 0) at->second[1] = opposite;
      }
    for (const auto& [ends, opposite] : found) {
      add_edge(ends.first, ends.second, opposite[1] < 0);
      if (opposite[1] >= 0) add_hinge(ends.first, ends.second, opposite[0], opposite[1]);
    }
  }

  void add_edge(std::int32_t a, std::int32_t b, bool free) {
    const float length = distance(a, b);
    const float along_warp = length > 0 ? std::fabs(flat(a).y - flat(b).y) / length : 0;
    const float share = along_warp * along_warp;
    float stiffness = share * fabric_.stretch_warp_n_m + (1 - share) * fabric_.stretch_weft_n_m;
    const bool band = free && on(a, kOnOpening) && on(b, kOnOpening);
    if (band) stiffness *= kBandStiffness;
    edges_.push_back({a, b, length * (band ? kBandShare : 1.0F), 1 / stiffness, band});
  }

  void add_hinge(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d) {
    const float ab = distance(a, b);
    // Cotangent of the angle between two sides, opposite a third.
    const auto cotangent = [](float side, float other, float opposite) {
      const float cosine = (side * side + other * other - opposite * opposite) / (2 * side * other);
      return cosine / std::sqrt(std::max(1e-6F, 1 - cosine * cosine));
    };
    const float at_a_c = cotangent(ab, distance(a, c), distance(b, c));
    const float at_b_c = cotangent(ab, distance(b, c), distance(a, c));
    const float at_a_d = cotangent(ab, distance(a, d), distance(b, d));
    const float at_b_d = cotangent(ab, distance(b, d), distance(a, d));
    // Two triangles' areas: base² / (2 (cot + cot)) each.
    const float area = (std::fabs(ab * ab / (at_a_c + at_b_c)) + std::fabs(ab * ab / (at_a_d + at_b_d))) / 2;
    Hinge h;
    h.vertex = {a, b, c, d};
    h.factor = {at_b_c + at_b_d, at_a_c + at_a_d, -at_a_c - at_b_c, -at_a_d - at_b_d};
    float stiffness = 3 * kWeightShare * fabric_.bending_un_m / area;  // uN m / mm² = N/m
    const auto any_on = [&](std::uint8_t border) {
      return on(a, border) || on(b, border) || on(c, border) || on(d, border);
    };
    if (any_on(kOnHem | kOnOpening)) stiffness *= kHemBending;
    if (on(a, kOnSeam) && on(b, kOnSeam)) stiffness *= kSeamBending;
    h.compliance = 1 / stiffness;
    hinges_.push_back(h);
  }

  template <class T, class F>
  int sort_by_colour(std::vector<T>& list, F vertices_of) {
    std::vector<std::uint64_t> used(mesh_.vertex_count(), 0);
    std::vector<std::pair<int, std::size_t>> colour;  // of each, and its number
    int most = 0;
    for (std::size_t i = 0; i < list.size(); ++i) {
      std::uint64_t taken = 0;
      for (const std::int32_t v : vertices_of(list[i])) taken |= used[static_cast<std::size_t>(v)];
      int c = 0;
      while (c + 1 < kColoursMax && ((taken >> c) & 1U) != 0) ++c;
      for (const std::int32_t v : vertices_of(list[i])) used[static_cast<std::size_t>(v)] |= std::uint64_t{1} << c;
      colour.push_back({c, i});
      most = std::max(most, c + 1);
    }
    std::stable_sort(colour.begin(), colour.end(), [](const auto& l, const auto& r) { return l.first < r.first; });
    std::vector<T> sorted;
    sorted.reserve(list.size());
    for (const auto& [c, i] : colour) sorted.push_back(list[i]);
    list.swap(sorted);
    return most;
  }

  // Fours of the list, in order, that share no vertex: one that does waits for a later four.
  template <class T, class F>
  std::vector<std::vector<std::size_t>> fours(const std::vector<T>& list, F vertices_of) {
    std::vector<std::uint8_t> done(list.size(), 0);
    std::vector<std::vector<std::size_t>> out;
    std::size_t first = 0;
    while (first < list.size()) {
      std::vector<std::size_t> four;
      std::vector<std::int32_t> taken;
      for (std::size_t i = first; i < list.size() && four.size() < 4; ++i) {
        if (done[i] != 0) continue;
        const auto vertices = vertices_of(list[i]);
        const bool free = std::none_of(vertices.begin(), vertices.end(), [&](std::int32_t v) {
          return std::find(taken.begin(), taken.end(), v) != taken.end();
        });
        if (!free) continue;
        taken.insert(taken.end(), vertices.begin(), vertices.end());
        four.push_back(i);
        done[i] = 1;
      }
      out.push_back(four);
      while (first < list.size() && done[first] != 0) ++first;
    }
    return out;
  }

  void pack(ClothConstraints& out) {
    const auto unused = static_cast<std::int32_t>(mesh_.vertex_count());
    for (const auto& four : fours(edges_, [](const Edge& e) { return std::array{e.a, e.b}; })) {
      StretchBatch batch;
      for (std::size_t lane = 0; lane < 4; ++lane) {
        const int l = static_cast<int>(lane);
        const Edge e = lane < four.size() ? edges_[four[lane]] : Edge{unused, unused, 0, 1, false};
        batch.a[lane] = e.a;
        batch.b[lane] = e.b;
        batch.length[l] = e.length;
        batch.compliance[l] = e.compliance;
        if (e.band) out.band.push_back({four[lane], out.stretch.size(), l, e.length});
      }
      out.stretch.push_back(batch);
    }
    for (const auto& four : fours(hinges_, [](const Hinge& h) { return h.vertex; })) {
      BendBatch batch;
      for (std::size_t lane = 0; lane < 4; ++lane) {
        const int l = static_cast<int>(lane);
        const Hinge h = lane < four.size() ? hinges_[four[lane]] : Hinge{{unused, unused, unused, unused}, {}, 1};
        for (std::size_t k = 0; k < 4; ++k) {
          batch.vertex[k][lane] = h.vertex[k];
          batch.factor[k][l] = h.factor[k];
        }
        batch.compliance[l] = h.compliance;
      }
      out.bend.push_back(batch);
    }
  }

  const GarmentMesh& mesh_;
  const Fabric& fabric_;
  std::vector<float> mass_;
  std::vector<Edge> edges_;
  std::vector<Hinge> hinges_;
};

// Four vertices as rows x, y, z, inverse mass of four lanes.
struct Gathered {
  Float4 x, y, z, w;
};
inline Float4 load(const ClothVertex& vertex) {
  Float4 row;
  std::memcpy(&row, &vertex, sizeof row);
  return row;
}
inline void store(ClothVertex& vertex, Float4 row) {
  std::memcpy(static_cast<void*>(&vertex), &row, sizeof row);
}
inline Gathered gather(const ClothVertex* vertices, const std::array<std::int32_t, 4>& index) {
  Gathered g{load(vertices[index[0]]), load(vertices[index[1]]), load(vertices[index[2]]), load(vertices[index[3]])};
  transpose(g.x, g.y, g.z, g.w);
  return g;
}
inline void scatter(ClothVertex* vertices, const std::array<std::int32_t, 4>& index, Gathered g) {
  transpose(g.x, g.y, g.z, g.w);
  store(vertices[index[0]], g.x);
  store(vertices[index[1]], g.y);
  store(vertices[index[2]], g.z);
  store(vertices[index[3]], g.w);
}

}  // namespace

ClothConstraints constrain(const GarmentMesh& mesh, const Fabric& fabric) {
  return Builder(mesh, fabric).run();
}

// XPBD (Macklin et al. 2016) with one pass a substep, so without multipliers to carry (Macklin et al. 2019): equation
// 18 with C = |a - b| - length.
void solve_stretch(std::span<const StretchBatch> batches, float inverse_h2, ClothVertex* vertices) {
  for (const StretchBatch& batch : batches) {
    Gathered a = gather(vertices, batch.a), b = gather(vertices, batch.b);
    const Float4 dx = a.x - b.x, dy = a.y - b.y, dz = a.z - b.z;
    const Float4 length = sqrt_of((dx * dx + dy * dy) + (dz * dz + all_of(1e-6F)));
    const Float4 stiff = (a.w + b.w) + batch.compliance * all_of(inverse_h2);
    const Float4 s = (length - batch.length) / (length * stiff);
    const Float4 sa = s * a.w, sb = s * b.w;
    a.x -= dx * sa;
    a.y -= dy * sa;
    a.z -= dz * sa;
    b.x += dx * sb;
    b.y += dy * sb;
    b.z += dz * sb;
    scatter(vertices, batch.a, a);
    scatter(vertices, batch.b, b);
  }
}

// The same for the vector C = sum of k_i x_i, whose gradient for vertex i is k_i times the identity.
void solve_bend(std::span<const BendBatch> batches, float inverse_h2, ClothVertex* vertices) {
  for (const BendBatch& batch : batches) {
    std::array<Gathered, 4> p;
    Float4 cx{}, cy{}, cz{};
    Float4 stiff = batch.compliance * all_of(inverse_h2);
    for (std::size_t k = 0; k < 4; ++k) {
      p[k] = gather(vertices, batch.vertex[k]);
      const Float4 f = batch.factor[k];
      cx += f * p[k].x;
      cy += f * p[k].y;
      cz += f * p[k].z;
      stiff += p[k].w * (f * f);
    }
    const Float4 scale = all_of(-1) / stiff;
    cx *= scale;
    cy *= scale;
    cz *= scale;
    for (std::size_t k = 0; k < 4; ++k) {
      const Float4 weight = batch.factor[k] * p[k].w;
      p[k].x += cx * weight;
      p[k].y += cy * weight;
      p[k].z += cz * weight;
      scatter(vertices, batch.vertex[k], p[k]);
    }
  }
}

}  // namespace im2fit::body
