// SPDX-License-Identifier: Apache-2.0
// FPFH against PCL's own, in metres, on a figure whose every point and normal is known; both tiers; times as a note.
#include <gtest/gtest.h>
#include <pcl/features/fpfh.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <string>
#include <vector>

#include "kernels/fpfh/fpfh.h"
#include "tests/kernels/analytic_figure.h"

namespace im2fit {
namespace {

using test::FigureCloud;

// Processor time: the machine may be busy with other tests.
double now_ms() {
  return 1000.0 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

std::vector<float> pcl_fpfh(const FigureCloud& c, std::span<const Vec3f> keypoints) {
  pcl::PointCloud<pcl::PointXYZ>::Ptr surface(new pcl::PointCloud<pcl::PointXYZ>);
  pcl::PointCloud<pcl::Normal>::Ptr normals(new pcl::PointCloud<pcl::Normal>);
  for (std::size_t i = 0; i < c.x.size(); ++i) {
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

struct Scene {
  const char* name;
  Intrinsics intrinsics;
  float x, z, lift;
  double noise_mm, tilt, missing;
};
constexpr Intrinsics kPortrait = {90, 130, 105, 105, 44.5F, 64.5F};
constexpr Scene kScenes[] = {
    {"whole", kPortrait, 0, 2300, 0, 3, 0.15, 0},
    {"missing_normals", kPortrait, 0, 2300, 0, 3, 0.15, 0.2},
    {"cut_by_the_border", kPortrait, 400, 1700, 500, 3, 0.15, 0.05},
    {"near_and_smooth", {60, 80, 60, 60, 29.5F, 39.5F}, 0, 900, 0, 0, 0, 0.05},
    {"quarter_resolution", {160, 240, 190, 190, 79.5F, 119.5F}, 0, 2300, 0, 5, 0.3, 0.1},
};

class FpfhAgainstPcl : public testing::TestWithParam<Scene> {};
INSTANTIATE_TEST_SUITE_P(Scenes, FpfhAgainstPcl, testing::ValuesIn(kScenes),
                         [](const auto& p) { return std::string(p.param.name); });

TEST_P(FpfhAgainstPcl, WithinAHundredthOfThreeHundred) {
  const Scene& s = GetParam();
  const test::Figure figure = test::standing_figure(s.x, s.z, s.lift);
  const FigureCloud c = test::render_cloud(figure, s.intrinsics, s.noise_mm, s.tilt, s.missing, 5);
  const OrganisedCloud cloud = {c.intrinsics, c.x.data(),  c.y.data(), c.z.data(),
                                c.nx.data(),  c.ny.data(), c.nz.data()};
  const auto& keypoints = figure.joints.position_mm;
  const double start = now_ms();
  const std::vector<float> want = pcl_fpfh(c, keypoints);
  const double pcl_ms = now_ms() - start;
  ASSERT_EQ(want.size(), keypoints.size() * kFpfhSize);

  FpfhWorkspace work(s.intrinsics.width, s.intrinsics.height);
  std::vector<float> got(want.size());
  for (const FpfhKernel& kernel : kFpfhKernels) {
    const double kernel_start = now_ms();
    kernel.function(cloud, keypoints, kFpfhRadiusMm, work, got);
    const double kernel_ms = now_ms() - kernel_start;
    double worst = 0, total = 0;
    int described = 0;
    for (std::size_t k = 0; k < keypoints.size(); ++k) {
      if (std::isnan(want[k * kFpfhSize])) continue;  // PCL's word for "nothing in range"
      double l1 = 0;
      for (std::size_t b = 0; b < kFpfhSize; ++b) {
        l1 += std::fabs(double{got[k * kFpfhSize + b]} - double{want[k * kFpfhSize + b]});
      }
      worst = std::max(worst, l1);
      total += l1;
      ++described;
    }
    EXPECT_LE(worst, 0.01) << kernel.name;
    EXPECT_GE(described, 8);
    std::printf("%s %s: %d points, L1 worst %.5f mean %.5f of 300; %.2f ms, PCL %.0f ms\n", s.name, kernel.name,
                c.valid_count, worst, total / described, kernel_ms, pcl_ms);
  }
}

}  // namespace
}  // namespace im2fit
