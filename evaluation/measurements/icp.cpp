// SPDX-License-Identifier: Apache-2.0
#include "evaluation/measurements/icp.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nanoflann.hpp>

namespace im2fit::lab {
namespace {

using Vec = Eigen::Vector3d;

Vec vec_of(Vec3f v) {
  return {double{v.x}, double{v.y}, double{v.z}};
}

// Ericson, Real-Time Collision Detection, 5.1.5: the regions of vertices, edges, inside.
Vec closest_on_triangle(const Vec& p, const Vec& a, const Vec& b, const Vec& c) {
  const Vec ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return a;
  const Vec bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + d1 / (d1 - d3) * ab;
  const Vec cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6) return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
  const double whole = va + vb + vc;
  return a + vb / whole * ab + vc / whole * ac;
}

}  // namespace

struct MeshSurface::Impl {
  std::vector<Vec> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<Vec> normals;                     // by triangle; zero where it has no area
  std::vector<std::uint32_t> first, of_vertex;  // triangles of vertex v: of_vertex[first[v] .. first[v + 1])

  std::size_t kdtree_get_point_count() const { return vertices.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t axis) const { return vertices[i][static_cast<Eigen::Index>(axis)]; }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
  using Tree =
      nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Impl>, Impl, 3, std::uint32_t>;
  std::unique_ptr<Tree> tree;
};

MeshSurface::MeshSurface(std::span<const Vec3f> vertices, std::span<const body::Triangle> triangles)
    : impl_(std::make_unique<Impl>()) {
  Impl& m = *impl_;
  constexpr std::uint32_t kUnused = ~0U;
  std::vector<std::uint32_t> number(vertices.size(), kUnused);
  for (const body::Triangle& t : triangles) {
    std::array<std::uint32_t, 3> corners{};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto v = static_cast<std::size_t>(t[i]);
      if (number[v] == kUnused) {
        number[v] = static_cast<std::uint32_t>(m.vertices.size());
        m.vertices.push_back(vec_of(vertices[v]));
      }
      corners[i] = number[v];
    }
    m.triangles.push_back(corners);
    const Vec& a = m.vertices[corners[0]];
    m.normals.push_back((m.vertices[corners[1]] - a).cross(m.vertices[corners[2]] - a).normalized());
  }
  m.first.assign(m.vertices.size() + 1, 0);
  for (const auto& t : m.triangles)
    for (const std::uint32_t v : t) ++m.first[v + 1];
  for (std::size_t v = 0; v < m.vertices.size(); ++v) m.first[v + 1] += m.first[v];
  std::vector<std::uint32_t> next(m.first.begin(), m.first.end() - 1);
  m.of_vertex.resize(3 * m.triangles.size());
  for (std::size_t t = 0; t < m.triangles.size(); ++t)
    for (const std::uint32_t v : m.triangles[t]) m.of_vertex[next[v]++] = static_cast<std::uint32_t>(t);
  m.tree = std::make_unique<Impl::Tree>(3, m, nanoflann::KDTreeSingleIndexAdaptorParams(10));
  m.tree->buildIndex();
}
MeshSurface::~MeshSurface() = default;
MeshSurface::MeshSurface(MeshSurface&&) noexcept = default;

MeshSurface::Foot MeshSurface::closest(const Eigen::Vector3d& from) const {
  constexpr std::size_t kVertices = 4;
  std::array<std::uint32_t, kVertices> near{};
  std::array<double, kVertices> squared{};
  const std::size_t found = impl_->tree->knnSearch(from.data(), kVertices, near.data(), squared.data());
  Foot best;
  best.distance_mm = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < found; ++i)
    for (std::uint32_t k = impl_->first[near[i]]; k < impl_->first[near[i] + 1]; ++k) {
      const std::uint32_t triangle = impl_->of_vertex[k];
      const auto& [a, b, c] = impl_->triangles[triangle];
      const Vec foot = closest_on_triangle(from, impl_->vertices[a], impl_->vertices[b], impl_->vertices[c]);
      const double distance = (from - foot).norm();
      if (distance < best.distance_mm) best = {foot, impl_->normals[triangle], distance};
    }
  return best;
}

double mean_distance_mm(const MeshSurface& surface, const Cloud& cloud, const Eigen::Isometry3d& motion) {
  double sum = 0;
  for (const Vec& p : cloud) sum += surface.closest(motion * p).distance_mm;
  return cloud.empty() ? 0 : sum / static_cast<double>(cloud.size());
}

IcpTrace register_cloud(const MeshSurface& surface, const Cloud& cloud, int iterations, double reach_mm) {
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  IcpTrace trace;
  trace.error_mm.push_back(mean_distance_mm(surface, cloud, trace.motion));
  for (int i = 0; i < iterations; ++i) {
    // Turning about the middle of the cloud keeps angles and lengths apart in the equations.
    Vec centre = Vec::Zero();
    for (const Vec& p : cloud) centre += trace.motion * p / static_cast<double>(cloud.size());
    Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
    Vector6 right = Vector6::Zero();
    for (const Vec& p : cloud) {
      const Vec moved = trace.motion * p;
      const MeshSurface::Foot foot = surface.closest(moved);
      if (foot.distance_mm > reach_mm) continue;
      Vector6 row;
      row << (moved - centre).cross(foot.normal), foot.normal;
      normal += row * row.transpose();
      right -= row * foot.normal.dot(moved - foot.point);
    }
    // A whisper of damping: a cloud that slides along its surface has directions nothing holds.
    normal.diagonal() *= 1 + 1e-9;
    normal.diagonal().array() += 1e-9;
    const Vector6 step = normal.ldlt().solve(right);
    const Vec turn = step.head<3>();
    const double angle = turn.norm();
    Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
    motion.translate(centre + Vec(step.tail<3>()));
    if (angle > 0) motion.rotate(Eigen::AngleAxisd(angle, turn / angle));
    motion.translate(-centre);
    trace.motion = motion * trace.motion;
    trace.error_mm.push_back(mean_distance_mm(surface, cloud, trace.motion));
  }
  return trace;
}

}  // namespace im2fit::lab
