// SPDX-License-Identifier: Apache-2.0
#include "garment/drape/cloth.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>

#include "garment/drape/flat_places.h"

namespace im2fit::body {
namespace {

constexpr float kFrameS = 1.0F / 30;
constexpr float kGravityMmS2 = 9810 * kWeightShare;
constexpr float kPushMm = 64;          // at most, a frame: no popping where skin meets skin
constexpr float kSpeedMmS = 4000;      // at most
constexpr float kRestMmS = 20;         // slower cloth is braked, so that it comes to rest
constexpr float kBrakePerS = 96;       // of its speed
constexpr float kReachMm = 60;         // farther cloth does not touch within a frame
constexpr float kNearMm = 20;          // cloth that comes so near is looked at each frame
constexpr float kSeamCosine = -0.15F;  // a seam between flat panels faces neither way
constexpr float kShoulderGrip = 2;     // times the friction
// Skin before the cloth, that it may be pinched by: two layers' kSkinMm; a rough mesh's vertices are far between.
constexpr float kPinchReachMm = 8, kRoughPinchReachMm = 25;
constexpr float kPinchNearMm = 15;     // off its own skin at most
constexpr float kCaughtMm = 25;        // skin that cloth is within, at most
constexpr float kPinchLeastMm = 0.5F;  // off the skin, where limbs overlap
// Edges stretched by kListed when a frame begins are held until it ends, after the skin has pushed: where skin pulls
// cloth apart, cloth wins. The first passes shorten edges over kOver to kHeld, a little less, so that an edge is not
// shortened again for a tiny excess. The other passes shorten edges over kPeak to kPeak: there skin and cloth
// disagree, and a corner's pull spreads to ever farther neighbours. The last passes, which few substeps need, shorten
// edges over kLast (docs/garments.md has the effects of other numbers).
constexpr float kListed = 0.07F, kHeld = 0.07F, kOver = 0.08F, kPeak = 0.155F, kLast = 0.25F;
constexpr int kFirmPasses = 9, kStrainPasses = 12, kLastPasses = 36;  // of a substep, at most so far; rough meshes: 1
constexpr unsigned kPlacedFrames = 3;  // in which a band that was drawn together spreads: one pass
constexpr int kAwakeFrames = 12;       // of still skin, until folds have fallen
constexpr float kSleepKeeps = 0.75F;   // of the motion, a frame
constexpr float kAsleep = 0.01F;
constexpr float kBeltPullPerS = 96;    // of the way to its place
constexpr float kFreeMm = 30;          // so near its anchor a vertex needs no tether
constexpr float kShoulderBandMm = 20;  // shoulders: above the shoulder joints less so much
constexpr float kLimbOverlapMm = 60;
constexpr float kSleeveFlare = 0.3F;  // a sleeve's lower edge may fall off by so much of the way from the underarm

Float4 lanes_of(Vec3f v) {
  return Float4{v.x, v.y, v.z, 0};
}

float along_sleeve(Flat f) {
  return f.x * kSleeveCosine - f.y * kSleeveSine;
}

// Upwards from the line through the shoulder joint's drawn place.
float across_sleeve(Flat f) {
  return f.x * kSleeveSine + f.y * kSleeveCosine;
}

}  // namespace

Cloth::Cloth(const GarmentMesh& mesh, const Fabric& fabric, int substeps)
    : mesh_(mesh),
      substeps_(substeps),
      step_s_(kFrameS / static_cast<float>(substeps)),
      push_mm_(kPushMm / static_cast<float>(substeps)),
      rest_keeps_(1 - kBrakePerS * step_s_),
      belt_pull_(kBeltPullPerS * step_s_),
      friction_(fabric.friction),
      rough_(substeps != kSubsteps),
      pinch_reach_mm_(rough_ ? kRoughPinchReachMm : kPinchReachMm),
      constraints_(constrain(mesh, fabric, step_s_)),
      layers_(mesh) {
  const std::size_t count = mesh.vertex_count();
  vertices_.resize(count + 1);
  before_ = vertices_;
  velocity_.resize(count + 1);
  normals_.resize(count);
  contacts_.resize(count);
  place_.resize(count);
  hint_.assign(count, -1);
  opposite_hint_.assign(count, -1);
  clear_mm_.assign(count, 0);
  frame_begin_ = vertices_;
  limbs_.assign(count, kTrunk);
  pinched_.assign(count, 0);
  joint_.assign(count, 0);
  grip_.assign(count, 1);
  const auto of = [&](CutMeasure m) { return mesh.body[static_cast<std::size_t>(m)]; };
  const Flat underarm = mesh.underarm;
  for (std::size_t v = 0; v < count; ++v) {
    const Flat f = mesh.flat[v];
    const bool left = mesh.side[v] >= 0, right = mesh.side[v] <= 0;
    const auto both = [&](std::uint8_t l, std::uint8_t r) {
      return static_cast<std::uint8_t>((left ? l : 0) | (right ? r : 0));
    };
    if (mesh.hang == Hang::shoulders) {
      // A wide hem lies farther out than the underarm, too, but below the sleeve.
      const float beyond = along_sleeve(f) - along_sleeve(underarm);
      const bool beside = across_sleeve(f) > across_sleeve(underarm) - kLimbOverlapMm - kSleeveFlare * beyond;
      const bool sleeve = f.y > underarm.y - kLimbOverlapMm || (f.x > underarm.x + kLimbOverlapMm && beside);
      if (sleeve && f.x > of(CutMeasure::shoulder_x) - kLimbOverlapMm) limbs_[v] |= both(kLeftArm, kRightArm);
      if (sleeve && beyond > kLimbOverlapMm / 2) limbs_[v] &= static_cast<std::uint8_t>(~kTrunk);
      if (!sleeve && f.y < -400) limbs_[v] |= kLeftLeg | kRightLeg;
      if (f.y > -kShoulderBandMm || (mesh.border[v] & kOnOpening) != 0) grip_[v] = kShoulderGrip;
    } else {
      limbs_[v] |= mesh.legs ? both(kLeftLeg, kRightLeg) : static_cast<std::uint8_t>(kLeftLeg | kRightLeg);
      if (mesh.legs && f.y < -of(CutMeasure::hip_to_crotch) - 2 * kLimbOverlapMm)
        limbs_[v] &= static_cast<std::uint8_t>(~kTrunk);
    }
  }
  for (std::size_t v = 0; v < count; ++v) joint_[v] = std::popcount(limbs_[v]) > 1 ? 1 : 0;
  belt_.reserve(count);
  stretched_.reserve(constraints_.edges.size());
  moved_in_.assign(count, 0);
  find_ring();
  tether();
}

// Long-range attachments (Kim et al. 2012) to the seam or band a garment hangs from; distances in the pattern.
void Cloth::tether() {
  const std::size_t count = mesh_.vertex_count();
  const float shoulder = mesh_.body[static_cast<std::size_t>(CutMeasure::shoulder)] / 2;
  // Of one panel: by what its vertices' layers and sides are.
  std::array<std::array<FlatPlaces, 3>, 3> anchors;
  const auto row = [](int side) { return static_cast<std::size_t>(side + 1); };
  for (std::size_t v = 0; v < count; ++v) {
    const bool seam = mesh_.hang == Hang::shoulders && (mesh_.border[v] & kOnSeam) != 0 && mesh_.flat[v].y > 0 &&
                      mesh_.flat[v].x < shoulder;
    if (!seam && (mesh_.border[v] & kOnOpening) == 0) continue;
    for (const std::uint8_t layer : {kFrontLayer, kBackLayer, kBothLayers})
      for (const int side : {-1, 0, 1}) {
        const bool same_layer = layer == mesh_.layer[v] || layer == kBothLayers || mesh_.layer[v] == kBothLayers;
        if (same_layer && side * mesh_.side[v] >= 0) anchors[layer][row(side)].add(mesh_.flat[v], v);
      }
  }
  for (std::size_t v = 0; v < count; ++v) {
    const auto nearest = anchors[mesh_.layer[v]][row(mesh_.side[v])].nearest(mesh_.flat[v]);
    const float most_mm = std::sqrt(nearest.squared_mm);
    if (nearest.vertex >= 0 && most_mm >= kFreeMm)
      tethers_.push_back({static_cast<std::int32_t>(v), nearest.vertex, most_mm});
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
    clear_mm_[v] = 0;
  }
  still_frames_ = 0;
  awake_ = 1;
  frames_ = 0;
  before_ = vertices_;  // the same size: no allocation
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

// Behind the skin's plane, but farther aside than behind: crumpled cloth faces skin that it does not lie on.
bool Cloth::lies_beside(const Contact& contact, Float4 at) {
  const Float4 off = at - contact.point;
  const float before = sum3(off * contact.normal);
  return before < 0 && 2 * before * before < sum3(off * off);
}

// Skin is followed from where it was, and looked for everywhere in every fourth frame.
bool Cloth::find_skin(const BodySurface& skin, const ClothFrame& frame, std::size_t v) {
  Vec3f facing = normals_[v];
  if (frame.flat) facing = {0, 0, mesh_.layer[v] == kFrontLayer ? 1.0F : mesh_.layer[v] == kBackLayer ? -1.0F : 0.0F};
  const float cosine = frame.flat ? kSeamCosine : 0.0F;
  // Cloth that falls asleep keeps to the skin it lies on.
  if (hint_[v] >= 0 && (awake_ < 1 || (frames_ + v) % 4 != 0))
    return skin.follow(position(v), facing, cosine, limbs_[v], kReachMm, hint_[v], place_[v]);
  if (hint_[v] < 0 && clear_mm_[v] > 0) {
    const Vec3f moved = Vec3f{velocity_[v].x, velocity_[v].y, velocity_[v].z} * kFrameS;
    clear_mm_[v] -= norm(moved) + skin.moved_mm();
    if (clear_mm_[v] > 0) return false;
  }
  // A vertex that met no skin looks first where the one before it did.
  if (hint_[v] < 0 && v > 0) hint_[v] = hint_[v - 1];
  bool found = skin.nearest(position(v), facing, cosine, limbs_[v], kReachMm, hint_[v], place_[v]);
  if (!found && !frame.flat && skin.nearest(position(v), {}, -1, limbs_[v], kCaughtMm, hint_[v], place_[v])) {
    // Crumpled within a limb no skin of which faces as the cloth does.
    found = dot(position(v) - skin.at(place_[v], false), skin.facing(place_[v], false)) < 0;
    if (!found) hint_[v] = -1;
  }
  clear_mm_[v] = found ? 0 : kReachMm - kNearMm;
  return found;
}

void Cloth::touch(const BodySurface& skin, std::size_t v, const SkinPlace& place) {
  const Float4 share = all_of(1.0F / static_cast<float>(substeps_));
  Contact& c = contacts_[v];
  c.clearance = kSkinMm;
  c.point = lanes_of(skin.at(place, false));
  c.normal = lanes_of(skin.facing(place, false));
  c.point_step = c.normal_step = Float4{};
  if (skin.moved_mm() <= 0) return;
  c.point_step = (lanes_of(skin.at(place, true)) - c.point) * share;
  c.normal_step = (lanes_of(skin.facing(place, true)) - c.normal) * share;
}

void Cloth::find_contacts(const BodySurface& skin, const ClothFrame& frame, std::span<const float> clearance_mm) {
  for (std::size_t v = 0; v < mesh_.vertex_count(); ++v) {
    Contact& c = contacts_[v];
    c.on = find_skin(skin, frame, v);
    if (!c.on) {
      place_[v].triangle = -1;
      pinched_[v] = 0;
      continue;
    }
    touch(skin, v, place_[v]);
    if (lies_beside(c, load(vertices_[v]))) {
      // Crumpled cloth gives way to the nearest skin, whichever way that faces.
      std::int32_t hint = hint_[v];
      SkinPlace nearest;
      if (skin.nearest(position(v), {}, -1, limbs_[v], kReachMm, hint, nearest)) {
        place_[v] = nearest;
        touch(skin, v, place_[v]);
      }
    }
    c.friction = friction_ * grip_[v];
    if (!clearance_mm.empty()) {
      const auto& t = skin.triangles()[static_cast<std::size_t>(place_[v].triangle)];
      for (std::size_t k = 0; k < 3; ++k)
        c.clearance += place_[v].share[k] * clearance_mm[static_cast<std::size_t>(t[k])];
    }
    pinched_[v] = 0;
    // Cloth that was not pinched is looked at in every second frame.
    if (!frame.flat && (opposite_hint_[v] >= 0 || ((frames_ + v) & 1U) == 0) && !yield_to_opposite_skin(skin, v))
      leave_other_limb(skin, v);
  }
}

// In an armpit, a crotch or a lap, cloth is pinched between two skins that face each other, and that overlap where a
// body's limbs do: there it keeps to the middle, instead of being pushed to and fro. Whether the opposite skin is
// there.
bool Cloth::yield_to_opposite_skin(const BodySurface& skin, std::size_t v) {
  Contact& c = contacts_[v];
  const Float4 off = load(vertices_[v]) - c.point;
  if (sum3(off * off) > kPinchNearMm * kPinchNearMm) return false;
  SkinPlace opposite;
  constexpr std::uint8_t kAll = kTrunk | kLeftArm | kRightArm | kLeftLeg | kRightLeg;
  if (!skin.nearest(position(v), normals_[v] * -1.0F, 0, kAll, pinch_reach_mm_, opposite_hint_[v], opposite) ||
      sum3(lanes_of(skin.facing(opposite, false)) * c.normal) > -0.2F)
    return false;
  const float gap = sum3((lanes_of(skin.at(opposite, false)) - c.point) * c.normal);
  if (gap / 2 >= c.clearance) return true;
  c.clearance = std::max(gap / 2, kPinchLeastMm);
  pinched_[v] = 1;
  return true;
}

// Where limbs meet, cloth that is off one of them may run into the side of another: out of that.
void Cloth::leave_other_limb(const BodySurface& skin, std::size_t v) {
  Contact& c = contacts_[v];
  if (joint_[v] == 0 || sum3((load(vertices_[v]) - c.point) * c.normal) < 0) return;
  SkinPlace other;
  std::int32_t hint = hint_[v];
  if (!skin.nearest(position(v), {}, -1, limbs_[v], kCaughtMm, hint, other) ||
      dot(position(v) - skin.at(other, false), skin.facing(other, false)) >= 0)
    return;
  touch(skin, v, other);
  c.clearance = kPinchLeastMm;
  pinched_[v] = 1;
}

void Cloth::find_stretched() {
  stretched_.clear();
  std::fill(moved_in_.begin(), moved_in_.end(), std::uint16_t{0});
  strain_pass_ = 0;
  for (const StretchBatch& batch : constraints_.stretch)
    for (std::size_t k = 0; k < 4; ++k) {
      const int lane = static_cast<int>(k);
      const Float4 d = load(vertices_[static_cast<std::size_t>(batch.a[k])]) -
                       load(vertices_[static_cast<std::size_t>(batch.b[k])]);
      const float length = batch.length[lane], much = length * (1 + kListed);
      if (sum3(d * d) <= much * much || length <= 0) continue;
      const float both = batch.share_a[lane] + batch.share_b[lane];
      stretched_.push_back({batch.a[k], batch.b[k], length, batch.share_a[lane] / both, batch.share_b[lane] / both});
    }
}

// The n-th pass of a substep: shortens edges stretched by more than `over` to `to`; returns whether there were any.
// After the first pass, an edge whose ends have not moved since its last check is skipped.
bool Cloth::limit_strain(int pass, float over_share, float to_share) {
  const float over = 1 + over_share, to = 1 + to_share;
  const std::uint16_t now = ++strain_pass_;
  const auto [vertices, before, velocity, count] = arrays();
  std::uint16_t* const moved_in = moved_in_.data();
  bool any = false;
  for (const Stretched& e : stretched_) {
    if (pass > 0 && std::max(moved_in[e.a], moved_in[e.b]) + 1 < now) continue;
    const Float4 a = load(vertices[e.a]), b = load(vertices[e.b]), d = a - b;
    const float squared = sum3(d * d), most_mm = e.rest_mm * over;
    if (squared <= most_mm * most_mm) continue;
    any = true;
    moved_in[e.a] = moved_in[e.b] = now;
    const float length = std::sqrt(squared), excess = (length - e.rest_mm * to) / length;
    store(vertices[e.a], a - d * all_of(excess * e.share_a));
    store(vertices[e.b], b + d * all_of(excess * e.share_b));
  }
  return any;
}

void Cloth::limit_all_strain(bool placed) {
  if (placed || rough_) {
    limit_strain(0, kPeak, kPeak);
    return;
  }
  int pass = 0;
  while (pass < kFirmPasses && limit_strain(pass, kOver, kHeld)) ++pass;
  if (pass < kFirmPasses) return;
  while (pass < kStrainPasses && limit_strain(pass, kPeak, kPeak)) ++pass;
  if (pass < kStrainPasses) return;
  while (pass < kLastPasses && limit_strain(pass, kLast, kLast)) ++pass;
}

void Cloth::integrate(const ClothFrame& frame) {
  const float keep = 1 - frame.damping_per_s * step_s_;
  const Float4 fall = {0, frame.weightless ? 0 : kGravityMmS2 * step_s_, 0, 0};
  const Float4 kept = all_of(keep), step_s = all_of(step_s_);
  const auto [vertices, before, velocity, count] = arrays();
  for (std::size_t v = 0; v < count; ++v) {
    const Float4 p = load(vertices[v]);
    store(before[v], p);
    store(vertices[v], p + (load(velocity[v]) - fall) * kept * step_s);
  }
}

void Cloth::hold_tethers() {
  for (const Tether& tether : tethers_) {
    ClothVertex& vertex = vertices_[static_cast<std::size_t>(tether.vertex)];
    const Float4 p = load(vertex);
    const Float4 d = p - load(vertices_[static_cast<std::size_t>(tether.anchor)]);
    const float squared = sum3(d * d);
    if (squared <= tether.most_mm * tether.most_mm) continue;
    const float length = std::sqrt(squared);
    store(vertex, p - d * all_of(0.5F * (length - tether.most_mm) / length));
  }
}

// Out of the skin along its normal, then Coulomb friction against the skin's own motion.
void Cloth::collide(int substep) {
  const Float4 steps = all_of(static_cast<float>(substep + 1));
  const auto [vertices, before, velocity, count] = arrays();
  const Contact* const contacts = contacts_.data();
  const float most_push = push_mm_;
  for (std::size_t v = 0; v < count; ++v) {
    const Contact& c = contacts[v];
    if (!c.on) continue;
    const Float4 p = load(vertices[v]);
    const Float4 normal = c.normal + c.normal_step * steps;
    const float depth = c.clearance - sum3(normal * (p - (c.point + c.point_step * steps)));
    if (depth <= 0) continue;
    const float push = depth < most_push ? depth : most_push;
    Float4 slide = p - load(before[v]) - c.point_step;
    slide -= normal * all_of(sum3(normal * slide));
    const float length = std::sqrt(sum3(slide * slide));
    const float most = c.friction * push;
    Float4 at = p + normal * all_of(push);
    if (length > 1e-6F) at -= slide * all_of(length < most ? 1.0F : most / length);
    store(vertices[v], at);
  }
}

void Cloth::update_velocities() {
  const Float4 per_s = all_of(1 / step_s_);
  const float rest_keeps = rest_keeps_;
  const auto [vertices, before, velocity, count] = arrays();
  for (std::size_t v = 0; v < count; ++v) {
    const Float4 speed = (load(vertices[v]) - load(before[v])) * per_s;
    const float squared = sum3(speed * speed);
    float keep = 1;
    if (squared > kSpeedMmS * kSpeedMmS)
      keep = kSpeedMmS / std::sqrt(squared);
    else if (squared < kRestMmS * kRestMmS)
      keep = rest_keeps;
    store(velocity[v], speed * all_of(keep));
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
  still_frames_ = frame.may_sleep && skin.still() ? still_frames_ + 1 : 0;
  awake_ = still_frames_ > kAwakeFrames ? awake_ * kSleepKeeps : 1.0F;
  if (awake_ < kAsleep) return;
  if (awake_ < 1) std::copy(vertices_.begin(), vertices_.end(), frame_begin_.begin());
  update_normals();
  find_contacts(skin, frame, clearance_mm);
  follow_belt(skin);
  // Pairs within reach of each other serve for two frames.
  if (frame.flat)
    layers_.clear();
  else if ((frames_ & 1U) == 0)
    layers_.find(vertices_, pinched_);
  ++frames_;
  if (frame.weightless)
    stretched_.clear();
  else
    find_stretched();
  for (int s = 0; s < substeps_; ++s) {
    integrate(frame);
    solve_stretch(constraints_.stretch, vertices_.data());
    if ((s & 1) != 0) {
      solve_bend(constraints_.bend, vertices_.data());
      solve_rims(constraints_.rims, vertices_.data());
    }
    if ((s & 1) == 0) hold_tethers();
    layers_.solve(vertices_, before_);
    pull_belt(s);
    collide(s);
    limit_all_strain(frames_ <= kPlacedFrames);
    update_velocities();
  }
  if (awake_ < 1) fall_asleep();
}

}  // namespace im2fit::body
