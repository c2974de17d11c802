// SPDX-License-Identifier: Apache-2.0
// Every hand-written tier of FPFH against portable, bit for bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "kernels/fpfh/fpfh.h"
#include "tests/kernels/checkasm.h"

namespace im2fit {
namespace {

using checkasm::Buffer;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

struct Shape {
  int width, height;
  float z_mm, depth_mm;  // the nearest point, and how far behind it they scatter
  double missing, blank, coincident;
  float step_mm;  // depths and normals are multiples of something: ties and planes; 0: not
  float radius_mm;
};

// A random cloud between guard pages.
struct Cloud {
  Cloud(const Shape& shape, checkasm::Trial& trial)
      : s(shape),
        count(static_cast<std::size_t>(s.width) * static_cast<std::size_t>(s.height)),
        x(count, trial.next_end()),
        y(count, trial.next_end()),
        z(count, trial.next_end()),
        nx(count, trial.next_end()),
        ny(count, trial.next_end()),
        nz(count, trial.next_end()) {
    const auto w = static_cast<float>(s.width), h = static_cast<float>(s.height);
    k = {s.width, s.height, 1.1F * w, 1.2F * w, 0.5F * w, 0.4F * h};
    for (std::size_t i = 0; i < count; ++i) fill(i, trial);
    for (std::size_t i = 1; i < count; ++i) {
      if (trial.rng().uniform() >= s.coincident || i % static_cast<std::size_t>(s.width) == 0) continue;
      // Pixels side by side may share a point between them.
      x[i] = x[i - 1], y[i] = y[i - 1], z[i] = z[i - 1];
      if (std::isnan(x[i])) continue;
      const auto u = static_cast<float>(i % static_cast<std::size_t>(s.width)) - 0.5F;
      x[i] = x[i - 1] = (u - k.cx) / k.fx * z[i];
    }
  }

  void fill(std::size_t i, checkasm::Trial& trial) {
    x[i] = y[i] = z[i] = nx[i] = ny[i] = nz[i] = kNan;
    if (trial.rng().uniform() < s.missing) return;
    float depth = s.z_mm + trial.between(0, s.depth_mm);
    if (s.step_mm > 0) depth = s.z_mm + std::floor(trial.between(0, s.depth_mm) / s.step_mm) * s.step_mm;
    const Vec3f p = unproject(k, static_cast<float>(i % static_cast<std::size_t>(s.width)),
                              static_cast<float>(i / static_cast<std::size_t>(s.width)), depth);
    x[i] = p.x, y[i] = p.y, z[i] = p.z;
    if (trial.rng().uniform() < s.blank) return;
    Vec3f n = {trial.between(-1, 1), trial.between(-1, 1), -trial.between(0.1F, 1)};
    if (s.step_mm > 0) n = {std::floor(2 * n.x), std::floor(2 * n.y), -1};
    n = normalized(n);
    nx[i] = n.x, ny[i] = n.y, nz[i] = n.z;
  }

  OrganisedCloud view() const { return {k, x.data(), y.data(), z.data(), nx.data(), ny.data(), nz.data()}; }

  Shape s;
  Intrinsics k;
  std::size_t count;
  Buffer<float> x, y, z, nx, ny, nz;
};

// Returns how many keypoints had anything in range.
int compare(const Shape& s, int keypoint_count, checkasm::Trial& trial, FpfhWorkspace& work) {
  IM2FIT_CHECK_PARAMETERS(trial, s.width << " x " << s.height << ", z " << s.z_mm << ", missing " << s.missing
                                         << ", blank " << s.blank << ", radius " << s.radius_mm);
  Cloud cloud(s, trial);
  std::vector<Vec3f> keypoints;
  for (int n = 0; n < keypoint_count; ++n) {
    const auto i = static_cast<std::size_t>(trial.rng().index(static_cast<int>(cloud.count)));
    keypoints.push_back({cloud.x[i], cloud.y[i], cloud.z[i]});  // NaN now and then
    if (n % 2 == 0) keypoints.back() = keypoints.back() + Vec3f{7, -11, 5};
  }
  Buffer<float> want(keypoints.size() * kFpfhSize, trial.next_end()), got(want.size(), trial.next_end());
  fpfh_portable(cloud.view(), keypoints, s.radius_mm, work, want.span());
  checkasm::each_simd(kFpfhKernels, [&](const auto& variant) {
    got.refill();
    variant.function(cloud.view(), keypoints, s.radius_mm, work, got.span());
    checkasm::expect_same_bits(want, got);
  });
  int described = 0;
  for (std::size_t n = 0; n < keypoints.size(); ++n) {
    const auto first = want.span().subspan(n * kFpfhSize, kFpfhSize);
    described += std::any_of(first.begin(), first.end(), [](float v) { return v > 0; }) ? 1 : 0;
  }
  return described;
}

TEST(FpfhSimd, RandomClouds) {
  checkasm::Trial trial;
  FpfhWorkspace work(64, 48);
  int described = 0;
  for (const int width : checkasm::odd_sizes(40)) {
    if (width < 3) continue;
    for (const float z : {150.0F, 900.0F}) {
      described += compare({width, 17, z, 300, 0.2, 0.1, 0.02, 0, 200}, 5, trial, work);
      described += compare({width, 13, z, 120, 0.0, 0.0, 0.0, 0, 200}, 1, trial, work);
      described += compare({width, 11, z, 300, 0.6, 0.5, 0.1, 0, 150}, 9, trial, work);
    }
  }
  EXPECT_GT(described, 200);
}

// Depths and normals of few values: coincident points, equal normals, ties of the swap rule, v = 0.
TEST(FpfhSimd, QuantisedClouds) {
  checkasm::Trial trial;
  FpfhWorkspace work(64, 48);
  for (int n = 0; n < 12; ++n) {
    EXPECT_GT(compare({29, 23, 600, 200, 0.1, 0.05, 0.1, 10, 200}, 6, trial, work), 0);
    EXPECT_GT(compare({31, 14, 300, 40, 0.0, 0.0, 0.0, 50, 200}, 3, trial, work), 0);
  }
}

// Thousands of neighbours: byte counters must be emptied in time, a source's own and the others'.
TEST(FpfhSimd, CountersDoNotOverflow) {
  checkasm::Trial trial;
  FpfhWorkspace work(300, 300);
  EXPECT_EQ(compare({299, 9, 250, 5, 0.0, 0.0, 0.0, 5, 200}, 4, trial, work), 4);
  EXPECT_GT(compare({7, 290, 250, 5, 0.05, 0.02, 0.0, 0, 400}, 4, trial, work), 0);
}

// Coordinates so small that their products are denormals, which some vector units take for zeros.
TEST(FpfhSimd, DenormalsDecideAlike) {
  checkasm::Trial trial;
  FpfhWorkspace work(16, 16);
  for (const float tiny : {1e-12F, 1e-20F, 1e-30F}) {
    Cloud cloud({9, 7, 300, 0, 0, 0, 0, 0, 200}, trial);
    for (std::size_t i = 0; i < cloud.count; ++i) {
      const Vec3f n =
          normalized({tiny * trial.between(-1, 1), i % 2 == 0 ? tiny : 1.0F, trial.between(-1, 1) * tiny});
      cloud.nx[i] = n.x, cloud.ny[i] = n.y, cloud.nz[i] = i % 2 == 0 ? -1.0F : n.z;
      if (i % 9 == 4) cloud.x[i] = tiny * trial.between(-1, 1);
    }
    const std::vector<Vec3f> keypoints = {{5, 3, 310}, {-40, 20, 290}};
    std::vector<float> want(keypoints.size() * kFpfhSize), got(want.size());
    fpfh_portable(cloud.view(), keypoints, 200, work, want);
    checkasm::each_simd(kFpfhKernels, [&](const auto& variant) {
      variant.function(cloud.view(), keypoints, 200, work, got);
      checkasm::expect_same_bits<float>(want, got);
    });
  }
}

// A workspace used before, for a larger picture: nothing of it may show.
TEST(FpfhSimd, WorkspaceIsCleanEachTime) {
  checkasm::Trial trial;
  FpfhWorkspace work(64, 48);
  const Shape small = {21, 9, 500, 100, 0.3, 0.2, 0, 0, 200}, large = {60, 40, 500, 100, 0.1, 0.1, 0, 0, 200};
  for (int n = 0; n < 3; ++n) {
    EXPECT_GT(compare(large, 3, trial, work), 0);
    EXPECT_GT(compare(small, 3, trial, work), 0);
  }
}

}  // namespace
}  // namespace im2fit
