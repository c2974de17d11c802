// SPDX-License-Identifier: Apache-2.0
#include "evaluation/measurements/icp.h"

#include <fmt/core.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nanoflann.hpp>
#include <nlohmann/json.hpp>
#include <optional>

#include "body/person_axes.h"
#include "formats/json_file.h"
#include "person/avatar.h"

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

namespace {

constexpr int kTriedPerWanted = 4;

Cloud fused_cloud(const Engine& engine, const Intrinsics& upright, const body::PersonAxes& axes) {
  const auto depth = engine.fused_depth_q4();
  const MaskView mask = engine.fused_mask();
  Cloud all;
  for (int v = 0; v < depth.height; ++v)
    for (int u = 0; u < depth.width; ++u) {
      if (mask.at(u, v) == 0 || depth.at(u, v) == 0) continue;
      const float z_mm = static_cast<float>(depth.at(u, v)) / 16;
      all.push_back(vec_of(axes.to_mesh(unproject(upright, static_cast<float>(u), static_cast<float>(v), z_mm))));
    }
  const std::size_t step = std::max<std::size_t>(1, (all.size() + kIcpPointsMost - 1) / kIcpPointsMost);
  Cloud downsampled;
  for (std::size_t i = 0; i < all.size(); i += step) downsampled.push_back(all[i]);
  return downsampled;
}

Result<std::optional<IcpCase>> icp_case(const SessionModels& models, const HeldOutPerson& person, Views views) {
  const auto engine = run_session(models, person, views, {});
  if (!engine) return engine.error();
  const EngineResult result = (*engine)->result();
  if (!result.measured) return std::optional<IcpCase>{};
  body::MeasurementFitter fitter(models.body);
  const auto body = body_of_answer(fitter, result.answer, result.measured_joints, result.floor, result.seen);
  if (!body) return body.error();
  std::vector<Vec3f> rest(static_cast<std::size_t>(models.body.vertex_count()));
  models.body.morph(body->params, rest);
  IcpCase out;
  const auto& truth = person.subject.truth;
  out.who =
      fmt::format("{}, {:.0f} mm, {:.0f} kg", person.subject.woman ? "woman" : "man",
                  truth[measurement_index(Measurement::stature)], truth[measurement_index(Measurement::weight)]);
  out.vertices.resize(rest.size());
  body::skin(models.body, rest, body::rest_skeleton(models.body, rest), body->pose, out.vertices);
  const Intrinsics upright = hal::rotate_upright(person.capture.intrinsics, person.capture.scene.rotate_deg);
  out.cloud = fused_cloud(**engine, upright, body::PersonAxes(result.measured_joints, result.floor));
  return std::optional<IcpCase>{std::move(out)};
}

}  // namespace

Result<std::vector<IcpCase>> icp_cases(const SessionModels& models, const EvaluationOptions& options, int count) {
  std::vector<IcpCase> cases;
  for (int i = 0; i < kTriedPerWanted * count && cases.size() < static_cast<std::size_t>(count); ++i) {
    const HeldOutPerson person = draw_person(models.body, options, static_cast<std::uint64_t>(i));
    auto made = icp_case(models, person, options.views);
    if (!made) return made.error();
    if (*made && !(*made)->cloud.empty()) cases.push_back(std::move(**made));
  }
  return cases;
}

std::vector<IcpCurve> icp_curves(const body::BodyModel& model, const std::vector<IcpCase>& cases) {
  std::vector<IcpCurve> curves;
  for (const IcpCase& c : cases) {
    const MeshSurface surface(c.vertices, model.body_triangles());
    curves.push_back(
        {"ours, point to plane", c.who, register_cloud(surface, c.cloud, kIcpIterations, kIcpReachMm).error_mm});
  }
  return curves;
}

std::string icp_json_of(const std::vector<IcpCurve>& curves) {
  nlohmann::ordered_json json = {
      {"schema", "im2fit.icp/1"}, {"label", "synthetic"}, {"curves", nlohmann::json::array()}};
  for (const IcpCurve& c : curves)
    json["curves"].push_back({{"method", c.method}, {"who", c.who}, {"error_mm", c.error_mm}});
  return json.dump(1) + "\n";
}

Result<std::vector<IcpCurve>> read_icp_curves(const std::string& path) {
  const auto read = read_json(path);
  if (!read) return read.error();
  const nlohmann::json& json = *read;
  const Error foreign{ErrorCode::corrupt, path + ": expected im2fit.icp/1 as references_bench icp writes it"};
  if (!json.is_object() || json.value("schema", "") != "im2fit.icp/1" || !json.contains("curves")) return foreign;
  std::vector<IcpCurve> curves;
  for (const auto& c : json["curves"]) {
    if (!c.is_object() || !c.contains("method") || !c["method"].is_string() || !c.contains("who") ||
        !c["who"].is_string() || !c.contains("error_mm") || !c["error_mm"].is_array())
      return foreign;
    IcpCurve curve{c["method"], c["who"], {}};
    for (const auto& value : c["error_mm"]) {
      if (!value.is_number()) return foreign;
      curve.error_mm.push_back(value);
    }
    curves.push_back(std::move(curve));
  }
  return curves;
}

}  // namespace im2fit::lab
