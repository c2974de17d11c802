// SPDX-License-Identifier: Apache-2.0
// Iterative closest point (Besl and McKay 1992; Chen and Medioni 1992, point to plane): a cloud moved rigidly onto a
// mesh, and how far it lies from it after each iteration. mm.
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <span>
#include <vector>

#include "body/section.h"
#include "core/vec3.h"

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

}  // namespace im2fit::lab
