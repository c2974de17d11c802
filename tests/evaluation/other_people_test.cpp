// SPDX-License-Identifier: Apache-2.0
// The family `other`: its mesh is refused where it is another file, its rig moves it as a body moves, its tape is
// right on shapes of known girth, and its people have the dimensions that were wanted of them.
#include "evaluation/population/other_people.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "evaluation/population/body_dimensions.h"
#include "evaluation/population/other_tape.h"
#include "tests/train/body_fixture.h"
#include "train/camera/synthetic_person.h"
#include "train/camera/virtual_camera.h"
#include "train/population/poses.h"

namespace im2fit::lab {
namespace {

using body::Segment;
using Triangles = std::vector<std::array<std::int32_t, 3>>;

std::string shared_folder(const char* what) {
  const char* given = std::getenv("IM2FIT_SHARED");
  return (given != nullptr ? std::string(given) : std::string(IM2FIT_SOURCE_DIR) + "/../shared") + "/data/" + what;
}

std::string mesh_file() {
  return other_mesh_file(shared_folder("other-makes"));
}

std::string written(const std::string& name, const std::string& text) {
  const std::string path = (std::filesystem::path(testing::TempDir()) / name).string();
  std::ofstream(path) << text;
  return path;
}

// --- the file ---

TEST(OtherMesh, AbsentFileIsAnErrorThatSaysWhatToDo) {
  const auto mesh = read_other_mesh("/no/such/folder/s-scape_male.obj");
  ASSERT_FALSE(mesh);
  EXPECT_NE(mesh.error().message.find("/no/such/folder"), std::string::npos) << mesh.error().message;
  EXPECT_NE(mesh.error().message.find("--other"), std::string::npos) << mesh.error().message;
}

TEST(OtherMesh, WrongLinesAreNamed) {
  const std::array<std::array<const char*, 2>, 7> table = {{
      {"v 1 2 nan\n", "line 1: a vertex needs three finite coordinates"},
      {"v 1 2\n", "line 1: a vertex needs three finite coordinates"},
      {"v 1 2 3\nf 1 2 6450\n", "line 2: vertex 6450 of 1..6449"},
      {"f 0 1 2\n", "line 1: vertex 0 of 1..6449"},
      {"f 1 2\n", "line 1: a triangle needs three vertex numbers"},
      {"f 1 2 3 4\n", "line 1: a face of more than three vertices"},
      {"# nothing\nv 1 2 3\nf 1 1 1\n", "1 vertices and 1 triangles, expected 6449 and 12894"},
  }};
  for (const auto& [text, what] : table) {
    const std::string file = written("other_mesh_wrong.obj", text);
    const auto mesh = read_other_mesh(file);
    ASSERT_FALSE(mesh) << text;
    EXPECT_EQ(mesh.error().message, file + ": " + what);
  }
}

// --- the tape ---

// A closed prism about the y axis.
struct Prism {
  std::vector<Vec3f> vertices;
  Triangles triangles;
};
Prism prism(int corners, float radius, float low, float high, float x = 0) {
  Prism p;
  for (const float y : {low, high})
    for (int i = 0; i < corners; ++i) {
      const float angle = 2 * std::numbers::pi_v<float> * static_cast<float>(i) / static_cast<float>(corners);
      p.vertices.push_back({x + radius * std::sin(angle), y, radius * std::cos(angle)});
    }
  const auto bottom = static_cast<std::int32_t>(p.vertices.size()), top = bottom + 1;
  p.vertices.push_back({x, low, 0});
  p.vertices.push_back({x, high, 0});
  for (int i = 0; i < corners; ++i) {
    const int next = (i + 1) % corners;
    p.triangles.push_back({i, next, corners + next});
    p.triangles.push_back({i, corners + next, corners + i});
    p.triangles.push_back({next, i, bottom});
    p.triangles.push_back({corners + i, corners + next, top});
  }
  return p;
}

TEST(OtherTape, GirthsOfPrismsAreKnown) {
  constexpr int kCorners = 360;
  const double polygon = 2 * kCorners * 100 * std::sin(std::numbers::pi / kCorners);
  Prism one = prism(kCorners, 100, 0, 500);
  EXPECT_NEAR(tape_round(one.vertices, one.triangles, {}, {0, 250, 0}, {0, 1, 0}), polygon, 0.01);
  // Across a tilted cylinder: an ellipse of half axes 100 and 100 / cos 30 degrees.
  const double tilted = tape_round(one.vertices, one.triangles, {}, {0, 250, 0}, {0, std::cos(0.5235988F), 0.5F});
  EXPECT_NEAR(tilted, ellipse_perimeter(200, 200 / std::cos(std::numbers::pi / 6)), 0.2);
  EXPECT_EQ(tape_round(one.vertices, one.triangles, {}, {0, 600, 0}, {0, 1, 0}), 0);
  EXPECT_NEAR(volume_within(one.vertices, one.triangles), std::numbers::pi * 0.01 * 0.5 * 1000, 0.01);
  // A tape round two spans the gap: one circle and twice the distance.
  const Prism two = prism(kCorners, 100, 0, 500, 300);
  const auto first = static_cast<std::int32_t>(one.vertices.size());
  std::vector<std::uint8_t> only_one(one.triangles.size(), 1);
  one.vertices.insert(one.vertices.end(), two.vertices.begin(), two.vertices.end());
  for (const auto& t : two.triangles) one.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  EXPECT_NEAR(tape_round(one.vertices, one.triangles, {}, {0, 250, 0}, {0, 1, 0}), polygon + 600, 0.01);
  only_one.resize(one.triangles.size(), 0);
  EXPECT_NEAR(tape_round(one.vertices, one.triangles, only_one, {0, 250, 0}, {0, 1, 0}), polygon, 0.01);
}

// --- the people ---

class OtherPeopleTest : public WithBody {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(mesh_file()))
      GTEST_SKIP() << "no " << mesh_file() << ": set IM2FIT_SHARED to the shared folder";
    const std::string survey = shared_folder("ansur2");
    if (!std::filesystem::exists(survey + "/ANSUR_II_MALE_Public.csv"))
      GTEST_SKIP() << "no ANSUR II in " << survey << ": set IM2FIT_SHARED to the shared folder";
    if (people() != nullptr) return;
    auto made = OtherPeople::load(shared_folder("other-makes"), survey);
    ASSERT_TRUE(made) << made.error().message;
    people() = std::make_unique<OtherPeople>(std::move(*made));
  }
  static std::unique_ptr<OtherPeople>& people() {
    static std::unique_ptr<OtherPeople> made;
    return made;
  }
  static const DimensionSurface& parts() { return people()->rig().parts; }
};

constexpr std::uint64_t kSeed = 7, kCount = 6;

float body_mass_index(const Subject& s) {
  const float metres = s.truth[measurement_index(Measurement::stature)] / 1000;
  return s.truth[measurement_index(Measurement::weight)] / (metres * metres);
}

bool same(Vec3f a, Vec3f b) {
  return a.x == b.x && a.y == b.y && a.z == b.z;
}

std::vector<Vec3f> posed_as(const Actor& actor, const body::Pose& pose) {
  std::vector<Vec3f> out(actor.rest.size());
  skin(actor, pose, out);
  return out;
}

TEST_F(OtherPeopleTest, TurnedOrOpenedMeshesAreRefused) {
  std::ifstream in(mesh_file());
  std::string inwards, open, line;
  bool changed = false;
  while (std::getline(in, line)) {
    std::istringstream words(line);
    std::string kind, a, b, c;
    words >> kind >> a >> b >> c;
    inwards += kind == "f" ? "f " + a + " " + c + " " + b + "\n" : line + "\n";
    open += kind == "f" && !changed ? "f " + a + " " + c + " " + b + "\n" : line + "\n";
    changed = changed || kind == "f";
  }
  const auto turned = read_other_mesh(written("other_mesh_inwards.obj", inwards));
  ASSERT_FALSE(turned);
  EXPECT_NE(turned.error().message.find("triangles face inwards"), std::string::npos) << turned.error().message;
  const auto opened = read_other_mesh(written("other_mesh_open.obj", open));
  ASSERT_FALSE(opened);
  EXPECT_NE(opened.error().message.find("not a closed surface"), std::string::npos) << opened.error().message;
}

TEST_F(OtherPeopleTest, TheMeshStandsOnTheFloorAndFacesForwards) {
  const auto mesh = read_other_mesh(mesh_file());
  ASSERT_TRUE(mesh) << mesh.error().message;
  const OtherRig rig = make_other_rig(*mesh);
  const body::Skeleton bones = bones_of(rig.parts, mesh->vertices);
  const auto head = [&](Segment s) { return bones.head[static_cast<std::size_t>(s)]; };
  float low = 1e9F, high = 0;
  for (const Vec3f& p : mesh->vertices) low = std::min(low, p.y), high = std::max(high, p.y);
  EXPECT_NEAR(low, 0, 0.01);
  EXPECT_NEAR(high, 1757.7, 0.1);
  for (const auto& [left, right] : {std::pair{Segment::left_upper_leg, Segment::right_upper_leg},
                                    std::pair{Segment::left_upper_arm, Segment::right_upper_arm}}) {
    EXPECT_GT(head(left).x, 50);
    EXPECT_LT(head(right).x, -50);
    EXPECT_NEAR(head(left).z, head(right).z, 12);
    EXPECT_NEAR(head(left).y, head(right).y, 6);
  }
  // Toes point forwards.
  for (const Segment foot : {Segment::left_foot, Segment::right_foot})
    EXPECT_GT(bones.tail[static_cast<std::size_t>(foot)].z, head(foot).z + 80);
}

TEST_F(OtherPeopleTest, WeightsSumToOneAndArmsStayOffTheTrunk) {
  const auto& skin = people()->rig().surface->skin;
  ASSERT_EQ(skin.size(), kOtherVertexCount);
  std::array<int, body::kSegmentCount> moved{};
  for (std::size_t v = 0; v < skin.size(); ++v) {
    float sum = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      sum += skin[v].weight[i];
      ASSERT_LT(skin[v].segment[i], body::kSegmentCount);
      if (i > 0) {
        EXPECT_LE(skin[v].weight[i], skin[v].weight[i - 1]) << v;
      }
    }
    EXPECT_NEAR(sum, 1, 1e-5) << v;
    ++moved[skin[v].segment[0]];
  }
  for (std::size_t s = 0; s < moved.size(); ++s) EXPECT_GT(moved[s], 20) << body::kSegmentNames[s];
  // Below the armpits nothing of the trunk hangs on an arm.
  const Subject subject = people()->draw(kSeed, 1);
  const body::Skeleton& bones = subject.actor->skeleton;
  const float armpits = bones.head[static_cast<std::size_t>(Segment::chest)].y + 60;
  for (std::size_t v = 0; v < skin.size(); ++v) {
    const Segment main = parts().segment[v];
    if (main != Segment::pelvis && main != Segment::abdomen && main != Segment::chest) continue;
    if (subject.actor->rest[v].y > armpits) continue;
    for (std::size_t i = 0; i < 4; ++i) {
      const auto s = static_cast<Segment>(skin[v].segment[i]);
      const bool arm = s >= Segment::left_upper_arm && s <= Segment::right_hand && s != Segment::right_shoulder;
      if (arm) {
        EXPECT_EQ(skin[v].weight[i], 0) << v;
      }
    }
  }
}

TEST_F(OtherPeopleTest, DrawsAreDeterministicMenOfEveryBand) {
  std::vector<float> index;
  for (std::uint64_t i = 0; i < kOtherBands.size(); ++i) {
    const OtherPeople::Made once = people()->make(kSeed, i);
    const Subject again = people()->draw(kSeed, i);
    EXPECT_FALSE(again.woman);
    EXPECT_EQ(again.family, Family::held_out);
    ASSERT_NE(again.actor, nullptr);
    EXPECT_TRUE(std::equal(again.actor->rest.begin(), again.actor->rest.end(), once.subject.actor->rest.begin(),
                           once.subject.actor->rest.end(), same));
    for (std::size_t m = 0; m < kMeasurementCount; ++m)
      if (m != measurement_index(Measurement::inside_leg)) {
        EXPECT_EQ(again.truth[m], once.subject.truth[m]);
      }
    const double metres = once.wanted[dimension_index(SurveyDimension::stature)] / 1000;
    const double wanted = once.wanted[dimension_index(SurveyDimension::weight)] / (metres * metres);
    EXPECT_GE(wanted, kOtherBands[i][0]);
    EXPECT_LT(wanted, kOtherBands[i][1]);
    EXPECT_GT(people()->rows_in_band(i), 50U);
    index.push_back(body_mass_index(again));
  }
  EXPECT_TRUE(std::is_sorted(index.begin(), index.end()));
  const Subject other = people()->draw(kSeed + 1, 0), first = people()->draw(kSeed, 0);
  EXPECT_FALSE(std::equal(other.actor->rest.begin(), other.actor->rest.end(), first.actor->rest.begin(),
                          first.actor->rest.end(), same));
}

TEST_F(OtherPeopleTest, DimensionsAreMet) {
  for (std::uint64_t i = 0; i < kCount; ++i) {
    const OtherPeople::Made made = people()->make(kSeed, i);
    const auto off = [&](SurveyDimension d) {
      return made.achieved[dimension_index(d)] - made.wanted[dimension_index(d)];
    };
    // Breadth, depth and girth apart: thickness does not follow from breadth.
    for (const SurveyDimension d :
         {SurveyDimension::stature, SurveyDimension::chest_depth, SurveyDimension::waist_breadth,
          SurveyDimension::waist_depth, SurveyDimension::waist_girth, SurveyDimension::hip_breadth,
          SurveyDimension::hip_depth, SurveyDimension::hip_girth, SurveyDimension::neck_girth,
          SurveyDimension::calf_girth, SurveyDimension::upper_arm_girth, SurveyDimension::wrist_girth})
      EXPECT_NEAR(off(d), 0, 3) << dimension_table()[dimension_index(d)].name << " of " << i;
    for (const SurveyDimension d : {SurveyDimension::chest_height, SurveyDimension::waist_height,
                                    SurveyDimension::cervicale_height, SurveyDimension::buttock_height})
      EXPECT_NEAR(off(d), 0, 7) << dimension_table()[dimension_index(d)].name << " of " << i;
    EXPECT_NEAR(off(SurveyDimension::weight), 0, 6) << i;
    for (const SurveyDimension d : {SurveyDimension::crotch_height, SurveyDimension::thigh_girth})
      EXPECT_TRUE(std::isnan(made.wanted[dimension_index(d)]));
    // The pose that is measured.
    const auto truth = [&](Measurement m) { return static_cast<double>(made.subject.truth[measurement_index(m)]); };
    const auto wanted = [&](SurveyDimension d) { return made.wanted[dimension_index(d)]; };
    EXPECT_NEAR(truth(Measurement::stature), wanted(SurveyDimension::stature), 5) << i;
    EXPECT_NEAR(truth(Measurement::chest_girth), wanted(SurveyDimension::chest_girth), 12) << i;
    EXPECT_NEAR(truth(Measurement::hip_girth), wanted(SurveyDimension::hip_girth), 15) << i;
    EXPECT_NEAR(truth(Measurement::neck_girth), wanted(SurveyDimension::neck_girth), 8) << i;
    EXPECT_NEAR(truth(Measurement::shoulder_breadth), wanted(SurveyDimension::acromion_breadth), 16) << i;
    EXPECT_TRUE(std::isnan(truth(Measurement::inside_leg)));
    for (std::size_t m = 0; m < kMeasurementCount; ++m)
      if (m != measurement_index(Measurement::inside_leg)) {
        EXPECT_TRUE(std::isfinite(made.subject.truth[m])) << m;
      }
  }
}

// Against extents of the posed mesh and ellipses over them: no cutter and no hull.
TEST_F(OtherPeopleTest, TruthAgreesWithSimpleExtents) {
  for (std::uint64_t i = 0; i < kCount; ++i) {
    const Subject subject = people()->draw(kSeed, i);
    const Actor& actor = *subject.actor;
    const auto truth = [&](Measurement m) { return subject.truth[measurement_index(m)]; };
    const std::vector<Vec3f> posed = posed_as(actor, body::relaxed_pose(actor.skeleton, 15));
    float low = 1e9F, high = -1e9F;
    for (const Vec3f& p : posed) low = std::min(low, p.y), high = std::max(high, p.y);
    EXPECT_NEAR(truth(Measurement::stature), high - low, 0.5) << i;
    const auto landmark = [&](std::size_t l) { return posed[static_cast<std::size_t>(parts().landmarks[l])]; };
    const float navel = landmark(3).y, chest = (landmark(0).y + landmark(1).y) / 2;
    const float waist = navel + 0.145F * (chest - navel);
    float x0 = 1e9F, x1 = -1e9F, z0 = 1e9F, z1 = -1e9F;
    for (std::size_t v = 0; v < posed.size(); ++v) {
      const Segment s = parts().segment[v];
      if (s != Segment::abdomen && s != Segment::pelvis && s != Segment::chest) continue;
      const Vec3f p = posed[v];
      if (std::fabs(p.y - waist) > 12) continue;
      x0 = std::min(x0, p.x), x1 = std::max(x1, p.x), z0 = std::min(z0, p.z), z1 = std::max(z1, p.z);
    }
    const double ellipse = ellipse_perimeter(static_cast<double>(x1 - x0), static_cast<double>(z1 - z0));
    EXPECT_NEAR(truth(Measurement::waist_girth) / ellipse, 1.02, 0.05) << i;
    EXPECT_GT(truth(Measurement::shoulder_girth), truth(Measurement::chest_girth));
    EXPECT_GT(truth(Measurement::hip_girth), 2 * truth(Measurement::neck_girth));
  }
}

TEST_F(OtherPeopleTest, PosesKeepBonesAndDoNotTearTheSkin) {
  for (std::uint64_t i = 0; i < kCount; ++i) {
    const Subject subject = people()->draw(kSeed, i);
    const Actor& actor = *subject.actor;
    const std::vector<Vec3f> unposed = posed_as(actor, {});
    for (std::size_t v = 0; v < unposed.size(); ++v) ASSERT_LT(norm(unposed[v] - actor.rest[v]), 0.01F);
    for (const StandingPose pose :
         {StandingPose::relaxed, StandingPose::arms_out, StandingPose::a_pose, StandingPose::free}) {
      Rng rng = Rng::for_item(kSeed, 1, i);
      const body::Pose standing = draw_pose(actor.skeleton, pose, rng, arm_spread_deg(body_mass_index(subject)));
      for (const body::Pose& p : {standing, striding(standing, 0.25F, 1), striding(standing, 0.5F, 0.3F)}) {
        const JointSet joints = joints_of(actor, p);
        const auto apart = [&](Joint a, Joint b) { return norm(joints[a] - joints[b]); };
        const auto bone = [&](Segment s) {
          return norm(actor.skeleton.tail[static_cast<std::size_t>(s)] -
                      actor.skeleton.head[static_cast<std::size_t>(s)]);
        };
        EXPECT_NEAR(apart(Joint::LS, Joint::LE), bone(Segment::left_upper_arm), 0.1);
        EXPECT_NEAR(apart(Joint::RH, Joint::RK), bone(Segment::right_upper_leg), 0.1);
        EXPECT_NEAR(apart(Joint::LK, Joint::LF), bone(Segment::left_lower_leg), 0.1);
        for (const float c : joints.confidence) EXPECT_EQ(c, 1);
      }
      if (pose != StandingPose::relaxed) continue;
      const std::vector<Vec3f> posed = posed_as(actor, standing);
      std::vector<float> stretched;
      for (const auto& t : actor.surface->triangles)
        for (std::size_t c = 0; c < 3; ++c) {
          const auto a = static_cast<std::size_t>(t[c]), b = static_cast<std::size_t>(t[(c + 1) % 3]);
          stretched.push_back(norm(posed[a] - posed[b]) / norm(actor.rest[a] - actor.rest[b]));
        }
      std::sort(stretched.begin(), stretched.end());
      EXPECT_LT(stretched.back(), 4.5F) << i;  // an edge in an armpit's fold
      EXPECT_GT(stretched[stretched.size() / 1000], 0.65F) << i;
      EXPECT_LT(stretched[stretched.size() - stretched.size() / 1000], 1.4F) << i;
    }
  }
}

class OtherSceneTest : public OtherPeopleTest {
 protected:
  void SetUp() override {
    WithBody::SetUp();
    if (IsSkipped()) return;
    OtherPeopleTest::SetUp();
  }
};

// What the camera sees is the actor, the joints are the rig's, and a turn shows the back.
TEST_F(OtherSceneTest, ScenesShowTheActor) {
  const Subject subject = people()->draw(kSeed, 2);
  SceneOptions options;
  options.rotate_deg = 0;
  options.yaw_deg = 0;
  options.sway = false;
  options.turn = {5, 10};
  const auto scene_of = [&](const Subject& who) {
    return VirtualScene(model(), who, options, sensor_of(false), kinect_intrinsics(320, 240), 3);
  };
  VirtualScene scene = scene_of(subject), again = scene_of(subject);
  std::vector<Vec3f> mesh(kOtherVertexCount);
  scene.person_mesh(0, mesh);
  float top = 1e9F, bottom = -1e9F;  // y is down
  for (const Vec3f& p : mesh) top = std::min(top, p.y), bottom = std::max(bottom, p.y);
  EXPECT_GT(bottom - top, 0.9F * subject.truth[measurement_index(Measurement::stature)]);
  std::vector<std::uint16_t> one(320 * 240), two(320 * 240);
  for (const std::uint64_t frame : {0U, 8U, 30U}) {
    scene.render(frame, DepthImage(one.data(), 320, 240));
    again.render(frame, DepthImage(two.data(), 320, 240));
    EXPECT_EQ(one, two) << frame;
    EXPECT_FALSE(scene.person_box().empty());
  }
  // Seen from the front the left hip is on the picture's right, after the turn on its left.
  const JointSet before = scene.joints(0), after = scene.joints(30);
  EXPECT_GT(before[Joint::LH].x, before[Joint::RH].x + 100);
  EXPECT_LT(after[Joint::LH].x, after[Joint::RH].x - 100);
  EXPECT_GT(before[Joint::LH].y, before[Joint::HE].y);
  // Restaged with one of the model's people and back, the frames are those of a new scene.
  const Subject of_model = draw_subject(model(), Family::held_out, kSeed, 0);
  VirtualScene fresh = scene_of(of_model);
  fresh.render(0, DepthImage(two.data(), 320, 240));
  scene.restage(of_model, options, 3);
  scene.render(0, DepthImage(one.data(), 320, 240));
  EXPECT_EQ(one, two);
  scene.restage(subject, options, 3);
  scene.render(0, DepthImage(one.data(), 320, 240));
  again.render(0, DepthImage(two.data(), 320, 240));
  EXPECT_EQ(one, two);
}

}  // namespace
}  // namespace im2fit::lab
