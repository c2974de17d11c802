// SPDX-License-Identifier: Apache-2.0
// Every hand-written tier of the normals against portable, bit for bit.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "kernels/normals/normals.h"
#include "tests/kernels/checkasm.h"

namespace im2fit {
namespace {

using checkasm::Buffer;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

struct Scene {
  float depth_mm;  // points scatter so far behind 900 mm; 0: a plane facing the camera
  double missing;
  float max_step_mm;
};

struct Cloud {
  Cloud(int width, int height, const Scene& scene, checkasm::Trial& trial)
      : count(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)),
        x(count, trial.next_end()),
        y(count, trial.next_end()),
        z(count, trial.next_end()) {
    k = {width, height, 90, 80, 0.5F * static_cast<float>(width), 0.4F * static_cast<float>(height)};
    for (std::size_t i = 0; i < count; ++i) {
      x[i] = y[i] = z[i] = kNan;
      if (trial.rng().uniform() < scene.missing) continue;
      const Vec3f p =
          unproject(k, static_cast<float>(i % static_cast<std::size_t>(width)),
                    static_cast<float>(i / static_cast<std::size_t>(width)), 900 + trial.between(0, scene.depth_mm));
      x[i] = p.x, y[i] = p.y, z[i] = p.z;
    }
  }
  Intrinsics k;
  std::size_t count;
  Buffer<float> x, y, z;
};

// Returns how many pixels have a normal. A NaN has many bit patterns and one meaning.
int compare(int width, int height, int radius, const Scene& scene, checkasm::Trial& trial) {
  IM2FIT_CHECK_PARAMETERS(trial, width << " x " << height << ", radius " << radius << ", depth " << scene.depth_mm
                                       << ", missing " << scene.missing << ", step " << scene.max_step_mm);
  Cloud c(width, height, scene, trial);
  Buffer<float> want[3] = {Buffer<float>(c.count), Buffer<float>(c.count), Buffer<float>(c.count)};
  normals_portable(c.k, c.x.data(), c.y.data(), c.z.data(), radius, scene.max_step_mm, want[0].data(), want[1].data(),
                   want[2].data());
  checkasm::each_simd(kNormalsKernels, [&](const auto& variant) {
    Buffer<float> x(c.count, trial.next_end()), y(c.count, trial.next_end()), z(c.count, trial.next_end());
    variant.function(c.k, c.x.data(), c.y.data(), c.z.data(), radius, scene.max_step_mm, x.data(), y.data(),
                     z.data());
    for (Buffer<float>* b : {&want[0], &want[1], &want[2], &x, &y, &z}) {
      for (float& value : b->span()) value = std::isnan(value) ? kNan : value;
    }
    checkasm::expect_same_bits(want[0], x);
    checkasm::expect_same_bits(want[1], y);
    checkasm::expect_same_bits(want[2], z);
  });
  int found = 0;
  for (const float value : want[2].span()) found += std::isnan(value) ? 0 : 1;
  return found;
}

TEST(NormalsSimd, OddSizes) {
  checkasm::Trial trial;
  int found = 0;
  for (const int width : checkasm::odd_sizes(50)) {
    for (const int radius : {1, 2, 7}) {
      found += compare(width, 9, radius, {40, 0.1, 60}, trial);
      compare(width, 1, radius, {40, 0.0, 60}, trial);
      compare(width, 2 * radius + 1, radius, {120, 0.4, 60}, trial);
    }
  }
  EXPECT_GT(found, 5000);
}

// Exact planes, where sums cancel; everything on its own surface, where windows are empty but for their centre.
TEST(NormalsSimd, PlanesAndScatter) {
  checkasm::Trial trial;
  EXPECT_GT(compare(41, 31, 1, {0, 0, 60}, trial), 1000);
  EXPECT_GT(compare(41, 31, 2, {0, 0.3, 60}, trial), 700);
  EXPECT_EQ(compare(41, 31, 1, {3000, 0, 0.5F}, trial), 0);
  EXPECT_EQ(compare(41, 31, 1, {40, 1.0, 60}, trial), 0);
}

}  // namespace
}  // namespace im2fit
