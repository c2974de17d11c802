// SPDX-License-Identifier: Apache-2.0
// Garments on bodies: strain, skin, folds, rest, and the same bits everywhere.
//
// IM2FIT_GARMENT_PEOPLE=100 dresses so many held-out people instead of two and moves them through ten poses instead
// of four.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

#include "allocations.h"
#include "body/model.h"
#include "body_pack.h"
#include "evaluation/garment/drape_quality.h"
#include "evaluation/garment/standing_quality.h"
#include "evaluation/garment/triangle_pixels.h"
#include "garment/drape/outfit.h"
#include "person/garment_fit.h"
#include "report/dressed_picture.h"
#include "train/dressed/dressed_people.h"

namespace im2fit::lab {
namespace {

struct SkinSeen {
  int cloth_px = 0;    // of all views
  int through_px = 0;  // of covered skin with the cloth that covers it right behind
  int bare_px = 0;     // of covered skin from which a hem has moved away: a shirt's as arms rise, a leg's in a lap
  int drawn_px = 0;    // through_px where skin that cloth hides as it lies is left out, as pictures leave it out
};

constexpr float kPixelMm = 3;
constexpr float kThroughMm = 40;  // deeper folds are rare; the cloth on the other side of a wrist is farther
constexpr int kWidth = 680, kHeight = 860;  // arms out, and up
enum : std::uint8_t { kNothing, kSkin, kCoveredSkin, kCloth };

struct Picture {
  std::vector<float> nearest = std::vector<float>(std::size_t{kWidth} * kHeight, -1e9F);
  std::vector<float> cloth = nearest;  // the nearest of the cloth alone
  std::vector<std::uint8_t> what = std::vector<std::uint8_t>(std::size_t{kWidth} * kHeight, kNothing);

  // Pixels and millimetres towards the viewer.
  void fill(Vec3f a, Vec3f b, Vec3f c, std::uint8_t kind) {
    for_each_pixel(kWidth, kHeight, a, b, c, [&](std::size_t at, float z) {
      if (kind == kCloth) cloth[at] = std::max(cloth[at], z);
      if (z <= nearest[at]) return;
      nearest[at] = z;
      what[at] = kind;
    });
  }
};

// The body's vertices that cloth covers now, some centimetres from any hem: 1 each.
std::vector<std::uint8_t> covered_skin(const body::BodyModel& model, const body::Outfit& outfit) {
  std::vector<std::uint8_t> covered(static_cast<std::size_t>(model.body_vertex_count()));
  outfit.hidden_skin(covered);
  return covered;
}

// Of four views (front, left, back, slant), 3 mm a pixel; but for drawn_px no skin is left out: cloth itself has to
// cover it. `covered`: of a pose in which it did.
SkinSeen look_for_skin(const body::BodyModel& model, const body::Outfit& outfit,
                       std::span<const std::uint8_t> covered) {
  const auto skin = outfit.body().first(static_cast<std::size_t>(model.body_vertex_count()));
  Vec3f low = skin[0], high = skin[0];
  for (const Vec3f& p : skin) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  const Vec3f middle = (low + high) * 0.5F;
  std::vector<std::vector<Vec3f>> cloth(outfit.size());
  for (std::size_t i = 0; i < outfit.size(); ++i) {
    cloth[i].resize(outfit.cloth(i).mesh().vertex_count());
    outfit.shown(i, cloth[i]);
  }
  SkinSeen seen;
  const auto hidden = covered_skin(model, outfit);
  for (const PictureView& view : {kFrontView, kLeftView, kBackView, kSlantView})
    for (const bool drawn : {false, true}) {
      Picture picture;
      const auto at = [&](Vec3f v) {
        const Vec3f p = v - middle;
        return Vec3f{kWidth / 2.0F + (view.cosine * p.x - view.sine * p.z) / kPixelMm,
                     kHeight / 2.0F - p.y / kPixelMm, view.sine * p.x + view.cosine * p.z};
      };
      for (const auto& t : model.body_triangles()) {
        const auto v = [&](std::size_t k) { return static_cast<std::size_t>(t[k]); };
        const auto all = [&](std::span<const std::uint8_t> of) {
          return of[v(0)] != 0 && of[v(1)] != 0 && of[v(2)] != 0;
        };
        if (drawn && all(hidden)) continue;
        picture.fill(at(skin[v(0)]), at(skin[v(1)]), at(skin[v(2)]), all(covered) ? kCoveredSkin : kSkin);
      }
      for (std::size_t i = 0; i < outfit.size(); ++i)
        for (const auto& t : outfit.cloth(i).mesh().triangles) {
          const auto v = [&](std::size_t k) { return cloth[i][static_cast<std::size_t>(t[k])]; };
          picture.fill(at(v(0)), at(v(1)), at(v(2)), kCloth);
        }
      int through = 0, bare = 0;
      for (std::size_t i = 0; i < picture.what.size(); ++i) {
        if (picture.what[i] != kCoveredSkin) continue;
        ++(picture.nearest[i] - picture.cloth[i] < kThroughMm ? through : bare);
      }
      if (drawn) {
        seen.drawn_px += through;
        continue;
      }
      seen.cloth_px += static_cast<int>(std::count(picture.what.begin(), picture.what.end(), kCloth));
      seen.through_px += through;
      seen.bare_px += bare;
    }
  return seen;
}

using body::Outfit;
using body::real_body;

class DressedBody : public testing::Test {
 protected:
  void SetUp() override { IM2FIT_NEEDS_BODY(); }
};

void rest(Outfit& outfit, int frames) {
  const body::Pose pose = outfit.pose();
  for (int i = 0; i < frames; ++i) outfit.frame(pose);
}

// Bounds are the solver's present values with a margin, not its goals: docs/garments.md has both.
TEST_F(DressedBody, ClothLiesOutsideTheSkinAndHardlyStretches) {
  for (const DressedPerson& person : example_people(*real_body())) {
    Outfit outfit(*real_body(), pieces_for(person, {"trousers", "t_shirt"}));
    outfit.dress(person.rest, person.skeleton, dressed_poses(*real_body(), person)[0].pose);
    for (std::size_t i = 0; i < outfit.size(); ++i) {
      const DrapeQuality q = judge(outfit, i);
      ASSERT_TRUE(q.finite) << person.name;
      EXPECT_LT(q.strain_mean, 0.02F) << person.name << " " << i;
      EXPECT_LT(q.strain_p95, 0.11F) << person.name << " " << i;
      EXPECT_LT(q.strain_peak, 0.5F) << person.name << " " << i;
      EXPECT_LT(q.inside_share, 0.002F) << person.name << " " << i;
      EXPECT_LT(q.hem_roughness_mm, 5) << person.name << " " << i;
      EXPECT_GT(q.folds_mm, 0.3F) << person.name << " " << i;
    }
  }
}

// Thirty frames after its body does, and when the body moves on it follows at once.
TEST_F(DressedBody, ComesToRestAndWakes) {
  const auto people = example_people(*real_body());
  const DressedPerson& person = people[1];
  const auto poses = dressed_poses(*real_body(), person);
  Outfit outfit(*real_body(), pieces_for(person, {"trousers", "t_shirt"}));
  outfit.dress(person.rest, person.skeleton, poses[0].pose);
  rest(outfit, 22);  // and eight in dress()
  for (std::size_t i = 0; i < outfit.size(); ++i) {
    const auto before = positions_of(outfit.cloth(i));
    rest(outfit, 1);
    EXPECT_LT(motion_since(outfit.cloth(i), before).rms_mm, 0.1F) << i;
  }
  rest(outfit, 30);
  const auto before = positions_of(outfit.cloth(1));
  outfit.move_to(poses[3].pose, 20);
  EXPECT_GT(motion_since(outfit.cloth(1), before).rms_mm, 10);
  const DrapeQuality q = judge(outfit, 1);
  EXPECT_LT(q.inside_share, 0.005F);
}

// A loose shirt hangs free at its hem, so it measures there the girth of its cut.
TEST_F(DressedBody, AHemMeasuresWhatThePatternSays) {
  const auto people = example_people(*real_body());
  Outfit outfit(*real_body(), pieces_for(people[0], {"t_shirt"}, 1));
  outfit.dress(people[0].rest, people[0].skeleton, dressed_poses(*real_body(), people[0])[0].pose);
  rest(outfit, 20);
  EXPECT_NEAR(hem_girth_mm(outfit.cloth(0), false), hem_girth_mm(outfit.cloth(0), true), 3);
}

TEST_F(DressedBody, ALooseShirtFoldsMoreThanATightOne) {
  const auto people = example_people(*real_body());
  const DressedPerson& person = people[1];
  float folds[2];
  for (const int loose : {0, 1}) {
    Outfit outfit(*real_body(), pieces_for(person, {"t_shirt"}, loose != 0 ? 1 : -2));
    outfit.dress(person.rest, person.skeleton, dressed_poses(*real_body(), person)[0].pose);
    folds[loose] = judge(outfit, 0).folds_mm;
  }
  EXPECT_GT(folds[1], folds[0]);
}

TEST_F(DressedBody, DoesNotAllocateOnceItIsMade) {
  const auto people = example_people(*real_body());
  Outfit outfit(*real_body(), pieces_for(people[3], {"t_shirt"}));
  const auto poses = dressed_poses(*real_body(), people[3]);
  const auto before = body::allocations_so_far();
  outfit.dress(people[3].rest, people[3].skeleton, poses[0].pose);
  outfit.move_to(poses[3].pose, 3);
  EXPECT_EQ(body::allocations_so_far(), before);
}

TEST_F(DressedBody, TheSameTwice) {
  const auto people = example_people(*real_body());
  std::uint64_t prints[2];
  for (std::uint64_t& print : prints) {
    Outfit outfit(*real_body(), pieces_for(people[3], {"t_shirt"}));
    outfit.dress(people[3].rest, people[3].skeleton, body::a_pose(people[3].skeleton));
    print = fingerprint(outfit.cloth(0));
  }
  EXPECT_EQ(prints[0], prints[1]);
}

// What stands out of the shirt over it is shown pressed down, but not into the skin.
TEST_F(DressedBody, WhatIsPressedDownStaysOffTheSkin) {
  const DressedPerson person = drawn_person(*real_body(), 2);
  Outfit outfit(*real_body(), pieces_for(person, {"trousers", "t_shirt"}));
  outfit.dress(person.rest, person.skeleton, dressed_poses(*real_body(), person)[0].pose);
  outfit.move_to(dressed_poses(*real_body(), person)[7].pose, 20);
  const body::Cloth& trousers = outfit.cloth(0);
  std::vector<Vec3f> shown(trousers.mesh().vertex_count());
  outfit.shown(0, shown);
  int pressed = 0;
  for (std::size_t v = 0; v < shown.size(); ++v) {
    if (norm(shown[v] - trousers.position(v)) < 1) continue;
    ++pressed;
    const body::SkinPlace& place = trousers.contacts()[v];
    if (place.triangle < 0) continue;
    const Vec3f facing = outfit.skin().facing(place, true);
    const auto off = [&](Vec3f p) { return dot(p - outfit.skin().at(place, true), facing); };
    EXPECT_GT(off(shown[v]), std::min(off(trousers.position(v)), 2.0F) - 0.01F) << v;
  }
  EXPECT_GT(pressed, 20);
}

// A heavy woman's trousers, which her lap would pull apart, lie within her thighs: they are shown on them.
TEST_F(DressedBody, WhatLiesWithinTheSkinIsShownOnIt) {
  const DressedPerson person = drawn_person(*real_body(), 99);
  const auto poses = dressed_poses(*real_body(), person);
  Outfit outfit(*real_body(), pieces_for(person, {"trousers", "t_shirt"}));
  outfit.dress(person.rest, person.skeleton, poses[0].pose);
  const auto covered = covered_skin(*real_body(), outfit);
  outfit.move_to(poses[9].pose, 20);
  rest(outfit, 20);
  const body::Cloth& trousers = outfit.cloth(0);
  std::vector<Vec3f> shown(trousers.mesh().vertex_count());
  outfit.shown(0, shown);
  int lifted = 0;
  for (std::size_t v = 0; v < shown.size(); ++v) {
    const body::SkinPlace& place = trousers.contacts()[v];
    if (place.triangle < 0 || trousers.pinched()[v] != 0) continue;
    const Vec3f facing = outfit.skin().facing(place, true);
    const auto off = [&](Vec3f p) { return dot(p - outfit.skin().at(place, true), facing); };
    if (off(trousers.position(v)) > -4 || off(trousers.position(v)) < -20) continue;
    ++lifted;
    EXPECT_GT(off(shown[v]), 1.9F) << v;
  }
  EXPECT_GT(lifted, 5);
  // It was a patch of 500 pixels.
  EXPECT_LT(look_for_skin(*real_body(), outfit, covered).drawn_px, 20);
}

// What evaluation people wear: off the skin, the same twice, and wider in a larger size.
TEST_F(DressedBody, GarmentsOfAnEvaluationHangOnTheSkin) {
  const auto people = example_people(*real_body());
  const DressedPerson& person = people[1];
  const body::Pose pose = dressed_poses(*real_body(), person)[0].pose;
  const auto hang = [&](int sizes_larger) {
    return dresser_of(*real_body(), person.woman, {{"trousers", "t_shirt"}, sizes_larger})(person.rest,
                                                                                           person.skeleton, pose);
  };
  const DrapedCloth cloth = hang(0), again = hang(0), larger = hang(1);
  ASSERT_GT(cloth.triangles.size(), 10'000U);
  ASSERT_EQ(cloth.vertices.size(), again.vertices.size());
  Vec3f low = cloth.vertices[0], high = low;
  for (std::size_t i = 0; i < cloth.vertices.size(); ++i) {
    const Vec3f p = cloth.vertices[i], q = again.vertices[i];
    ASSERT_TRUE(p.x == q.x && p.y == q.y && p.z == q.z);
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  for (const body::Segment covered : {body::Segment::pelvis, body::Segment::chest, body::Segment::left_lower_leg}) {
    const Vec3f joint = body::pose_skeleton(person.skeleton, pose).head[static_cast<std::size_t>(covered)];
    EXPECT_TRUE(joint.x > low.x && joint.x < high.x && joint.y > low.y && joint.y < high.y && joint.z > low.z &&
                joint.z < high.z);
  }
  EXPECT_NE(larger.vertices.size(), cloth.vertices.size());
}

// Everyone in every size is im2fit-lab make garment-sizes; these were among the worst. Before sleeves touched hands,
// 579 pixels of the first one's wrists came through his cuffs; the second one's front fell through her back (4067
// pixels of cloth's inside), and rims were as rough as 3.1 mm.
TEST_F(DressedBody, NothingShowsThroughInTheWorstSizes) {
  struct Worst {
    std::size_t person;
    const char* garment;
    int larger, crossed_px;
  };
  for (const Worst& worst : {Worst{1, "long_sleeved_shirt", 0, 400}, Worst{3, "skirt", 5, 40}}) {
    const DressedPerson person = example_people(*real_body())[worst.person];
    Outfit outfit(*real_body(), pieces_for(person, {worst.garment}, worst.larger));
    outfit.dress(person.rest, person.skeleton, dressed_poses(*real_body(), person)[0].pose);
    const StandingQuality seen = judge_standing(*real_body(), outfit, 0);
    EXPECT_GT(seen.cloth_px, 50'000) << person.name;
    EXPECT_EQ(seen.skin_px, 0) << person.name;
    EXPECT_LT(seen.crossed_px, worst.crossed_px) << person.name;
    EXPECT_LT(seen.rim_mm, 2.0F) << person.name;
  }
}

// How many of a garment's vertices stand out of the garment over it by half a millimetre, of those that have some of
// it over them. Both where `places` has them; normals are of those places.
struct StandsOut {
  int below = 0, out = 0;
};
StandsOut stands_out(const Outfit& outfit, std::span<const Vec3f> lower, std::span<const Vec3f> upper) {
  constexpr float kNearMm = 45, kAsideMm = 8, kOutMm = 0.5F;
  const body::Cloth &under = outfit.cloth(0), &over = outfit.cloth(1);
  std::vector<Vec3f> normals(upper.size());
  for (const auto& t : over.mesh().triangles) {
    const auto v = [&](std::size_t k) { return static_cast<std::size_t>(t[k]); };
    const Vec3f n = cross(upper[v(1)] - upper[v(0)], upper[v(2)] - upper[v(0)]);
    for (const std::size_t k : {0U, 1U, 2U}) normals[v(k)] = normals[v(k)] + n;
  }
  StandsOut found;
  for (std::size_t v = 0; v < lower.size(); ++v) {
    float best = kNearMm * kNearMm;
    std::size_t nearest = upper.size();
    for (std::size_t c = 0; c < upper.size(); ++c) {
      const Vec3f d = upper[c] - lower[v];
      const bool alike = (over.limbs(c) & under.limbs(v)) != 0 && dot(normals[c], under.normals()[v]) > 0;
      if (dot(d, d) >= best || !alike) continue;
      best = dot(d, d);
      nearest = c;
    }
    if (nearest == upper.size()) continue;
    const Vec3f d = lower[v] - upper[nearest];
    const float out = dot(d, normalized(normals[nearest]));
    if (best - out * out > kAsideMm * kAsideMm) continue;
    ++found.below;
    found.out += out > kOutMm ? 1 : 0;
  }
  return found;
}

// Rims are shown smoother than simulated, those of cloth over other cloth as well: what lies below is pressed under
// the places that are simulated, and has to lie under those that are shown.
TEST_F(DressedBody, ClothLiesBelowTheClothOverItAsShown) {
  for (const char* lower : {"trousers", "skirt"}) {
    const DressedPerson person = drawn_person(*real_body(), 1);  // whose shirt's rims move farthest
    Outfit outfit(*real_body(), pieces_for(person, {lower, "t_shirt"}));
    outfit.dress(person.rest, person.skeleton, dressed_poses(*real_body(), person)[0].pose);
    std::vector<std::vector<Vec3f>> shown(2);
    for (const std::size_t i : {0U, 1U}) {
      shown[i].resize(outfit.cloth(i).mesh().vertex_count());
      outfit.shown(i, shown[i]);
      EXPECT_LT(rim_roughness_mm(outfit.cloth(i).mesh(), shown[i]), 2.5F) << lower << " " << i;
    }
    const auto raw = positions_of(outfit.cloth(0));
    EXPECT_GT(stands_out(outfit, raw, shown[1]).out, 0) << lower << ": the simulation alone would do";
    const StandsOut seen = stands_out(outfit, shown[0], shown[1]);
    EXPECT_GT(seen.below, 1000) << lower;
    EXPECT_EQ(seen.out, 0) << lower;
  }
}

// Level in the best size: their pattern has the curve that seat, belly and thigh take up.
TEST_F(DressedBody, ShortsHangLevel) {
  for (const std::size_t i : {1U, 4U}) {
    const DressedPerson person = example_people(*real_body())[i];
    Outfit outfit(*real_body(), pieces_for(person, {"shorts"}));
    outfit.dress(person.rest, person.skeleton, dressed_poses(*real_body(), person)[0].pose);
    const StandingQuality seen = judge_standing(*real_body(), outfit, 0);
    EXPECT_GE(seen.hem_share, 0.9F) << person.name << " " << seen.hem_off_mm;
    EXPECT_FALSE(seen.hem_points.empty());
  }
}

// A wide hem lies farther out than the underarm: it is held off the trunk, a sleeve off its arm alone.
TEST_F(DressedBody, AWideHemIsNoSleeve) {
  const DressedPerson person = example_people(*real_body())[3];
  const Outfit outfit(*real_body(), pieces_for(person, {"dress"}, 5));
  const body::Cloth& dress = outfit.cloth(0);
  float lowest = 0, farthest = 0;
  std::size_t hem = 0, cuff = 0;
  for (std::size_t v = 0; v < dress.mesh().vertex_count(); ++v) {
    const body::Flat f = dress.mesh().flat[v];
    if (f.x - f.y > lowest && f.y < -600) lowest = f.x - f.y, hem = v;
    if ((dress.mesh().border[v] & body::kOnHem) != 0 && f.y > -600 && f.x > farthest) farthest = f.x, cuff = v;
  }
  EXPECT_GT(dress.mesh().flat[hem].x, dress.mesh().underarm.x + 60);
  EXPECT_NE(dress.limbs(hem) & body::kTrunk, 0);
  EXPECT_EQ(dress.limbs(hem) & (body::kLeftArm | body::kRightArm), 0);
  EXPECT_NE(dress.limbs(cuff) & (body::kLeftArm | body::kRightArm), 0);
}

// A tilted hem is level; a point of it that is bent out is not.
TEST_F(DressedBody, HemsAreJudgedByTheirPlane) {
  std::vector<Vec3f> hem;
  for (int i = 0; i < 40; ++i) {
    const float turn = static_cast<float>(i) * 0.15707963F;
    const float x = 200 * std::cos(turn), z = 120 * std::sin(turn);
    hem.push_back({x, 700 + 0.2F * x - 0.1F * z, z});
  }
  for (const float above : above_plane_mm(hem)) EXPECT_NEAR(above, 0, 0.1F);
  hem[7].y += 20;
  const auto bent = above_plane_mm(hem);
  EXPECT_GT(bent[7], 15);
  EXPECT_LT(bent[20], 5);
}

TEST_F(DressedBody, FollowsPeopleThroughPoses) {
  const char* asked = std::getenv("IM2FIT_GARMENT_PEOPLE");
  const int count = asked != nullptr ? std::atoi(asked) : 2;
  const char* const from = std::getenv("IM2FIT_GARMENT_FROM");  // so that two processes share the people
  // Relaxed, arms up, stride, sitting; or all ten.
  const std::vector<std::size_t> shown = asked != nullptr ? std::vector<std::size_t>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9}
                                                          : std::vector<std::size_t>{0, 3, 7, 9};
  double strain = 0, p95 = 0, peak = 0, highest_peak = 0, inside = 0, deepest = 0, folds = 0, moved = 0;
  double shown_inside = 0, shown_deepest = 0;
  int drapes = 0, restless = 0, poses_with_skin = 0, poses_drawn_with_skin = 0, poses_seen = 0;
  double through_px = 0, bare_px = 0, cloth_px = 0, drawn_px = 0;
  for (int number = from != nullptr ? std::atoi(from) : 0; number < count; ++number) {
    const DressedPerson person = drawn_person(*real_body(), static_cast<std::uint64_t>(number));
    const auto poses = dressed_poses(*real_body(), person);
    Outfit outfit(*real_body(), pieces_for(person, {"trousers", "t_shirt"}));
    outfit.dress(person.rest, person.skeleton, poses[0].pose);
    const auto covered = covered_skin(*real_body(), outfit);
    for (const std::size_t p : shown) {
      if (p > 0) outfit.move_to(poses[p].pose, 20);
      rest(outfit, p > 0 ? 29 : 21);  // 30 since the body stood still, eight of them in dress()
      std::vector<std::vector<Vec3f>> before;
      for (std::size_t i = 0; i < outfit.size(); ++i) before.push_back(positions_of(outfit.cloth(i)));
      rest(outfit, 1);
      for (std::size_t i = 0; i < outfit.size(); ++i) {
        const DrapeQuality q = judge(outfit, i);
        ASSERT_TRUE(q.finite) << person.name << " " << poses[p].name;
        const Motion motion = motion_since(outfit.cloth(i), before[i]);
        std::vector<Vec3f> shown_at(outfit.cloth(i).mesh().vertex_count());
        outfit.shown(i, shown_at);
        const Inside as_shown = judge_inside(outfit.skin(), outfit.cloth(i), shown_at);
        shown_inside += static_cast<double>(as_shown.share);
        shown_deepest = std::max(shown_deepest, static_cast<double>(as_shown.deepest_mm));
        strain += static_cast<double>(q.strain_mean);
        p95 += static_cast<double>(q.strain_p95);
        peak += static_cast<double>(q.strain_peak);
        highest_peak = std::max(highest_peak, static_cast<double>(q.strain_peak));
        inside += static_cast<double>(q.inside_share);
        deepest = std::max(deepest, static_cast<double>(q.inside_deepest_mm));
        folds += static_cast<double>(q.folds_mm);
        moved += static_cast<double>(motion.rms_mm);
        restless += motion.rms_mm > 0.1F ? 1 : 0;
        ++drapes;
        if (asked != nullptr)
          std::printf(
              "%s %s %zu: strain %.2f %% p95 %.1f peak %.0f inside %.2f %% deepest %.1f folds %.2f rest %.3f shown "
              "inside %.2f "
              "%% deepest %.1f\n",
              person.name.c_str(), poses[p].name.c_str(), i, 100.0 * q.strain_mean, 100.0 * q.strain_p95,
              100.0 * q.strain_peak, 100.0 * q.inside_share, q.inside_deepest_mm, q.folds_mm, motion.rms_mm,
              100.0 * as_shown.share, as_shown.deepest_mm);
      }
      const SkinSeen seen = look_for_skin(*real_body(), outfit, covered);
      through_px += seen.through_px;
      bare_px += seen.bare_px;
      drawn_px += seen.drawn_px;
      cloth_px += seen.cloth_px;
      poses_with_skin += seen.through_px > 0 ? 1 : 0;
      poses_drawn_with_skin += seen.drawn_px > 0 ? 1 : 0;
      ++poses_seen;
      if (asked != nullptr)
        std::printf("%s %s: of %d pixels skin is before cloth in %d, bare in %d, drawn in %d\n", person.name.c_str(),
                    poses[p].name.c_str(), seen.cloth_px, seen.through_px, seen.bare_px, seen.drawn_px);
      if (p > 0) outfit.move_to(poses[0].pose, 20);
    }
  }
  std::printf(
      "%d drapes: strain mean %.2f %%, p95 %.1f %%, peak %.0f %%; inside %.3f %%, deepest %.1f mm; folds %.2f mm; "
      "%.3f mm a frame at rest, %d over 0.1; as shown inside %.3f %%, deepest %.1f mm\n",
      drapes, 100 * strain / drapes, 100 * p95 / drapes, 100 * peak / drapes, 100 * inside / drapes, deepest,
      folds / drapes, moved / drapes, restless, 100 * shown_inside / drapes, shown_deepest);
  std::printf(
      "of %.0f pixels skin is before cloth in %.0f, of %d in %d poses; bare in %.0f; drawn in %.0f, in %d poses\n",
      cloth_px, through_px, poses_seen, poses_with_skin, bare_px, drawn_px, poses_drawn_with_skin);
  EXPECT_LT(strain / drapes, 0.02);
  EXPECT_LT(highest_peak, 0.3);
  EXPECT_LT(inside / drapes, 0.004);
  EXPECT_EQ(restless, 0);
  EXPECT_LT(through_px / cloth_px, 0.00005);
  EXPECT_LT(bare_px / cloth_px, 0.001);
}

}  // namespace
}  // namespace im2fit::lab
