// SPDX-License-Identifier: Apache-2.0
#include "evaluation/tracker/clip_trials.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/rng.h"
#include "evaluation/tracker/upright_scene.h"
#include "perception/observe/observe.h"
#include "train/common/parallel.h"

namespace im2fit::lab {
namespace {

constexpr std::uint64_t kClipStream = 0xC119;
constexpr std::size_t kPeople = 2;
constexpr int kChoiceFrame = 10;      // the person found then is to be kept
constexpr float kHeadMm = 300;        // a user's crown and the true head joint: one person's
constexpr double kInViewShare = 0.3;  // of the pixels a person showed at most: in view

float draw(Rng& rng, double low, double high) {
  return static_cast<float>(rng.uniform(low, high));
}

// Two people whose paths cross once, one before the other, at different times of the clip and speeds.
Shot draw_clip(std::uint64_t seed, std::uint64_t clip, int frames) {
  Rng rng = Rng::for_item(seed, kClipStream, clip);
  Shot shot;
  shot.seed = rng.next();
  shot.sensor = rng.uniform() < 0.7 ? kinect_sensor() : tof_sensor();
  shot.intrinsics = rng.uniform() < 0.25 ? kinect_intrinsics(640, 480) : kinect_intrinsics(320, 240);
  SceneOptions& scene = shot.scene;
  scene.rotate_deg = 0;
  scene.distance_mm = draw(rng, 2700, 3100);
  scene.camera_height_mm = draw(rng, 900, 1500);
  scene.wall_distance_mm = draw(rng, 1400, 2200);
  scene.furniture_count = rng.index(3);
  scene.clothing = static_cast<Clothing>(rng.index(4));
  scene.hair = rng.uniform() < 0.5;
  const float side = rng.uniform() < 0.5 ? -1.0F : 1.0F;
  const auto path = [&](float from_side, double z_low, double z_high) {
    FloorPath path;
    path.from_x_mm = from_side * draw(rng, 700, 1000);
    path.to_x_mm = -from_side * draw(rng, 700, 1000);
    path.from_z_mm = draw(rng, z_low, z_high);
    path.to_z_mm = draw(rng, z_low, z_high);
    path.frame_count = std::min(frames, 60 + rng.index(90));
    path.frame_first = std::min(30 + rng.index(60), std::max(0, frames - path.frame_count));
    return path;
  };
  const bool main_in_front = rng.uniform() < 0.5;
  scene.walk = main_in_front ? path(side, 100, 500) : path(side, -900, -500);
  Bystander other;
  other.family = Family::held_out;
  other.subject_seed = rng.next();
  other.subject_index = static_cast<std::uint64_t>(rng.index(2));
  other.clothing = static_cast<Clothing>(rng.index(4));
  other.hair = rng.uniform() < 0.5;
  other.path = main_in_front ? path(-side, -900, -500) : path(-side, 100, 500);
  scene.others.push_back(other);
  return shot;
}

std::uint64_t count_of(MaskView mask) {
  return static_cast<std::uint64_t>(person_of_mask(mask).pixel_count);
}

// Matches the frame's users to the true people and counts what changed.
class IdBook {
 public:
  // Changes: an id seen on another person than before, or a person in view under another id.
  std::uint64_t note(std::span<const User> users, const std::array<JointSet, kPeople>& truth,
                     const std::array<bool, kPeople>& in_view) {
    std::uint64_t changes = 0;
    for (std::size_t p = 0; p < kPeople; ++p) {
      if (!in_view[p]) continue;
      const User* user = user_of(users, truth[p]);
      if (user == nullptr) continue;
      const auto [person, new_id] = person_of_.try_emplace(user->id, p);
      const bool other_person = !new_id && person->second != p;
      const bool other_id = id_of_[p] != 0 && id_of_[p] != user->id;
      if (other_person || other_id) ++changes;
      person->second = p;
      id_of_[p] = user->id;
    }
    return changes;
  }

 private:
  static const User* user_of(std::span<const User> users, const JointSet& truth) {
    const User* nearest = nullptr;
    float least = kHeadMm;
    for (const User& user : users) {
      const float away = norm(user.head_mm - truth[Joint::HE]);
      if (user.has_head && user.confirmed && away < least) {
        least = away;
        nearest = &user;
      }
    }
    return nearest;
  }

  std::map<int, std::size_t> person_of_;
  std::array<int, kPeople> id_of_{};
};

ClipOutcome run_clip(const body::BodyModel& model, const JointModel& joint_model, const ClipOptions& options,
                     std::uint64_t clip) {
  const Subject subject = draw_subject(model, Family::held_out, options.seed, clip);
  UprightScene scene(model, subject, draw_clip(options.seed, clip, options.frames));
  const Intrinsics k = scene.intrinsics();
  PersonDetector sensor(k.width, k.height, joint_model);
  std::vector<std::uint8_t> mask(static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height));
  IdBook book;
  std::array<std::uint64_t, kPeople> most{};
  std::size_t kept = kPeople;  // the person to stay with; kPeople: not chosen yet
  ClipOutcome outcome;
  outcome.clip = clip;
  bool astray = false;
  for (int frame = 0; frame < options.frames; ++frame) {
    scene.show(static_cast<std::uint64_t>(frame));
    const Detection detection = sensor.sense(scene.depth(), k, MaskImage(mask.data(), k.width, k.height));
    std::array<JointSet, kPeople> truth;
    std::array<bool, kPeople> in_view{};
    std::size_t owner = kPeople;
    for (std::size_t p = 0; p < kPeople; ++p) {
      const MaskView true_mask = p == 0 ? scene.truth_mask() : scene.other_mask(p);
      const std::uint64_t pixels = count_of(true_mask);
      most[p] = std::max(most[p], pixels);
      in_view[p] = static_cast<double>(pixels) >= kInViewShare * static_cast<double>(most[p]) && pixels > 0;
      truth[p] = scene.truth(p);
      if (detection.person.found &&
          overlap_of(scene.depth(), MaskView(mask.data(), k.width, k.height), true_mask).finding() == Finding::person)
        owner = p;
    }
    ++outcome.frames;
    outcome.found += owner < kPeople ? 1 : 0;
    outcome.id_switches +=
        book.note({detection.users.data(), static_cast<std::size_t>(detection.user_count)}, truth, in_view);
    if (kept == kPeople && frame >= kChoiceFrame && owner < kPeople && detection.person.id > 0) {
      kept = owner;
      sensor.people().select(detection.person.id);
    }
    // One change, however long it lasts.
    const bool on_other = kept < kPeople && owner < kPeople && owner != kept;
    if (on_other && !astray) ++outcome.switches;
    if (owner < kPeople) astray = on_other;
  }
  return outcome;
}

}  // namespace

std::vector<ClipOutcome> run_clips(const body::BodyModel& model, const JointModel& joint_model,
                                   const ClipOptions& options) {
  std::vector<ClipOutcome> outcomes(static_cast<std::size_t>(options.clips));
  for_each_item(
      outcomes.size(), options.threads,
      [&](std::uint64_t clip) {
        outcomes[static_cast<std::size_t>(clip)] = run_clip(model, joint_model, options, clip);
      },
      begin_progress(options.progress, "two-person clips", outcomes.size()));
  return outcomes;
}

}  // namespace im2fit::lab
