// SPDX-License-Identifier: Apache-2.0
// A depth folder of two rendered people who come one after the other, with no person between.
#pragma once

#include <string>
#include <vector>

#include "data_paths.h"
#include "depth_folder.h"
#include "train/camera/virtual_camera.h"
#include "train/population/population.h"

namespace im2fit::test {

inline constexpr int kFramesEach = 9;
inline constexpr int kFramesEmpty = 30;  // a loss is 16

inline void append_person(const body::BodyModel& model, std::uint64_t person, int frames, std::vector<Picture>& out) {
  constexpr int kWidth = 320;
  constexpr int kHeight = 240;
  lab::SceneOptions options;
  options.rotate_deg = 90;
  options.yaw_deg = 0;
  const lab::Subject subject = lab::draw_subject(model, lab::Family::training, 5, person);
  lab::VirtualScene scene(model, subject, options, lab::exact_sensor(), lab::kinect_intrinsics(kWidth, kHeight), 5);
  for (int i = 0; i < frames; ++i) {
    out.emplace_back(kWidth, kHeight, 0);
    scene.render(static_cast<std::uint64_t>(i), {out.back().mm.data(), kWidth, kHeight});
  }
}

// `empty_end`: no person after the second either, for a folder that is played round and round.
inline void write_two_people(const std::string& folder, int frames_each = kFramesEach, bool empty_end = false) {
  const auto model = body::BodyModel::load(body_path());
  ASSERT_TRUE(model) << model.error().message;
  std::vector<Picture> pictures;
  for (const std::uint64_t person : {1, 2}) {
    append_person(*model, person, frames_each, pictures);
    if (person == 1 || empty_end)
      for (int i = 0; i < kFramesEmpty; ++i) pictures.emplace_back(320, 240, 0);
  }
  CameraText camera;
  camera.rotate_deg = 90;
  write_depth_folder(folder, pictures, camera);
}

}  // namespace im2fit::test
