// SPDX-License-Identifier: Apache-2.0
#include "evaluation/population/other_rig.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace im2fit::lab {
namespace {

using body::Segment;

constexpr std::size_t kCount = body::kSegmentCount;
constexpr std::size_t at(Segment s) {
  return static_cast<std::size_t>(s);
}

// --- joints ---

// Where the bones begin and end, mm in the file's coordinates, found on level sections of the surface:
// - knee, ankle, elbow, wrist: the middle of the limb's section at the height of the kneecap's middle (ANSUR II:
//   0.278 of stature), above the sole where the shank is thinnest, at 0.54 of the way from shoulder to wrist, and
//   where the arm is thinnest before the hand;
// - hip: 0.514 of stature up (ANSUR II's trochanter: 0.513), half of the thigh's breadth inside its outer side;
// - shoulder: the middle of the arm's depth, 45 mm below the skin;
// - spine: a quarter of the trunk's depth before the back; neck: the middle of its section; crown: the highest
// vertex.
struct BonePlace {
  Segment segment;
  Vec3f head, tail;
};
constexpr Vec3f kWaistJoint{-3, 130, -38}, kChestJoint{-2, 275, -48}, kNeckRoot{6, 592, -38}, kSkull{0, 690, 22};
constexpr Vec3f kLeftShoulder{194, 508, 0}, kRightShoulder{-185, 505, -42};
constexpr Vec3f kLeftElbow{281, 258, 29}, kRightElbow{-273, 258, -54};
constexpr Vec3f kLeftWrist{378, 48, 90}, kRightWrist{-380, 48, -17};
constexpr Vec3f kLeftHip{87, 15, 4}, kRightHip{-92, 15, -14};
constexpr Vec3f kLeftKnee{92, -400, -10}, kRightKnee{-87, -400, -38};
constexpr Vec3f kLeftAnkle{97, -806, -34}, kRightAnkle{-91, -806, -63};
constexpr std::array<BonePlace, kCount> kBones = {{
    {Segment::pelvis, {-3, 30, -20}, kWaistJoint},
    {Segment::abdomen, kWaistJoint, kChestJoint},
    {Segment::chest, kChestJoint, kNeckRoot},
    {Segment::neck, kNeckRoot, kSkull},
    {Segment::head, kSkull, {4, 866, 41}},
    {Segment::left_shoulder, {30, 548, 20}, kLeftShoulder},
    {Segment::left_upper_arm, kLeftShoulder, kLeftElbow},
    {Segment::left_lower_arm, kLeftElbow, kLeftWrist},
    {Segment::left_hand, kLeftWrist, {398, -20, 118}},
    {Segment::right_shoulder, {-22, 548, 5}, kRightShoulder},
    {Segment::right_upper_arm, kRightShoulder, kRightElbow},
    {Segment::right_lower_arm, kRightElbow, kRightWrist},
    {Segment::right_hand, kRightWrist, {-410, -20, 18}},
    {Segment::left_upper_leg, kLeftHip, kLeftKnee},
    {Segment::left_lower_leg, kLeftKnee, kLeftAnkle},
    {Segment::left_foot, kLeftAnkle, {133, -865, 105}},
    {Segment::right_upper_leg, kRightHip, kRightKnee},
    {Segment::right_lower_leg, kRightKnee, kRightAnkle},
    {Segment::right_foot, kRightAnkle, {-143, -865, 60}},
}};

// Vertices around a place whose plain mean is that place, nearly: one after another, each the one that brings the
// mean nearest. They are taken from a ball that grows until the mean is that near, in kAroundSteps at most.
constexpr std::size_t kJointVertices = 24;
constexpr float kAroundFirst = 1.3F, kAroundStep = 0.2F;  // times the nearest vertex' distance
constexpr int kAroundSteps = 11;
constexpr float kAroundMm = 15;  // added to it
constexpr float kJointOffMm = 1.5F;

struct Around {
  std::vector<std::int32_t> vertices;
  float off_mm = 0;  // of their mean
};

Around vertices_within(std::span<const Vec3f> vertices, Vec3f place, float reach) {
  std::vector<std::int32_t> open;
  for (std::size_t v = 0; v < vertices.size(); ++v)
    if (norm(vertices[v] - place) <= reach) open.push_back(static_cast<std::int32_t>(v));
  Around around;
  Vec3f off;  // sum of the chosen ones' distances from the place
  const auto after = [&](std::int32_t v) { return norm(off + vertices[static_cast<std::size_t>(v)] - place); };
  while (around.vertices.size() < kJointVertices && !open.empty()) {
    const auto best = std::min_element(open.begin(), open.end(),
                                       [&](std::int32_t a, std::int32_t b) { return after(a) < after(b); });
    off = off + vertices[static_cast<std::size_t>(*best)] - place;
    around.vertices.push_back(*best);
    open.erase(best);
  }
  around.off_mm = norm(off) / static_cast<float>(std::max<std::size_t>(around.vertices.size(), 1));
  return around;
}

std::vector<std::int32_t> vertices_about(std::span<const Vec3f> vertices, Vec3f place) {
  float nearest = 1e9F;
  for (const Vec3f& p : vertices) nearest = std::min(nearest, norm(p - place));
  Around best;
  best.off_mm = 1e9F;
  for (int step = 0; step < kAroundSteps && best.off_mm > kJointOffMm; ++step) {
    const float factor = kAroundFirst + kAroundStep * static_cast<float>(step);
    Around around = vertices_within(vertices, place, factor * nearest + kAroundMm);
    if (around.off_mm < best.off_mm) best = std::move(around);
  }
  return best.vertices;
}

// --- parts ---

// Borders, mm in the file's coordinates. An arm begins outside the line from armpit to shoulder top, a leg below the
// line from crotch to the side of the hip; both lines as seen from the front. Head and neck begin above planes that
// fall towards the front, under the chin and to the pit of the neck.
constexpr Vec3f kLeftArmpit{184, 388, 0}, kLeftTop{176, 578, 0}, kRightArmpit{-178, 388, -35},
    kRightTop{-168, 572, -35};
constexpr Vec3f kCrotch{-3, -125, 0}, kLeftHipSide{180, 45, 0}, kRightHipSide{-186, 45, 0};
constexpr float kHeadFall = 0.45F, kNeckFall = 0.25F, kNeckHalfMm = 80, kNeckBackMm = 600;
constexpr float kClavicleReachMm = 75, kClavicleFromMm = 65, kClavicleLowMm = 495;

float from_bone(Vec3f p, Vec3f head, Vec3f tail) {
  const Vec3f along = tail - head;
  const float t = std::clamp(dot(p - head, along) / dot(along, along), 0.0F, 1.0F);
  return norm(p - (head + along * t));
}

using Neighbours = std::vector<std::vector<std::int32_t>>;

Neighbours neighbours_of(const OtherMesh& mesh) {
  Neighbours out(mesh.vertices.size());
  for (const auto& t : mesh.triangles)
    for (std::size_t i = 0; i < 3; ++i) out[static_cast<std::size_t>(t[i])].push_back(t[(i + 1) % 3]);
  return out;
}

class Parts {
 public:
  Parts(const OtherMesh& mesh, const body::Skeleton& bones, const Neighbours& beside)
      : mesh_(mesh), bones_(bones), beside_(beside), segment_(mesh.vertices.size(), Segment::chest) {}

  std::vector<Segment> run() {
    for (std::size_t v = 0; v < segment_.size(); ++v) segment_[v] = of_trunk(v);
    for (std::size_t v = 0; v < segment_.size(); ++v) {
      const Vec3f p = mesh_.vertices[v];
      const bool left = p.x > placed_as_read(kCrotch).x;
      if (below(p, kCrotch, left ? kLeftHipSide : kRightHipSide))
        segment_[v] = nearest(v, left ? Segment::left_upper_leg : Segment::right_upper_leg);
    }
    arm(Segment::left_upper_arm, kLeftArmpit, kLeftTop, 1);
    arm(Segment::right_upper_arm, kRightArmpit, kRightTop, -1);
    return std::move(segment_);
  }

 private:
  Vec3f head(Segment s) const { return bones_.head[at(s)]; }
  Vec3f tail(Segment s) const { return bones_.tail[at(s)]; }

  static bool below(Vec3f p, Vec3f from_in_file, Vec3f to_in_file) {
    const Vec3f from = placed_as_read(from_in_file), to = placed_as_read(to_in_file);
    return p.y < from.y + (to.y - from.y) * (p.x - from.x) / (to.x - from.x);
  }

  Segment of_trunk(std::size_t v) const {
    const Vec3f p = mesh_.vertices[v];
    const Vec3f skull = head(Segment::head), root = head(Segment::neck);
    if (p.y > skull.y - kHeadFall * (p.z - skull.z)) return Segment::head;
    if (p.y > placed_as_read({0, kNeckBackMm, 0}).y - kNeckFall * p.z && std::fabs(p.x - root.x) < kNeckHalfMm)
      return Segment::neck;
    if (p.y < head(Segment::abdomen).y) return Segment::pelvis;
    if (p.y < head(Segment::chest).y) return Segment::abdomen;
    const Segment shoulder = p.x > 0 ? Segment::left_shoulder : Segment::right_shoulder;
    const bool on_clavicle = from_bone(p, head(shoulder), tail(shoulder)) < kClavicleReachMm &&
                             std::fabs(p.x) > kClavicleFromMm && p.y > placed_as_read({0, kClavicleLowMm, 0}).y;
    return on_clavicle ? shoulder : Segment::chest;
  }

  // Of the three bones of a limb from `first` on.
  Segment nearest(std::size_t v, Segment first) const {
    Segment best = first;
    float best_mm = 1e9F;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto s = static_cast<Segment>(at(first) + i);
      const float mm = from_bone(mesh_.vertices[v], head(s), tail(s));
      if (mm < best_mm) best_mm = mm, best = s;
    }
    return best;
  }

  // What is connected with the hand without passing the line from armpit to shoulder top: no vertex of the flank is.
  void arm(Segment upper, Vec3f armpit_in_file, Vec3f top_in_file, float side) {
    const Vec3f armpit = placed_as_read(armpit_in_file), top = placed_as_read(top_in_file);
    const auto outside = [&](std::size_t v) {
      const Vec3f p = mesh_.vertices[v];
      return side * (p.x - armpit.x - (top.x - armpit.x) * (p.y - armpit.y) / (top.y - armpit.y)) > 0;
    };
    const Vec3f finger = tail(static_cast<Segment>(at(upper) + 2));
    const auto start = static_cast<std::size_t>(
        std::min_element(mesh_.vertices.begin(), mesh_.vertices.end(),
                         [&](Vec3f a, Vec3f b) { return norm(a - finger) < norm(b - finger); }) -
        mesh_.vertices.begin());
    std::vector<bool> reached(segment_.size());
    std::vector<std::size_t> open = {start};
    reached[start] = true;
    while (!open.empty()) {
      const std::size_t v = open.back();
      open.pop_back();
      segment_[v] = nearest(v, upper);
      for (const std::int32_t next : beside_[v]) {
        const auto n = static_cast<std::size_t>(next);
        if (reached[n] || !outside(n)) continue;
        reached[n] = true;
        open.push_back(n);
      }
    }
  }

  const OtherMesh& mesh_;
  const body::Skeleton& bones_;
  const Neighbours& beside_;
  std::vector<Segment> segment_;
};

// --- weights ---

constexpr int kRounds = 14;  // of a neighbourhood's mean: edges are 18 mm, so a border spreads over some 50 mm
constexpr float kSmoothShare = 0.5F;  // towards it
constexpr float kWeightMin = 0.02F;   // smaller ones are dropped

using Weights = std::vector<std::array<float, kCount>>;

Weights smoothed_weights(const std::vector<Segment>& segment, const Neighbours& beside) {
  Weights w(segment.size());
  for (std::size_t v = 0; v < w.size(); ++v) w[v][at(segment[v])] = 1;
  for (int round = 0; round < kRounds; ++round) {
    Weights next = w;
    for (std::size_t v = 0; v < w.size(); ++v) {
      const float share = kSmoothShare / static_cast<float>(beside[v].size());
      for (std::size_t s = 0; s < kCount; ++s) {
        float sum = (1 - kSmoothShare) * w[v][s];
        for (const std::int32_t n : beside[v]) sum += share * w[static_cast<std::size_t>(n)][s];
        next[v][s] = sum;
      }
    }
    w = std::move(next);
  }
  return w;
}

SkinRecord record_of(const std::array<float, kCount>& weights) {
  std::array<std::uint8_t, kCount> order{};
  for (std::size_t s = 0; s < kCount; ++s) order[s] = static_cast<std::uint8_t>(s);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint8_t a, std::uint8_t b) { return weights[a] > weights[b]; });
  SkinRecord record;
  float sum = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    if (i > 0 && weights[order[i]] < kWeightMin) break;
    record.segment[i] = order[i];
    record.weight[i] = weights[order[i]];
    sum += record.weight[i];
  }
  for (float& x : record.weight) x /= sum;
  return record;
}

bool of_arm(std::uint8_t segment) {
  const auto s = static_cast<Segment>(segment);
  return s >= Segment::left_upper_arm && s <= Segment::right_hand && s != Segment::right_shoulder;
}

// --- landmarks ---

// Vertices, found by looking at the mesh: the chest's foremost points at either side of the middle, 0.724 of stature
// up; between the thighs; the navel's pit, 0.607 up; where the back bends to the neck; the skin above and outside of
// the shoulder joints. In the order of body::Landmark.
constexpr std::array<std::int32_t, 7> kLandmarks = {3865, 638, 5194, 30, 1158, 4140, 923};

}  // namespace

body::Skeleton bones_of(const DimensionSurface& parts, std::span<const Vec3f> rest) {
  const auto mean = [&](const std::vector<std::int32_t>& list) {
    Vec3f sum;
    for (const std::int32_t v : list) sum = sum + rest[static_cast<std::size_t>(v)];
    return sum * (1.0F / static_cast<float>(list.size()));
  };
  body::Skeleton bones;
  for (std::size_t s = 0; s < kCount; ++s) {
    bones.head[s] = mean(parts.head[s]);
    bones.tail[s] = mean(parts.tail[s]);
  }
  return bones;
}

OtherRig make_other_rig(const OtherMesh& mesh) {
  OtherRig rig;
  DimensionSurface& parts = rig.parts;
  parts.vertex_count = static_cast<std::int32_t>(mesh.vertices.size());
  parts.triangles = mesh.triangles;
  parts.landmarks.assign(kLandmarks.begin(), kLandmarks.end());
  for (const BonePlace& bone : kBones) {
    parts.head[at(bone.segment)] = vertices_about(mesh.vertices, placed_as_read(bone.head));
    parts.tail[at(bone.segment)] = vertices_about(mesh.vertices, placed_as_read(bone.tail));
  }
  const Neighbours beside = neighbours_of(mesh);
  const body::Skeleton bones = bones_of(parts, mesh.vertices);
  const Weights weights = smoothed_weights(Parts(mesh, bones, beside).run(), beside);
  auto surface = std::make_shared<ActorSurface>();
  surface->triangles = mesh.triangles;
  for (const auto& w : weights) {
    surface->skin.push_back(record_of(w));
    parts.segment.push_back(static_cast<Segment>(surface->skin.back().segment[0]));
  }
  for (const auto& t : mesh.triangles) {
    float arm = 0;
    for (const std::int32_t v : t) {
      const SkinRecord& record = surface->skin[static_cast<std::size_t>(v)];
      for (std::size_t i = 0; i < 4; ++i)
        if (of_arm(record.segment[i])) arm += record.weight[i] / 3;
    }
    parts.triangle_is_arm.push_back(arm >= 0.5F ? 1 : 0);
  }
  rig.surface = std::move(surface);
  return rig;
}

}  // namespace im2fit::lab
