// SPDX-License-Identifier: Apache-2.0
#include <string>

#include "body/model.h"
#include "pictures.h"
#include "train/camera/virtual_camera.h"
#include "train/population/population.h"

namespace im2fit::openni2_virtual {
namespace {

lab::Family family_of(const std::string& word) {
  if (word == "training") return lab::Family::training;
  if (word == "paper") return lab::Family::paper;
  return lab::Family::held_out;
}

lab::StandingPose pose_of(const std::string& word) {
  if (word == "a_pose") return lab::StandingPose::a_pose;
  if (word == "psi") return lab::StandingPose::psi;
  if (word == "free") return lab::StandingPose::free;
  return lab::StandingPose::relaxed;
}

lab::SceneOptions scene_of(const Settings& settings) {
  lab::SceneOptions scene;
  scene.rotate_deg = settings.rotate_deg;
  scene.furniture_count = settings.furniture_count;
  scene.pose = pose_of(settings.pose);
  scene.back_view = settings.back_view != 0;
  return scene;
}

lab::SensorOptions sensor_of(const Settings& settings) {
  const bool real = settings.noise != 0;
  return {real, real, real, real};
}

// Keeps the model beside the scene that uses it.
class PersonPictures final : public Pictures {
 public:
  PersonPictures(body::BodyModel model, const Settings& settings)
      : model_(std::move(model)),
        scene_(
            model_,
            lab::draw_subject(model_, family_of(settings.family), settings.seed, lab::subject_of_seed(settings.seed)),
            scene_of(settings), sensor_of(settings), lab::kinect_intrinsics(settings.width, settings.height),
            settings.seed) {}
  const Intrinsics& camera() const override { return scene_.intrinsics(); }
  void make(std::uint64_t index, DepthImage out) override { scene_.render(index, out); }

 private:
  body::BodyModel model_;
  lab::VirtualScene scene_;
};

}  // namespace

Result<std::unique_ptr<Pictures>> person_pictures(const Settings& settings) {
  auto model = body::BodyModel::load(settings.body_path);
  if (!model)
    return Error{model.error().code,
                 model.error().message + "; run im2fit-lab fetch, or set IM2FIT_VIRTUAL_BODY to a .i2b file"};
  return std::unique_ptr<Pictures>(new PersonPictures(std::move(*model), settings));
}

}  // namespace im2fit::openni2_virtual
