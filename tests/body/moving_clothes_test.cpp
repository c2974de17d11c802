// SPDX-License-Identifier: Apache-2.0
// Clothes that move as rough meshes and are shown as fine ones: beside the fine cloth simulated itself, and beside
// cloth that the skeleton alone takes along.
#include "garment/drape/moving_clothes.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <cstring>
#include <span>
#include <vector>

#include "allocations.h"
#include "body_pack.h"
#include "evaluation/garment/drape_quality.h"
#include "garment/drape/cloth_part.h"
#include "garment/drape/dressing_pose.h"
#include "garment/drape/refinement.h"
#include "train/dressed/dressed_people.h"

namespace im2fit::body {
namespace {

// Where a viewer shows the vertices of a garment that moves: offsets added at rest, then skinned (docs/garments.md).
// `offsets`: of the rough mesh; none: by the skeleton alone.
std::vector<Vec3f> shown_cloth(const ClothPart& part, std::span<const Refinement::Spot> spots,
                               std::span<const Vec3f> offsets, const Skeleton& rest, const Pose& pose) {
  const PosedSkeleton posed = pose_skeleton(rest, pose);
  std::vector<Vec3f> out;
  for (std::size_t v = 0; v < part.rest.size(); ++v) {
    Vec3f at = part.rest[v], shown{};
    for (std::size_t k = 0; k < 3 && !offsets.empty(); ++k)
      at = at + offsets[static_cast<std::size_t>(spots[v].corner[k])] * spots[v].share[k];
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t s = part.segments[v][k];
      shown = shown + (posed.head[s] + pose.rotation[s] * (at - rest.head[s])) * part.weights[v][k];
    }
    out.push_back(shown);
  }
  return out;
}

class MovingCloth : public testing::Test {
 protected:
  void SetUp() override {
    IM2FIT_NEEDS_BODY();
    person_ = lab::example_people(*real_body())[1];  // a median man
    poses_ = lab::dressed_poses(*real_body(), person_);
  }
  std::unique_ptr<Outfit> dressed() const {
    auto outfit = std::make_unique<Outfit>(*real_body(), lab::pieces_for(person_, {"trousers", "t_shirt"}, 0, true));
    outfit->dress(person_.rest, person_.skeleton, poses_[0].pose);
    return outfit;
  }
  std::unique_ptr<MovingClothes> moving() const {
    return std::make_unique<MovingClothes>(*real_body(), dressed(), person_.skeleton);
  }
  const Pose& pose(const std::string& name) const {
    for (const auto& p : poses_)
      if (p.name == name) return p.pose;
    ADD_FAILURE() << name;
    return poses_[0].pose;
  }
  // As a person moves there and stays a while.
  static void go(MovingClothes& clothes, const Pose& to, int frames = 20, int stay = 10) {
    const Pose from = clothes.outfit().pose();
    for (int i = 1; i <= frames + stay; ++i)
      clothes.frame(between(from, to, std::min(1.0F, static_cast<float>(i) / static_cast<float>(frames))));
    clothes.find_offsets();
  }
  static float longest(const MovingClothes& clothes) {
    float most = 0;
    for (std::size_t i = 0; i < clothes.size(); ++i)
      for (const Vec3f& o : clothes.offsets(i)) most = std::max(most, norm(o));
    return most;
  }
  static double mean_length(const MovingClothes& clothes) {
    double sum = 0, count = 0;
    for (std::size_t i = 0; i < clothes.size(); ++i)
      for (const Vec3f& o : clothes.offsets(i)) {
        sum += static_cast<double>(norm(o));
        ++count;
      }
    return sum / count;
  }
  // The fine cloth of garments as a page shows them, beside the skin there.
  struct Shown {
    const MovingClothes& clothes;
    const Outfit& fine;
    const std::vector<ClothPart>& parts;
    const lab::DressedPerson& person;
    std::vector<Vec3f> of(std::size_t garment, std::span<const Vec3f> offsets) const {
      return shown_cloth(parts[garment], fine.refinement(garment).spots(), offsets, person.skeleton,
                         clothes.outfit().pose());
    }
    lab::Inside inside(std::size_t garment, std::span<const Vec3f> offsets) const {
      std::vector<Vec3f> mesh(person.rest.size());
      skin(*real_body(), person.rest, person.skeleton, clothes.outfit().pose(), mesh);
      BodySurface surface(*real_body());
      surface.put(mesh);
      return lab::judge_inside(surface, fine.cloth(garment), of(garment, offsets));
    }
  };
  lab::DressedPerson person_;
  std::vector<lab::NamedPose> poses_;
};

double mean_distance(const std::vector<Vec3f>& a, const std::vector<Vec3f>& b) {
  double sum = 0;
  for (std::size_t v = 0; v < a.size(); ++v) sum += static_cast<double>(norm(a[v] - b[v]));
  return sum / static_cast<double>(a.size());
}

TEST_F(MovingCloth, BeginsAtRestAndComesBackThere) {
  const auto clothes = moving();
  EXPECT_EQ(longest(*clothes), 0);
  for (int i = 0; i < 10; ++i) clothes->frame(poses_[0].pose);
  clothes->find_offsets();
  EXPECT_LT(mean_length(*clothes), 1) << "it had come to rest";
  EXPECT_LT(longest(*clothes), 25) << "where limbs press on cloth it is shown out of them";
  go(*clothes, pose("arms-up"));
  EXPECT_GT(longest(*clothes), 30);
  go(*clothes, poses_[0].pose, 20, 20);
  EXPECT_LT(mean_length(*clothes), 12) << "folds fall otherwise, but there they are again";
}

// Bounds are the present values with a margin.
TEST_F(MovingCloth, IsNearerToFineClothThanTheSkeletonAlone) {
  const auto fine = dressed();
  const auto clothes = moving();
  std::vector<ClothPart> parts;
  for (std::size_t i = 0; i < fine->size(); ++i)
    parts.push_back(cloth_part(*real_body(), *fine, i, person_.skeleton));
  const Shown shown{*clothes, *fine, parts, person_};
  double shown_inside = 0, skinned_inside = 0, off = 0, skinned_off = 0;
  float deepest = 0;
  int count = 0;
  for (const char* name : {"arms-up", "stride", "twist", "knee", "relaxed"}) {
    const Pose& to = pose(name);
    go(*clothes, to);
    const Pose from = fine->pose();
    for (int i = 1; i <= 30; ++i) fine->frame(between(from, to, std::min(1.0F, static_cast<float>(i) / 20)));
    for (std::size_t i = 0; i < clothes->size(); ++i) {
      const auto truth = lab::positions_of(fine->cloth(i));
      const auto inside = shown.inside(i, clothes->offsets(i)), skinned_is = shown.inside(i, {});
      const double is_off = mean_distance(shown.of(i, clothes->offsets(i)), truth),
                   skinned_is_off = mean_distance(shown.of(i, {}), truth);
      std::printf(
          "%-8s %zu: %.1f mm off fine cloth (skinned alone %.1f); inside %.2f %%, deepest %.0f mm (%.2f %%, %.0f "
          "mm)\n",
          name, i, is_off, skinned_is_off, 100.0 * inside.share, inside.deepest_mm, 100.0 * skinned_is.share,
          skinned_is.deepest_mm);
      shown_inside += inside.share;
      skinned_inside += skinned_is.share;
      deepest = std::max(deepest, inside.deepest_mm);
      off += is_off;
      skinned_off += skinned_is_off;
      ++count;
    }
  }
  std::printf("mean: %.1f mm off fine cloth (skinned alone %.1f); inside %.2f %% (%.2f %%)\n", off / count,
              skinned_off / count, 100 * shown_inside / count, 100 * skinned_inside / count);
  EXPECT_LT(off, 0.5 * skinned_off);
  EXPECT_LT(shown_inside / count, 0.001);
  EXPECT_LT(shown_inside, 0.2 * skinned_inside);
  EXPECT_LT(deepest, 25);
}

// Also between two rests: each third frame, as a page gets them, of motions of 0.4 s.
TEST_F(MovingCloth, StaysOutsideTheSkinOnTheWay) {
  const auto fine = dressed();
  const auto clothes = moving();
  std::vector<ClothPart> parts;
  for (std::size_t i = 0; i < fine->size(); ++i)
    parts.push_back(cloth_part(*real_body(), *fine, i, person_.skeleton));
  const Shown shown{*clothes, *fine, parts, person_};
  double share = 0;
  float worst = 0, deepest = 0;
  int count = 0;
  for (const char* name : {"arms-up", "stride", "twist", "knee", "sitting", "relaxed"}) {
    const Pose from = clothes->outfit().pose();
    for (int i = 1; i <= 12; ++i) {
      clothes->frame(between(from, pose(name), static_cast<float>(i) / 12));
      if (i % 3 != 0) continue;
      clothes->find_offsets();
      for (std::size_t k = 0; k < clothes->size(); ++k) {
        const auto inside = shown.inside(k, clothes->offsets(k));
        share += inside.share;
        worst = std::max(worst, inside.share);
        deepest = std::max(deepest, inside.deepest_mm);
        ++count;
      }
    }
  }
  std::printf("on the way: inside %.3f %%, a frame at most %.2f %%, deepest %.0f mm\n", 100 * share / count,
              100.0 * worst, deepest);
  EXPECT_LT(share / count, 0.002);
  EXPECT_LT(worst, 0.01F);
  EXPECT_LT(deepest, 40);
}

TEST_F(MovingCloth, TakesLeapsInStrides) {
  const auto clothes = moving();
  const Pose& far = pose("arms-up");
  clothes->frame(far);
  const PosedSkeleton before = pose_skeleton(person_.skeleton, poses_[0].pose),
                      now = pose_skeleton(person_.skeleton, clothes->outfit().pose());
  const auto hand = static_cast<std::size_t>(Segment::left_hand);
  EXPECT_GT(norm(now.head[hand] - before.head[hand]), MovingClothes::kStrideMm / 3);
  EXPECT_LT(norm(now.head[hand] - before.head[hand]), MovingClothes::kStrideMm * 1.2F);
  for (int i = 0; i < 30; ++i) clothes->frame(far);
  const PosedSkeleton there = pose_skeleton(person_.skeleton, clothes->outfit().pose()),
                      wanted = pose_skeleton(person_.skeleton, far);
  EXPECT_LT(norm(there.head[hand] - wanted.head[hand]), 0.1F);
}

TEST_F(MovingCloth, IsTheSameTwiceAndAllocatesNothing) {
  std::vector<Vec3f> first;
  for (const int time : {0, 1}) {
    const auto clothes = moving();
    const Pose& to = pose("elbows");
    const auto before = allocations_so_far();
    for (int i = 0; i < 8; ++i) {
      clothes->frame(to);
      clothes->find_offsets();
    }
    EXPECT_EQ(allocations_so_far(), before);
    const auto offsets = clothes->offsets(1);
    if (time == 0) first.assign(offsets.begin(), offsets.end());
    ASSERT_EQ(first.size(), offsets.size());
    EXPECT_EQ(std::memcmp(first.data(), offsets.data(), offsets.size_bytes()), 0);
  }
}

}  // namespace
}  // namespace im2fit::body
