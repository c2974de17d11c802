// SPDX-License-Identifier: Apache-2.0
#include "train/population/clothing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "body/model_data.h"
#include "body_fixture.h"
#include "mesh_checks.h"
#include "train/camera/virtual_camera.h"
#include "train/population/population.h"
#include "train/population/poses.h"

namespace im2fit::lab {
namespace {

using body::Segment;

class Clothes : public WithBody {
 protected:
  struct Dressed {
    std::vector<Vec3f> rest;
    body::Skeleton skeleton;
    Subject subject;
    Outfit outfit;
  };
  static Dressed dress(std::uint64_t index, Clothing clothing, bool hair) {
    Dressed d;
    d.subject = draw_subject(model(), Family::held_out, 12, index);
    d.rest.resize(static_cast<std::size_t>(model().vertex_count()));
    morph_subject(model(), d.subject, d.rest);
    d.skeleton = body::rest_skeleton(model(), d.rest);
    Tailor tailor(model());
    Rng rng(index);
    tailor.dress(d.rest, d.skeleton, d.subject.woman, clothing, hair, rng, d.outfit);
    return d;
  }
  static Segment segment_of(std::size_t vertex) {
    return static_cast<Segment>(model().data().skin[vertex].segment[0]);
  }
  static bool of_trunk(std::size_t vertex) {
    const Segment s = segment_of(vertex);
    return s == Segment::pelvis || s == Segment::abdomen || s == Segment::chest || s == Segment::left_shoulder ||
           s == Segment::right_shoulder;
  }
  static Vec3f joint(const Dressed& d, Segment s) { return d.skeleton.head[static_cast<std::size_t>(s)]; }
  // What hangs, in the rest pose.
  static DrapedCloth hung(const Dressed& d, const HangingCut& cut) {
    return hang_clothes(model(), cut, std::span<const Vec3f>(d.outfit.rest).first(body_count()),
                        {d.skeleton.head, d.skeleton.tail});
  }
  static HangingCut::Shirt shirt_cut(float slack_mm) {
    HangingCut::Shirt shirt;
    shirt.end = -0.2F;
    shirt.slack_mm = slack_mm;
    return shirt;
  }
  // Of a shirt that hangs, at a height between hips (0) and shoulders (1).
  static float breadth_at(const Dressed& d, const HangingCut::Shirt& shirt, float up) {
    HangingCut cut;
    cut.shirt = shirt;
    const float hips = joint(d, Segment::left_upper_leg).y, shoulders = joint(d, Segment::left_upper_arm).y;
    float left = 0, right = 0;
    for (const Vec3f& p : hung(d, cut).vertices) {
      if (std::abs((p.y - hips) / (shoulders - hips) - up) > 0.03F) continue;
      left = std::max(left, p.x);
      right = std::min(right, p.x);
    }
    return left - right;
  }
  static std::size_t body_count() { return static_cast<std::size_t>(model().body_vertex_count()); }
};

TEST_F(Clothes, ThicknessIsWithinTheStatedRange) {
  struct Stated {
    Clothing clothing;
    float least, trunk, limb;
  };
  for (const auto& [clothing, least, trunk, limb] : {Stated{Clothing::tight, 3, 8, 8},
                                                     {Clothing::normal, 4, 20, 20},
                                                     {Clothing::loose, 6, 28, 20},
                                                     {Clothing::hanging, 4, 120, 28}}) {
    double sum = 0;
    int count = 0;
    for (std::uint64_t i = 0; i < 8; ++i) {
      const Dressed d = dress(i, clothing, false);
      for (std::size_t v = 0; v < body_count(); ++v) {
        const float thick = norm(d.outfit.rest[v] - d.rest[v]);
        if (d.outfit.cover[v] == Cover::bare) {
          ASSERT_EQ(thick, 0);
          continue;
        }
        ASSERT_GE(thick, least - 0.01F);
        ASSERT_LE(thick, (of_trunk(v) ? trunk : limb) + 0.01F);
        sum += static_cast<double>(thick);
        ++count;
      }
    }
    EXPECT_GT(sum / count, static_cast<double>(least) + 0.2);
    EXPECT_GT(count, 8 * 2500);
  }
}

// A shirt's tail falls straight from the hips unless it is cut to fall inwards.
TEST_F(Clothes, AShirtsTailFallsStraight) {
  for (std::uint64_t i = 0; i < 8; ++i) {
    const Dressed d = dress(i, Clothing::hanging, false);
    const HangingCut::Shirt straight = shirt_cut(0), shaped = shirt_cut(3);
    const float at_hips = breadth_at(d, straight, 0.12F);
    EXPECT_GT(at_hips, 150) << i;
    EXPECT_GE(breadth_at(d, straight, -0.15F), at_hips - 1) << i;
    EXPECT_LE(breadth_at(d, shaped, -0.15F), breadth_at(d, straight, -0.15F)) << i;
  }
}

// Wide trousers do not follow the ankle; their hem is as wide as it is cut.
TEST_F(Clothes, TrousersHangOffTheAnkles) {
  for (std::uint64_t i = 0; i < 6; ++i) {
    const Dressed d = dress(i, Clothing::hanging, false);
    HangingCut cut;
    cut.trousers =
        HangingCut::Trousers{.drop_mm = 30, .end = 1.9F, .thigh_mm = 5, .hem = 1.4F, .narrowing = 1, .rest = {}};
    const DrapedCloth cloth = hung(d, cut);
    const Vec3f knee = joint(d, Segment::left_lower_leg), ankle = joint(d, Segment::left_foot);
    const Vec3f bone = ankle - knee;
    const auto off_bone = [&](std::span<const Vec3f> places, float from, float to) {
      double sum = 0;
      int count = 0;
      for (const Vec3f& p : places) {
        const float along = dot(p - knee, bone) / dot(bone, bone);
        if (p.x * ankle.x <= 0 || along < from || along > to) continue;
        const float off = norm(p - knee - bone * along);
        if (off > 200) continue;
        sum += static_cast<double>(off);
        ++count;
      }
      EXPECT_GT(count, 20);
      return sum / count;
    };
    const double skin = off_bone(std::span<const Vec3f>(d.rest).first(body_count()), 0.75F, 0.9F);
    const double calf = off_bone(std::span<const Vec3f>(d.rest).first(body_count()), 0.2F, 0.45F);
    const double hem = off_bone(cloth.vertices, 0.75F, 0.9F);
    EXPECT_GT(hem, skin + 28) << i;  // farther than the layer on the limb may
    EXPECT_GT(hem, 1.15 * calf) << i;
    EXPECT_LT(hem, 1.4 * (calf + 28)) << i;  // of the calf as worn
  }
}

// Where one sees between the legs of a naked body, a shirt's tail falls before.
TEST_F(Clothes, AShirtsTailClosesTheGapBetweenTheLegs) {
  for (std::uint64_t i = 0; i < 6; ++i) {
    const Dressed d = dress(i, Clothing::hanging, false);
    HangingCut cut;
    const Vec3f hip = joint(d, Segment::left_upper_leg);
    const float height = joint(d, Segment::left_upper_arm).y - hip.y;
    const auto hit = [&](float up) {
      const DrapedCloth cloth = hung(d, cut);
      return first_hit({0, hip.y + up * height, 1000}, {0, 0, -1}, cloth.vertices, cloth.triangles);
    };
    cut.shirt.end = -0.33F;
    EXPECT_GT(hit(-0.3F), 0) << i;
    cut.shirt.end = -0.1F;
    EXPECT_LE(hit(-0.3F), 0) << i;
  }
}

TEST_F(Clothes, ShortSleevesStandOffTheArm) {
  for (std::uint64_t i = 0; i < 6; ++i) {
    const Dressed d = dress(i, Clothing::hanging, false);
    const auto farthest = [&](float room_mm) {
      HangingCut cut;
      cut.sleeve = HangingCut::Sleeve{.end = 0.6F, .is_short = true, .room_mm = room_mm, .rest = {}};
      const Vec3f shoulder = joint(d, Segment::left_upper_arm), bone = joint(d, Segment::left_lower_arm) - shoulder;
      double sum = 0;
      int count = 0;
      for (const Vec3f& p : hung(d, cut).vertices) {
        const float along = dot(p - shoulder, bone) / dot(bone, bone);
        const float off = norm(p - shoulder - bone * along);
        if (p.x * shoulder.x <= 0 || along < 0.5F || along > 0.7F || off > 150) continue;
        sum += static_cast<double>(off);
        ++count;
      }
      EXPECT_GT(count, 20);
      return sum / count;
    };
    EXPECT_NEAR(farthest(40) - farthest(10), 30, 4) << i;
  }
}

TEST_F(Clothes, NothingHangsBelowTheFeet) {
  for (std::uint64_t i = 0; i < 12; ++i) {
    const Dressed d = dress(i, Clothing::hanging, false);
    ASSERT_TRUE(d.outfit.hanging);
    EXPECT_EQ(d.outfit.hanging->trousers.has_value(), d.outfit.skirt.empty());
    float lowest = 1e9F;
    for (std::size_t v = 0; v < body_count(); ++v) lowest = std::min(lowest, d.outfit.rest[v].y);
    for (const Vec3f& p : hung(d, *d.outfit.hanging).vertices) ASSERT_GE(p.y, lowest);
  }
  EXPECT_FALSE(dress(0, Clothing::loose, false).outfit.hanging);
}

TEST_F(Clothes, HandsFaceAndFeetStayBare) {
  for (std::uint64_t i = 0; i < 6; ++i) {
    const Dressed d = dress(i, Clothing::loose, true);
    const float chin = d.skeleton.head[static_cast<std::size_t>(Segment::head)].y;
    int faces = 0;
    for (std::size_t v = 0; v < body_count(); ++v) {
      const Segment s = segment_of(v);
      const bool hand = s == Segment::left_hand || s == Segment::right_hand;
      const bool foot = s == Segment::left_foot || s == Segment::right_foot;
      const bool face = s == Segment::head && d.rest[v].y < chin + 90 &&
                        d.rest[v].z > d.skeleton.head[static_cast<std::size_t>(Segment::head)].z + 80;
      faces += face ? 1 : 0;
      ASSERT_TRUE(d.outfit.cover[v] == Cover::bare || !(hand || foot || face)) << v;
    }
    EXPECT_GT(faces, 50);
  }
}

// At rest cloth is nowhere deeper than 2 mm inside the body, except in armpits and groin, where the path out along
// the cloth runs into the body again within two layers.
TEST_F(Clothes, NeverInsideTheBody) {
  constexpr std::array kKinds = {Clothing::tight,  Clothing::normal, Clothing::loose,   Clothing::tight,
                                 Clothing::normal, Clothing::loose,  Clothing::hanging, Clothing::hanging};
  for (std::uint64_t i = 0; i < kKinds.size(); ++i) {
    const Dressed d = dress(i, kKinds[i], true);
    const auto triangles = model().body_triangles();
    int checked = 0, met = 0;
    for (std::size_t v = i; v < body_count(); v += 37) {
      if (d.outfit.cover[v] == Cover::bare) continue;
      const Vec3f path = d.outfit.rest[v] - d.rest[v];
      const Vec3f out = normalized(path);
      const float again = first_hit(d.rest[v] + out * 2, out, d.rest, triangles);
      if (again > 0 && again < 2.5F * norm(path)) {
        ++met;
        continue;
      }
      ++checked;
      if (winding(d.outfit.rest[v], d.rest, triangles) > 0.5F) {
        EXPECT_LT(distance_to(d.outfit.rest[v], d.rest, triangles), 2) << "subject " << i << " vertex " << v;
      }
    }
    EXPECT_GT(checked, 70);
    EXPECT_LT(met, checked / 10);
  }
}

// Nor does the body show through when posed: covered skin is inside the drawn surface or within 2 mm of it.
TEST_F(Clothes, CoveredSkinDoesNotShow) {
  for (std::uint64_t i = 0; i < 4; ++i) {
    const Dressed d = dress(i, i % 2 == 0 ? Clothing::hanging : Clothing::loose, true);
    Rng rng(200 + i);
    const body::Pose pose = draw_pose(d.skeleton, i < 2 ? StandingPose::free : StandingPose::seated, rng, 15);
    std::vector<Vec3f> naked(d.rest.size()), worn(d.rest.size());
    body::skin(model(), d.rest, d.skeleton, pose, naked);
    body::skin(model(), d.outfit.rest, d.skeleton, pose, worn);
    int checked = 0;
    for (std::size_t v = i; v < body_count(); v += 37) {
      if (d.outfit.cover[v] == Cover::bare) continue;
      ++checked;
      if (winding(naked[v], worn, model().body_triangles()) < 0.5F) {
        EXPECT_LT(distance_to(naked[v], worn, model().body_triangles()), 2) << "subject " << i << " vertex " << v;
      }
    }
    EXPECT_GT(checked, 70);
  }
}

TEST_F(Clothes, HairHasVolumeAndStaysOnTheHead) {
  float most = 0;
  for (std::uint64_t i = 0; i < 12; ++i) {
    const Dressed d = dress(i, Clothing::none, true);
    EXPECT_EQ(d.outfit.sole_mm, 0);
    for (std::size_t v = 0; v < body_count(); ++v) {
      const float thick = norm(d.outfit.rest[v] - d.rest[v]);
      most = std::max(most, thick);
      ASSERT_LE(thick, kHairMostMm + 0.01F);
      ASSERT_TRUE(thick == 0 || segment_of(v) == Segment::head || segment_of(v) == Segment::neck);
    }
  }
  EXPECT_GT(most, 15);
}

TEST_F(Clothes, FeetAreInsideTheirShoes) {
  for (std::uint64_t i = 0; i < 4; ++i) {
    const Dressed d = dress(i, Clothing::normal, false);
    EXPECT_GE(d.outfit.sole_mm, kSoleLeastMm);
    EXPECT_LE(d.outfit.sole_mm, kSoleMostMm);
    int checked = 0;
    float lowest_foot = 1e9F, shoe_lowest = 1e9F, worst = 0;
    for (const Vec3f& p : d.outfit.shoe) shoe_lowest = std::min(shoe_lowest, p.y);
    for (std::size_t v = 0; v < body_count(); ++v) lowest_foot = std::min(lowest_foot, d.rest[v].y);
    for (std::size_t v = 0; v < body_count(); ++v) {
      if (segment_of(v) != Segment::left_foot && segment_of(v) != Segment::right_foot) continue;
      const float ankle = d.skeleton.head[static_cast<std::size_t>(segment_of(v))].y;
      if (v % 7 != 0 || d.rest[v].y > lowest_foot + 0.5F * (ankle - lowest_foot)) continue;
      ++checked;
      if (winding(d.rest[v], d.outfit.shoe, d.outfit.shoe_body) > 0.5F) continue;
      worst = std::max(worst, distance_to(d.rest[v], d.outfit.shoe, d.outfit.shoe_body));
    }
    EXPECT_NEAR(lowest_foot - shoe_lowest, d.outfit.sole_mm, 3);
    EXPECT_GT(checked, 60);
    EXPECT_LT(worst, 4);  // toes and ball may touch the leather
  }
}

// The same person in the same pose, dressed and not: joints differ by the sole's height and nothing else.
TEST_F(Clothes, TruthStaysTheNakedBodysRaisedByTheSole) {
  for (const Clothing clothing : {Clothing::tight, Clothing::normal, Clothing::loose, Clothing::hanging}) {
    SceneOptions options;
    options.sway = false;
    options.distance_mm = 2600;
    options.camera_height_mm = 1000;
    options.pitch_deg = 0;
    const Subject subject = draw_subject(model(), Family::training, 4, 3);
    const Intrinsics k = kinect_intrinsics(320, 240);
    VirtualScene bare(model(), subject, options, exact_sensor(), k, 9);
    options.clothing = clothing;
    options.hair = true;
    if (clothing == Clothing::hanging) options.outfit_seed = 9;  // with shoes
    VirtualScene dressed(model(), subject, options, exact_sensor(), k, 9);
    const JointSet a = bare.joints(0), b = dressed.joints(0);
    const Vec3f up = bare.floor().up;
    const float raised = dot(up, b[Joint::TO] - a[Joint::TO]);
    EXPECT_GE(raised, kSoleLeastMm - 3);  // toes may have pointed a little below the sole
    EXPECT_LE(raised, kSoleMostMm + 3);
    for (std::size_t j = 0; j < kJointCount; ++j)
      EXPECT_LT(norm(b.position_mm[j] - a.position_mm[j] - up * raised), 0.01F) << kJointNames[j];
    // The drawn surface is as near to the floor as the naked one was.
    float lowest = 1e9F;
    const VirtualScene::Surface surface = dressed.person_surface(0);
    for (const Vec3f& p : surface.vertices) lowest = std::min(lowest, dot(up, p) + dressed.floor().camera_height_mm);
    EXPECT_NEAR(lowest, 0, 0.5);
    // Joints lie inside the drawn mesh.
    for (std::size_t j = 0; j < kJointCount; ++j)
      EXPECT_GT(winding(b.position_mm[j], surface.vertices, surface.triangles), 0.5F) << kJointNames[j];
  }
}

}  // namespace
}  // namespace im2fit::lab
