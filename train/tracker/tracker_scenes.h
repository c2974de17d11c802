// SPDX-License-Identifier: Apache-2.0
// Scenes for training and judging the tracker, drawn from a mixture and labelled with the drawn values.
//
//   TrackerScene t = draw_tracker_scene(training_mix(), rng);
//   VirtualScene scene(model, subject, t.scene, t.sensor, t.intrinsics, t.seed);   // or restage()
//   t.place(scene);                                                              // distance, height, whole
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "core/camera.h"
#include "core/rng.h"
#include "train/camera/depth_sensor.h"
#include "train/camera/virtual_camera.h"
#include "train/population/clothing.h"

namespace im2fit::lab {

enum class PoseClass : std::uint8_t {
  calm,     // relaxed or A-pose, yaw sd 4.5 degrees
  psi,      // calibration pose
  free,     // arms anywhere, trunk bent, legs in stride; yaw sd 20
  crossed,  // one or both forearms across the trunk, hands on the hips; yaw sd 10
  seated,   // on a chair or stool; yaw sd 12
  turned,   // calm or free, yaw 20..turned_max_deg to either side
  bowed,    // trunk bent from the hips by 24..56 degrees; yaw sd 10
};
inline constexpr std::size_t kPoseClassCount = 7;
inline constexpr std::array<std::string_view, kPoseClassCount> kPoseClassNames = {
    "calm", "psi", "free", "crossed", "seated", "turned", "bowed"};

// Weights are relative, shares are of 1.
struct TrackerMix {
  std::array<double, kPoseClassCount> pose_weight = {1, 1, 1, 1, 1, 1, 1};
  float turned_max_deg = 60;
  double clothed_share = 0;  // of these: a fifth tight, half normal, the rest loose
  double hair_share = 0;     // hair with volume
  double back_share = 0;     // seen from behind; seated people never
  double furniture_share = 0;
  double touching_share = 0;  // of the furnished: something stands at the lower legs
  double decoy_share = 0;     // of the furnished: coat stand, chair with a coat, dog-sized box
  double others_share = 0;    // one or two further people, never before the main one
  double cut_share = 0;       // distance taken at its word: people near the camera are cut off
  double tof_share = 0;       // time of flight; the rest structured light
  double vga_share = 0;       // 640x480; the rest 320x240
  double portrait_share = 0.55;
  double wide_share = 0;  // heights 0.5..2.2 m, pitch within +-20 degrees, distances 1..4 m; the rest as
                          // SceneOptions draws them (0.8..1.2 m, 2..3.2 m)
  bool noise = true;      // false: exact_sensor()
};
TrackerMix training_mix();         // everything, half of it from where cameras are advised to stand
TrackerMix full_conditions_mix();  // clothing, hair, furniture, sensor noise, others behind; whole, usual distances
TrackerMix bare_mix();             // naked, alone, no furniture; calm and Psi : free = 1 : 1

TrackerMix person_mix();  // training_mix() with more poses that resemble things: turned, bent, seated

struct TrackerScene {
  SceneOptions scene;
  SensorOptions sensor;
  Intrinsics intrinsics;  // as the sensor delivers
  std::uint64_t seed = 0;

  PoseClass pose_class = PoseClass::calm;
  bool back_view = false;
  Clothing clothing = Clothing::none;
  SensorKind kind = SensorKind::structured_light;
  int rotate_deg = 0;
  int others = 0;
  bool furnished = false;
  // Known once staged: call place().
  float distance_mm = 0;
  float camera_height_mm = 0;
  bool whole = true;  // all fifteen joints are inside the picture

  void place(const VirtualScene& staged);
};

// `family`: of the further people (the main subject is the caller's): pass the main subject's.
TrackerScene draw_tracker_scene(const TrackerMix& mix, Rng& rng, Family family = Family::training);

// No person; many coat stands and chairs with coats. The camera is placed as for the subject staged.
TrackerScene draw_empty_room(Rng& rng);

}  // namespace im2fit::lab
