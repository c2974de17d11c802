// SPDX-License-Identifier: Apache-2.0
// Held-out synthetic people through the whole device path, against the truth measured on their meshes.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "body/model.h"
#include "engine/engine.h"
#include "estimate/age.h"
#include "evaluation/measurements/driver_filters.h"
#include "evaluation/population/ansur_people.h"
#include "evaluation/population/other_people.h"
#include "index/index.h"
#include "perception/joints/tracker.h"
#include "train/common/parallel.h"
#include "train/dataset/features.h"
#include "train/index/raw_nearest.h"

namespace im2fit::lab {

// Which sides of the person the camera is shown. `both`: front first, then the back, once the engine requests the
// turn.
// `around`, `half`: the person steps round once, or half, from then on. `walk`: a camera is carried round the person.
enum class Views { front, back, both, around, half, walk };

// Who is measured (docs/evaluation.md). `modifiers`: the body model's held-out family, of the same sliders as
// training people. `ansur`: people of measured dimensions made in another way (evaluation/population/ansur_people.h).
// `mixed`: two of one, two of the other, in turns. `other`: men of a surface and rig of another make, shown bare
// (evaluation/population/other_people.h). `unlike`: the out-of-distribution people that training calibrates on
// (train/population/ood_subjects.h); they judge nothing.
enum class PeopleFamily { modifiers, ansur, mixed, other, unlike };
inline constexpr std::array<std::string_view, 5> kPeopleFamilyNames = {"modifiers", "ansur", "mixed", "other",
                                                                       "unlike"};
constexpr std::string_view name_of(PeopleFamily family) {
  return kPeopleFamilyNames[static_cast<std::size_t>(family)];
}
Result<PeopleFamily> people_family_of(std::string_view name);

// What people report of themselves. Weight on a scale: within kScaleSdKg; stated: within kStatedWeightSdKg, to the
// kilogram. all: stature (kStatedStatureSdMm, to the centimetre), weight as stated, sex, age in completed years.
enum class KnownOf { nothing, weight_on_scale, weight_stated, all };

struct EvaluationOptions {
  int subjects = 200;
  std::uint64_t seed = 20'260'101;
  bool noise = true;              // false: a perfect sensor in an empty room
  bool tof = false;               // a time-of-flight sensor in place of a Kinect
  bool smoothed = false;          // by a driver, over time (driver_filters.h)
  EdgeFilterOptions edges;        // the driver's filter at edges, before it smooths
  float tremor_deg = 0;           // of a camera held in the hand (session.cpp)
  bool poses_told = false;        // the device says where that camera is, frame by frame
  bool sensor_reported = false;   // the driver reports what kind of sensor it is
  bool clothing_reported = true;  // the clothing worn is reported to the device
  bool clothed = false;           // tight, normal or loose clothes, shoes and hair; the truth stays the body's
  bool garments = false;  // with `clothed`: draped garments in the clothes' place (train/dressed/dressed_people.h)
  int frames = kFramesWantedDefault;  // accepted frames wanted; three times as many are shown at most
  int width = 640, height = 480;
  float camera_scale = 1;  // of the depth delivered, by the true one: a camera that is out of true
  float distance_mm = 0;   // of the camera, grown until the whole person fits; 0: drawn
  float yaw_deg = -1;      // of the person, to either side by turns; below 0: drawn
  StandingPose pose = StandingPose::relaxed;
  float body_mass_index_min = 0;  // only people of at least that much; 0: all
  Views views = Views::front;
  KnownOf known = KnownOf::nothing;
  float known_weight_off_kg = 0;  // added to the weight reported, to either side by turns: is it doubted?
  bool fit = true;                // false: features answer alone, no shape is fitted
  bool twice = false;             // shown again in a new pose, room and noise
  float second_waist_mm = 0;      // by so much the waist has grown then; not of the family other
  int threads = 1;                // does not change the result
  ProgressSink progress = {};
  PeopleFamily family = PeopleFamily::modifiers;
  std::shared_ptr<const AnsurPeople> ansur;  // not null when the family is ansur or mixed
  std::shared_ptr<const OtherPeople> other;  // not null when the family is other
};

// Changes a picture as the engine is given it, upright; `k` is its.
using PictureChange = std::function<void(const Intrinsics& k, const VirtualScene& scene, DepthImage upright)>;

// The person `index` of an evaluation, and where the camera stands. `showing` 1: the second time.
struct HeldOutPerson {
  Subject subject;
  CaptureOptions capture;
  bool smoothed = false, sensor_reported = false, clothing_reported = true;
  PeopleFamily family = PeopleFamily::modifiers;  // never mixed
  float camera_scale = 1;                         // as EvaluationOptions
  EdgeFilterOptions edges = {};
  float tremor_deg = 0;
  bool poses_told = false;
  KnownFacts known = {};
  std::vector<Vec3f> rest = {};  // the mesh at rest in place of the subject's own; empty: its own
  PictureChange change = {};     // of every picture; empty: none
};
HeldOutPerson draw_person(const body::BodyModel& model, const EvaluationOptions& options, std::uint64_t index,
                          int showing = 0);

// One person, one session; a second one for the sake of repeatability.
struct Outcome {
  PeopleFamily family = PeopleFamily::modifiers;  // never mixed
  bool woman = false;
  bool measured = false;
  GuidanceSet guidance_seen = 0;
  std::uint64_t frames_seen = 0;
  bool lifted_arms = false;  // on guidance (session.h)
  bool dressed = false;
  MeasurementValues truth{};  // NaN: not known, and left out of every figure
  float true_age_years = 0;
  index::Answer answer;
  AgeAnswer age;
  KnownOutcome known;
  MeasurementValues paper{};  // NaN where not measured
  bool has_raw = false;
  index::RawNearest::Match raw;
  bool measured_again = false;
  MeasurementValues again{};  // the second session's answer
  // Over all frames and joints with a person found.
  int joint_count = 0;
  int joints_within_100mm = 0;
  double joint_error_sum_mm = 0;
};

// `raw`: the paper's nearest neighbour, or null. Depends on the options except threads. `what` is shown with the
// progress.
Result<std::vector<Outcome>> evaluate(const body::BodyModel& model, const JointModel& joint_model,
                                      const index::Index& index, const index::RawNearest* raw,
                                      const EvaluationOptions& options, const std::string& what = "people");

}  // namespace im2fit::lab
