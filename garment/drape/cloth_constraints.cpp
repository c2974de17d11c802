// SPDX-License-Identifier: Apache-2.0
#include "garment/drape/cloth_constraints.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace im2fit::body {
namespace {

constexpr float kBandShare = 0.95F;  // a band's own length of the edge it holds
constexpr float kBandStiffness = 3;  // ribs and hems are of several layers
constexpr float kHemBending = 4;
constexpr float kSeamBending = 2;
constexpr float kHemMass = 1.6F;
constexpr float kRimPull = 0.5F;  // of the way to a smooth rim, a pass: hems and bands are folded over and stitched
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
  Builder(const GarmentMesh& mesh, const Fabric& fabric, float step_s)
      : mesh_(mesh), fabric_(fabric), step_s_(step_s) {}

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
    span_rims(out);
    return out;
  }

 private:
  Flat flat(std::int32_t v) const { return mesh_.flat[static_cast<std::size_t>(v)]; }
  float distance(std::int32_t a, std::int32_t b) const {
    return mesh_.length_mm(static_cast<std::size_t>(a), static_cast<std::size_t>(b));
  }
  bool on(std::int32_t v, std::uint8_t border) const {
    return (mesh_.border[static_cast<std::size_t>(v)] & border) != 0;
  }

  float mass_of(std::int32_t v) const { return mass_[static_cast<std::size_t>(v)]; }

  void weigh() {
    mass_.assign(mesh_.vertex_count(), 0);
    const float kg_per_mm2 = fabric_.weight_g_m2 * 1e-9F;
    for (const auto& t : mesh_.triangles) {
      const Flat a = flat(t[0]), b = flat(t[1]), c = flat(t[2]);
      const float area = std::fabs((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)) / 2;
      for (const std::int32_t v : t) {
        const float longer = mesh_.longer[static_cast<std::size_t>(v)];
        mass_[static_cast<std::size_t>(v)] += kg_per_mm2 * area * (longer * longer) / 3;
      }
    }
    for (std::size_t v = 0; v < mass_.size(); ++v)
      if ((mesh_.border[v] & (kOnHem | kOnOpening)) != 0) mass_[v] *= kHemMass;
  }

  // A side of a triangle, as it is gone along.
  struct Side {
    std::int32_t from, to, opposite;
    std::int32_t low() const { return std::min(from, to); }
    std::int32_t high() const { return std::max(from, to); }
  };

  // In ascending order of low(), then high(); those of one edge in the order of the mesh.
  std::vector<Side> sides() const {
    std::vector<std::size_t> first(mesh_.vertex_count() + 1, 0);
    for (const auto& t : mesh_.triangles)
      for (std::size_t k = 0; k < 3; ++k) ++first[static_cast<std::size_t>(std::min(t[k], t[(k + 1) % 3])) + 1];
    for (std::size_t v = 0; v < mesh_.vertex_count(); ++v) first[v + 1] += first[v];
    std::vector<std::size_t> end(first.begin(), first.end() - 1);
    std::vector<Side> sorted(3 * mesh_.triangles.size());
    for (const auto& t : mesh_.triangles)
      for (std::size_t k = 0; k < 3; ++k) {
        const Side side = {t[k], t[(k + 1) % 3], t[(k + 2) % 3]};
        const auto low = static_cast<std::size_t>(side.low());
        std::size_t at = end[low]++;
        for (; at > first[low] && sorted[at - 1].high() > side.high(); --at) sorted[at] = sorted[at - 1];
        sorted[at] = side;
      }
    return sorted;
  }

  void collect() {
    const std::vector<Side> all = sides();
    rim_next_.assign(mesh_.vertex_count(), -1);
    for (std::size_t i = 0; i < all.size();) {
      const Side& side = all[i];
      std::size_t end = i + 1;
      while (end < all.size() && all[end].low() == side.low() && all[end].high() == side.high()) ++end;
      const bool free = end == i + 1;
      if (free) rim_next_[static_cast<std::size_t>(side.from)] = side.to;
      add_edge(side.low(), side.high(), free);
      if (!free) add_hinge(side.low(), side.high(), side.opposite, all[i + 1].opposite);
      i = end;
    }
  }

  void span_rims(ClothConstraints& out) const {
    for (std::int32_t first = 0; first < static_cast<std::int32_t>(rim_next_.size()); ++first) {
      RimSpan span{};
      std::size_t length = 0;
      for (std::int32_t at = first; at >= 0 && length < 5; at = rim_next_[static_cast<std::size_t>(at)])
        if (rim_next_[static_cast<std::size_t>(at)] >= 0) span.vertex[length++] = at;
      // A rim of fewer vertices would meet itself.
      if (length < 5 || std::find(span.vertex.begin() + 1, span.vertex.end(), first) != span.vertex.end()) continue;
      float sum = 0;
      for (std::size_t k = 0; k < 5; ++k) sum += kRimFactor[k] * kRimFactor[k] / mass_of(span.vertex[k]);
      for (std::size_t k = 0; k < 5; ++k) span.share[k] = kRimPull * kRimFactor[k] / mass_of(span.vertex[k]) / sum;
      out.rims.push_back(span);
    }
  }

  void add_edge(std::int32_t a, std::int32_t b, bool free) {
    const float length = distance(a, b);
    const float dx = flat(a).x - flat(b).x, dy = flat(a).y - flat(b).y;
    const float drawn = std::sqrt(dx * dx + dy * dy);
    const float along_warp = drawn > 0 ? std::fabs(dy) / drawn : 0;
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
    std::vector<std::uint8_t> colour(list.size());
    std::array<std::size_t, kColoursMax + 1> first{};  // of each colour; at the end: their ends
    int most = 0;
    for (std::size_t i = 0; i < list.size(); ++i) {
      std::uint64_t taken = 0;
      for (const std::int32_t v : vertices_of(list[i])) taken |= used[static_cast<std::size_t>(v)];
      int c = 0;
      while (c + 1 < kColoursMax && ((taken >> c) & 1U) != 0) ++c;
      for (const std::int32_t v : vertices_of(list[i])) used[static_cast<std::size_t>(v)] |= std::uint64_t{1} << c;
      colour[i] = static_cast<std::uint8_t>(c);
      ++first[static_cast<std::size_t>(c) + 1];
      most = std::max(most, c + 1);
    }
    for (std::size_t c = 1; c < first.size(); ++c) first[c] += first[c - 1];
    std::vector<T> sorted(list.size());
    for (std::size_t i = 0; i < list.size(); ++i) sorted[first[colour[i]]++] = list[i];
    list.swap(sorted);
    return most;
  }

  struct Four {
    std::array<std::size_t, 4> index{};
    std::size_t count = 0;
  };
  // Fours of the list, in order, that share no vertex: one that does waits for a later four.
  template <class T, class F>
  std::vector<Four> fours(const std::vector<T>& list, F vertices_of) {
    std::vector<std::uint8_t> done(list.size(), 0);
    std::vector<Four> out;
    std::vector<std::int32_t> taken;
    std::size_t first = 0;
    while (first < list.size()) {
      Four four;
      taken.clear();
      for (std::size_t i = first; i < list.size() && four.count < four.index.size(); ++i) {
        if (done[i] != 0) continue;
        const auto vertices = vertices_of(list[i]);
        const bool free = std::none_of(vertices.begin(), vertices.end(), [&](std::int32_t v) {
          return std::find(taken.begin(), taken.end(), v) != taken.end();
        });
        if (!free) continue;
        taken.insert(taken.end(), vertices.begin(), vertices.end());
        four.index[four.count++] = i;
        done[i] = 1;
      }
      out.push_back(four);
      while (first < list.size() && done[first] != 0) ++first;
    }
    return out;
  }

  void pack(ClothConstraints& out) {
    const float inverse_h2 = 1 / (step_s_ * step_s_);
    const auto unused = static_cast<std::int32_t>(mesh_.vertex_count());
    const auto weight = [&](std::int32_t v) { return 1 / mass_of(v); };
    for (const auto& four : fours(edges_, [](const Edge& e) { return std::array{e.a, e.b}; })) {
      StretchBatch batch{{unused, unused, unused, unused}, {unused, unused, unused, unused}, {}, {}, {}};
      for (std::size_t lane = 0; lane < four.count; ++lane) {
        const int l = static_cast<int>(lane);
        const Edge& e = edges_[four.index[lane]];
        batch.a[lane] = e.a;
        batch.b[lane] = e.b;
        batch.length[l] = e.length;
        const float stiff = (weight(e.a) + weight(e.b)) + e.compliance * inverse_h2;
        batch.share_a[l] = weight(e.a) / stiff;
        batch.share_b[l] = weight(e.b) / stiff;
        if (e.band) out.band.push_back({four.index[lane], out.stretch.size(), l, e.length});
      }
      out.stretch.push_back(batch);
    }
    for (const Hinge& h : hinges_) {
      // Bending is soft: every second step at twice the step's compliance is as good and half the work.
      float stiff = h.compliance * (inverse_h2 / 2);
      for (std::size_t k = 0; k < 4; ++k) stiff += weight(h.vertex[k]) * (h.factor[k] * h.factor[k]);
      BendHinge hinge{h.vertex, {}, {}};
      for (std::size_t k = 0; k < 4; ++k) {
        hinge.factor[static_cast<int>(k)] = h.factor[k];
        hinge.share[static_cast<int>(k)] = h.factor[k] * weight(h.vertex[k]) / stiff;
      }
      out.bend.push_back(hinge);
    }
  }

  const GarmentMesh& mesh_;
  const Fabric& fabric_;
  const float step_s_;
  std::vector<float> mass_;  // kg, a vertex each
  std::vector<Edge> edges_;
  std::vector<Hinge> hinges_;
  std::vector<std::int32_t> rim_next_;  // of each vertex, along edges of one triangle; -1: none
};

}  // namespace

ClothConstraints constrain(const GarmentMesh& mesh, const Fabric& fabric, float step_s) {
  return Builder(mesh, fabric, step_s).run();
}

// XPBD (Macklin et al. 2016) with one pass a substep, so without multipliers to carry (Macklin et al. 2019): equation
// 18 with C = |a - b| - length.
void solve_stretch(std::span<const StretchBatch> batches, ClothVertex* vertices) {
  for (const StretchBatch& batch : batches) {
    std::array<Float4, 4> a, b, d;
    for (std::size_t k = 0; k < 4; ++k) {
      a[k] = load(vertices[batch.a[k]]);
      b[k] = load(vertices[batch.b[k]]);
      d[k] = a[k] - b[k];
    }
    Float4 x = d[0], y = d[1], z = d[2], none = d[3];
    transpose(x, y, z, none);
    const Float4 length = sqrt_of((x * x + y * y) + (z * z + all_of(1e-6F)));
    const Float4 excess = (length - batch.length) / length;
    const Float4 back_a = excess * batch.share_a, back_b = excess * batch.share_b;
    for (std::size_t k = 0; k < 4; ++k) {
      const int lane = static_cast<int>(k);
      store(vertices[batch.a[k]], a[k] - d[k] * all_of(back_a[lane]));
      store(vertices[batch.b[k]], b[k] + d[k] * all_of(back_b[lane]));
    }
  }
}

// The same for the vector C = sum of k_i x_i, whose gradient for vertex i is k_i times the identity.
void solve_bend(std::span<const BendHinge> hinges, ClothVertex* vertices) {
  for (const BendHinge& hinge : hinges) {
    std::array<Float4, 4> p;
    for (std::size_t k = 0; k < 4; ++k) p[k] = load(vertices[hinge.vertex[k]]);
    const Float4 f = hinge.factor;
    const Float4 bend = (p[0] * all_of(f[0]) + p[1] * all_of(f[1])) + (p[2] * all_of(f[2]) + p[3] * all_of(f[3]));
    for (std::size_t k = 0; k < 4; ++k)
      store(vertices[hinge.vertex[k]], p[k] - bend * all_of(hinge.share[static_cast<int>(k)]));
  }
}

void solve_rims(std::span<const RimSpan> rims, ClothVertex* vertices) {
  for (const RimSpan& rim : rims) {
    std::array<Float4, 5> p;
    for (std::size_t k = 0; k < 5; ++k) p[k] = load(vertices[rim.vertex[k]]);
    const Float4 off = (p[0] + p[4]) * all_of(kRimFactor[0]) + (p[1] + p[3]) * all_of(kRimFactor[1]) + p[2];
    for (std::size_t k = 0; k < 5; ++k) store(vertices[rim.vertex[k]], p[k] - off * all_of(rim.share[k]));
  }
}

}  // namespace im2fit::body
