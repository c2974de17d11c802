// SPDX-License-Identifier: Apache-2.0
#include "garment/drape/outfit.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <utility>

#include "body/model_data.h"
#include "garment/drape/dressing_pose.h"

namespace im2fit::body {
namespace {

constexpr int kPutOnFrames = 10;     // from a flat body to a whole one
constexpr int kFlatFrames = 7;       // of them with panels that face front and back
constexpr int kHangFrames = 2;       // until folds have fallen
constexpr int kPoseFrames = 8;       // from the dressing pose to another
constexpr int kRoughRestFrames = 6;  // until it hangs
constexpr int kSettleFrames = 2;     // of the finer mesh, until its own folds have formed
constexpr float kPutOnDamping = 12;  // per second
constexpr float kFirstDepth = 0.02F;
// Arms and trunk begin thin, so that a small size goes over them; thighs would slip beside the crotch.
constexpr float kFirstSideways = 0.7F;
constexpr float kBeltShare = 0.98F;  // of the body's girth where the band lies
constexpr float kLayerMm = 6;        // half the distance of front and back as they lie flat
// Below the underarm or band front and back stand apart like a lens, a side seam its rim: cloth wider than its wearer
// then closes into a tube, and its front does not fall through its back.
constexpr float kLensSlope = 0.5F, kLensMm = 90, kLensFromMm = 150, kLensWaistMm = 50, kLensSleeve = 0.6F;
constexpr float kTrunkTurnsMm = 150;  // below the underarm, as far as a sleeve that is raised takes the side along
constexpr float kWornMm = 3;          // cloth on cloth stands off by so much
constexpr float kWornMaxMm = 4;       // looser cloth below is pressed flat, or hidden
constexpr float kSlopeMm = 5;         // over an edge of the body's mesh
constexpr int kSlopePasses = 4;
constexpr float kHiddenReachMm = 60;  // farther cloth hides nothing: it lies before it anyway
constexpr float kHiddenRimMm = 40;    // skin nearer to a hem may be seen
constexpr float kHiddenClothRimMm = 10;
constexpr float kHiddenCosine = 0.2F;
constexpr float kHiddenAsideMm = 30;
constexpr float kCrumpledMm = 16;  // more than an edge of the mesh
constexpr float kPressMm = 2, kPressAsideMm = 45;
constexpr float kLiftedOffSkinMm = 2;  // of the places shown: half of what cloth keeps, see Cloth::kSkinMm
constexpr int kRimPasses = 8;          // that smooth the rims shown
constexpr float kSkinBehindMm = 20;    // skin that stands farther out of cloth is seen
constexpr float kClothBehindMm = 40;   // cloth may stand so far out of the garment over it

std::size_t at(Segment s) {
  return static_cast<std::size_t>(s);
}

// Whatever their translations.
bool stands_alike(const Pose& a, const Pose& b) {
  for (std::size_t s = 0; s < a.rotation.size(); ++s)
    if (a.rotation[s].m != b.rotation[s].m) return false;
  return true;
}

float smooth(float share) {
  return share * share * (3 - 2 * share);
}

// Trousers do not lie flat: the crotch's extensions reach under the body, half of them from the front, half from the
// back. How far front and back stand apart at a place of the pattern.
class CrotchDepth {
 public:
  explicit CrotchDepth(const GarmentMesh& mesh) {
    for (const Flat& f : mesh.flat) {
      if (f.x < inner_x_) {
        inner_x_ = f.x;
        crotch_y_ = f.y;
      }
      outer_x_ = std::max(outer_x_, f.x);
      top_y_ = std::max(top_y_, f.y);
    }
    thigh_y_ = crotch_y_ - kThighMm;
    float nearest = 1e30F;
    for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
      if ((mesh.border[v] & kOnSeam) == 0 || std::fabs(mesh.flat[v].y - thigh_y_) > kGarmentEdgeMm) continue;
      if (mesh.flat[v].x < nearest) nearest = mesh.flat[v].x;
    }
    thigh_x_ = nearest < 1e29F ? nearest : 0;
  }
  float half_mm(Flat f) const {
    const float extension = -inner_x_;
    const float along = std::clamp((crotch_y_ - f.y) / (crotch_y_ - thigh_y_), 0.0F, 1.0F);
    const float inner = f.y < crotch_y_ ? inner_x_ * (1 - along) + along * thigh_x_
                                        : inner_x_ * std::max(0.0F, 1 - (f.y - crotch_y_) / kThighMm * 2.5F);
    const float seat_y = crotch_y_ + kThighMm * 0.4F;
    const float up = f.y > seat_y ? std::max(0.0F, 1 - (f.y - seat_y) / (top_y_ - seat_y)) : 1.0F;
    const float outwards = extension * std::max(0.0F, 1 - std::max(0.0F, f.x) / outer_x_);
    const float depth = std::min(std::min(f.x - inner, extension), outwards) * (1 - along) * up;
    return std::max(kLayerMm, depth);
  }

 private:
  static constexpr float kThighMm = 300;  // below the crotch a leg is a flat tube
  float inner_x_ = 0, crotch_y_ = 0, outer_x_ = 1, top_y_ = -1e9F, thigh_y_ = 0, thigh_x_ = 0;
};

}  // namespace

Outfit::Outfit(const BodyModel& model, std::vector<Piece> pieces)
    : model_(model),
      surface_(model,
               std::any_of(pieces.begin(), pieces.end(), [](const Piece& p) { return reaches_hand(p.rough); })) {
  std::size_t most = 0;
  for (Piece& piece : pieces) {
    meshes_.push_back(std::make_unique<GarmentMesh>(std::move(piece.mesh)));
    rough_meshes_.push_back(std::make_unique<GarmentMesh>(std::move(piece.rough)));
    cloths_.push_back(std::make_unique<Cloth>(*meshes_.back(), piece.fabric));
    rough_.push_back(std::make_unique<Cloth>(*rough_meshes_.back(), piece.fabric, Cloth::kRoughSubsteps));
    refinements_.emplace_back(*rough_meshes_.back(), *meshes_.back());
    add_seam_distances_mm(*rough_meshes_.back(), to_seam_mm_);
    if (piece.moving) {
      moving_meshes_.push_back(std::make_unique<GarmentMesh>(std::move(*piece.moving)));
      moving_.push_back(std::make_unique<Cloth>(*moving_meshes_.back(), piece.fabric, Cloth::kRoughSubsteps));
      from_moving_.emplace_back(*moving_meshes_.back(), *meshes_.back());
    }
    most = std::max(most, meshes_.back()->vertex_count());
  }
  belt_mm_.resize(cloths_.size());
  const auto all = static_cast<std::size_t>(model.vertex_count());
  rest_.resize(all);
  posed_.resize(all);
  drawn_.resize(static_cast<std::size_t>(model.body_vertex_count()));
  axes_.resize(drawn_.size());
  clearance_mm_.resize(drawn_.size());
  flat_.reserve(most);
  boxes_.reserve(most / (4 * kBlock) + 1);
  groups_.reserve(most / (4 * kBlock * kBlock) + 1);
  level_.reserve(drawn_.size());
  hull_points_.reserve(drawn_.size());
  hull_.reserve(drawn_.size());
}

Outfit::~Outfit() = default;

Outfit::Piece Outfit::piece(const GarmentPattern& pattern, const CutBody& body, const Fabric& fabric, bool moves) {
  return {sew(pattern, body), sew(pattern, body, kRoughEdgeMm), fabric,
          moves ? std::optional(sew(pattern, body, kMovingEdgeMm)) : std::nullopt};
}

void Outfit::skin_body(const Pose& pose) {
  pose_ = pose;
  pose_.translation_mm = {};
  body::skin(model_, rest_, skeleton_, pose_, posed_);
}

// Adds the distance of worn cloth from the skin, spread as slopes: cloth over it does not catch on its edges.
void Outfit::add_clearance(const Cloth& cloth) {
  for (std::size_t v = 0; v < cloth.mesh().vertex_count(); ++v) {
    const SkinPlace& place = cloth.contacts()[v];
    if (place.triangle < 0) continue;
    const float off = dot(cloth.position(v) - surface_.at(place, true), surface_.facing(place, true));
    const float over = std::clamp(off - Cloth::kSkinMm + kWornMm, 0.0F, kWornMaxMm);
    for (const std::int32_t corner : surface_.triangles()[static_cast<std::size_t>(place.triangle)])
      clearance_mm_[static_cast<std::size_t>(corner)] =
          std::max(clearance_mm_[static_cast<std::size_t>(corner)], over);
  }
  for (int pass = 0; pass < kSlopePasses; ++pass)
    for (const auto& t : surface_.triangles()) {
      float& a = clearance_mm_[static_cast<std::size_t>(t[0])];
      float& b = clearance_mm_[static_cast<std::size_t>(t[1])];
      float& c = clearance_mm_[static_cast<std::size_t>(t[2])];
      const float slope = std::max(a, std::max(b, c)) - kSlopeMm;
      a = std::max(a, slope);
      b = std::max(b, slope);
      c = std::max(c, slope);
    }
}

void Outfit::run(const Cloths& cloths, const Pose& pose) {
  if (surface_.moved_mm() > 0 || !stands_alike(pose, pose_)) {
    skin_body(pose);
    surface_.advance(posed_);
  }
  ClothFrame frame;
  frame.may_sleep = true;
  std::fill(clearance_mm_.begin(), clearance_mm_.end(), 0.0F);
  for (std::size_t i = 0; i < cloths.size(); ++i) {
    cloths[i]->run(surface_, frame, i == 0 ? std::span<const float>() : clearance_mm_);
    if (i + 1 < cloths.size()) add_clearance(*cloths[i]);
  }
}

void Outfit::move(const Cloths& cloths, const Pose& pose, int frames) {
  const Pose from = pose_;
  for (int i = 1; i <= frames; ++i)
    run(cloths, i == frames ? pose : between(from, pose, smooth(static_cast<float>(i) / static_cast<float>(frames))));
}

void Outfit::frame(const Pose& pose) {
  run(cloths_, pose);
}

void Outfit::move_to(const Pose& pose, int frames) {
  move(cloths_, pose, frames);
}

void Outfit::place_flat(Cloth& cloth, std::span<const float> seam_mm, const PosedSkeleton& bones) {
  const GarmentMesh& mesh = cloth.mesh();
  const Vec3f shoulder = bones.head[at(Segment::left_upper_arm)], hip = bones.head[at(Segment::left_upper_leg)];
  const Vec3f middle = bones.head[at(Segment::pelvis)];
  constexpr float kRaised = kRaisedArmSine / kRaisedArmCosine, kSpread = kSpreadLegSine / kSpreadLegCosine;
  // A pattern is drawn at other angles than a body is dressed at: its sleeves and legs are pushed over to those.
  constexpr float kSleeveUp = kSleeveSine / kSleeveCosine - kRaised, kLegOut = kSpread - kLegTangent;
  constexpr float kSleeveLonger = kRaisedArmCosine / kSleeveCosine - 1;
  const float shoulder_x = mesh.body[static_cast<std::size_t>(CutMeasure::shoulder_x)];
  // The sleeve's middle line falls on the arm's: a pattern's shoulder joint may lie farther out than the body's.
  const float out = shoulder.x - middle.x - shoulder_x;
  const float up = mesh.hang == Hang::shoulders ? shoulder.y + kRaised * out : hip.y;
  const float z = mesh.hang == Hang::shoulders ? shoulder.z : hip.z;
  const CrotchDepth crotch(mesh);
  flat_.clear();
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const Flat f = mesh.flat[v];
    float x = f.x, y = f.y;
    float half = kLayerMm;
    if (mesh.legs) {
      half = crotch.half_mm(f);
      x = mesh.side[v] == 0 ? 0.0F : std::max(x + kLegOut * std::max(0.0F, -y), 2.0F);
    }
    if (mesh.hang == Hang::shoulders) {
      // All of a sleeve, its low cuff too, is pushed over and keeps its length: else it begins in ruffles.
      const float above_mm =
          (x - mesh.underarm.x) * kSleeveSine + (y - mesh.underarm.y) * kSleeveCosine;  // the underarm, across
      const float along = std::max(0.0F, x - shoulder_x) * std::clamp(above_mm / kTrunkTurnsMm + 1, 0.0F, 1.0F);
      y += along * (kSleeveUp - kRaised * kSleeveLonger);
      x += along * kSleeveLonger;
    }
    if (!mesh.legs) {
      const bool hangs = mesh.hang == Hang::shoulders;
      const float below = std::clamp(((hangs ? mesh.underarm.y : -kLensWaistMm) - f.y) / kLensFromMm, 0.0F, 1.0F);
      const float sleeve = hangs ? std::clamp((f.x - mesh.underarm.x) / kLensFromMm, 0.0F, kLensSleeve) : 0.0F;
      half += std::max(below, sleeve) * std::min(kLensSlope * seam_mm[v], kLensMm);
    }
    const float toward = mesh.layer[v] == kFrontLayer ? half : mesh.layer[v] == kBackLayer ? -half : 0.0F;
    const float side = mesh.side[v] < 0 ? -1.0F : 1.0F;
    flat_.push_back({middle.x + side * x, y + up, z + toward});
  }
  cloth.place(flat_);
}

// A tape round the trunk at the mean height of the band.
float Outfit::girth_at_band(const Cloth& cloth, const PosedSkeleton& bones) {
  const GarmentMesh& mesh = cloth.mesh();
  float sum = 0, count = 0;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    if ((mesh.border[v] & kOnOpening) == 0) continue;
    sum += mesh.flat[v].y;
    ++count;
  }
  if (count == 0) return 0;
  const float level = bones.head[at(Segment::left_upper_leg)].y + sum / count;
  const auto on_arm = [&](std::int32_t v) { return (surface_.limbs(v) & (kLeftArm | kRightArm)) != 0; };
  level_.clear();
  for (const auto& t : surface_.triangles()) {
    if (on_arm(t[0]) || on_arm(t[1]) || on_arm(t[2])) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3f a = posed_[static_cast<std::size_t>(t[k])], b = posed_[static_cast<std::size_t>(t[(k + 1) % 3])];
      // Two triangles share an edge and pass it in opposite directions: one of them adds it.
      if (a.y < level && b.y >= level) level_.push_back(a + (b - a) * ((level - a.y) / (b.y - a.y)));
    }
  }
  hull_.convex_hull(level_, level_plane(level), hull_points_);
  return static_cast<float>(perimeter_mm(hull_points_));
}

// A flat body grows between the panels until it fills them.
void Outfit::put_on(std::size_t index) {
  Cloth& cloth = *rough_[index];
  const Pose pose = dressing_pose(skeleton_);
  skin_body(pose);
  const PosedSkeleton bones = pose_skeleton(skeleton_, pose_);
  bone_axes(model_, bones, posed_, axes_);
  std::size_t first = 0;
  for (std::size_t i = 0; i < index; ++i) first += rough_[i]->mesh().vertex_count();
  place_flat(cloth, std::span(to_seam_mm_).subspan(first), bones);
  DrawnIn drawn;
  drawn.middle_z = cloth.mesh().hang == Hang::shoulders ? bones.head[at(Segment::left_upper_arm)].z
                                                        : bones.head[at(Segment::left_upper_leg)].z;
  const bool waist = cloth.mesh().hang == Hang::waist;
  const float sideways = waist ? 1.0F : kFirstSideways;
  belt_mm_[index] = waist ? kBeltShare * girth_at_band(cloth, bones) : 1e9F;
  cloth.close_belt(belt_mm_[index]);
  for (int i = 0; i <= kPutOnFrames; ++i) {
    const float share = static_cast<float>(i) / kPutOnFrames;
    drawn.depth = kFirstDepth + (1 - kFirstDepth) * share;
    drawn.sideways = sideways + (1 - sideways) * share;
    draw_in(drawn, axes_, posed_, drawn_);
    if (i == 0) {
      surface_.put(drawn_);
      continue;
    }
    surface_.advance(drawn_);
    ClothFrame frame;
    frame.weightless = true;
    frame.flat = i <= kFlatFrames;
    frame.damping_per_s = kPutOnDamping;
    cloth.run(surface_, frame);
  }
  surface_.put(posed_);
  if (waist) cloth.hold_belt(surface_, bones.head[at(Segment::left_upper_leg)].y);
  for (int i = 0; i < kHangFrames; ++i) cloth.run(surface_, {}, clearance_mm_);
  add_clearance(cloth);
}

void Outfit::turn_rough(const Mat3f& rotation, Vec3f about) {
  for (auto& cloth : rough_) {
    flat_.clear();
    for (std::size_t v = 0; v < cloth->mesh().vertex_count(); ++v)
      flat_.push_back(about + rotation * (cloth->position(v) - about));
    cloth->carry(flat_);
  }
}

void Outfit::dress(std::span<const Vec3f> rest, const Skeleton& skeleton, const Pose& pose) {
  assert(rest.size() == rest_.size());
  std::copy(rest.begin(), rest.end(), rest_.begin());
  skeleton_ = skeleton;
  std::fill(clearance_mm_.begin(), clearance_mm_.end(), 0.0F);
  for (std::size_t i = 0; i < rough_.size(); ++i) put_on(i);
  // A person seen from behind is not turned about within the cloth: everything turns with the pelvis first.
  const Mat3f& pelvis = pose.rotation[at(Segment::pelvis)];
  Pose start = dressing_pose(skeleton_);
  turn_rough(pelvis, skeleton_.head[at(Segment::pelvis)]);
  for (Mat3f& r : start.rotation) r = pelvis * r;
  skin_body(start);
  surface_.put(posed_);
  move(rough_, pose, kPoseFrames);
  for (int i = 0; i < kRoughRestFrames; ++i) run(rough_, pose);
  refine();
  for (int i = 0; i < kSettleFrames; ++i) frame(pose);
}

// From the rough meshes to those that are shown.
void Outfit::refine() {
  for (std::size_t i = 0; i < cloths_.size(); ++i) {
    rough_[i]->update_normals();
    flat_.resize(meshes_[i]->vertex_count());
    refinements_[i].places(*rough_[i], flat_);
    cloths_[i]->place(flat_);
    cloths_[i]->close_belt(belt_mm_[i]);
    cloths_[i]->hold_belt_here(surface_);
  }
}

void Outfit::FourBoxes::take(std::size_t lane, Vec3f p) {
  const std::array<float, 3> at = {p.x, p.y, p.z};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    low[axis][lane] = std::min(low[axis][lane], at[axis]);
    high[axis][lane] = std::max(high[axis][lane], at[axis]);
  }
}

// A little less, so that a box is not passed by for the last bit.
inline Int4 Outfit::FourBoxes::within(Vec3f p, float squared) const {
  constexpr float kRounding = 0.999F;
  const std::array<float, 3> at = {p.x, p.y, p.z};
  Float4 sum = {};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Float4 least, most;
    std::memcpy(&least, low[axis].data(), sizeof least);
    std::memcpy(&most, high[axis].data(), sizeof most);
    const Float4 before = least - all_of(at[axis]), beyond = all_of(at[axis]) - most, none = {};
    Float4 off = before > beyond ? before : beyond;
    off = off > none ? off : none;
    sum += off * off;
  }
  return sum * all_of(kRounding) <= all_of(squared);
}

void Outfit::keep_moving_alone() {
  assert(can_move());
  for (std::size_t i = 0; i < cloths_.size(); ++i) {
    std::vector<Vec3f> places(moving_meshes_[i]->vertex_count());
    cloths_[i]->update_normals();
    Refinement(*meshes_[i], *moving_meshes_[i]).places(*cloths_[i], places);
    moving_[i]->place(places);
    moving_[i]->close_belt(belt_mm_[i]);
    moving_[i]->hold_belt_here(surface_);
    moving_[i]->update_normals();
  }
  cloths_ = std::move(moving_);  // before the meshes: cloth refers to them
  rough_.clear();
  meshes_ = std::move(moving_meshes_);
  rough_meshes_.clear();
  moving_.clear();
  moving_meshes_.clear();
  refinements_.clear();
  from_moving_.clear();
}

void Outfit::box(const Cloth& cloth) const {
  boxes_.clear();
  groups_.clear();
  for (std::size_t c = 0; c < cloth.mesh().vertex_count(); ++c) {
    const Vec3f p = cloth.position(c);
    const std::size_t box = c / kBlock, group = box / kBlock;
    if (c % (4 * kBlock) == 0) boxes_.push_back({});
    if (c % (4 * kBlock * kBlock) == 0) groups_.push_back({});
    boxes_.back().take(box % 4, p);
    groups_.back().take(group % 4, p);
  }
}

template <class F>
void Outfit::near(const Cloth& cloth, Vec3f p, const float& best, F consider) const {
  const std::size_t count = cloth.mesh().vertex_count();
  // Calls `look` with each box of `four` that may hold a vertex so near.
  const auto each = [&](const std::vector<FourBoxes>& all, std::size_t four, auto look) {
    const Int4 within = all[four].within(p, best);
    if ((within[0] | within[1] | within[2] | within[3]) == 0) return;
    for (std::size_t lane = 0; lane < 4; ++lane)
      if (within[lane] != 0) look(4 * four + lane);
  };
  for (std::size_t g = 0; g < groups_.size(); ++g)
    each(groups_, g, [&](std::size_t group) {
      const std::size_t fours_end = std::min(boxes_.size(), (group + 1) * kBlock / 4);
      for (std::size_t four = group * kBlock / 4; four < fours_end; ++four)
        each(boxes_, four, [&](std::size_t box) {
          const std::size_t end = std::min(count, (box + 1) * kBlock);
          for (std::size_t c = box * kBlock; c < end; ++c) consider(c);
        });
    });
}

// A place at `p` with normal `n` is hidden by the nearest cloth that faces the same way, if it lies no more than
// `behind_mm` before that cloth; cloth near a hem does not hide it. An arm beside the trunk is hidden by its sleeve
// alone. `hint`: the vertex that hid the previous place, most often near to this one; updated.
bool Outfit::hides(const Cloth& cloth, Vec3f p, Vec3f n, std::uint8_t limbs, float behind_mm, float crumpled_mm,
                   float rim_mm, std::size_t& hint) const {
  const GarmentMesh& mesh = cloth.mesh();
  const bool arm = (limbs & kTrunk) == 0 && (limbs & (kLeftArm | kRightArm)) != 0;
  float best = kHiddenReachMm * kHiddenReachMm, rim = 0;
  std::size_t found = 0;  // of vertices equally near the first
  const auto consider = [&](std::size_t c) {
    const Vec3f d = cloth.position(c) - p;
    const float squared = dot(d, d);
    if (squared > best || (squared == best && c >= found) || (cloth.limbs(c) & limbs) == 0) return;
    const float before = dot(d, n);
    // Crumpled cloth that is so near hides and is hidden whichever way it faces.
    const bool facing = dot(cloth.normals()[c], n) >= kHiddenCosine || squared < crumpled_mm * crumpled_mm;
    if (!facing || squared - before * before > kHiddenAsideMm * kHiddenAsideMm) return;
    best = squared;
    found = c;
    const bool sleeve = !arm || (cloth.limbs(c) & kTrunk) == 0;
    rim = before > -behind_mm && sleeve ? mesh.rim_mm[c] : 0;
  };
  consider(hint);
  near(cloth, p, best, consider);
  hint = found;
  return rim > rim_mm;
}

void Outfit::hidden_skin(std::span<std::uint8_t> out, float more_mm) const {
  assert(out.size() >= drawn_.size());
  std::fill(out.begin(), out.end(), std::uint8_t{0});
  for (const auto& cloth : cloths_) {
    box(*cloth);
    std::size_t hint = 0;
    for (const std::int32_t v : surface_.vertices()) {
      const auto i = static_cast<std::size_t>(v);
      if (out[i] == 0 && hides(*cloth, posed_[i], surface_.normal(true)[i], surface_.limbs(v), kSkinBehindMm, 0,
                               kHiddenRimMm + more_mm, hint))
        out[i] = 1;
    }
  }
}

// Cloth that skin would pull apart lies within the skin and is shown on it, but not in folds, which have no room.
Vec3f Outfit::lifted(std::size_t index, std::size_t v, Vec3f p) const {
  const Cloth& cloth = *cloths_[index];
  const SkinPlace& place = cloth.contacts()[v];
  if (place.triangle < 0 || cloth.pinched()[v] != 0) return p;
  const float off_mm = index == 0 ? kLiftedOffSkinMm : kLiftedOffSkinMm + kPressMm;
  const Vec3f facing = surface_.facing(place, true);
  const float off = dot(p - surface_.at(place, true), facing);
  return off < off_mm && off > -kSkinBehindMm ? p + facing * (off_mm - off) : p;
}

// Towards the cubic of RimSpan: hems and bands are stiffer than a simulation of edges makes them.
void Outfit::smooth_rims(const Cloth& cloth, std::span<Vec3f> places) {
  float sum = 0;
  for (const float factor : kRimFactor) sum += factor * factor;
  for (int pass = 0; pass < kRimPasses; ++pass)
    for (const RimSpan& rim : cloth.constraints().rims) {
      Vec3f off{};
      for (std::size_t k = 0; k < 5; ++k) off = off + places[static_cast<std::size_t>(rim.vertex[k])] * kRimFactor[k];
      for (std::size_t k = 0; k < 5; ++k) {
        Vec3f& place = places[static_cast<std::size_t>(rim.vertex[k])];
        place = place - off * (kRimFactor[k] / sum);
      }
    }
}

void Outfit::shown(std::size_t index, std::span<Vec3f> out) const {
  const Cloth& cloth = *cloths_[index];
  assert(out.size() >= cloth.mesh().vertex_count());
  for (std::size_t v = 0; v < cloth.mesh().vertex_count(); ++v) out[v] = cloth.position(v);
  smooth_rims(cloth, out);
  for (std::size_t v = 0; v < cloth.mesh().vertex_count(); ++v) out[v] = lifted(index, v, out[v]);
  for (std::size_t over = index + 1; over < cloths_.size(); ++over) {
    const Cloth& upper = *cloths_[over];
    box(upper);
    std::size_t found = 0;
    for (std::size_t v = 0; v < cloth.mesh().vertex_count(); ++v) {
      const Vec3f p = out[v], n = cloth.normals()[v];
      float best = kClothBehindMm * kClothBehindMm + kPressAsideMm * kPressAsideMm;
      const std::size_t hint = std::exchange(found, upper.mesh().vertex_count());
      const auto consider = [&](std::size_t c) {
        const Vec3f d = upper.position(c) - p;
        const float squared = dot(d, d);
        if (squared > best || (squared == best && c >= found) || (upper.limbs(c) & cloth.limbs(v)) == 0 ||
            dot(upper.normals()[c], n) < kHiddenCosine)
          return;
        best = squared;
        found = c;
      };
      consider(hint < upper.mesh().vertex_count() ? hint : 0);
      near(upper, p, best, consider);
      if (found == upper.mesh().vertex_count()) continue;
      const Vec3f facing = upper.normals()[found], d = lifted(over, found, upper.position(found)) - p;
      const float over_mm = kPressMm - dot(d, facing);
      const float aside = std::sqrt(std::max(0.0F, dot(d, d) - dot(d, facing) * dot(d, facing)));
      if (over_mm <= 0 || aside >= kPressAsideMm) continue;
      float by_mm = over_mm * std::min(1.0F, 2 * (1 - aside / kPressAsideMm));
      const SkinPlace& place = cloth.contacts()[v];
      const Vec3f skin = place.triangle >= 0 ? surface_.facing(place, true) : Vec3f{};
      const float slope = dot(facing, skin);
      if (slope > 0) {
        const float off = dot(p - surface_.at(place, true), skin) - kLiftedOffSkinMm;
        by_mm = std::min(by_mm, std::max(0.0F, off) / slope);
      }
      out[v] = p - facing * by_mm;
    }
  }
}

void Outfit::hidden_cloth(std::size_t index, std::span<std::uint8_t> out, float more_mm) const {
  const Cloth& cloth = *cloths_[index];
  assert(out.size() >= cloth.mesh().vertex_count());
  std::fill(out.begin(), out.end(), std::uint8_t{0});
  for (std::size_t over = index + 1; over < cloths_.size(); ++over) {
    box(*cloths_[over]);
    std::size_t hint = 0;
    for (std::size_t v = 0; v < cloth.mesh().vertex_count(); ++v)
      if (out[v] == 0 && hides(*cloths_[over], cloth.position(v), cloth.normals()[v], cloth.limbs(v), kClothBehindMm,
                               kCrumpledMm, kHiddenClothRimMm + more_mm, hint))
        out[v] = 1;
  }
}

}  // namespace im2fit::body
