// SPDX-License-Identifier: Apache-2.0
#include "evaluation/garment/drape_quality.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>

namespace im2fit::lab {
namespace {

using body::Cloth;
using body::GarmentMesh;

std::vector<std::vector<std::size_t>> neighbours_of(const Cloth& cloth) {
  std::vector<std::vector<std::size_t>> out(cloth.mesh().vertex_count());
  for (const auto& e : cloth.constraints().edges) {
    out[static_cast<std::size_t>(e[0])].push_back(static_cast<std::size_t>(e[1]));
    out[static_cast<std::size_t>(e[1])].push_back(static_cast<std::size_t>(e[0]));
  }
  return out;
}

bool on_rim(const GarmentMesh& mesh, std::size_t v) {
  return (mesh.border[v] & (body::kOnHem | body::kOnOpening)) != 0;
}

// Taubin 1995: shrinks by .5 and grows by .53 in turn; rims stay.
float folds_of(const Cloth& cloth) {
  constexpr int kPasses = 20;
  const GarmentMesh& mesh = cloth.mesh();
  const auto neighbours = neighbours_of(cloth);
  std::vector<Vec3f> smooth = positions_of(cloth), next = smooth;
  for (int pass = 0; pass < 2 * kPasses; ++pass) {
    const float step = (pass & 1) != 0 ? -0.53F : 0.5F;
    for (std::size_t v = 0; v < smooth.size(); ++v) {
      if (on_rim(mesh, v) || neighbours[v].empty()) continue;
      Vec3f mean{};
      for (const std::size_t n : neighbours[v]) mean = mean + smooth[n];
      mean = mean * (1 / static_cast<float>(neighbours[v].size()));
      next[v] = smooth[v] + (mean - smooth[v]) * step;
    }
    smooth = next;
  }
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t v = 0; v < smooth.size(); ++v) {
    if (on_rim(mesh, v)) continue;
    const float off = dot(cloth.position(v) - smooth[v], cloth.normals()[v]);
    sum += static_cast<double>(off) * off;
    ++count;
  }
  return count > 0 ? static_cast<float>(std::sqrt(sum / static_cast<double>(count))) : 0;
}

// Edges of one triangle, as next vertices along the rims.
std::map<std::int32_t, std::int32_t> rim_successors(const GarmentMesh& mesh) {
  std::map<std::pair<std::int32_t, std::int32_t>, int> count;
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t a = t[k], b = t[(k + 1) % 3];
      ++count[{std::min(a, b), std::max(a, b)}];
    }
  std::map<std::int32_t, std::int32_t> next;
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t a = t[k], b = t[(k + 1) % 3];
      if (count[{std::min(a, b), std::max(a, b)}] == 1) next[a] = b;
    }
  return next;
}

// Behind the nearest skin of the limbs it covers and behind the nearest that faces as it does, looked for afresh: the
// solver leaves some of it out. Crumpled cloth may face skin far beside it, and where limbs press on each other the
// nearest may be the other one's.
Inside inside_of(const body::BodySurface& skin, const Cloth& cloth, std::span<const Vec3f> places,
                 std::span<const Vec3f> normals) {
  constexpr float kLookMm = 60;
  std::size_t count = 0;
  Inside inside;
  const auto behind_mm = [&](std::size_t v, Vec3f facing, float cosine) {
    body::SkinPlace place;
    std::int32_t hint = -1;
    if (!skin.nearest(places[v], facing, cosine, cloth.limbs(v), kLookMm, hint, place)) return 0.0F;
    return dot(skin.at(place, false) - places[v], skin.facing(place, false));
  };
  for (std::size_t v = 0; v < places.size(); ++v) {
    const float behind = std::min(behind_mm(v, {}, -1), behind_mm(v, normals[v], 0));
    if (behind <= 0) continue;
    ++count;
    inside.deepest_mm = std::max(inside.deepest_mm, behind);
  }
  inside.share = static_cast<float>(count) / static_cast<float>(places.size());
  return inside;
}

}  // namespace

std::vector<Rim> rims_of(const GarmentMesh& mesh) {
  auto next = rim_successors(mesh);
  std::vector<Rim> rims;
  while (!next.empty()) {
    Rim rim;
    std::int32_t v = next.begin()->first;
    for (auto at = next.find(v); at != next.end(); at = next.find(v)) {
      rim.vertices.push_back(v);
      v = at->second;
      next.erase(at);
    }
    rim.closed = v == rim.vertices.front();
    rims.push_back(std::move(rim));
  }
  return rims;
}

// A point between two and two others on a cubic: (4 (b + c) - (a + d)) / 6.
float rim_roughness_mm(const GarmentMesh& mesh, std::span<const Vec3f> places) {
  float worst = 0;
  for (const Rim& one : rims_of(mesh)) {
    const auto& rim = one.vertices;
    const bool closed = one.closed;
    const std::size_t n = rim.size();
    if (n < 8) continue;
    const auto at = [&](std::size_t i) { return places[static_cast<std::size_t>(rim[i % n])]; };
    for (std::size_t i = closed ? 0 : 2; i < (closed ? n : n - 2); ++i) {
      const Vec3f through = (at(i + n - 1) + at(i + 1)) * (4.0F / 6) - (at(i + n - 2) + at(i + 2)) * (1.0F / 6);
      worst = std::max(worst, norm(at(i) - through));
    }
  }
  return worst;
}

Inside judge_inside(const body::BodySurface& skin, const Cloth& cloth, std::span<const Vec3f> places) {
  std::vector<Vec3f> normals(places.size());
  for (const auto& t : cloth.mesh().triangles) {
    const auto a = static_cast<std::size_t>(t[0]), b = static_cast<std::size_t>(t[1]),
               c = static_cast<std::size_t>(t[2]);
    const Vec3f n = cross(places[b] - places[a], places[c] - places[a]);
    for (const std::size_t v : {a, b, c}) normals[v] = normals[v] + n;
  }
  for (Vec3f& n : normals) n = normalized(n);
  return inside_of(skin, cloth, places, normals);
}

DrapeQuality judge(const body::Outfit& outfit, std::size_t index) {
  const Cloth& cloth = outfit.cloth(index);
  DrapeQuality q;
  const auto positions = positions_of(cloth);
  const auto normals = cloth.normals();
  for (const Vec3f& p : positions)
    q.finite = q.finite && std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
  if (!q.finite) return q;

  std::vector<float> strain;
  double sum = 0;
  const auto& constraints = cloth.constraints();
  for (std::size_t e = 0; e < constraints.edges.size(); ++e) {
    const auto& ends = constraints.edges[e];
    const float length =
        norm(positions[static_cast<std::size_t>(ends[0])] - positions[static_cast<std::size_t>(ends[1])]);
    strain.push_back(length / constraints.edge_mm[e] - 1);
    sum += static_cast<double>(strain.back());
  }
  std::sort(strain.begin(), strain.end());
  q.strain_mean = static_cast<float>(sum / static_cast<double>(strain.size()));
  q.strain_p95 = strain[strain.size() * 95 / 100];
  q.strain_peak = strain.back();

  const Inside inside = inside_of(outfit.skin(), cloth, positions, normals);
  q.inside_share = inside.share;
  q.inside_deepest_mm = inside.deepest_mm;
  q.folds_mm = folds_of(cloth);
  q.hem_roughness_mm = rim_roughness_mm(cloth.mesh(), positions);
  return q;
}

std::vector<Vec3f> positions_of(const Cloth& cloth) {
  std::vector<Vec3f> out;
  for (std::size_t v = 0; v < cloth.mesh().vertex_count(); ++v) out.push_back(cloth.position(v));
  return out;
}

Motion motion_since(const Cloth& cloth, const std::vector<Vec3f>& before) {
  Motion m;
  double sum = 0;
  for (std::size_t v = 0; v < before.size(); ++v) {
    const float d = norm(cloth.position(v) - before[v]);
    sum += static_cast<double>(d) * d;
    m.most_mm = std::max(m.most_mm, d);
  }
  m.rms_mm = static_cast<float>(std::sqrt(sum / static_cast<double>(before.size())));
  return m;
}

float hem_girth_mm(const Cloth& cloth, bool in_pattern) {
  const GarmentMesh& mesh = cloth.mesh();
  float lowest = 1e9F, girth = 0;
  for (const auto& [rim, closed] : rims_of(mesh)) {
    float y = 0, length = 0;
    for (std::size_t i = 0; i < rim.size(); ++i) {
      const auto a = static_cast<std::size_t>(rim[i]), b = static_cast<std::size_t>(rim[(i + 1) % rim.size()]);
      y += mesh.flat[a].y / static_cast<float>(rim.size());
      if (!closed && i + 1 == rim.size()) continue;
      const float dx = mesh.flat[a].x - mesh.flat[b].x, dy = mesh.flat[a].y - mesh.flat[b].y;
      length += in_pattern ? std::sqrt(dx * dx + dy * dy) : norm(cloth.position(a) - cloth.position(b));
    }
    if (y >= lowest) continue;
    lowest = y;
    girth = length;
  }
  return girth;
}

std::uint64_t fingerprint(const Cloth& cloth) {
  std::uint64_t hash = 14695981039346656037U;
  for (std::size_t v = 0; v < cloth.mesh().vertex_count(); ++v) {
    const Vec3f p = cloth.position(v);
    for (const float c : {p.x, p.y, p.z}) {
      auto bits = std::bit_cast<std::uint32_t>(c);
      for (int i = 0; i < 4; ++i, bits >>= 8U) hash = (hash ^ (bits & 0xFFU)) * 1099511628211U;
    }
  }
  return hash;
}

}  // namespace im2fit::lab
