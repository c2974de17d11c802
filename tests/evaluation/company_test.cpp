// SPDX-License-Identifier: Apache-2.0
// A person beside a mannequin and a person whose hand is at a wall, in rendered rooms, by the device's own stages but
// the index. IM2FIT_COMPANY_SCENES: how many of each (default 4).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "engine/sensing_stages.h"
#include "evaluation/tracker/scene_props.h"
#include "evaluation/tracker/upright_scene.h"
#include "person/data_files.h"
#include "tests/train/body_fixture.h"

namespace im2fit::lab {
namespace {

constexpr int kFramesMax = 150;  // five seconds
constexpr int kFramesWanted = 30;

int scene_count() {
  const char* text = std::getenv("IM2FIT_COMPANY_SCENES");
  return text != nullptr ? std::atoi(text) : 4;
}

const Tracker* tracker() {
  static const auto loaded = Tracker::load(data_path("IM2FIT_TRACKER", "tracker.i2t"));
  return loaded ? &*loaded : nullptr;
}

struct Seen {
  int frames_used = 0;
  double other_share = 0;  // of the accepted frames' masks, the part that is the other one's
  EngineResult result;
  std::map<std::string_view, int> codes;
};

// One still frame over and over, or `kFramesMax` frames.
struct Play {
  int frames = kFramesMax;
  bool one_frame = false;
  int user_from_frame = -1;  // select the person there; -1: never
  std::optional<FloorRegion> region;
  std::vector<MirrorWall> walls;
};

using Company = WithBody;

Seen watch(const body::BodyModel& model, const Subject& subject, const Shot& shot, const Play& play) {
  UprightScene scene(model, subject, shot);
  Seen seen;
  EngineSettings settings;
  settings.intrinsics = scene.intrinsics();
  settings.width = settings.intrinsics.width;
  settings.height = settings.intrinsics.height;
  settings.frames_wanted = kFramesMax + 1;
  settings.single_thread = true;
  settings.region = play.region;
  double other = 0, all = 0;
  settings.watch = [&](const FrameSeen& frame) {
    if (frame.result.guidance != 0) return;
    if (shot.scene.others.empty()) return;
    const MaskView not_own = scene.other_mask(1);
    for (int v = 0; v < not_own.height; v += 2)
      for (int u = 0; u < not_own.width; u += 2) {
        if (frame.mask.at(u, v) == 0) continue;
        all += 1;
        other += not_own.at(u, v) != 0 ? 1 : 0;
      }
  };
  auto engine =
      create_engine(settings, std::make_unique<SensingStages>(settings.width, settings.height, tracker()->model()));
  const PropAxes axes(scene.floor(), scene.staged().distance_mm());
  for (int i = 0; i < play.frames; ++i) {
    const auto shown = static_cast<std::uint64_t>(play.one_frame ? 0 : i);
    scene.show(shown);
    for (std::size_t w = 0; w < play.walls.size(); ++w)
      draw_props({{}, play.walls[w]}, axes, settings.intrinsics, shot.seed + w, shown, scene.depth());
    if (i == play.user_from_frame) {
      const EngineResult now = (*engine)->result();
      const auto truth = scene.truth();
      const float x = truth[Joint::TO].x;
      int best = 0;
      float away = 1e9F;
      for (int k = 0; k < now.user_count; ++k) {
        const User& user = now.users[static_cast<std::size_t>(k)];
        const float d = std::fabs(user.centroid_mm.x - x);
        if (d < away) {
          away = d;
          best = user.id;
        }
      }
      (*engine)->select_user(best);
    }
    hal::FrameInfo info;
    info.sequence = static_cast<std::uint64_t>(i);
    info.host_ns = i * 33'333'333LL;
    EXPECT_TRUE((*engine)->push(scene.depth(), info));
    for (const auto code : names_of((*engine)->result().guidance)) ++seen.codes[code];
  }
  seen.result = (*engine)->result();
  seen.frames_used = static_cast<int>(seen.result.frames_used);
  seen.other_share = all > 0 ? other / all : 0;
  return seen;
}

bool measured(const Seen& seen) {
  return seen.frames_used >= kFramesWanted && seen.other_share < 0.05;
}

void tell(const char* what, int i, const Seen& seen) {
  std::printf("%s %d: used %d, other %.3f", what, i, seen.frames_used, seen.other_share);
  for (const auto& [code, count] : seen.codes)
    std::printf(" %.*s %d", static_cast<int>(code.size()), code.data(), count);
  for (int k = 0; k < seen.result.user_count; ++k) {
    const User& user = seen.result.users[static_cast<std::size_t>(k)];
    std::printf(" [%d x %.0f z %.0f %s %d]", user.id, user.centroid_mm.x, user.centroid_mm.z,
                user.confirmed ? "confirmed" : "candidate", static_cast<int>(user.left_out));
  }
  std::printf("\n");
}

Shot shop(std::uint64_t seed, float beside_mm, float nearer_mm, bool still) {
  Shot shot;
  shot.seed = seed;
  shot.sensor = kinect_sensor();
  shot.intrinsics = kinect_intrinsics(640, 480);
  shot.scene = {};
  shot.scene.yaw_deg = 0;
  shot.scene.pose = StandingPose::a_pose;
  Bystander other;
  other.family = Family::held_out;
  other.subject_seed = seed;
  other.subject_index = 31;
  other.yaw_deg = 10;
  other.path = {};
  other.path.from_x_mm = beside_mm;
  other.path.from_z_mm = nearer_mm;
  other.still = still;
  shot.scene.others = {other};
  return shot;
}

// Whether two people of a scene are so far apart that they do not touch.
bool apart(const body::BodyModel& model, const Subject& subject, const Shot& shot) {
  constexpr float kGapMm = 60;
  constexpr std::size_t kStride = 7;
  const UprightScene staged(model, subject, shot);
  std::vector<Vec3f> one(static_cast<std::size_t>(model.body_vertex_count())), two = one;
  staged.staged().person_mesh(0, one, 0);
  staged.staged().person_mesh(0, two, 1);
  for (std::size_t i = 0; i < one.size(); i += kStride)
    for (std::size_t j = 0; j < two.size(); j += kStride)
      if (norm(one[i] - two[j]) < kGapMm) return false;
  return true;
}

struct Pair {
  Shot shot;
  Subject subject;
};
// A person who alone is measured, beside another one: some stand with their arms too close.
Pair pair_of(const body::BodyModel& model, int i, bool still) {
  for (std::uint64_t draw = 0;; ++draw) {
    Rng rng(900 + static_cast<std::uint64_t>(i) + 1000 * draw);
    const float beside = static_cast<float>(rng.uniform(620, 800)) * (rng.uniform() < 0.5 ? -1.0F : 1.0F);
    const float nearer = static_cast<float>(rng.uniform(-300, 250));
    Pair pair{shop(rng.next(), beside, nearer, still),
              draw_subject(model, Family::held_out, 900 + draw, static_cast<std::uint64_t>(i))};
    Shot alone = pair.shot;
    alone.scene.others.clear();
    Play play;
    play.frames = kFramesWanted + 10;
    if (apart(model, pair.subject, pair.shot) && watch(model, pair.subject, alone, play).frames_used >= kFramesWanted)
      return pair;
  }
}

TEST_F(Company, AMannequinBesideIsLeftOut) {
  if (tracker() == nullptr) GTEST_SKIP() << "no tracker";
  int good = 0;
  for (int i = 0; i < scene_count(); ++i) {
    const Pair pair = pair_of(model(), i, true);
    const Seen seen = watch(model(), pair.subject, pair.shot, {});
    tell("mannequin", i, seen);
    good += measured(seen) ? 1 : 0;
  }
  std::printf("mannequin: %d of %d\n", good, scene_count());
  EXPECT_GE(good * 100, scene_count() * 95);
}

TEST_F(Company, APersonBesideIsNotLeftOut) {
  if (tracker() == nullptr) GTEST_SKIP() << "no tracker";
  for (int i = 0; i < scene_count(); ++i) {
    const Pair pair = pair_of(model(), i, false);
    const Seen seen = watch(model(), pair.subject, pair.shot, {});
    tell("two people", i, seen);
    for (int k = 0; k < seen.result.user_count; ++k)
      EXPECT_EQ(seen.result.users[static_cast<std::size_t>(k)].left_out, im2fit::LeftOut::no) << i;
  }
}

TEST_F(Company, WhoIsSelectedIsMeasuredBesideAnother) {
  if (tracker() == nullptr) GTEST_SKIP() << "no tracker";
  int good = 0;
  for (int i = 0; i < scene_count(); ++i) {
    const Pair pair = pair_of(model(), i, false);
    Play play;
    play.user_from_frame = 10;
    const Seen seen = watch(model(), pair.subject, pair.shot, play);
    tell("selected", i, seen);
    good += measured(seen) ? 1 : 0;
  }
  std::printf("selected: %d of %d\n", good, scene_count());
  EXPECT_GE(good * 100, scene_count() * 95);
}

TEST_F(Company, WhoStandsInTheRegionIsMeasuredBesideAnother) {
  if (tracker() == nullptr) GTEST_SKIP() << "no tracker";
  int good = 0;
  for (int i = 0; i < scene_count(); ++i) {
    const Pair pair = pair_of(model(), i, false);
    const UprightScene staged(model(), pair.subject, pair.shot);
    const float z = staged.staged().distance_mm();
    Play play;
    play.region = FloorRegion{-350, z - 600, 350, z + 500};
    const Seen seen = watch(model(), pair.subject, pair.shot, play);
    tell("region", i, seen);
    good += measured(seen) ? 1 : 0;
  }
  std::printf("region: %d of %d\n", good, scene_count());
  EXPECT_GE(good * 100, scene_count() * 95);
}

// A cabin: the outermost point of the person's left or right hand is in the wall's plane.
TEST_F(Company, AHandAtAWall) {
  if (tracker() == nullptr) GTEST_SKIP() << "no tracker";
  int good = 0, told = 0;
  for (std::uint64_t draw = 0, i = 0; i < static_cast<std::uint64_t>(scene_count()); ++draw) {
    Rng rng(700 + draw);
    Shot shot;
    shot.seed = rng.next();
    shot.sensor = kinect_sensor();
    shot.intrinsics = kinect_intrinsics(640, 480);
    shot.scene.yaw_deg = 0;
    shot.scene.pose = StandingPose::a_pose;
    shot.scene.wall_distance_mm = static_cast<float>(rng.uniform(500, 1500));
    const Subject subject = draw_subject(model(), Family::held_out, 700, draw);
    Play play;
    play.frames = kFramesWanted + 15;
    if (watch(model(), subject, shot, play).frames_used < kFramesWanted) continue;  // the arms too close
    const UprightScene staged(model(), subject, shot);
    const PropAxes axes(staged.floor(), staged.staged().distance_mm());
    std::vector<Vec3f> mesh(static_cast<std::size_t>(model().body_vertex_count()));
    staged.staged().person_mesh(0, mesh);
    float left = 1e9F, right = -1e9F;
    for (const Vec3f p : mesh) {
      const float x = axes.from_camera(p).x;
      left = std::min(left, x);
      right = std::max(right, x);
    }
    const bool at_left = rng.uniform() < 0.5;
    const float gap = static_cast<float>(rng.uniform(60, 200));
    MirrorWall one, two;
    one.normal = {-1, 0, 0};
    one.distance_mm = -left + (at_left ? 0 : gap);
    two.normal = {1, 0, 0};
    two.distance_mm = right + (at_left ? gap : 0);
    play.walls = {one, two};
    const Seen seen = watch(model(), subject, shot, play);
    tell("wall", static_cast<int>(i++), seen);
    good += measured(seen) ? 1 : 0;
    told += seen.codes.contains("STEP_TO_THE_MIDDLE") ? 1 : 0;
  }
  std::printf("wall: %d of %d measured, %d told\n", good, scene_count(), told);
  EXPECT_GE(good * 100, scene_count() * 70);
}

}  // namespace
}  // namespace im2fit::lab
