// SPDX-License-Identifier: Apache-2.0
// One person through one frame, and the features of fused frames: what the engine runs on the device and the
// dataset runs on renders, so that both see the same numbers. No allocation after construction, no threads.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "core/camera.h"
#include "core/guidance.h"
#include "core/joints.h"
#include "core/sensor_kind.h"
#include "perception/joints/tracker.h"
#include "perception/observe/gate.h"
#include "perception/observe/hole_filler.h"
#include "perception/observe/joint_filter.h"
#include "perception/observe/lean.h"
#include "perception/observe/sensor_traits.h"
#include "perception/observe/surroundings.h"
#include "perception/paper/paper.h"
#include "perception/profile/profile.h"
#include "perception/segment/person_tracker.h"
#include "perception/segment/segment.h"

namespace im2fit {

// The paper's 501 dimensions (4 lengths, 2 ratios, 33 x 15 FPFH) first, then our section profile, then what kind
// of sensor the frames are from.
inline constexpr std::size_t kPaperFeatureSize = 4 + 2 + 33 * kJointCount;
inline constexpr std::size_t kProfileSize = ProfileLayout::kSize;
inline constexpr std::size_t kFeatureSize = kPaperFeatureSize + kProfileSize + kSensorTraits;
using Feature = std::array<float, kFeatureSize>;

// First stage (thread SENSE): the people in view, and the joints of one of them.
struct Detection {
  Person person;
  JointSet joints;        // meaningful when person.found
  float back_chance = 0;  // of the back being towards the camera
  ViewSide view = ViewSide::unknown;
  std::array<User, kUserCountMax> users{};  // all people in view, nearest first; the first user_count are set
  int user_count = 0;
  GuidanceSet guidance = 0;     // the person's and the pose's: zero means the frame may be used
  ArmSet arms_close = 0;        // which arms arms_close is about; 0 without that code
  float height_mm = 0;          // mask_height_mm() of one who is wholly seen and stands; else 0
  bool edges_restored = false;  // the frame's, by EdgeRestorer before it was sensed
};
class PersonDetector {
 public:
  PersonDetector(int width, int height, const JointModel& model);
  // `seconds` since the frame before. `frame_guidance`: codes that the frame as a whole carries already, reported
  // with those of a person found.
  Detection sense(DepthView depth, const Intrinsics& intrinsics, MaskImage mask, float seconds = kFramePeriodS,
                  GuidanceSet frame_guidance = 0);
  // The direction of gravity, a unit vector in the frames' axes, from the next frame on: it defines upright where no
  // floor is seen. Holds until reset().
  void set_down(Vec3f down) { up_ = -down; }
  // The people followed, the selected one and the session's. Between frames.
  PersonTracker& people() { return people_; }
  void reset();  // forgets the room and the people; a selection stays

 private:
  JointEvidence evidence(const Person& person) const;
  Detection without_person(const Detection& refused, MaskImage mask);
  static void judge_height(DepthView depth, const Intrinsics& intrinsics, MaskView mask, Detection& detection);
  void judge_pose(DepthView depth, const Intrinsics& intrinsics, MaskView mask, const Lean& lean,
                  Detection& detection);

  HoleFiller holes_;
  Segmenter segmenter_;
  PersonTracker people_;
  std::optional<Vec3f> up_;
  JointTracker tracker_;
  int previous_user_ = 0;  // whose joints tracker_ followed in the last frame; 0: none's
};

// Second stage (thread FIT): accumulate frames, then describe.
class Fuser {
 public:
  Fuser(int width, int height);
  ~Fuser();
  Fuser(Fuser&&) noexcept;
  void reset();
  // Adds an accepted frame (guidance zero). A frame that does not fit the accumulated ones is not added: returns
  // guidance (moving).
  GuidanceSet add(DepthView depth, MaskView mask, const Intrinsics& intrinsics, const Detection& detection);
  int frame_count() const;
  // Of the frames accumulated.
  const Intrinsics& intrinsics() const;

  struct Description {
    bool valid = false;
    JointSet joints;  // robust mean over the frames
    FloorPlane floor;
    int distance_mm = 0;  // of the trunk's middle, along the camera's axis; 65535 at most
    PaperMeasurements paper;
    Feature feature;
    float crown_flatness = 0;  // observe/surroundings.h; not a number where no head is seen
  };
  // What lies about the person, of the frames accumulated so far.
  SurroundingsSigns surroundings() const;
  // Features of the frames accumulated so far, from a sensor of this kind. `ground_mm`: what the feet stand on, above
  // the floor; heights count from there.
  const Description& describe(SensorKind kind = SensorKind::unknown, float ground_mm = 0);
  // The fused picture, for overlays: depth in 1/16 mm and mask.
  ImageView<const std::uint16_t> depth_q4() const;
  MaskView mask() const;

 private:
  struct Workspace;
  std::unique_ptr<Workspace> work_;
};

}  // namespace im2fit
