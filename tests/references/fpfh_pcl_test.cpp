// SPDX-License-Identifier: Apache-2.0
// FPFH against PCL's on a figure whose every point and normal is known.
#include "tests/perception/analytic_figure.h"
#include "tests/references/pcl_fpfh.h"

namespace im2fit {
namespace {

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
  const test::FigureCloud c = test::render_cloud(figure, s.intrinsics, s.noise_mm, s.tilt, s.missing, 5);
  const OrganisedCloud cloud = {c.intrinsics, c.x.data(),  c.y.data(), c.z.data(),
                                c.nx.data(),  c.ny.data(), c.nz.data()};
  test::expect_pcl(s.name, cloud, figure.joints.position_mm, 8);
}

}  // namespace
}  // namespace im2fit
