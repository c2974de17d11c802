// SPDX-License-Identifier: Apache-2.0
#include "perception/observe/arm_gap.h"

#include <algorithm>
#include <array>
#include <cmath>

// The thresholds of this file: where a gap between arm and trunk is looked for, and what counts as one. Sources:
//   [ansur]  6,068 people of ANSUR II, between trochanter and acromion less 40 mm: buttock -.03 (SD .03), navel .31
//            (.04), midway from lowest rib to iliac crest .38 men, .40 women (.03), chest .76 (.04), crotch -.12
//            (.04), wrist of a hanging arm -.11 (.08)
//   [start]  330 starts of eight real people with hanging arms, 320x240 at 2.9 m: joined in all of 14,039 frames; 11
//   of
//            12 frames with arms apart are not
//   [eval]   200 people of im2fit-lab eval with arms 12 to 25 degrees off the body: 199 measured, 195 in clothes;
//   those
//            who are not do touch
//   [joints] one joint error (25 mm of shoulders and hips, 100 mm of hands): docs/tracker-evaluation.md
namespace im2fit::arm_gap_limits {

// Bands of the trunk, in shares of the way from the hip joints up to the shoulder joints. A band that is moved off
// its girth accepts people whose arm touches just there.
constexpr float kHipLow = -0.08F, kHipHigh = 0.12F;     // [ansur]
constexpr float kWaistLow = 0.25F, kWaistHigh = 0.45F;  // [ansur]
constexpr int kRows = 26;  // looked at from the waist's upper end to the hips' lower: 10 mm apart
// Of a band's rows that are seen, the share that must show a gap. Lower: wrinkles of sleeves open a gap for a row
// ([start]); higher: wrists bent inwards close one that is wide enough.
constexpr float kApartShareMin = 0.5F;
constexpr int kRowsMin = 3;  // seen in a band, least; with fewer, the band is not judged

constexpr float kNearMm = 200.0F;  // no camera of ours measures nearer (body/fit/sight.cpp)
constexpr float kTorsoMinMm = 250.0F,
                kTorsoMaxMm = 900.0F;  // hips to shoulders; beyond, no joints of a person

// Widths, mm.
constexpr float kStartMm = 40.0F;       // from the spine to the first pixel with data, most: holes
constexpr float kGapMinMm = 15.0F;      // without the person between trunk and arm; a shadow of a structured
                                        // light sensor within one person is 5 mm; [start]
constexpr int kGapMinPx = 2;            // and in pixels: one is noise at outlines; [start]
constexpr float kStepMm = 70.0F;        // in depth, away from the camera: the arm is behind the trunk's edge
                                        // (kContourStepQ4 of kernels/contour)
constexpr float kArmMinMm = 25.0F;      // of an arm's piece, least: less is an outline's noise; half a wrist
constexpr float kTrunkMinMm = 80.0F;    // of the trunk's half width, least: holes nearer to the spine are none;
                                        // the slimmest waist measures 100
constexpr float kSearchMaxMm = 700.0F;  // from the spine: beyond, nothing of the arm hangs

// Of the lowest rows with a gap, the mean width above which the hand ends beside the hips, in the air: a hand that
// lies on the hip closes its gap row by row, by 10 mm each.
constexpr float kHandOutMm = 50.0F;
constexpr int kLowestRows = 3;

// Arms that are not beside the trunk at all.
constexpr float kAwayMin = 0.5F;   // outwards of the shoulder joint, in torso lengths: an upper arm raised
                                   // by 55 degrees or more; [joints]
constexpr float kAwayLow = 0.5F;   // rows where that is looked for, from ...
constexpr float kAwayHigh = 1.3F;  // ... to
constexpr int kAwayRows = 9;       // 50 mm apart

}  // namespace im2fit::arm_gap_limits

namespace im2fit {

using namespace arm_gap_limits;

namespace {

// Outwards in the picture.
enum class Way : int { left = -1, right = 1 };

enum class Kind {
  unseen,   // outside the picture, or without data at the spine
  gap,      // trunk, then background or a step backwards, then a piece of an arm
  bare,     // one piece, then background: trunk alone, or trunk and arm joined
  overlap,  // a step forwards: something hides the trunk's edge
};
struct RowSays {
  Kind kind = Kind::unseen;
  float gap_mm = 0;  // from the trunk's edge to the arm
};

struct Band {
  int gap = 0, bare = 0, overlap = 0;  // rows
  void add(Kind kind) {
    gap += kind == Kind::gap ? 1 : 0;
    bare += kind == Kind::bare ? 1 : 0;
    overlap += kind == Kind::overlap ? 1 : 0;
  }
  int seen() const { return gap + bare + overlap; }
  bool judged() const { return seen() >= kRowsMin; }
  bool apart() const { return static_cast<float>(gap) >= kApartShareMin * static_cast<float>(seen()); }
};

class Arms {
 public:
  Arms(DepthView depth, MaskView mask, const Intrinsics& k, const JointSet& joints)
      : depth_(depth), mask_(mask), k_(k), joints_(joints) {
    hips_ = (joints[Joint::LH] + joints[Joint::RH]) * 0.5F;
    torso_ = (joints[Joint::LS] + joints[Joint::RS]) * 0.5F - hips_;
    length_mm_ = norm(torso_);
  }
  bool has_torso() const { return length_mm_ >= kTorsoMinMm && length_mm_ <= kTorsoMaxMm; }

  bool joined(Way way, Joint shoulder) const {
    Band waist, hip;
    std::array<float, kLowestRows> lowest{};  // gaps, the lowest last
    for (int i = 0; i < kRows; ++i) {
      const float share = share_of(kWaistHigh, kHipLow, i, kRows);
      const RowSays says = row(way, share);
      if (share >= kWaistLow) waist.add(says.kind);
      if (share <= kHipHigh) hip.add(says.kind);
      if (says.kind != Kind::gap) continue;
      std::copy(lowest.begin() + 1, lowest.end(), lowest.begin());
      lowest.back() = says.gap_mm;
    }
    if (waist.judged() && !waist.apart()) return waist.overlap > 0 || !away(way, shoulder);
    if (!hip.judged() || hip.apart()) return false;
    if (hip.overlap * 2 > hip.seen()) return true;
    float sum = 0;
    for (const float gap : lowest) sum += gap;
    return sum < kHandOutMm * static_cast<float>(kLowestRows) && !away(way, shoulder);
  }

 private:
  struct Start {
    bool seen = false;
    int u = 0, v = 0;
    float z_mm = 0;
    float mm_per_px = 0;
  };
  // The pixel of the spine at a height, or the nearest beside it.
  Start start(float share) const {
    const Vec3f p = hips_ + torso_ * share;
    Start s;
    if (!(p.z > kNearMm)) return s;
    const float u = k_.fx * p.x / p.z + k_.cx, v = k_.fy * p.y / p.z + k_.cy;
    if (!(u >= 0 && v >= 0 && u < static_cast<float>(mask_.width) && v < static_cast<float>(mask_.height))) return s;
    s.v = static_cast<int>(v);
    s.mm_per_px = p.z / k_.fx;
    const int reach = static_cast<int>(kStartMm / s.mm_per_px);
    for (int d = 0; d <= reach && !s.seen; ++d) {
      for (const int at : {static_cast<int>(u) - d, static_cast<int>(u) + d}) {
        if (z_at(at, s.v) <= 0) continue;
        s.seen = true;
        s.u = at;
        s.z_mm = z_at(at, s.v);
        break;
      }
    }
    return s;
  }

  static float share_of(float low, float high, int i, int count) {
    return low + (high - low) * (static_cast<float>(i) / static_cast<float>(count - 1));
  }
  // The nearest of the picture.
  int column(float u) const {
    return static_cast<int>(std::fmax(0.0F, std::fmin(static_cast<float>(mask_.width - 1), u)));
  }

  // 0 outside the person.
  float z_at(int u, int v) const {
    if (u < 0 || u >= mask_.width || mask_.at(u, v) == 0) return 0;
    return static_cast<float>(depth_.at(u, v));
  }

  RowSays row(Way way, float share) const {
    const Start s = start(share);
    if (!s.seen) return {};
    const int step = static_cast<int>(way);
    const int reach = static_cast<int>(kSearchMaxMm / s.mm_per_px);
    const int gap_min = std::max(kGapMinPx, static_cast<int>(std::ceil(kGapMinMm / s.mm_per_px)));
    const int trunk_min = static_cast<int>(kTrunkMinMm / s.mm_per_px);
    const int arm_min = std::max(2, static_cast<int>(kArmMinMm / s.mm_per_px));
    float last = s.z_mm;
    int hole = 0, piece = 0;
    bool beyond = false;  // the trunk's edge is behind us
    int edge_at = 0;      // it
    for (int i = 1; i <= reach; ++i) {
      const int u = s.u + i * step;
      // An arm that leaves the picture is SIDE_CUT's.
      if (u < 0 || u >= mask_.width) return {beyond || hole > 0 ? Kind::bare : Kind::unseen};
      const float z = z_at(u, s.v);
      if (z <= 0) {
        ++hole;
        piece = 0;
        continue;
      }
      if (!beyond) {
        const bool wide = i - hole > trunk_min;
        if (wide && (hole >= gap_min || z - last >= kStepMm)) {
          beyond = true;
          edge_at = i - hole;
        } else if (last - z >= kStepMm) {
          return {Kind::overlap};
        }
      }
      hole = 0;
      last = z;
      if (beyond && ++piece >= arm_min) return {Kind::gap, static_cast<float>(i - piece + 1 - edge_at) * s.mm_per_px};
    }
    return {Kind::bare};
  }

  // Something of the person lies far outwards of the shoulder joint at the chest or above: the arm is raised.
  bool away(Way way, Joint shoulder) const {
    const Vec3f joint = joints_[shoulder];
    if (!(joint.z > kNearMm)) return false;
    const float u0 = k_.fx * joint.x / joint.z + k_.cx;
    const float far_px = kAwayMin * length_mm_ * k_.fx / joint.z;
    const float end_px = 2.0F * kAwayMin * length_mm_ * k_.fx / joint.z;
    for (int i = 0; i < kAwayRows; ++i) {
      const Vec3f p = hips_ + torso_ * share_of(kAwayLow, kAwayHigh, i, kAwayRows);
      if (!(p.z > kNearMm)) continue;
      const float v = k_.fy * p.y / p.z + k_.cy;
      if (!(v >= 0 && v < static_cast<float>(mask_.height))) continue;
      const auto sign = static_cast<float>(static_cast<int>(way));
      const float a = u0 + sign * far_px, b = u0 + sign * end_px;
      const int first = column(std::fmin(a, b)), last = column(std::fmax(a, b));
      for (int u = first; u <= last; ++u)
        if (z_at(u, static_cast<int>(v)) > 0) return true;
    }
    return false;
  }

  DepthView depth_;
  MaskView mask_;
  const Intrinsics& k_;
  const JointSet& joints_;
  Vec3f hips_, torso_;
  float length_mm_ = 0;
};

}  // namespace

ArmSet arms_joined(DepthView depth, MaskView mask, const Intrinsics& intrinsics, const JointSet& joints) {
  const Arms arms(depth, mask, intrinsics, joints);
  if (!arms.has_torso()) return 0;
  // A person who faces the camera has the left arm on the picture's right.
  const bool facing = joints[Joint::LS].x + joints[Joint::LH].x > joints[Joint::RS].x + joints[Joint::RH].x;
  ArmSet set = 0;
  if (arms.joined(facing ? Way::right : Way::left, Joint::LS)) set |= kLeftArm;
  if (arms.joined(facing ? Way::left : Way::right, Joint::RS)) set |= kRightArm;
  return set;
}

}  // namespace im2fit
