// SPDX-License-Identifier: Apache-2.0
#include "train/population/scene_person.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

#include "body/model_data.h"

namespace im2fit::lab {
namespace {

using body::Mat3f;
using body::Segment;

enum Stream : std::uint64_t { kPoseStream = 0x5C02, kSwayStream = 0x5C04, kDressStream = 0x5C05 };

constexpr float kBriskMmPerS = 1300;   // full swing of legs and arms
constexpr float kStrideMm = 1350;      // two steps of a brisk walk
constexpr int kTurnFrames = 10;        // into the path's direction and out of it
constexpr int kStepFrames = 8;         // into the walk and out of it
constexpr float kTurnSteps = 2;        // strides in a turn on the spot
constexpr float kTurnStepping = 0.3F;  // their strength
constexpr float kSunkMm = 10;          // into the seat
constexpr float kBreathDepthMm = 80;

std::vector<std::uint8_t> hair_labels(const body::BodyModel& model, std::span<const Vec3f> rest,
                                      const body::Skeleton& skeleton, std::size_t who) {
  const Vec3f low = skeleton.head[static_cast<std::size_t>(Segment::head)];
  float crown = low.y;
  for (std::size_t i = 0; i < static_cast<std::size_t>(model.body_vertex_count()); ++i)
    crown = std::max(crown, rest[i].y);
  const auto triangles = model.body_triangles();
  const auto quads = model.body_quads();
  std::vector<std::uint8_t> labels(triangles.size(), label_of(who, false));
  const auto at = [&](std::int32_t i) { return rest[static_cast<std::size_t>(i)]; };
  for (std::size_t q = 0; q < quads.size(); ++q) {
    const auto& quad = quads[q];
    const auto below = [&](std::size_t i) { return rest[static_cast<std::size_t>(quad[i])].y < low.y; };
    if (below(0) && below(1) && below(2) && below(3)) continue;  // no hair below the head's joint
    for (const std::size_t t : {2 * q, 2 * q + 1}) {
      const Vec3f centre = (at(triangles[t][0]) + at(triangles[t][1]) + at(triangles[t][2])) * (1.0F / 3);
      if (in_hair_region(skeleton, crown, centre)) labels[t] = label_of(who, true);
    }
  }
  return labels;
}

std::vector<std::uint8_t> hair_labels(const Actor& actor, std::size_t who) {
  const auto& triangles = actor.surface->triangles;
  const auto at = [&](std::int32_t i) { return actor.rest[static_cast<std::size_t>(i)]; };
  const float low = actor.skeleton.head[static_cast<std::size_t>(Segment::head)].y;
  float crown = low;
  for (const Vec3f& p : actor.rest) crown = std::max(crown, p.y);
  std::vector<std::uint8_t> labels;
  labels.reserve(triangles.size());
  for (const Triangle& t : triangles) {
    const Vec3f centre = (at(t[0]) + at(t[1]) + at(t[2])) * (1.0F / 3);
    labels.push_back(label_of(who, centre.y >= low && in_hair_region(actor.skeleton, crown, centre)));
  }
  return labels;
}

// 0 at both ends of the path, 1 in between, over `frames`.
float ramp(std::uint64_t index, const FloorPath& path, int frames) {
  const auto i = static_cast<std::int64_t>(index) - path.frame_first;
  const auto left = path.frame_count - i;
  const auto inside = static_cast<float>(std::min<std::int64_t>(i, left));
  return std::clamp(inside / static_cast<float>(frames), 0.0F, 1.0F);
}

float share_of_way(std::uint64_t index, const FloorPath& path) {
  if (path.frame_count <= 0) return 0;
  const auto i = static_cast<float>(static_cast<std::int64_t>(index) - path.frame_first);
  return std::clamp(i / static_cast<float>(path.frame_count), 0.0F, 1.0F);
}

// 0 before the turn, 1 after it; slow at both ends.
float share_of_turn(std::uint64_t index, const AboutTurn& turn) {
  if (turn.frame_count <= 0) return 0;
  const auto i = static_cast<float>(static_cast<std::int64_t>(index) - turn.frame_first);
  const float t = std::clamp(i / static_cast<float>(turn.frame_count), 0.0F, 1.0F);
  return t * t * (3 - 2 * t);
}

float length_of(const FloorPath& path) {
  return std::hypot(path.to_x_mm - path.from_x_mm, path.to_z_mm - path.from_z_mm);
}

}  // namespace

Sway::Sway(std::uint64_t seed) {
  Rng rng = Rng::for_item(seed, kSwayStream, 0);
  constexpr std::array<double, 3> kSize = {0.15, 0.10, 0.25};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      waves_[i][j] = {static_cast<float>(rng.uniform(0.1, 0.6)), static_cast<float>(rng.uniform(0, 1)),
                      static_cast<float>(kSize[i] * rng.uniform(0.5, 1.0))};
}

float Sway::value(std::size_t axis, double seconds) const {
  double sum = 0;
  for (const Wave& w : waves_[axis])
    sum += static_cast<double>(w.size) *
           std::sin(2 * std::numbers::pi * (static_cast<double>(w.hertz) * seconds + static_cast<double>(w.phase)));
  return static_cast<float>(sum);
}

Rigid Sway::at(std::uint64_t frame) const {
  const double t = static_cast<double>(frame) / kFramesPerSecond;
  return {body::rotation_about(kAxisX, value(0, t)) * body::rotation_about(kAxisZ, value(1, t)) *
              body::rotation_about(kAxisY, value(2, t)),
          {}};
}

ScenePerson::ScenePerson(const body::BodyModel& model) : model_(model), sway_(0) {}

void ScenePerson::stage(const Subject& subject, std::span<const Vec3f> rest, const PersonPlan& plan,
                        std::uint64_t seed, std::size_t who, Tailor* tailor) {
  plan_ = plan;
  sway_ = Sway(seed);
  stepping_ = StepRoundMotion(plan.step_round, seed);
  Rng rng = Rng::for_item(seed, kPoseStream, 0);
  actor_ = subject.actor;
  if (actor_ != nullptr)
    take_actor();
  else
    take_rest(subject, rest);
  const float stature_m = subject.truth[measurement_index(Measurement::stature)] / 1000;
  const float mass_kg = subject.truth[measurement_index(Measurement::weight)];
  const float bmi = stature_m > 0 ? mass_kg / (stature_m * stature_m) : 24;
  std::optional<TrunkShape> trunk;
  if (actor_ == nullptr && (plan.pose == StandingPose::crossed || plan.pose == StandingPose::seated))
    trunk.emplace(model_, rest_, skeleton_);
  pose_ = draw_pose(skeleton_, plan.pose, rng, arm_spread_deg(bmi), trunk ? &*trunk : nullptr);
  const float drawn_yaw = draw_yaw_deg(plan.pose, rng);
  yaw_deg_ = plan.yaw_deg.value_or(drawn_yaw) + (plan.back_view ? 180.0F : 0.0F);
  faces_path_ = !plan.yaw_deg && plan.path.frame_count > 0 && length_of(plan.path) > 0;
  Worn worn{actor_ == nullptr && tailor != nullptr && (plan.clothing != Clothing::none || plan.hair),
            plan.clothing,
            plan.hair,
            subject.woman,
            0,
            who};
  if (worn.dressed) worn.seed = plan.outfit_seed != 0 ? plan.outfit_seed : seed;
  // Front and back show one person in one outfit.
  if (outfit_of_ != worn) dress(worn, tailor);
  outfit_of_ = worn;
  striding_ = false;
  seat_.reset();
  pose_as(pose_);
}

void ScenePerson::take_rest(const Subject& subject, std::span<const Vec3f> rest) {
  rest_.resize(static_cast<std::size_t>(model_.vertex_count()));
  const auto same = [](Vec3f a, Vec3f b) { return a.x == b.x && a.y == b.y && a.z == b.z; };
  if (!std::equal(rest.begin(), rest.end(), rest_.begin(), rest_.end(), same)) {
    outfit_of_.reset();
    if (rest.size() == rest_.size())
      std::copy(rest.begin(), rest.end(), rest_.begin());
    else
      morph_subject(model_, subject, rest_);
  }
  skeleton_ = body::rest_skeleton(model_, rest_);
}

void ScenePerson::take_actor() {
  outfit_of_.reset();
  rest_ = actor_->rest;
  skeleton_ = actor_->skeleton;
}

void ScenePerson::dress(const Worn& worn, Tailor* tailor) {
  dressed_ = worn.dressed;
  open_.clear();
  skirt_.clear();
  skirt_triangle_count_ = 0;
  if (!dressed_) {
    labels_ = actor_ != nullptr ? hair_labels(*actor_, worn.who) : hair_labels(model_, rest_, skeleton_, worn.who);
    return;
  }
  Rng rng = Rng::for_item(worn.seed, kDressStream, 0);
  tailor->dress(rest_, skeleton_, worn.woman, worn.clothing, worn.hair, rng, outfit_);
  // Drawn vertices: body, then the skirt's, then the shoes'.
  const auto body_count = static_cast<std::int32_t>(model_.body_vertex_count());
  std::vector<std::int32_t> place(rest_.size(), -1);
  for (const Triangle& t : outfit_.skirt) {
    Triangle moved{};
    for (std::size_t c = 0; c < 3; ++c) {
      std::int32_t& at = place[static_cast<std::size_t>(t[c])];
      if (at < 0) {
        at = body_count + static_cast<std::int32_t>(skirt_.size());
        skirt_.push_back(t[c]);
      }
      moved[c] = at;
    }
    open_.push_back(moved);
  }
  skirt_triangle_count_ = open_.size();
  triangles_.assign(model_.body_triangles().begin(), model_.body_triangles().end());
  labels_.clear();
  for (const std::uint8_t hair : outfit_.hair) labels_.push_back(label_of(worn.who, hair != 0));
  const auto first = body_count + static_cast<std::int32_t>(skirt_.size());
  for (const Triangle& t : outfit_.shoe_body) {
    triangles_.push_back({t[0] + first, t[1] + first, t[2] + first});
    labels_.push_back(label_of(worn.who, false));
  }
}

// Drawn after the shoes.
void ScenePerson::drape(const body::Pose& pose) {
  add_cloth(plan_.dresser(rest_, skeleton_, pose));
}

void ScenePerson::add_cloth(const DrapedCloth& cloth) {
  const auto first = static_cast<std::int32_t>(worn_.size());
  worn_.insert(worn_.end(), cloth.vertices.begin(), cloth.vertices.end());
  for (const Triangle& t : cloth.triangles) open_.push_back({t[0] + first, t[1] + first, t[2] + first});
}

// Skins body and clothes, turns them and puts the lowest vertex on the floor, the hips above the origin.
void ScenePerson::pose_as(const body::Pose& pose, float breath_mm) {
  const auto body_count = static_cast<std::size_t>(model_.body_vertex_count());
  posed_.resize(rest_.size());
  if (actor_ != nullptr) {
    skin(*actor_, pose, posed_);
    joints_ = joints_of(*actor_, pose);
    breathe(pose, breath_mm);
    body_ = posed_;
  } else {
    body::skin(model_, rest_, skeleton_, pose, posed_);
    joints_ = body::joints_of(model_, posed_);
    breathe(pose, breath_mm);
    body_.assign(posed_.begin(), posed_.begin() + static_cast<std::ptrdiff_t>(body_count));
  }
  float lowest = 1e9F;
  worn_.clear();
  if (dressed_) {
    body::skin(model_, outfit_.rest, skeleton_, pose, posed_);
    worn_.assign(posed_.begin(), posed_.begin() + static_cast<std::ptrdiff_t>(body_count));
    for (const std::int32_t v : skirt_) worn_.push_back(posed_[static_cast<std::size_t>(v)]);
    const body::PosedSkeleton bones = body::pose_skeleton(skeleton_, pose);
    const std::size_t half = outfit_.shoe.size() / 2;
    for (std::size_t i = 0; i < outfit_.shoe.size(); ++i) {
      const auto foot = static_cast<std::size_t>(i < half ? Segment::left_foot : Segment::right_foot);
      worn_.push_back(pose.rotation[foot] * (outfit_.shoe[i] - skeleton_.head[foot]) + bones.head[foot]);
    }
    open_.resize(skirt_triangle_count_);
    if (plan_.clothing == Clothing::garments && plan_.dresser) drape(pose);
    if (outfit_.hanging) add_cloth(hang_clothes(model_, *outfit_.hanging, worn_, bones));
  }
  for (const Vec3f& p : surface()) lowest = std::min(lowest, p.y);
  const Vec3f hips = (joints_[Joint::LH] + joints_[Joint::RH]) * 0.5F;
  if (plan_.pose == StandingPose::seated && actor_ == nullptr) find_seat({hips.x, lowest, hips.z});
  const Mat3f turn = body::rotation_about(kAxisY, yaw_deg_);
  const auto to_world = [&](Vec3f p) { return turn * Vec3f{p.x - hips.x, p.y - lowest, p.z - hips.z}; };
  for (Vec3f& p : body_) p = to_world(p);
  for (Vec3f& p : worn_) p = to_world(p);
  for (Vec3f& p : joints_.position_mm) p = to_world(p);
}

// Of a person without clothes, which would not follow: moves the front of the chest forwards, what lies
// kBreathDepthMm before the chest's joint by the whole of it.
void ScenePerson::breathe(const body::Pose& pose, float breath_mm) {
  if (breath_mm == 0 || dressed_) return;
  const std::span<const SkinRecord> skin =
      actor_ != nullptr ? std::span<const SkinRecord>(actor_->surface->skin) : model_.data().skin;
  const auto chest = static_cast<std::size_t>(Segment::chest);
  const Vec3f forwards = pose.rotation[chest] * kAxisZ;
  for (std::size_t i = 0; i < posed_.size() && i < skin.size(); ++i) {
    float weight = 0;
    for (std::size_t k = 0; k < 4; ++k)
      if (skin[i].segment[k] == chest) weight += skin[i].weight[k];
    const float front = std::clamp((rest_[i].z - skeleton_.head[chest].z) / kBreathDepthMm, 0.0F, 1.0F);
    posed_[i] = posed_[i] + forwards * (breath_mm * weight * front);
  }
}

// Under thighs and seat, from the surface before it is turned; `origin` becomes the floor below the hips.
void ScenePerson::find_seat(Vec3f origin) {
  const auto surface_now = surface();
  const auto skin = model_.data().skin;
  const float knee_z = joints_[Joint::LK].z - origin.z;
  Seat seat{1e9F, 0.78F * knee_z, 1e9F, 380, yaw_deg_};
  for (std::size_t i = 0; i < static_cast<std::size_t>(model_.body_vertex_count()); ++i) {
    const auto segment = static_cast<Segment>(skin[i].segment[0]);
    const Vec3f p = surface_now[i] - origin;
    const bool seat_part =
        segment == Segment::pelvis || segment == Segment::left_upper_leg || segment == Segment::right_upper_leg;
    if (seat_part && p.z < seat.front_mm) seat.height_mm = std::min(seat.height_mm, p.y);
    if (seat_part || segment == Segment::abdomen || segment == Segment::chest)
      seat.back_mm = std::min(seat.back_mm, p.z);
    if (segment == Segment::pelvis) seat.width_mm = std::max(seat.width_mm, 2 * std::fabs(p.x));
  }
  seat.height_mm += kSunkMm;
  seat.width_mm = std::min(seat.width_mm, 560.0F);
  seat.x_mm = plan_.path.from_x_mm;
  seat.z_mm = plan_.path.from_z_mm;
  seat_ = seat;
}

ScenePerson::Gait ScenePerson::gait(std::uint64_t index) const {
  const FloorPath& path = plan_.path;
  const float turned = share_of_turn(index, plan_.turn);
  if (turned > 0 && turned < 1) return {kTurnSteps * turned, kTurnStepping * 4 * turned * (1 - turned)};
  if (path.frame_count <= 0 || plan_.pose == StandingPose::seated) return {};
  const float length = length_of(path);
  const float speed = length / static_cast<float>(path.frame_count) * static_cast<float>(kFramesPerSecond);
  const float brisk = std::clamp(speed / kBriskMmPerS, 0.0F, 1.0F);
  const float stride = kStrideMm * std::max(brisk, 0.5F);
  return {share_of_way(index, path) * length / stride, brisk * ramp(index, path, kStepFrames)};
}

void ScenePerson::choose_frame(std::uint64_t index) {
  if (steps_round()) {
    pose_as(stepping_.pose(pose_, index), stepping_.breath_mm(index));
    return;
  }
  const Gait g = gait(index);
  if (g.strength > 0) {
    pose_as(striding(pose_, g.phase, g.strength));
    striding_ = true;
  } else if (striding_) {
    pose_as(pose_);
    striding_ = false;
  }
}

Rigid ScenePerson::placed(std::uint64_t index) const {
  Rigid sway = plan_.sway ? sway_.at(index) : Rigid{};
  sway.translation.y += plan_.raised_mm;
  const float turned = share_of_turn(index, plan_.turn);
  if (turned > 0) sway = Rigid{body::rotation_about(kAxisY, -180.0F * turned), {}} * sway;
  if (steps_round()) {
    const Rigid shifted{{}, body::rotation_about(kAxisY, yaw_deg_) * stepping_.shift_mm(index)};
    const Rigid carried = stepping_.carried(index);
    sway = plan_.step_round.camera ? carried * shifted * sway : shifted * carried * sway;
  }
  const FloorPath& path = plan_.path;
  if (path.frame_count <= 0 && path.from_x_mm == 0 && path.from_z_mm == 0) return sway;
  const float t = share_of_way(index, path);
  Rigid walk;
  walk.translation = {path.from_x_mm + t * (path.to_x_mm - path.from_x_mm), 0,
                      path.from_z_mm + t * (path.to_z_mm - path.from_z_mm)};
  if (faces_path_) {
    const float heading =
        std::atan2(path.to_x_mm - path.from_x_mm, path.to_z_mm - path.from_z_mm) * 180 / std::numbers::pi_v<float>;
    walk.rotation =
        body::rotation_about(kAxisY, std::remainder(heading - yaw_deg_, 360.0F) * ramp(index, path, kTurnFrames));
  }
  return walk * sway;
}

std::span<const Triangle> ScenePerson::closed_triangles() const {
  if (actor_ != nullptr) return actor_->surface->triangles;
  return dressed_ ? std::span<const Triangle>(triangles_) : model_.body_triangles();
}

}  // namespace im2fit::lab
