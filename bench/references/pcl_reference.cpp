// SPDX-License-Identifier: Apache-2.0
#include <pcl/features/fpfh.h>
#include <pcl/features/integral_image_normal.h>
#include <pcl/features/normal_3d.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/point_types.h>
#include <pcl/registration/icp.h>
#include <pcl/search/kdtree.h>

#include "bench/references/reference.h"

namespace im2fit::bench {
namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;
using Normals = pcl::PointCloud<pcl::Normal>;

Cloud::Ptr cloud_of(std::span<const Vec3f> points) {
  Cloud::Ptr cloud(new Cloud);
  for (const Vec3f& p : points) cloud->push_back({p.x, p.y, p.z});
  return cloud;
}

void take(const Normals& from, std::vector<Vec3f>& to) {
  to.clear();
  for (const pcl::Normal& n : from) to.push_back({n.normal_x, n.normal_y, n.normal_z});
}

class Pcl : public Reference {
 public:
  std::string name() const override { return "PCL " PCL_VERSION_PRETTY; }

  double normals(const Points& points, double radius_m, std::vector<Vec3f>& normals) override {
    pcl::NormalEstimation<pcl::PointXYZ, pcl::Normal> estimation;
    estimation.setInputCloud(cloud_of(points.position_m));
    estimation.setSearchMethod(pcl::search::KdTree<pcl::PointXYZ>::Ptr(new pcl::search::KdTree<pcl::PointXYZ>));
    estimation.setRadiusSearch(radius_m);
    Normals out;
    const double start = cpu_ms();
    estimation.compute(out);
    const double spent = cpu_ms() - start;
    take(out, normals);
    return spent;
  }

  double fpfh(const Points& points, std::span<const Vec3f> keypoints_m, double radius_m,
              std::vector<float>& out) override {
    Normals::Ptr normals(new Normals);
    for (const Vec3f& n : points.normal) normals->push_back(pcl::Normal(n.x, n.y, n.z));
    pcl::FPFHEstimation<pcl::PointXYZ, pcl::Normal, pcl::FPFHSignature33> estimation;
    estimation.setInputCloud(cloud_of(keypoints_m));
    estimation.setSearchSurface(cloud_of(points.position_m));
    estimation.setInputNormals(normals);
    estimation.setSearchMethod(pcl::search::KdTree<pcl::PointXYZ>::Ptr(new pcl::search::KdTree<pcl::PointXYZ>));
    estimation.setRadiusSearch(radius_m);
    pcl::PointCloud<pcl::FPFHSignature33> signatures;
    const double start = cpu_ms();
    estimation.compute(signatures);
    const double spent = cpu_ms() - start;
    out.clear();
    for (const auto& signature : signatures)
      out.insert(out.end(), signature.histogram, signature.histogram + signature.descriptorSize());
    return spent;
  }

  double voxels(const Points& points, double edge_m, Points& out) override {
    const auto edge = static_cast<float>(edge_m);
    pcl::VoxelGrid<pcl::PointXYZ> grid;
    grid.setInputCloud(cloud_of(points.position_m));
    grid.setLeafSize(edge, edge, edge);
    Cloud downsampled;
    const double start = cpu_ms();
    grid.filter(downsampled);
    const double spent = cpu_ms() - start;
    out = {};
    for (const auto& p : downsampled) out.position_m.push_back({p.x, p.y, p.z});
    return spent;
  }

  double icp(const Points& source, const Points& target, double reach_m, int iterations) override {
    pcl::IterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> registration;
    registration.setInputSource(cloud_of(source.position_m));
    registration.setInputTarget(cloud_of(target.position_m));
    registration.setMaximumIterations(iterations);
    registration.setMaxCorrespondenceDistance(reach_m);
    Cloud moved;
    const double start = cpu_ms();
    registration.align(moved);
    return cpu_ms() - start;
  }
};

}  // namespace

std::unique_ptr<Reference> make_pcl() {
  return std::make_unique<Pcl>();
}

double pcl_integral_normals(const Points& organised, int width, int height, std::vector<Vec3f>& normals) {
  const Cloud::Ptr cloud = cloud_of(organised.position_m);
  cloud->width = static_cast<std::uint32_t>(width);
  cloud->height = static_cast<std::uint32_t>(height);
  cloud->is_dense = false;
  pcl::IntegralImageNormalEstimation<pcl::PointXYZ, pcl::Normal> estimation;
  estimation.setNormalEstimationMethod(estimation.AVERAGE_3D_GRADIENT);
  estimation.setMaxDepthChangeFactor(0.02F);
  estimation.setNormalSmoothingSize(10);
  estimation.setInputCloud(cloud);
  Normals out;
  const double start = cpu_ms();
  estimation.compute(out);
  const double spent = cpu_ms() - start;
  take(out, normals);
  return spent;
}

}  // namespace im2fit::bench
