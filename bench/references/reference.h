// SPDX-License-Identifier: Apache-2.0
// Reference implementations (PCL, Open3D), the alternatives a user could pick, behind one interface. Each call
// converts outside the clock and returns the processor time of the library's own work in ms, its search tree
// included. One thread.
#pragma once

#include <ctime>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/vec3.h"

namespace im2fit::bench {

// Metres, as PCL and Open3D users have them. A missing normal is NaN.
struct Points {
  std::vector<Vec3f> position_m;
  std::vector<Vec3f> normal;  // empty, or one a point
};

// Of the process: the machine may be busy with others' work.
inline double cpu_ms() {
  timespec now;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

class Reference {
 public:
  virtual ~Reference() = default;
  virtual std::string name() const = 0;
  virtual double normals(const Points& points, double radius_m, std::vector<Vec3f>& normals) = 0;
  // `out`: 33 values a keypoint, or empty where the library describes its own points only.
  virtual double fpfh(const Points& points, std::span<const Vec3f> keypoints_m, double radius_m,
                      std::vector<float>& out) = 0;
  virtual double voxels(const Points& points, double edge_m, Points& out) = 0;
  virtual double icp(const Points& source, const Points& target, double reach_m, int iterations) = 0;
};

// nullptr where the library was not there when this was built.
std::unique_ptr<Reference> make_pcl();
std::unique_ptr<Reference> make_open3d();

// PCL's normals of an organised cloud by integral images: width * height points, NaN where there is none.
double pcl_integral_normals(const Points& organised, int width, int height, std::vector<Vec3f>& normals);

// `references_bench icp`, with PCL and the judges: argv[0] is the word icp, its options follow. Returns an exit code.
int icp_references(int argc, char** argv);

}  // namespace im2fit::bench
