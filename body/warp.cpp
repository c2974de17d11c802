// SPDX-License-Identifier: Apache-2.0
#include "body/warp.h"

#include <algorithm>
#include <cassert>

#include "body/model_data.h"
#include "body/skeleton.h"

namespace im2fit::body {
namespace {

constexpr std::size_t at(Segment s) {
  return static_cast<std::size_t>(s);
}
constexpr std::size_t at(std::int32_t vertex) {
  return static_cast<std::size_t>(vertex);
}

float limited(float v, float low, float high) {
  return v > low ? (v < high ? v : high) : low;
}
// 0 up to `from`, 1 from `to` on, smooth between.
float smooth_step(float v, float from, float to) {
  const float t = limited((v - from) / (to - from), 0, 1);
  return t * t * (3 - 2 * t);
}
float between(float a, float b, float share) {
  return a + (b - a) * share;
}

// The body (arms and head apart) at one height.
struct Node {
  float y = 0;
  SectionWarp warp;
  SectionFrame frame;
};

bool is_arm(const BodyModel::Data& d, std::size_t vertex) {
  const auto s = static_cast<Segment>(d.skin[vertex].segment[0]);
  return (s >= Segment::left_upper_arm && s <= Segment::left_hand) ||
         (s >= Segment::right_upper_arm && s <= Segment::right_hand);
}

constexpr float kExtentBandMm = 15;      // vertices this near a level tell its extents: rings lie 10 to 20 mm apart
constexpr float kLegsBeginBelowMm = 90;  // the crotch: a shorter passage from one trunk to two legs shows as a step
constexpr float kShoulderDepthShare = 0.3F;  // of the chest's, at the height of the shoulder joints

class Field {
 public:
  // Without a warp until it is set.
  Field(const BodyModel& model, std::span<const Vec3f> rest)
      : d_(model.data()), rest_(rest), skeleton_(rest_skeleton(model, rest)), marks_(warp_landmarks(model, rest)) {
    place_nodes(model);
    for (const bool left : {true, false}) place_arm(left);
  }

  void set(const Warp& warp) {
    warp_ = warp;
    set_nodes();
    list_rises();
    for (Arm& arm : arms_) arm.shoulder_move = of_body(arm.shoulder);
  }

  Vec3f moved(std::size_t vertex) const {
    const Vec3f p = rest_[vertex];
    float upper = 0, lower = 0;  // weights of the arm
    const SkinRecord& skin = d_.skin[vertex];
    for (std::size_t i = 0; i < 4; ++i) {
      const auto s = static_cast<Segment>(skin.segment[i]);
      if (s == Segment::left_upper_arm || s == Segment::right_upper_arm) upper += skin.weight[i];
      if (s == Segment::left_lower_arm || s == Segment::right_lower_arm || s == Segment::left_hand ||
          s == Segment::right_hand)
        lower += skin.weight[i];
    }
    const float arm = upper + lower;
    if (arm <= 0) return p + of_body(p);
    const Arm& a = arms_[p.x > 0 ? 0 : 1];
    return p + of_body(p) * (1 - arm) + of_upper_arm(a, p) * upper + of_forearm(a, p) * lower;
  }

 private:
  struct Arm {
    Vec3f shoulder, elbow, wrist;
    Vec3f shoulder_move;
  };

  SectionWarp trunk_warp(WarpValue first) const {
    const auto value = [&](std::size_t i) { return warp_.values[static_cast<std::size_t>(first) + i]; };
    return {value(0), value(1), value(2), value(3)};
  }
  static SectionWarp even(float girth) { return {girth, girth, girth, 0}; }

  void place_nodes(const BodyModel& model) {
    const auto frame = [&](float y) { return section_frame(model, rest_, y); };
    const auto middle_z = [&](Vec3f a, Vec3f b) { return 0.5F * (a.z + b.z); };
    const SectionFrame hip = frame(marks_.buttock);
    SectionFrame neck, head;
    neck.middle_z = middle_z(skeleton_.head[at(Segment::neck)], skeleton_.head[at(Segment::head)]);
    head.middle_z = middle_z(skeleton_.head[at(Segment::head)], skeleton_.tail[at(Segment::head)]);
    nodes_ = {{{marks_.crotch, {}, hip},
               {marks_.buttock, {}, hip},
               {marks_.navel, {}, frame(marks_.navel)},
               {marks_.nipple, {}, frame(marks_.nipple)},
               {marks_.shoulder, {}, frame(marks_.shoulder)},
               {0.5F * (marks_.neck + marks_.head), {}, neck},
               {between(marks_.head, marks_.crown, 0.4F), {}, head}}};
  }
  void set_nodes() {
    nodes_[0].warp = nodes_[1].warp = trunk_warp(WarpValue::hip_breadth);
    nodes_[2].warp = trunk_warp(WarpValue::waist_breadth);
    const SectionWarp chest = nodes_[3].warp = trunk_warp(WarpValue::chest_breadth);
    nodes_[4].warp = {warp_[WarpValue::shoulder_breadth], kShoulderDepthShare * chest.front,
                      kShoulderDepthShare * chest.back, 0};
    nodes_[5].warp = even(warp_[WarpValue::neck_girth]);
    const float length = warp_[WarpValue::head_length];
    nodes_[6].warp = {warp_[WarpValue::head_breadth], length, length, 0};
  }

  void list_rises() {
    const float tall = marks_.crown - marks_.floor;
    const auto rise = [&](WarpValue v) { return tall * warp_[v]; };
    rises_ = {{{marks_.floor, 0},
               {marks_.knee, rise(WarpValue::knee_rise)},
               {marks_.crotch, rise(WarpValue::crotch_rise)},
               {marks_.navel, rise(WarpValue::navel_rise)},
               {marks_.nipple, rise(WarpValue::nipple_rise)},
               {marks_.shoulder, rise(WarpValue::shoulder_rise)},
               {marks_.neck, rise(WarpValue::neck_rise)},
               {marks_.head, rise(WarpValue::head_rise)},
               {marks_.crown, 0}}};
  }
  float rise(float y) const {
    for (std::size_t i = 1; i < rises_.size(); ++i) {
      const auto& [from, from_rise] = rises_[i - 1];
      const auto& [to, to_rise] = rises_[i];
      if (y <= to) return between(from_rise, to_rise, limited((y - from) / (to - from), 0, 1));
    }
    return 0;
  }

  Vec3f of_trunk(Vec3f p) const {
    if (p.y <= nodes_.front().y) return section_move(nodes_.front().warp, nodes_.front().frame, p);
    for (std::size_t i = 1; i < nodes_.size(); ++i) {
      const Node &a = nodes_[i - 1], &b = nodes_[i];
      if (p.y > b.y) continue;
      const float share = smooth_step(p.y, a.y, b.y);
      const SectionWarp warp = {between(a.warp.breadth, b.warp.breadth, share),
                                between(a.warp.front, b.warp.front, share), between(a.warp.back, b.warp.back, share),
                                between(a.warp.square, b.warp.square, share)};
      const SectionFrame frame = {between(a.frame.middle_z, b.frame.middle_z, share),
                                  between(a.frame.half_breadth, b.frame.half_breadth, share),
                                  between(a.frame.half_depth, b.frame.half_depth, share)};
      return section_move(warp, frame, p);
    }
    return section_move(nodes_.back().warp, nodes_.back().frame, p);
  }

  // Below the crotch each leg is scaled about its own axis, which the hips carry outwards.
  Vec3f of_leg(Vec3f p) const {
    const auto leg = p.x > 0 ? Segment::left_upper_leg : Segment::right_upper_leg;
    const Vec3f hip = skeleton_.head[at(leg)], knee = skeleton_.tail[at(leg)], ankle = skeleton_.tail[at(leg) + 1];
    const bool above = p.y > knee.y;
    const Vec3f from = above ? knee : ankle, to = above ? hip : knee;
    const float share = limited((p.y - from.y) / (to.y - from.y), -0.1F, 1.2F);
    const Vec3f axis = from + (to - from) * share;
    const float thigh = warp_[WarpValue::thigh_girth], calf = warp_[WarpValue::calf_girth];
    const float middle = 0.5F * (thigh + calf);
    float wider = 0;
    if (above)
      wider = between(middle, thigh, smooth_step(share, 0, 0.75F));
    else  // the calf is thickest a third below the knee; ankles and feet stay
      wider =
          share > 0.67F ? between(calf, middle, smooth_step(share, 0.67F, 1)) : calf * smooth_step(share, 0, 0.67F);
    const float outwards = warp_[WarpValue::hip_breadth] * smooth_step(p.y, knee.y, marks_.crotch);
    return {(p.x - axis.x) * wider + axis.x * outwards, 0, (p.z - axis.z) * wider};
  }

  Vec3f of_body(Vec3f p) const {
    const float from = marks_.crotch - kLegsBeginBelowMm;
    Vec3f move;
    if (p.y <= from)
      move = of_leg(p);
    else if (p.y >= marks_.buttock)
      move = of_trunk(p);
    else {
      const float share = smooth_step(p.y, from, marks_.buttock);
      move = of_leg(p) * (1 - share) + of_trunk(p) * share;
    }
    move.y = rise(p.y);
    return move;
  }

  void place_arm(bool left) {
    const auto upper = at(left ? Segment::left_upper_arm : Segment::right_upper_arm);
    Arm& a = arms_[left ? 0 : 1];
    a.shoulder = skeleton_.head[upper];
    a.elbow = skeleton_.head[upper + 1];
    a.wrist = skeleton_.head[upper + 2];
  }
  static float along(Vec3f p, Vec3f from, Vec3f bone) { return dot(p - from, bone) / dot(bone, bone); }
  Vec3f of_upper_arm(const Arm& a, Vec3f p) const {
    const Vec3f bone = a.elbow - a.shoulder;
    const float t = along(p, a.shoulder, bone);
    const float deltoid = warp_[WarpValue::deltoid_girth], middle = warp_[WarpValue::upper_arm_girth];
    const float elbow = 0.5F * (middle + warp_[WarpValue::forearm_girth]);
    const float wider = t < 0.5F ? between(deltoid, middle, smooth_step(t, 0.15F, 0.5F))
                                 : between(middle, elbow, smooth_step(t, 0.5F, 1));
    const Vec3f aside = p - a.shoulder - bone * t;
    return a.shoulder_move + bone * (warp_[WarpValue::upper_arm_length] * limited(t, 0, 1)) + aside * wider;
  }
  Vec3f of_forearm(const Arm& a, Vec3f p) const {
    const Vec3f bone = a.wrist - a.elbow;
    const float t = along(p, a.elbow, bone);
    const float thick = warp_[WarpValue::forearm_girth];
    const float elbow = 0.5F * (thick + warp_[WarpValue::upper_arm_girth]);
    const float wider =
        t < 0.25F ? between(elbow, thick, smooth_step(t, 0, 0.25F)) : thick * (1 - smooth_step(t, 0.25F, 1));
    const Vec3f aside = p - a.elbow - bone * t;
    return a.shoulder_move + (a.elbow - a.shoulder) * warp_[WarpValue::upper_arm_length] +
           bone * (warp_[WarpValue::forearm_length] * limited(t, 0, 1)) + aside * wider;
  }

  const BodyModel::Data& d_;
  std::span<const Vec3f> rest_;
  Warp warp_;
  Skeleton skeleton_;
  WarpLandmarks marks_;
  std::array<Node, 7> nodes_;
  struct Rise {
    float y = 0, by = 0;
  };
  std::array<Rise, 9> rises_;
  std::array<Arm, 2> arms_;
};

}  // namespace

SectionFrame section_frame(const BodyModel& model, std::span<const Vec3f> rest, float y) {
  float low_z = 1e9F, high_z = -1e9F, widest = 1;
  for (std::size_t v = 0; v < static_cast<std::size_t>(kBodyVertexCount); ++v) {
    const Vec3f p = rest[v];
    if (p.y < y - kExtentBandMm || p.y > y + kExtentBandMm || is_arm(model.data(), v)) continue;
    low_z = std::min(low_z, p.z);
    high_z = std::max(high_z, p.z);
    widest = std::max(widest, p.x < 0 ? -p.x : p.x);
  }
  if (low_z > high_z) return {};
  return {0.5F * (low_z + high_z), widest, std::max(0.5F * (high_z - low_z), 1.0F)};
}

Vec3f section_move(const SectionWarp& warp, const SectionFrame& frame, Vec3f p) {
  const float z = p.z - frame.middle_z;
  const float u = p.x / frame.half_breadth, w = z / frame.half_depth;
  const float squares = u * u + w * w;
  const float corner = squares > 0 ? warp.square * 4 * u * u * w * w / (squares * squares) : 0;
  return {p.x * (warp.breadth + corner), 0, z * ((z > 0 ? warp.front : warp.back) + corner)};
}

WarpLandmarks warp_landmarks(const BodyModel& model, std::span<const Vec3f> rest) {
  assert(rest.size() == static_cast<std::size_t>(model.vertex_count()));
  const BodyModel::Data& d = model.data();
  const auto y = [&](Landmark l) { return rest[at(d.landmark(l))].y; };
  const auto head_y = [&](Segment s) { return mean_of_list(d, kHeadLists + at(s), rest).y; };
  WarpLandmarks m;
  m.floor = m.crown = rest[0].y;
  for (std::size_t v = 0; v < static_cast<std::size_t>(kBodyVertexCount); ++v) {
    m.floor = std::min(m.floor, rest[v].y);
    m.crown = std::max(m.crown, rest[v].y);
  }
  m.knee = 0.5F * (head_y(Segment::left_lower_leg) + head_y(Segment::right_lower_leg));
  m.crotch = y(Landmark::crotch);
  m.navel = y(Landmark::navel);
  m.nipple = 0.5F * (y(Landmark::left_nipple) + y(Landmark::right_nipple));
  m.shoulder = 0.5F * (y(Landmark::left_acromion) + y(Landmark::right_acromion));
  m.neck = y(Landmark::c7);
  m.head = head_y(Segment::head);
  float rearmost = 1e9F;
  for (std::size_t v = 0; v < static_cast<std::size_t>(kBodyVertexCount); ++v) {
    if (rest[v].z >= rearmost || rest[v].y < m.crotch - 60 || rest[v].y > m.navel) continue;
    const auto s = static_cast<Segment>(d.skin[v].segment[0]);
    if (s != Segment::pelvis && s != Segment::left_upper_leg && s != Segment::right_upper_leg) continue;
    rearmost = rest[v].z;
    m.buttock = rest[v].y;
  }
  // A file of other landmarks may have them in another order: heights rise all the same.
  float below = m.floor;
  for (float* mark : {&m.knee, &m.crotch, &m.buttock, &m.navel, &m.nipple, &m.shoulder, &m.neck, &m.head, &m.crown}) {
    *mark = std::max(*mark, below + 1);
    below = *mark;
  }
  return m;
}

void apply_warp(const BodyModel& model, const Warp& warp, std::span<Vec3f> rest) {
  Field field(model, rest);
  field.set(warp);
  // A vertex moves by its own and the joints' old places: the field keeps the needed part of the old mesh.
  for (std::size_t v = 0; v < rest.size(); ++v) rest[v] = field.moved(v);
}

void warp_vertices(const BodyModel& model, const Warp& warp, std::span<const Vec3f> rest,
                   std::span<const std::int32_t> vertices, std::span<Vec3f> out) {
  assert(out.size() == vertices.size());
  Field field(model, rest);
  field.set(warp);
  for (std::size_t v = 0; v < vertices.size(); ++v) out[v] = field.moved(at(vertices[v]));
}

void warp_slopes(const BodyModel& model, std::span<const Vec3f> rest, std::span<const std::int32_t> vertices,
                 std::span<Vec3f> out) {
  assert(out.size() == vertices.size() * kWarpCount);
  Field field(model, rest);
  for (std::size_t i = 0; i < kWarpCount; ++i) {
    Warp one;
    one.values[i] = 1;
    field.set(one);
    for (std::size_t v = 0; v < vertices.size(); ++v)
      out[v * kWarpCount + i] = field.moved(at(vertices[v])) - rest[at(vertices[v])];
  }
}

}  // namespace im2fit::body
