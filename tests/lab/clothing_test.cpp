// SPDX-License-Identifier: Apache-2.0
#include "lab/population/clothing.h"

#include <array>
#include <cmath>
#include <vector>

#include "body/model_data.h"
#include "body_fixture.h"
#include "lab/camera/virtual_camera.h"
#include "lab/population/population.h"
#include "lab/population/poses.h"
#include "mesh_checks.h"

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
  static bool of_leg(std::size_t vertex) {
    const Segment s = segment_of(vertex);
    return s == Segment::left_upper_leg || s == Segment::right_upper_leg || s == Segment::left_lower_leg ||
           s == Segment::right_lower_leg;
  }
  // Mean distance of cloth and skin about the waist, a third of the way from hips to shoulders.
  static double off_the_waist(const Dressed& d) {
    const auto y = [&](Segment s) { return d.skeleton.head[static_cast<std::size_t>(s)].y; };
    const float hips = y(Segment::left_upper_leg), shoulders = y(Segment::left_upper_arm);
    double sum = 0;
    int count = 0;
    for (std::size_t v = 0; v < body_count(); ++v) {
      const float up = (d.rest[v].y - hips) / (shoulders - hips);
      if (!of_trunk(v) || up < 0.3F || up > 0.4F) continue;
      sum += static_cast<double>(norm(d.outfit.rest[v] - d.rest[v]));
      ++count;
    }
    return sum / count;
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
        // Over the thighs, and where trousers' crotch hangs.
        const bool over_thigh = clothing == Clothing::hanging && of_leg(v);
        ASSERT_LE(thick, (of_trunk(v) || over_thigh ? trunk : limb) + 0.01F);
        sum += static_cast<double>(thick);
        ++count;
      }
    }
    EXPECT_GT(sum / count, static_cast<double>(least) + 0.2);
    EXPECT_GT(count, 8 * 2500);
  }
}

// A draped shirt does not follow the waist.
TEST_F(Clothes, AHangingShirtIsFurtherOffTheWaistThanALooseOne) {
  double loose = 0, hanging = 0;
  for (std::uint64_t i = 0; i < 8; ++i) {
    loose += off_the_waist(dress(i, Clothing::loose, false)) / 8;
    hanging += off_the_waist(dress(i, Clothing::hanging, false)) / 8;
  }
  EXPECT_GT(hanging, loose + 5);
  EXPECT_LT(hanging, 90);
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
      // A long shirt falls over the groin; what is under it there is between the thighs, and unseen.
      const bool groin = kKinds[i] == Clothing::hanging && of_trunk(v) && std::abs(d.rest[v].x) < 30 &&
                         d.rest[v].y < d.skeleton.head[static_cast<std::size_t>(Segment::left_upper_leg)].y;
      if (groin || (again > 0 && again < 2.5F * norm(path))) {
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
