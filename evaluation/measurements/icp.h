// SPDX-License-Identifier: Apache-2.0
// Iterative closest point (Besl and McKay 1992; Chen and Medioni 1992, point to plane): a cloud moved rigidly onto a
// mesh, and how far it lies from it after each iteration. mm.
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "body/section.h"
#include "core/vec3.h"
#include "evaluation/measurements/session.h"

namespace im2fit::lab {

// Closest points on a triangle mesh. Compares the triangles round the few vertices nearest to the point: exact where
// triangles are of about one size, as a body's are.
class MeshSurface {
 public:
  // Vertices no triangle uses are left out. At least one triangle.
  MeshSurface(std::span<const Vec3f> vertices, std::span<const body::Triangle> triangles);
  ~MeshSurface();
  MeshSurface(MeshSurface&&) noexcept;

  struct Foot {
    Eigen::Vector3d point, normal;  // of the triangle it lies on, unit
    double distance_mm = 0;
  };
  Foot closest(const Eigen::Vector3d& from) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

using Cloud = std::vector<Eigen::Vector3d>;

// The mean over the cloud of its distances to the surface.
double mean_distance_mm(const MeshSurface& surface, const Cloud& cloud, const Eigen::Isometry3d& motion);

struct IcpTrace {
  std::vector<double> error_mm;  // mean distance before the first iteration and after each
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
};
// `reach_mm`: farther pairs have no part in a step, and all of them in the error.
IcpTrace register_cloud(const MeshSurface& surface, const Cloud& cloud, int iterations, double reach_mm);

// The paper's last figure: the fused depth of a person against the retrieved body in the measured pose, aligned by
// its joints, then by ICP.
struct IcpCase {
  std::string who;              // "man, 1783 mm, 78 kg"
  Cloud cloud;                  // mesh axes, where the joints put it
  std::vector<Vec3f> vertices;  // of the posed body
};
inline constexpr int kIcpIterations = 15;
inline constexpr double kIcpReachMm = 150;
inline constexpr std::size_t kIcpPointsMost = 6000;

// The first `count` of an evaluation's people who are measured, of at most four times as many.
Result<std::vector<IcpCase>> icp_cases(const SessionModels& models, const EvaluationOptions& options, int count);

struct IcpCurve {
  std::string method, who;
  std::vector<double> error_mm;  // by iteration, from 0
};
// Ours, a curve a case.
std::vector<IcpCurve> icp_curves(const body::BodyModel& model, const std::vector<IcpCase>& cases);

// Written by `references_bench icp`: the same cases under ours and PCL's. Errors name the file and the
// field.
Result<std::vector<IcpCurve>> read_icp_curves(const std::string& path);
std::string icp_json_of(const std::vector<IcpCurve>& curves);

}  // namespace im2fit::lab
