// SPDX-License-Identifier: Apache-2.0
// One synthetic person before the virtual camera, with the truth about it. Workstation builds only.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "body/model.h"
#include "core/status.h"
#include "formats/truth_file.h"
#include "hal/source.h"
#include "train/camera/virtual_camera.h"
#include "train/population/population.h"

namespace im2fit::lab {

struct PersonOptions {
  std::uint64_t seed = 1;
  std::uint64_t subject = 0;
  Family family = Family::held_out;
  int width = 640, height = 480;  // as the sensor delivers it
  bool noise = true;              // false: a perfect sensor in an empty room
  SceneOptions scene;
};

// A person who stands still for so many frames turns round in the next kTurnFrames and shows the back; 0: never.
inline constexpr int kTurnFrames = 45;
AboutTurn turn_after(int frames);
// The same, who then steps round once.
StepRound step_round_after(int frames);
// The same, whom a camera is then carried round once.
StepRound walk_round_after(int frames);

// A furnished room seen by a camera in portrait mount.
SceneOptions furnished_room();
SensorOptions sensor_of(bool noise);
Result<Family> family_of(const std::string& word);  // paper | training | held_out
std::string name_of(Family family);
Result<StandingPose> pose_of(
    const std::string& word);  // relaxed | arms_out | a_pose | psi | free | bowed | squat | bent_knees | arm_raised

class SyntheticPerson {
 public:
  // The model must outlive the person.
  SyntheticPerson(const body::BodyModel& model, const PersonOptions& options);
  const Subject& subject() const { return subject_; }
  VirtualScene& scene() { return scene_; }
  Truth truth(int frame_count) const;

 private:
  PersonOptions options_;
  Subject subject_;
  VirtualScene scene_;
};

// Everyday clothes, shoes and hair.
void dress(SceneOptions& scene);

// What the person of `synthetic` does.
struct SyntheticActing {
  AboutTurn turn;
  StepRound step_round;  // with the arms held off the body
  bool clothed = false;
};
// `synthetic[:SEED]` as an endless source; loads the body itself. `rotate_deg` is the camera's mount.
struct SyntheticInput {
  std::unique_ptr<hal::Source> source;
  Truth truth;
};
Result<SyntheticInput> open_synthetic(const std::string& seed, const std::string& body_path, int rotate_deg,
                                      int width, int height, const SyntheticActing& acting);

}  // namespace im2fit::lab
