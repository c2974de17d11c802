// SPDX-License-Identifier: Apache-2.0
// A depth camera that renders a room: z-buffer, Kinect intrinsics, structured-light noise (Nguyen 2012),
// disparity quantisation (Khoshelham 2012), shadow, holes, floor, wall, furniture.
//
// Mounting. The sensor always delivers its own landscape frame `in` (W x H). With rotate_deg the camera hangs
// turned clockwise by that much, seen from behind it, and the upright picture the program works on is
//     0:   upright(u', v') = in(u', v')                    W wide, H high
//    90:   upright(u', v') = in(v', H - 1 - u')            H wide, W high (the picture's top is the column u = 0)
//   180:   upright(u', v') = in(W - 1 - u', H - 1 - v')    W wide, H high
//   270:   upright(u', v') = in(W - 1 - v', u')            H wide, W high
// which is hal::rotate_upright. Joints and floor are in the upright picture's camera axes; frames and masks are as
// the sensor delivers them.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "body/skeleton.h"
#include "core/camera.h"
#include "core/joints.h"
#include "hal/source.h"
#include "perception/segment/segment.h"
#include "train/camera/depth_sensor.h"
#include "train/population/clothing.h"
#include "train/population/population.h"
#include "train/population/poses.h"
#include "train/population/scene_person.h"

namespace im2fit::lab {

// Landscape 640x480 (f 575.8 px, centre 319.5, 239.5) or 320x240 (287.9; 159.5, 119.5); other sizes scale with width.
Intrinsics kinect_intrinsics(int width, int height);
// A point or direction in the upright picture's camera axes, in the sensor's own. rotate_deg 0|90|180|270.
Vec3f upright_to_sensor(Vec3f upright, int rotate_deg);

// Another person in the room. The subject is draw_subject(model, family, subject_seed, subject_index).
struct Bystander {
  Family family = Family::training;
  std::uint64_t subject_seed = 0;
  std::uint64_t subject_index = 0;
  StandingPose pose = StandingPose::relaxed;
  Clothing clothing = Clothing::none;
  bool hair = false;
  float yaw_deg = 1e9F;  // 0 faces the camera; 1e9: along the path while walking, else drawn by pose class
  FloorPath path;        // {x, z} alone: stands there
  bool still = false;    // without sway: a mannequin
};
inline constexpr std::size_t kBystandersMax = 30;

struct SceneOptions {
  bool floor = true;
  bool wall = true;
  int furniture_count = 0;     // boxes, tables, chairs about the person, not in front of the person
  float wall_distance_mm = 0;  // behind the person; 0: drawn 450..2500
  float distance_mm = 0;       // camera to person along the floor; 0: drawn (2.0..2.6 m portrait, 2.4..3.2 m
                               // landscape), then enlarged until the whole person fits with a margin
  float camera_height_mm = 0;  // 0: drawn 800..1200
  float pitch_deg = 1e9F;      // looking down is positive; 1e9: drawn, about at the person's middle
  float yaw_deg = 1e9F;        // of the person; 1e9: drawn by pose class
  StandingPose pose = StandingPose::relaxed;
  int rotate_deg = 90;     // camera mounting, 0|90|180|270: the image is rendered as the sensor delivers it
  bool back_view = false;  // turned by 180 degrees
  bool sway = true;        // standing sway of a few mm and tenths of a degree; false: frames differ by noise only

  // Off by default; a disabled option leaves every other draw as it was.
  Clothing clothing = Clothing::none;  // also shoes; joints and person_mesh stay the naked body's, raised by the sole
  bool hair = false;                   // volume of 0..40 mm on the head's hair region
  Dresser dresser;                     // of Clothing::garments, of the main person
  std::uint64_t outfit_seed = 0;       // of clothes, shoes and hair; 0: the scene's
  bool person = true;                  // false: the room (and `others`) without the main person, who is still drawn
                                       // for the camera's place; mask empty, joints of confidence 0
  FloorPath walk;                      // of the main person; yaw 1e9: along it while walking. Camera and room are
                                       // placed as for a person standing at the origin
  AboutTurn turn;                      // of the main person, on the spot
  StepRound step_round;                // of the main person; not with `walk` or `turn`. Where the camera is carried
                                       // round the person, the room is carried along: it looks alike from all sides
  std::vector<Bystander> others;       // at most kBystandersMax
  bool furniture_touching = false;     // one or two pieces at the feet or beside the lower legs, 0..40 mm away
  int decoy_count = 0;          // coat stands, chairs with a coat, dog-sized boxes; without a person also where
                                // one would stand
  bool enlarge_to_fit = false;  // a given distance_mm, too, grows until the whole person fits (4.5 m at most)
  float pitch_limit_deg = 90;   // of a drawn pitch, up or down
  FloorPlate plate;             // what the main person stands on
};

// A scene drawn once; frames differ by sensor noise and by sway. Not shareable between threads; the model must
// outlive it, the subject need not.
class VirtualScene {
 public:
  VirtualScene(const body::BodyModel& model, const Subject& subject, const SceneOptions& scene,
               const SensorOptions& sensor, const Intrinsics& intrinsics, std::uint64_t seed);
  ~VirtualScene();
  VirtualScene(VirtualScene&&) noexcept;

  // The same camera before another person and room, as if newly made, without its allocations: for those who render
  // thousands.
  void restage(const Subject& subject, const SceneOptions& scene, std::uint64_t seed);
  // The same with another sensor of the same picture size. `rest`: what morph_subject() makes of the subject, where
  // the caller has it.
  void restage(const Subject& subject, const SceneOptions& scene, const SensorOptions& sensor, std::uint64_t seed,
               std::span<const Vec3f> rest = {});

  // Frame `index`: depends on the scene's seed and the index only. Depth as the sensor delivers it: `intrinsics`
  // size, before any --rotate. Frame times are index/30 s.
  void render(std::uint64_t index, DepthImage out);
  // Frame `index` again with other noise than the one rendered last, the same but for that (SceneOptions::sway off,
  // no person walking): its pixels of `box` alone; others of `out` stay as they are.
  void render_part(std::uint64_t index, const PixelBox& box, DepthImage out);
  const Intrinsics& intrinsics() const;
  // Truth in camera axes of the *upright* image, the one the program sees after undoing rotate_deg. `who`: 0 the main
  // person, 1.. SceneOptions::others in order; out of range: confidence 0.
  JointSet joints(std::uint64_t index, std::size_t who = 0) const;
  std::size_t people_count() const;  // with the main person, shown or not
  // Of the upright picture, where the camera is carried round the person: the place at rest is where it would stand
  // if it were not.
  hal::CameraPose camera_pose(std::uint64_t index) const;
  FloorPlane floor() const;  // known also when SceneOptions::floor is off
  // Body vertices (body_vertex_count of them, an actor's own) of frame `index`, upright camera axes.
  void person_mesh(std::uint64_t index, std::span<Vec3f> out, std::size_t who = 0) const;
  // What is drawn of a person: body in clothes, skirt, shoes, hair; upright camera axes.
  struct Surface {
    std::vector<Vec3f> vertices;
    std::vector<Triangle> triangles;
  };
  Surface person_surface(std::uint64_t index, std::size_t who = 0) const;
  // Mask of the person, upright or not like render()'s output, of the frame rendered last: 255 where the pixel is
  // the person's, flying ones too (holes and shadow are 0). Masks of different people are disjoint.
  void person_mask(MaskImage out, std::size_t who = 0) const;
  // Those pixels of the main person's mask whose delivered depth is a mixture with the surface behind or in front,
  // more than kMixedMm off the person's surface (flying pixels; time of flight alone).
  void mixed_mask(MaskImage out) const;
  // Box of the main person's clean silhouette in the frame rendered last, sensor pixels; empty before the first.
  PixelBox person_box() const;
  float distance_mm() const;  // as drawn or given

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace im2fit::lab
