// SPDX-License-Identifier: Apache-2.0
// One person of a scene: posed, dressed, placed on the floor, walking along a path. World axes (room.h).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "body/skeleton.h"
#include "core/joints.h"
#include "train/population/actor.h"
#include "train/population/clothing.h"
#include "train/population/population.h"
#include "train/population/poses.h"
#include "train/population/step_round.h"
#include "train/render/room.h"
#include "train/render/scene_axes.h"

namespace im2fit::lab {

// A straight path over the floor at even speed, world axes: mm from where the main person stands by default, x to the
// camera's right, z towards the camera. Stands at `from` before and at `to` after; legs and arms swing while walking.
struct FloorPath {
  float from_x_mm = 0, from_z_mm = 0;
  float to_x_mm = 0, to_z_mm = 0;
  int frame_first = 0;
  int frame_count = 0;  // 0: stands at `from` for ever
};

// Turns round on the spot by 180 degrees, stepping, towards the person's right; stands so for ever after.
struct AboutTurn {
  int frame_first = 0;
  int frame_count = 0;  // 0: never
};

// A square plate on the floor, under the person: a scale, a turntable, a platform.
struct FloorPlate {
  float height_mm = 0;  // of its top; 0: none
  float side_mm = 300;
};

// Hangs clothes on a body: `rest` has all vertices of the model. The same for the same arguments. Called from the
// threads of the caller that holds it.
using Dresser =
    std::function<DrapedCloth(std::span<const Vec3f> rest, const body::Skeleton& skeleton, const body::Pose& pose)>;

struct PersonPlan {
  StandingPose pose = StandingPose::relaxed;
  Clothing clothing = Clothing::none;
  bool hair = false;
  std::uint64_t outfit_seed = 0;  // 0: the person's in this scene
  std::optional<float> yaw_deg;   // none: drawn by pose class; on a path: along it
  bool back_view = false;
  bool sway = true;
  FloorPath path;
  AboutTurn turn;
  Dresser dresser;  // of Clothing::garments: called for every pose, so a walk takes its time
  StepRound step_round;
  float raised_mm = 0;  // above the floor
};

// Slow sway about the ankles and a little turning: sums of three incommensurate waves, 0.1..0.6 Hz, so that any
// frame can be had without the ones before it. Sizes: 3.5 mm sideways and 5 mm back and forth at head height.
class Sway {
 public:
  explicit Sway(std::uint64_t seed);
  Rigid at(std::uint64_t frame) const;

 private:
  struct Wave {
    float hertz = 0, phase = 0, size = 0;
  };
  float value(std::size_t axis, double seconds) const;
  std::array<std::array<Wave, 3>, 3> waves_;  // lean forwards, lean sideways, turn (degrees)
};

// Not shareable between threads; model must outlive it. Staged again without allocating anew where sizes allow.
class ScenePerson {
 public:
  explicit ScenePerson(const body::BodyModel& model);

  // `tailor` may be null when nothing is worn. `seed`: of this person in this scene; `who`: number in the labels.
  // `rest`: the subject's rest mesh where the caller has it, else empty.
  void stage(const Subject& subject, std::span<const Vec3f> rest, const PersonPlan& plan, std::uint64_t seed,
             std::size_t who, Tailor* tailor);
  // Poses and dresses for the frame; everything below is of the frame chosen last (after stage: a standing person
  // at the origin of the floor before any sway or path).
  void choose_frame(std::uint64_t index);

  Rigid placed(std::uint64_t index) const;  // sway, turn and path: person axes to world
  // With StepRound::camera: how the world moves before the camera.
  Rigid carried(std::uint64_t index) const { return plan_.step_round.camera ? stepping_.carried(index) : Rigid{}; }
  bool moves() const {
    return plan_.sway || plan_.path.frame_count > 0 || plan_.turn.frame_count > 0 || steps_round();
  }
  const std::vector<Vec3f>& body() const { return body_; }  // naked; person axes: the world's but for placed()
  const JointSet& joints() const { return joints_; }
  // What is drawn, person axes.
  std::span<const Vec3f> surface() const { return dressed_ ? std::span<const Vec3f>(worn_) : body_; }
  std::span<const Triangle> closed_triangles() const;
  std::span<const Triangle> open_triangles() const { return open_; }
  std::span<const std::uint8_t> labels() const { return labels_; }  // of closed_triangles
  const Seat* seat() const { return seat_ ? &*seat_ : nullptr; }

 private:
  // What a rest mesh is dressed in.
  struct Worn {
    bool dressed = false;
    Clothing clothing = Clothing::none;
    bool hair = false;
    bool woman = false;
    std::uint64_t seed = 0;
    std::size_t who = 0;
    bool operator==(const Worn&) const = default;
  };
  void take_rest(const Subject& subject, std::span<const Vec3f> rest);
  void take_actor();
  void dress(const Worn& worn, Tailor* tailor);
  bool steps_round() const { return plan_.step_round.seconds > 0; }
  void pose_as(const body::Pose& pose, float breath_mm = 0);
  void breathe(const body::Pose& pose, float breath_mm);
  void drape(const body::Pose& pose);
  void add_cloth(const DrapedCloth& cloth);
  void find_seat(Vec3f origin);
  struct Gait {
    float phase = 0, strength = 0;
  };
  Gait gait(std::uint64_t index) const;

  const body::BodyModel& model_;
  std::shared_ptr<const Actor> actor_;  // shown in the model's place, or null
  PersonPlan plan_;
  Sway sway_;
  StepRoundMotion stepping_;
  body::Skeleton skeleton_;
  body::Pose pose_;  // standing
  std::vector<Vec3f> rest_;
  std::optional<Worn> outfit_of_;  // with the rest mesh, what outfit_ and labels_ were made from
  Outfit outfit_;
  bool dressed_ = false;
  float yaw_deg_ = 0;  // baked into body_
  bool faces_path_ = false;
  bool striding_ = false;  // body_ is in mid-stride
  std::vector<Triangle> triangles_, open_;
  std::size_t skirt_triangle_count_ = 0;  // first ones of `open_`
  std::vector<std::int32_t> skirt_;       // vertices of `open_` in the rest mesh, in the order drawn
  std::vector<std::uint8_t> labels_;
  std::optional<Seat> seat_;
  std::vector<Vec3f> posed_, body_, worn_;
  JointSet joints_;
};

}  // namespace im2fit::lab
