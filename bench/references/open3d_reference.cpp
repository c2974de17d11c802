// SPDX-License-Identifier: Apache-2.0
#include <omp.h>
#include <open3d/geometry/KDTreeSearchParam.h>
#include <open3d/geometry/PointCloud.h>
#include <open3d/pipelines/registration/Feature.h>
#include <open3d/pipelines/registration/Registration.h>

#include "bench/references/reference.h"

namespace im2fit::bench {
namespace {

namespace registration = open3d::pipelines::registration;
using open3d::geometry::KDTreeSearchParamRadius;
using open3d::geometry::PointCloud;

Eigen::Vector3d vector_of(const Vec3f& p) {
  return {double{p.x}, double{p.y}, double{p.z}};
}

PointCloud cloud_of(const Points& points) {
  PointCloud cloud;
  for (const Vec3f& p : points.position_m) cloud.points_.push_back(vector_of(p));
  for (const Vec3f& n : points.normal) cloud.normals_.push_back(vector_of(n));
  return cloud;
}

Vec3f back(const Eigen::Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

class Open3d : public Reference {
 public:
  Open3d() { omp_set_num_threads(1); }
  std::string name() const override { return "Open3D " OPEN3D_VERSION; }

  double normals(const Points& points, double radius_m, std::vector<Vec3f>& normals) override {
    PointCloud cloud = cloud_of({points.position_m, {}});
    const double start = cpu_ms();
    cloud.EstimateNormals(KDTreeSearchParamRadius(radius_m));
    const double spent = cpu_ms() - start;
    normals.clear();
    for (const Eigen::Vector3d& n : cloud.normals_) normals.push_back(back(n));
    return spent;
  }

  // Describes every point of the cloud: it has no keypoints.
  double fpfh(const Points& points, std::span<const Vec3f>, double radius_m, std::vector<float>& out) override {
    const PointCloud cloud = cloud_of(points);
    const double start = cpu_ms();
    const auto feature = registration::ComputeFPFHFeature(cloud, KDTreeSearchParamRadius(radius_m));
    const double spent = cpu_ms() - start;
    out.clear();
    return feature->Num() == points.position_m.size() ? spent : 0;
  }

  double voxels(const Points& points, double edge_m, Points& out) override {
    const PointCloud cloud = cloud_of({points.position_m, {}});
    const double start = cpu_ms();
    const auto downsampled = cloud.VoxelDownSample(edge_m);
    const double spent = cpu_ms() - start;
    out = {};
    for (const Eigen::Vector3d& p : downsampled->points_) out.position_m.push_back(back(p));
    return spent;
  }

  double icp(const Points& source, const Points& target, double reach_m, int iterations) override {
    const PointCloud from = cloud_of({source.position_m, {}}), to = cloud_of({target.position_m, {}});
    const double start = cpu_ms();
    const auto result = registration::RegistrationICP(from, to, reach_m, Eigen::Matrix4d::Identity(),
                                                      registration::TransformationEstimationPointToPoint(),
                                                      registration::ICPConvergenceCriteria(0, 0, iterations));
    return result.fitness_ > 0 ? cpu_ms() - start : 0;
  }
};

}  // namespace

std::unique_ptr<Reference> make_open3d() {
  return std::make_unique<Open3d>();
}

}  // namespace im2fit::bench
