// SPDX-License-Identifier: Apache-2.0
// PCL's FPFH of an organised cloud, and how far our tiers are from it.
#pragma once

#include <gtest/gtest.h>
#include <pcl/features/fpfh.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <span>
#include <string>
#include <vector>

#include "kernels/fpfh/fpfh.h"
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit::test {

// Processor time: the machine may be busy with other tests.
inline double cpu_ms() {
  return 1000.0 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

inline std::vector<float> pcl_fpfh(const OrganisedCloud& c, std::span<const Vec3f> keypoints) {
  pcl::PointCloud<pcl::PointXYZ>::Ptr surface(new pcl::PointCloud<pcl::PointXYZ>);
  pcl::PointCloud<pcl::Normal>::Ptr normals(new pcl::PointCloud<pcl::Normal>);
  const int pixel_count = c.intrinsics.width * c.intrinsics.height;
  for (int i = 0; i < pixel_count; ++i) {
    if (std::isnan(c.x[i])) continue;
    surface->push_back({c.x[i] * 0.001F, c.y[i] * 0.001F, c.z[i] * 0.001F});
    normals->push_back(pcl::Normal(c.nx[i], c.ny[i], c.nz[i]));
  }
  pcl::PointCloud<pcl::PointXYZ>::Ptr input(new pcl::PointCloud<pcl::PointXYZ>);
  for (const Vec3f& p : keypoints) input->push_back({p.x * 0.001F, p.y * 0.001F, p.z * 0.001F});
  pcl::FPFHEstimation<pcl::PointXYZ, pcl::Normal, pcl::FPFHSignature33> estimation;
  estimation.setInputCloud(input);
  estimation.setSearchSurface(surface);
  estimation.setInputNormals(normals);
  estimation.setSearchMethod(pcl::search::KdTree<pcl::PointXYZ>::Ptr(new pcl::search::KdTree<pcl::PointXYZ>));
  estimation.setRadiusSearch(0.2);
  pcl::PointCloud<pcl::FPFHSignature33> out;
  estimation.compute(out);
  std::vector<float> flat;
  for (const auto& signature : out) flat.insert(flat.end(), signature.histogram, signature.histogram + kFpfhSize);
  return flat;
}

// Every tier within 0.01 of 300 per keypoint (L1); figures on stdout.
inline void expect_pcl(const std::string& name, const OrganisedCloud& cloud, std::span<const Vec3f> keypoints,
                       int described_min) {
  const double start = cpu_ms();
  const std::vector<float> want = pcl_fpfh(cloud, keypoints);
  const double pcl_ms = cpu_ms() - start;
  ASSERT_EQ(want.size(), keypoints.size() * kFpfhSize);
  FpfhWorkspace work(cloud.intrinsics.width, cloud.intrinsics.height);
  std::vector<float> got(want.size());
  for (const FpfhKernel& kernel : kFpfhWithRef) {
    const double kernel_start = cpu_ms();
    kernel.function(cloud, keypoints, kFpfhRadiusMm, work, got);
    const double kernel_ms = cpu_ms() - kernel_start;
    double worst = 0, total = 0;
    int described = 0;
    for (std::size_t k = 0; k < keypoints.size(); ++k) {
      const std::span ours = std::span(got).subspan(k * kFpfhSize, kFpfhSize);
      if (std::isnan(want[k * kFpfhSize])) {  // PCL's word for "nothing in range"
        EXPECT_TRUE(std::all_of(ours.begin(), ours.end(), [](float v) { return v == 0; }));
        continue;
      }
      double l1 = 0;
      for (std::size_t b = 0; b < kFpfhSize; ++b) l1 += std::fabs(double{ours[b]} - double{want[k * kFpfhSize + b]});
      worst = std::max(worst, l1);
      total += l1;
      ++described;
    }
    EXPECT_LE(worst, 0.01) << name << ' ' << kernel.name;
    EXPECT_GE(described, described_min) << name;
    std::printf("%s %s: L1 worst %.5f mean %.5f of 300; %.2f ms, PCL %.0f ms\n", name.c_str(), kernel.name, worst,
                total / described, kernel_ms, pcl_ms);
  }
}

}  // namespace im2fit::test
