// SPDX-License-Identifier: Apache-2.0
// FPFH against PCL's on people of the virtual camera, the way the device goes: sensor noise, mask, grid, our normals.
#include <vector>

#include "kernels/normals/normals.h"
#include "perception/fuse/decimate.h"
#include "tests/body/body_pack.h"
#include "tests/references/pcl_fpfh.h"
#include "train/camera/virtual_camera.h"

namespace im2fit {
namespace {

struct Shot {
  const char* name;
  std::uint64_t person;
  int step_px;        // 0: the device's own grid
  float distance_mm;  // 1500: head and feet leave the picture
};
constexpr Shot kShots[] = {{"man_device_grid", 4, 0, 3000},
                           {"woman_device_grid", 5, 0, 3000},
                           {"cut_device_grid", 7, 0, 1500},
                           {"woman_every_third_pixel", 5, 3, 3000}};

class PersonAgainstPcl : public testing::TestWithParam<Shot> {};
INSTANTIATE_TEST_SUITE_P(Shots, PersonAgainstPcl, testing::ValuesIn(kShots),
                         [](const auto& p) { return std::string(p.param.name); });

TEST_P(PersonAgainstPcl, WithinAHundredthOfThreeHundred) {
  IM2FIT_NEEDS_BODY();
  const body::BodyModel& model = *body::real_body();
  const Shot& shot = GetParam();
  const lab::Subject subject = lab::draw_subject(model, lab::Family::held_out, 20, shot.person);
  lab::SceneOptions scene;
  scene.rotate_deg = 0;
  scene.distance_mm = shot.distance_mm;
  const Intrinsics k = lab::kinect_intrinsics(640, 480);
  lab::VirtualScene camera(model, subject, scene, lab::kinect_sensor(), k, 3);
  std::vector<std::uint16_t> depth(640 * 480);
  std::vector<std::uint8_t> mask(depth.size());
  camera.render(0, {depth.data(), 640, 480});
  camera.person_mask({mask.data(), 640, 480});
  const JointSet joints = camera.joints(0);
  for (std::uint16_t& d : depth) d = static_cast<std::uint16_t>(d < 4096 ? d * 16 : 0);

  const int step = shot.step_px > 0 ? shot.step_px : grid_step_px(k, joints[Joint::TO].z);
  const Intrinsics grid = grid_intrinsics(k, step);
  const auto size = static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height);
  std::vector<float> x(size), y(size), z(size), nx(size), ny(size), nz(size);
  decimate({depth.data(), 640, 480}, {mask.data(), 640, 480}, grid, step, x, y, z);
  normals_portable(grid, x.data(), y.data(), z.data(), 1, 60, nx.data(), ny.data(), nz.data());
  int points = 0, blank = 0;
  for (std::size_t i = 0; i < size; ++i) {
    points += std::isnan(x[i]) ? 0 : 1;
    blank += !std::isnan(x[i]) && std::isnan(nx[i]) ? 1 : 0;
  }
  EXPECT_GT(points, 400);
  EXPECT_GT(blank, 0);
  std::printf("%s: %d points, %d without a normal\n", shot.name, points, blank);
  const OrganisedCloud cloud = {grid, x.data(), y.data(), z.data(), nx.data(), ny.data(), nz.data()};
  test::expect_pcl(shot.name, cloud, joints.position_mm, 10);
}

}  // namespace
}  // namespace im2fit
