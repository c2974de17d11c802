// SPDX-License-Identifier: Apache-2.0
#include "evaluation/tracker/guidance_scenes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "body/model.h"
#include "body/skeleton.h"
#include "core/rng.h"
#include "perception/profile/person_frame.h"
#include "train/population/population.h"

namespace im2fit::lab {
namespace {

constexpr std::uint64_t kGuidanceStream = 0x6D1DA;
constexpr std::uint64_t kSpoilStream = 0x6D1DB;
constexpr int kDrawsMax = 200;       // until a scene is of its kind
constexpr float kHandReachMm = 150;  // from the hand's joint to the finger tips, and some
constexpr float kDegree = std::numbers::pi_v<float> / 180;

GuidanceSet bits(std::initializer_list<Guidance> codes) {
  GuidanceSet set = 0;
  for (const Guidance code : codes) set |= static_cast<GuidanceSet>(code);
  return set;
}

float draw(Rng& rng, double low, double high) {
  return static_cast<float>(rng.uniform(low, high));
}

float either_sign(Rng& rng, float value) {
  return rng.uniform() < 0.5 ? -value : value;
}

// No pose bows, so the rest mesh is bent: the subject with the trunk above the hips tilted by `bend_deg`, towards
// `toward_deg` (0: forwards, +90: the person's left). The bend spreads over the hand's breadths above the hip joints;
// legs stay upright, arms go where the pose points them. Truth measured on the mesh is left as it was.
Subject bent(const body::BodyModel& model, const Subject& subject, float bend_deg, float toward_deg) {
  std::vector<Vec3f> rest(static_cast<std::size_t>(model.vertex_count()));
  morph_subject(model, subject, rest);
  const body::Skeleton skeleton = body::rest_skeleton(model, rest);
  const Vec3f left = skeleton.head[static_cast<std::size_t>(body::Segment::left_upper_leg)];
  const Vec3f right = skeleton.head[static_cast<std::size_t>(body::Segment::right_upper_leg)];
  const Vec3f hips = (left + right) * 0.5F;
  const float toward = toward_deg * std::numbers::pi_v<float> / 180;
  const Vec3f axis{std::cos(toward), 0, -std::sin(toward)};  // of rest axes: x the person's left, y up, z forwards
  constexpr float kBendStartMm = 20, kBendSpanMm = 160;
  constexpr float kArmsFromMm = 330;  // sideways; no thigh reaches there
  Subject out = subject;
  // Also the helper vertices that mark where the joints are.
  out.rest_offset_mm.resize(rest.size());
  for (std::size_t i = 0; i < out.rest_offset_mm.size(); ++i) {
    const Vec3f from_hips = rest[i] - hips;
    // Hands of the rest pose hang below the hips, yet belong to the trunk.
    const bool arm = std::fabs(from_hips.x) > kArmsFromMm;
    const float share = arm ? 1 : std::clamp((from_hips.y - kBendStartMm) / kBendSpanMm, 0.0F, 1.0F);
    const Vec3f turned = body::rotation_about(axis, bend_deg * share) * from_hips;
    out.rest_offset_mm[i] = out.rest_offset_mm[i] + (turned - from_hips);
  }
  return out;
}

// The subject of the scene, and the scene so far: a dressed person, posed as given, whole in the picture.
class Maker {
 public:
  Maker(const body::BodyModel& model, Rng& rng, const Subject& subject)
      : model_(model), rng_(rng), scene_{subject, {}, 0, {}} {
    Shot& shot = scene_.shot;
    shot.seed = rng.next();
    shot.sensor = rng.uniform() < 0.75 ? kinect_sensor() : tof_sensor();
    shot.intrinsics = rng.uniform() < 0.4 ? kinect_intrinsics(640, 480) : kinect_intrinsics(320, 240);
    SceneOptions& s = shot.scene;
    constexpr std::array<int, 4> kMounts = {90, 0, 0, 270};
    s.rotate_deg = kMounts[static_cast<std::size_t>(rng.index(4))];
    constexpr std::array<Clothing, 4> kClothing = {Clothing::none, Clothing::tight, Clothing::normal,
                                                   Clothing::loose};
    s.clothing = kClothing[static_cast<std::size_t>(rng.index(4))];
    s.hair = rng.uniform() < 0.5;
    s.furniture_count = rng.index(3);
    s.pose = rng.uniform() < 0.7 ? StandingPose::relaxed : StandingPose::a_pose;
  }

  void ok() {}
  void no_person();
  void too_near();
  void too_far();
  void feet_cut();
  void head_cut();
  void side_cut();
  void arms_close();
  void not_frontal();
  void not_upright();
  void moving();
  void several_people();
  void too_noisy() { scene_.lost_share = rng_.uniform(0.4, 0.6); }
  void pet();
  void pet_alone();
  void wall() { options().wall_distance_mm = draw(rng_, 170, 400); }  // the back some 50 to 280 mm before it
  void mirror();
  void legs_alone();
  GuidanceScene take() { return std::move(scene_); }

 private:
  SceneOptions& options() { return scene_.shot.scene; }
  bool portrait() { return options().rotate_deg % 180 != 0; }
  // Half the upright picture's angle, top to bottom.
  float half_height_angle() {
    const Intrinsics& k = scene_.shot.intrinsics;
    return std::atan(0.5F * static_cast<float>(portrait() ? k.width : k.height) / k.fx);
  }
  float stature_mm() const { return scene_.subject.truth[measurement_index(Measurement::stature)]; }

  // By the truth, fingers and all: nothing is cut at the sides.
  bool hands_inside();

  const body::BodyModel& model_;
  Rng& rng_;
  GuidanceScene scene_;
};

bool Maker::hands_inside() {
  const UprightScene staged(model_, scene_.subject, scene_.shot);
  const JointSet truth = staged.staged().joints(0);
  const Intrinsics& k = staged.intrinsics();
  return std::ranges::all_of(std::array{Joint::LA, Joint::RA, Joint::LE, Joint::RE}, [&](Joint j) {
    const float x = truth[j].x, limit = truth[j].z * k.cx / k.fx - kHandReachMm;
    return std::fabs(x) < limit;
  });
}

void Maker::no_person() {
  options().person = false;
  options().furniture_count = rng_.index(5);
  options().decoy_count = rng_.index(3);
}

// Nearer than a metre the whole person fits into no picture of ours; the head, in most of them, or some of it.
void Maker::too_near() {
  options().distance_mm = draw(rng_, 650, 880);
  options().camera_height_mm = stature_mm() - draw(rng_, 100, 320);
  options().pitch_deg = draw(rng_, -5, 5);
}

void Maker::too_far() {
  options().distance_mm = draw(rng_, 4200, 4650);
  options().wall_distance_mm = draw(rng_, 600, 2500);
}

// The picture's lower edge meets the person between ankle and knee; the head stays inside. Without a floor in view
// a camera pitched up cannot be distinguished from a person who leans back: it is pitched up by 12 degrees at most.
void Maker::feet_cut() {
  for (int i = 0; i < kDrawsMax; ++i) {
    const float distance = draw(rng_, 1500, 2600), height = draw(rng_, 900, 1500);
    const float cut = draw(rng_, 200, 480);
    const float half = half_height_angle();
    const float pitch = std::atan((height - cut) / distance) - half;
    const float top = height + distance * std::tan(half - pitch);
    if (top < stature_mm() + 120 || std::fabs(pitch) > 12 * kDegree) continue;
    options().distance_mm = distance;
    options().camera_height_mm = height;
    options().pitch_deg = pitch / kDegree;
    if (hands_inside()) return;
  }
}

// The upper edge between chin and a little below the crown; the floor before the feet stays inside.
void Maker::head_cut() {
  for (int i = 0; i < kDrawsMax; ++i) {
    const float distance = draw(rng_, 1700, 3000), height = draw(rng_, 700, 1300);
    const float top = stature_mm() - draw(rng_, 60, 220);
    const float half = half_height_angle();
    const float pitch = half - std::atan((top - height) / distance);
    const float bottom = height - (distance - 300) * std::tan(std::min(1.5F, pitch + half));
    if (bottom > -60 || std::fabs(pitch) > 22 * kDegree) continue;
    options().distance_mm = distance;
    options().camera_height_mm = height;
    options().pitch_deg = pitch / kDegree;
    if (hands_inside()) return;
  }
}

// The camera turned aside until its edge runs between shoulder and hand: the principal point moves instead, which is
// the same picture's other part.
void Maker::side_cut() {
  Shot& shot = scene_.shot;
  options().distance_mm = draw(rng_, 2600, 3200);
  options().enlarge_to_fit = true;
  const UprightScene staged(model_, scene_.subject, shot);
  const JointSet truth = staged.staged().joints(0);
  const Intrinsics& k = staged.intrinsics();
  const auto column = [&](Joint j) { return truth[j].x * k.fx / truth[j].z + k.cx; };
  const bool left_arm = rng_.uniform() < 0.5;
  const float shoulder = column(left_arm ? Joint::LS : Joint::RS);
  const float hand = column(left_arm ? Joint::LA : Joint::RA);
  const float edge = shoulder + (hand - shoulder) * draw(rng_, 0.1, 0.6);
  const float shift = hand > shoulder ? static_cast<float>(k.width - 1) - edge : -edge;  // to the right when positive
  // Upright columns are the sensor's columns, rows from below (90) or rows (270): upright_to_sensor of (1, 0, 0).
  const Vec3f along = upright_to_sensor({1, 0, 0}, options().rotate_deg);
  shot.intrinsics.cx += shift * along.x;
  shot.intrinsics.cy += shift * along.y;
  options().distance_mm = staged.staged().distance_mm();
  options().enlarge_to_fit = false;
}

// A hand before the body or on it: by the truth, not further out than the hip joint beside it. The person faces the
// camera within the program's limit (12 degrees): folded arms and a turn aside are two codes at once.
void Maker::arms_close() {
  options().pose = StandingPose::crossed;
  for (int i = 0; i < kDrawsMax; ++i) {
    const UprightScene staged(model_, scene_.subject, scene_.shot);
    const JointSet truth = staged.staged().joints(0);
    const Vec3f across = normalized(truth[Joint::LH] - truth[Joint::RH]);
    const float left = dot(truth[Joint::LA] - truth[Joint::LH], across);
    const float right = dot(truth[Joint::RH] - truth[Joint::RA], across);
    const Vec3f line = (truth[Joint::LS] - truth[Joint::RS]) + (truth[Joint::LH] - truth[Joint::RH]);
    const FloorPlane floor = staged.floor();
    const float turn = dot(normalized(line), person_frame(floor, truth[Joint::TO]).toward);
    if (std::min(left, right) < 0 && std::fabs(turn) < std::sin(12 * kDegree)) return;
    scene_.shot.seed = rng_.next();
  }
}

void Maker::not_frontal() {
  options().back_view = rng_.uniform() < 0.3;  // from behind about squarely
  if (!options().back_view) options().yaw_deg = either_sign(rng_, draw(rng_, 40, 80));
}

void Maker::not_upright() {
  const float bend = draw(rng_, 28, 50);
  const float toward = draw(rng_, -110, 110);  // forwards and to either side
  scene_.subject = bent(model_, scene_.subject, bend, toward);
}

// Walks for the whole clip and faces the camera more or less; never leaves the picture.
void Maker::moving() {
  // Standing the person fits; halfway nearer still does.
  options().distance_mm = UprightScene(model_, scene_.subject, scene_.shot).staged().distance_mm() + 450;
  options().wall_distance_mm = draw(rng_, 1500, 2500);
  options().yaw_deg = static_cast<float>(rng_.normal(0, 5));
  const float path = draw(rng_, 350, 750);  // mm in the clip's 28 frames: 0.37 to 0.8 m/s
  const float angle = draw(rng_, -70, 70) * kDegree;
  const float sign = either_sign(rng_, 1);
  const float x = sign * path * std::sin(angle) / 2, z = sign * path * std::cos(angle) / 2;
  options().walk = {-x, -z, x, z, 0, 28};
}

void Maker::several_people() {
  options().wall_distance_mm = draw(rng_, 2200, 3000);
  options().furniture_count = rng_.index(2);
  const int count = 1 + rng_.index(2);
  const float first_side = either_sign(rng_, 1);
  for (int i = 0; i < count; ++i) {
    Bystander other;
    other.family = Family::held_out;
    other.subject_seed = rng_.next();
    other.subject_index = static_cast<std::uint64_t>(rng_.index(2));
    other.pose = rng_.uniform() < 0.5 ? StandingPose::relaxed : StandingPose::crossed;
    other.clothing = Clothing::normal;
    other.hair = rng_.uniform() < 0.5;
    // Beside or behind, inside even a portrait picture's width.
    const float side = i == 0 ? first_side : -first_side;
    other.path.from_x_mm = other.path.to_x_mm = side * draw(rng_, portrait() ? 600 : 750, portrait() ? 750 : 1100);
    other.path.from_z_mm = other.path.to_z_mm = draw(rng_, -1300, portrait() ? -900 : -300);
    options().others.push_back(other);
  }
}

// A dog or a cat beside the person, standing or walking past.
void Maker::pet() {
  const bool dog = rng_.uniform() < 0.6;
  const float heading_deg = draw(rng_, 0, 360), height_mm = dog ? draw(rng_, 350, 650) : draw(rng_, 220, 280);
  Animal animal = make_animal(height_mm, heading_deg);
  const float side = either_sign(rng_, 1);
  animal.place = {side * draw(rng_, 550, 900), 0, draw(rng_, -500, 350)};
  if (rng_.uniform() < 0.5) animal.step = {0, 0, either_sign(rng_, draw(rng_, 8, 25))};  // 0.25 to 0.75 m/s
  options().wall_distance_mm = draw(rng_, 1200, 2500);
  scene_.props.animal = animal;
}

void Maker::pet_alone() {
  pet();
  options().person = false;
  scene_.props.animal->place.x = draw(rng_, -400, 400);
}

// A mirror on the wall behind the person, turned by 15 to 30 degrees so that the camera sees the person's back in it,
// twice as far off as the wall is. The reflection is a person of the same sex, pose and clothes, turned round.
void Maker::mirror() {
  const float turn = either_sign(rng_, draw(rng_, 15, 30)), wall = draw(rng_, 600, 1000);
  const float s = std::sin(turn * kDegree), c = std::cos(turn * kDegree);
  scene_.props.mirror =
      MirrorWall{{s, 0, -c}, wall, draw(rng_, 450, 700), draw(rng_, 50, 300), draw(rng_, 1800, 2100)};
  options().wall_distance_mm = 2 * wall + 600;
  options().furniture_count = 0;
  options().yaw_deg = 0;
  Bystander reflection;
  reflection.family = Family::held_out;
  reflection.subject_seed = rng_.next();
  reflection.subject_index = scene_.subject.woman ? 1 : 0;
  reflection.pose = options().pose;
  reflection.clothing = options().clothing;
  reflection.hair = options().hair;
  reflection.yaw_deg = 180 - 2 * turn;
  reflection.path.from_x_mm = reflection.path.to_x_mm = 2 * wall * s;
  reflection.path.from_z_mm = reflection.path.to_z_mm = -2 * wall * c;
  options().others.push_back(reflection);
}

// The upper edge between the knees and the crotch.
void Maker::legs_alone() {
  for (int i = 0; i < kDrawsMax; ++i) {
    const float distance = draw(rng_, 1700, 3000), height = draw(rng_, 400, 1000);
    const float top = draw(rng_, 450, 750);
    const float half = half_height_angle();
    const float pitch = half - std::atan((top - height) / distance);
    const float bottom = height - (distance - 300) * std::tan(std::min(1.5F, pitch + half));
    if (bottom > -60 || std::fabs(pitch) > 45 * kDegree) continue;
    options().distance_mm = distance;
    options().camera_height_mm = height;
    options().pitch_deg = pitch / kDegree;
    return;
  }
}

struct Kind {
  const char* name;
  GuidanceSet named;
  GuidanceSet companions;
  void (Maker::*make)();
};

// Companions are codes that such a scene deserves as well: no person fits into the picture nearer than a metre; a
// person turned aside or bent has the arms before the body, a walking person swings them past it. A mirror image may
// be taken for another person; of legs alone neither the direction they face nor the arms can be seen.
const std::array<Kind, 18>& kinds() {
  using G = Guidance;
  static const std::array<Kind, 18> kKinds = {{
      {"OK", 0, 0, &Maker::ok},
      {"NO_PERSON", bits({G::no_person}), 0, &Maker::no_person},
      {"TOO_NEAR", bits({G::too_near}), bits({G::feet_cut, G::head_cut, G::side_cut}), &Maker::too_near},
      {"TOO_FAR", bits({G::too_far}), 0, &Maker::too_far},
      {"FEET_CUT", bits({G::feet_cut}), 0, &Maker::feet_cut},
      {"HEAD_CUT", bits({G::head_cut}), 0, &Maker::head_cut},
      {"ARMS_CLOSE", bits({G::arms_close}), 0, &Maker::arms_close},
      {"NOT_FRONTAL", bits({G::not_frontal}), bits({G::arms_close}), &Maker::not_frontal},
      {"NOT_UPRIGHT", bits({G::not_upright}), bits({G::arms_close}), &Maker::not_upright},
      {"MOVING", bits({G::moving}), bits({G::arms_close}), &Maker::moving},
      {"SEVERAL_PEOPLE", bits({G::several_people}), 0, &Maker::several_people},
      {"TOO_NOISY", bits({G::too_noisy}), 0, &Maker::too_noisy},
      {"SIDE_CUT", bits({G::side_cut}), 0, &Maker::side_cut},
      {"PET", 0, 0, &Maker::pet},
      {"PET_ALONE", bits({G::no_person}), 0, &Maker::pet_alone},
      {"WALL", 0, 0, &Maker::wall},
      {"MIRROR", 0, bits({G::several_people}), &Maker::mirror},
      {"LEGS_ALONE", bits({G::head_cut}), bits({G::no_person, G::too_near, G::not_frontal, G::arms_close}),
       &Maker::legs_alone},
  }};
  return kKinds;
}

const Kind& kind_of(const std::string& name) {
  const auto& all = kinds();
  const auto found = std::find_if(all.begin(), all.end(), [&](const Kind& kind) { return name == kind.name; });
  return found != all.end() ? *found : all.front();
}

}  // namespace

std::vector<std::string> guidance_kinds() {
  std::vector<std::string> names;
  for (const Kind& kind : kinds()) names.emplace_back(kind.name);
  return names;
}

GuidanceRule guidance_rule(const std::string& kind) {
  return {kind_of(kind).named, kind_of(kind).companions};
}

GuidanceScene draw_guidance_scene(const body::BodyModel& model, const std::string& kind, std::uint64_t seed,
                                  std::uint64_t number) {
  const Kind& wanted = kind_of(kind);
  const auto stream = kGuidanceStream + static_cast<std::uint64_t>(&wanted - kinds().data()) * 0x100;
  Rng rng = Rng::for_item(seed, stream, number);
  // The same people stand before every kind of scene.
  const Subject subject = draw_subject(model, Family::held_out, seed, number);
  Maker maker(model, rng, subject);
  (maker.*wanted.make)();
  return maker.take();
}

void spoil(DepthImage depth, double lost_share, std::uint64_t seed, std::uint64_t frame) {
  if (lost_share <= 0) return;
  Rng rng = Rng::for_item(seed, kSpoilStream, frame);
  const auto pixels = static_cast<double>(depth.width) * depth.height;
  const double scale = depth.width * depth.height > 200'000 ? 2 : 1;
  // Blobs overlap: n blobs of share s leave (1 - s)^n. Sides of 1 to 4: 7.5 px on average.
  const double blob_share = 7.5 * scale * scale / pixels;
  const auto blobs = static_cast<std::int64_t>(std::log(1 - lost_share) / std::log(1 - blob_share));
  for (std::int64_t i = 0; i < blobs; ++i) {
    const int side = static_cast<int>(scale) * (1 + rng.index(4));
    const int u0 = rng.index(depth.width), v0 = rng.index(depth.height);
    for (int v = v0; v < std::min(depth.height, v0 + side); ++v)
      for (int u = u0; u < std::min(depth.width, u0 + side); ++u) depth.at(u, v) = 0;
  }
}

}  // namespace im2fit::lab
