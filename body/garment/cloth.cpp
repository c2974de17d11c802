// SPDX-License-Identifier: Apache-2.0
#include "body/garment/cloth.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace im2fit::body {
namespace {

constexpr int kSubsteps = 16;
constexpr float kFrameS = 1.0F / 30;
constexpr float kStepS = kFrameS / kSubsteps;
constexpr float kGravityMmS2 = 9810 * kWeightShare;
constexpr float kPushMm = 4;        // at most, a substep: no popping where skin meets skin
constexpr float kSpeedMmS = 4000;   // at most
constexpr float kRestMmS = 20;      // slower cloth is braked, so that it comes to rest
constexpr float kRestKeeps = 0.8F;  // of its speed, a substep
constexpr float kReachMm = 60;      // farther cloth does not touch within a frame
constexpr float kShoulderGrip = 2;  // times the friction
constexpr float kWaistGrip = 4;     // a band is held by its belt
constexpr float kBeltReachMm = 120;
constexpr int kBeltSmoothPasses = 10;
constexpr float kBeltOffMaxMm = 30;    // where a belt bridges a fold of skin
constexpr float kPinchReachMm = 25;    // skin before the cloth, that it may be pinched by
constexpr float kPinchNearMm = 15;     // off its own skin at most
constexpr float kPinchLeastMm = 0.5F;  // off the skin, where limbs overlap
constexpr int kAwakeFrames = 12;       // of still skin, until folds have fallen
constexpr float kSleepKeeps = 0.75F;   // of the motion, a frame
constexpr float kAsleep = 0.01F;
constexpr float kBeltPull = 0.2F;      // of the way to its place, a substep
constexpr float kFreeMm = 30;          // so near its anchor a vertex needs no tether
constexpr float kShoulderBandMm = 20;  // shoulders: above the shoulder joints less so much
constexpr float kLimbOverlapMm = 60;

}  // namespace

Cloth::Cloth(const GarmentMesh& mesh, const Fabric& fabric)
    : mesh_(mesh), friction_(fabric.friction), constraints_(constrain(mesh, fabric)), layers_(mesh) {
  const std::size_t count = mesh.vertex_count();
  vertices_.resize(count + 1);
  for (std::size_t v = 0; v < count; ++v) vertices_[v].inverse_mass = 1 / constraints_.mass_kg[v];
  before_ = vertices_;
  velocity_.resize(count + 1);
  normals_.resize(count);
  contacts_.resize(count);
  place_.resize(count);
  hint_.assign(count, -1);
  opposite_hint_.assign(count, -1);
  frame_begin_ = vertices_;
  limbs_.assign(count, kTrunk);
  pinched_.assign(count, 0);
  grip_.assign(count, 1);
  anchor_.assign(count, -1);
  anchor_mm_.assign(count, 0);
  const auto of = [&](CutMeasure m) { return mesh.body[static_cast<std::size_t>(m)]; };
  for (std::size_t v = 0; v < count; ++v) {
    const Flat f = mesh.flat[v];
    const bool left = mesh.side[v] >= 0, right = mesh.side[v] <= 0;
    const auto both = [&](std::uint8_t l, std::uint8_t r) {
      return static_cast<std::uint8_t>((left ? l : 0) | (right ? r : 0));
    };
    if (mesh.hang == Hang::shoulders) {
      // A sleeve begins above the underarm, or beyond the side seam.
      const float chest = of(CutMeasure::chest);
      const bool sleeve = f.y > -0.085F * chest - 50 - kLimbOverlapMm || f.x > chest / 4 + kLimbOverlapMm;
      if (sleeve && f.x > of(CutMeasure::shoulder_x) - kLimbOverlapMm) limbs_[v] |= both(kLeftArm, kRightArm);
      if (sleeve && f.x > of(CutMeasure::shoulder_x) + 2 * kLimbOverlapMm)
        limbs_[v] &= static_cast<std::uint8_t>(~kTrunk);
      if (!sleeve && f.y < -400) limbs_[v] |= kLeftLeg | kRightLeg;
      if (f.y > -kShoulderBandMm || (mesh.border[v] & kOnOpening) != 0) grip_[v] = kShoulderGrip;
    } else {
      limbs_[v] |= mesh.legs ? both(kLeftLeg, kRightLeg) : static_cast<std::uint8_t>(kLeftLeg | kRightLeg);
      if (mesh.legs && f.y < -of(CutMeasure::hip_to_crotch) - 2 * kLimbOverlapMm)
        limbs_[v] &= static_cast<std::uint8_t>(~kTrunk);
      if (f.y > 0 || (mesh.border[v] & kOnOpening) != 0) grip_[v] = kWaistGrip;
    }
  }
  belt_.reserve(count);
  find_ring();
  tether();
}

// Long-range attachments (Kim et al. 2012) to the seam or band a garment hangs from; distances in the pattern.
void Cloth::tether() {
  const std::size_t count = mesh_.vertex_count();
  const float shoulder = mesh_.body[static_cast<std::size_t>(CutMeasure::shoulder)] / 2;
  std::vector<std::size_t> anchors;
  for (std::size_t v = 0; v < count; ++v) {
    const bool seam = mesh_.hang == Hang::shoulders && (mesh_.border[v] & kOnSeam) != 0 && mesh_.flat[v].y > 0 &&
                      mesh_.flat[v].x < shoulder;
    if (seam || (mesh_.border[v] & kOnOpening) != 0) anchors.push_back(v);
  }
  for (std::size_t v = 0; v < count; ++v) {
    float nearest = 1e30F;
    for (const std::size_t a : anchors) {
      const bool same_layer =
          mesh_.layer[v] == mesh_.layer[a] || mesh_.layer[v] == kBothLayers || mesh_.layer[a] == kBothLayers;
      if (!same_layer || mesh_.side[v] * mesh_.side[a] < 0) continue;
      const float dx = mesh_.flat[v].x - mesh_.flat[a].x, dy = mesh_.flat[v].y - mesh_.flat[a].y;
      const float squared = dx * dx + dy * dy;
      if (squared >= nearest) continue;
      nearest = squared;
      anchor_[v] = static_cast<std::int32_t>(a);
    }
    anchor_mm_[v] = std::sqrt(nearest);
    if (anchor_mm_[v] < kFreeMm) anchor_[v] = -1;
  }
}

void Cloth::place(std::span<const Vec3f> vertices) {
  carry(vertices);
  belt_.clear();
}

void Cloth::carry(std::span<const Vec3f> vertices) {
  assert(vertices.size() == mesh_.vertex_count());
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    ClothVertex& p = vertices_[v];
    p.x = vertices[v].x;
    p.y = vertices[v].y;
    p.z = vertices[v].z;
    velocity_[v] = {};
    hint_[v] = -1;
    opposite_hint_[v] = -1;
  }
  still_frames_ = 0;
  awake_ = 1;
  before_ = vertices_;  // the same size: no allocation
}

void Cloth::close_belt(float girth_mm) {
  float band = 0;
  for (const BandEdge& e : constraints_.band) band += e.length;
  const float share = band > girth_mm && girth_mm > 0 ? girth_mm / band : 1.0F;
  for (const BandEdge& e : constraints_.band) {
    constraints_.stretch[e.batch].length[e.lane] = e.length * share;
    constraints_.edge_mm[e.edge] = e.length * share;
  }
}

// The band's vertices in order round the waist, from the middle of the front on.
void Cloth::find_ring() {
  const std::size_t count = mesh_.vertex_count();
  if (mesh_.hang != Hang::waist) return;
  std::vector<std::array<std::int32_t, 2>> next(count, {-1, -1});
  for (const BandEdge& e : constraints_.band)
    for (const std::size_t k : {0U, 1U}) {
      auto& of = next[static_cast<std::size_t>(constraints_.edges[e.edge][k])];
      of[of[0] < 0 ? 0 : 1] = constraints_.edges[e.edge][1 - k];
    }
  std::int32_t start = -1;
  for (std::size_t v = 0; v < count; ++v)
    if (next[v][1] >= 0 && mesh_.side[v] == 0 && mesh_.layer[v] == kFrontLayer) start = static_cast<std::int32_t>(v);
  for (std::int32_t v = start, before = -1; v >= 0 && ring_.size() < count;) {
    ring_.push_back(v);
    const auto& of = next[static_cast<std::size_t>(v)];
    const std::int32_t after = of[0] != before ? of[0] : of[1];
    before = v;
    v = after == start ? -1 : after;
  }
  ring_at_.resize(ring_.size());
  ring_work_.resize(ring_.size());
}

// A belt lies flat, and its band is spread evenly along it: the places of ring_ in ring_at_.
void Cloth::lay_belt(float up_mm) {
  const std::size_t count = ring_.size();
  const auto vertex = [&](std::size_t i) { return static_cast<std::size_t>(ring_[i % count]); };
  for (std::size_t i = 0; i < count; ++i) ring_at_[i] = position(vertex(i));
  for (int pass = 0; pass < kBeltSmoothPasses; ++pass) {
    std::copy(ring_at_.begin(), ring_at_.end(), ring_work_.begin());
    for (std::size_t i = 0; i < count; ++i)
      ring_at_[i] =
          ring_work_[i] * 0.5F + (ring_work_[(i + count - 1) % count] + ring_work_[(i + 1) % count]) * 0.25F;
  }
  const auto cut_mm = [&](std::size_t i) {
    const Flat a = mesh_.flat[vertex(i)], b = mesh_.flat[vertex(i + 1)];
    return std::sqrt((a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y));
  };
  float cut = 0, laid = 0;
  for (std::size_t i = 0; i < count; ++i) {
    cut += cut_mm(i);
    laid += norm(ring_at_[(i + 1) % count] - ring_at_[i]);
  }
  std::copy(ring_at_.begin(), ring_at_.end(), ring_work_.begin());
  std::size_t piece = 0;
  float want = 0, passed = 0;
  for (std::size_t i = 0; i < count; ++i) {
    float length = norm(ring_work_[(piece + 1) % count] - ring_work_[piece]);
    while (piece + 1 < count && passed + length < want) {
      passed += length;
      ++piece;
      length = norm(ring_work_[(piece + 1) % count] - ring_work_[piece]);
    }
    const float share = length > 0 ? std::min(1.0F, (want - passed) / length) : 0;
    ring_at_[i] = ring_work_[piece] + (ring_work_[(piece + 1) % count] - ring_work_[piece]) * share;
    ring_at_[i].y = mesh_.flat[vertex(i)].y + up_mm;
    want += cut_mm(i) * laid / cut;
  }
}

void Cloth::hold_belt(const BodySurface& skin, float up_mm) {
  update_normals();
  belt_.clear();
  lay_belt(up_mm);
  for (std::size_t i = 0; i < ring_.size(); ++i) {
    Held held;
    held.vertex = ring_[i];
    const Vec3f facing = normals_[static_cast<std::size_t>(ring_[i])];
    std::int32_t hint = -1;
    if (!skin.nearest(ring_at_[i], facing, 0, kTrunk, kBeltReachMm, hint, held.place)) continue;
    const float off = dot(ring_at_[i] - skin.at(held.place, false), skin.facing(held.place, false));
    held.off_mm = std::clamp(off, kSkinMm, kBeltOffMaxMm);
    belt_.push_back(held);
  }
}

void Cloth::pull_belt(int substep) {
  const float steps = static_cast<float>(substep + 1);
  for (const Held& held : belt_) {
    ClothVertex& p = vertices_[static_cast<std::size_t>(held.vertex)];
    const Vec3f to = held.point + held.point_step * steps - Vec3f{p.x, p.y, p.z};
    p.x += kBeltPull * to.x;
    p.y += kBeltPull * to.y;
    p.z += kBeltPull * to.z;
  }
}

void Cloth::update_normals() {
  std::fill(normals_.begin(), normals_.end(), Vec3f{});
  for (const auto& t : mesh_.triangles) {
    const auto a = static_cast<std::size_t>(t[0]), b = static_cast<std::size_t>(t[1]),
               c = static_cast<std::size_t>(t[2]);
    const Vec3f n = cross(position(b) - position(a), position(c) - position(a));
    normals_[a] = normals_[a] + n;
    normals_[b] = normals_[b] + n;
    normals_[c] = normals_[c] + n;
  }
  for (Vec3f& n : normals_) n = normalized(n);
}

void Cloth::find_contacts(const BodySurface& skin, const ClothFrame& frame, std::span<const float> clearance_mm) {
  constexpr float kPerStep = 1.0F / kSubsteps;
  for (std::size_t v = 0; v < mesh_.vertex_count(); ++v) {
    Contact& c = contacts_[v];
    Vec3f facing = normals_[v];
    pinched_[v] = 0;
    if (frame.flat)
      facing = {0, 0, mesh_.layer[v] == kFrontLayer ? 1.0F : mesh_.layer[v] == kBackLayer ? -1.0F : 0.0F};
    // A seam between flat panels faces neither way.
    c.on = skin.nearest(position(v), facing, frame.flat ? -0.15F : 0.0F, limbs_[v], kReachMm, hint_[v], place_[v]);
    if (!c.on) {
      place_[v].triangle = -1;
      continue;
    }
    c.clearance = kSkinMm;
    c.point = skin.at(place_[v], false);
    c.point_step = (skin.at(place_[v], true) - c.point) * kPerStep;
    c.normal = skin.facing(place_[v], false);
    c.normal_step = (skin.facing(place_[v], true) - c.normal) * kPerStep;
    c.friction = friction_ * grip_[v];
    if (!clearance_mm.empty()) {
      const auto& t = skin.triangles()[static_cast<std::size_t>(place_[v].triangle)];
      for (std::size_t k = 0; k < 3; ++k)
        c.clearance += place_[v].share[k] * clearance_mm[static_cast<std::size_t>(t[k])];
    }
    if (!frame.flat) yield_to_opposite_skin(skin, v);
  }
}

// In an armpit, a crotch or a lap, cloth is pinched between two skins that face each other, and that overlap where a
// body's limbs do: there it keeps to the middle, instead of being pushed to and fro.
void Cloth::yield_to_opposite_skin(const BodySurface& skin, std::size_t v) {
  Contact& c = contacts_[v];
  const Vec3f off = position(v) - c.point;
  if (dot(off, off) > kPinchNearMm * kPinchNearMm) return;
  SkinPlace opposite;
  constexpr std::uint8_t kAll = kTrunk | kLeftArm | kRightArm | kLeftLeg | kRightLeg;
  if (!skin.nearest(position(v), normals_[v] * -1.0F, 0, kAll, kPinchReachMm, opposite_hint_[v], opposite)) return;
  const Vec3f other = skin.facing(opposite, false);
  if (dot(other, c.normal) > -0.2F) return;
  const float gap = dot(skin.at(opposite, false) - c.point, c.normal);
  if (gap / 2 >= c.clearance) return;
  c.clearance = std::max(gap / 2, kPinchLeastMm);
  pinched_[v] = 1;
}

void Cloth::follow_belt(const BodySurface& skin) {
  constexpr float kPerStep = 1.0F / kSubsteps;
  for (Held& held : belt_) {
    held.point = skin.at(held.place, false) + skin.facing(held.place, false) * held.off_mm;
    const Vec3f end = skin.at(held.place, true) + skin.facing(held.place, true) * held.off_mm;
    held.point_step = (end - held.point) * kPerStep;
  }
}

void Cloth::integrate(const ClothFrame& frame) {
  const float keep = 1 - frame.damping_per_s * kStepS;
  const float fall = frame.weightless ? 0 : kGravityMmS2 * kStepS;
  for (std::size_t v = 0; v < mesh_.vertex_count(); ++v) {
    ClothVertex& p = vertices_[v];
    const ClothVertex& speed = velocity_[v];
    before_[v] = p;
    p.x += speed.x * keep * kStepS;
    p.y += (speed.y - fall) * keep * kStepS;
    p.z += speed.z * keep * kStepS;
  }
}

void Cloth::hold_tethers() {
  for (std::size_t v = 0; v < mesh_.vertex_count(); ++v) {
    if (anchor_[v] < 0) continue;
    ClothVertex& p = vertices_[v];
    const ClothVertex& a = vertices_[static_cast<std::size_t>(anchor_[v])];
    const float dx = p.x - a.x, dy = p.y - a.y, dz = p.z - a.z;
    const float squared = dx * dx + dy * dy + dz * dz;
    if (squared <= anchor_mm_[v] * anchor_mm_[v]) continue;
    const float length = std::sqrt(squared);
    const float back = 0.5F * (length - anchor_mm_[v]) / length;
    p.x -= dx * back;
    p.y -= dy * back;
    p.z -= dz * back;
  }
}

// Out of the skin along its normal, then Coulomb friction against the skin's own motion.
void Cloth::collide(int substep) {
  const float steps = static_cast<float>(substep + 1);
  for (std::size_t v = 0; v < mesh_.vertex_count(); ++v) {
    const Contact& c = contacts_[v];
    if (!c.on) continue;
    ClothVertex& p = vertices_[v];
    const Vec3f point = c.point + c.point_step * steps;
    const Vec3f normal = c.normal + c.normal_step * steps;
    Vec3f at = {p.x, p.y, p.z};
    const float depth = c.clearance - dot(normal, at - point);
    if (depth <= 0) continue;
    const float push = depth < kPushMm ? depth : kPushMm;
    const Vec3f was = {before_[v].x, before_[v].y, before_[v].z};
    Vec3f slide = at - was - c.point_step;
    slide = slide - normal * dot(normal, slide);
    const float length = norm(slide);
    const float most = c.friction * push;
    at = at + normal * push;
    if (length > 1e-6F) at = at - slide * (length < most ? 1.0F : most / length);
    p.x = at.x;
    p.y = at.y;
    p.z = at.z;
  }
}

void Cloth::update_velocities() {
  constexpr float kPerS = 1 / kStepS;
  for (std::size_t v = 0; v < mesh_.vertex_count(); ++v) {
    const ClothVertex &p = vertices_[v], &b = before_[v];
    float x = (p.x - b.x) * kPerS, y = (p.y - b.y) * kPerS, z = (p.z - b.z) * kPerS;
    const float squared = x * x + y * y + z * z;
    float keep = 1;
    if (squared > kSpeedMmS * kSpeedMmS)
      keep = kSpeedMmS / std::sqrt(squared);
    else if (squared < kRestMmS * kRestMmS)
      keep = kRestKeeps;
    velocity_[v] = {x * keep, y * keep, z * keep, 0};
  }
}

void Cloth::fall_asleep() {
  for (std::size_t v = 0; v < mesh_.vertex_count(); ++v) {
    ClothVertex& p = vertices_[v];
    const ClothVertex& from = frame_begin_[v];
    p.x = from.x + (p.x - from.x) * awake_;
    p.y = from.y + (p.y - from.y) * awake_;
    p.z = from.z + (p.z - from.z) * awake_;
    ClothVertex& speed = velocity_[v];
    speed = {speed.x * awake_, speed.y * awake_, speed.z * awake_, 0};
  }
}

void Cloth::run(const BodySurface& skin, const ClothFrame& frame, std::span<const float> clearance_mm) {
  constexpr float kPerS2 = 1 / (kStepS * kStepS);
  still_frames_ = frame.may_sleep && skin.still() ? still_frames_ + 1 : 0;
  awake_ = still_frames_ > kAwakeFrames ? awake_ * kSleepKeeps : 1.0F;
  if (awake_ < kAsleep) return;
  if (awake_ < 1) std::copy(vertices_.begin(), vertices_.end(), frame_begin_.begin());
  update_normals();
  find_contacts(skin, frame, clearance_mm);
  follow_belt(skin);
  if (frame.flat)
    layers_.clear();
  else
    layers_.find(vertices_, pinched_);
  for (int s = 0; s < kSubsteps; ++s) {
    integrate(frame);
    solve_stretch(constraints_.stretch, kPerS2, vertices_.data());
    // Bending is soft: every second substep at twice the time step's compliance is as good and half the work.
    if ((s & 1) != 0) solve_bend(constraints_.bend, kPerS2 / 2, vertices_.data());
    hold_tethers();
    layers_.solve(vertices_, before_);
    pull_belt(s);
    collide(s);
    update_velocities();
  }
  if (awake_ < 1) fall_asleep();
}

}  // namespace im2fit::body
