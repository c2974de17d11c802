// SPDX-License-Identifier: Apache-2.0
#include "perception/observe/surroundings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "perception/profile/person_frame.h"

// The thresholds of this file. Source of all: synthetic rooms and people, 2026-11-30, docs/notebook/limits.md.
namespace im2fit::surroundings_limits {

constexpr int kBendFrames = 8;  // a floor is the same in every frame

constexpr int kGroundAcross = 320;        // pixels read along the picture's long side
constexpr float kFeetTopMm = 120;         // above the lowest of the mask: feet
constexpr float kGroundReachMm = 170;     // from the middle of the feet
constexpr float kFeetAheadMaxMm = 150;    // of the trunk: farther, it is the front of what the person stands on
constexpr float kGroundHalfFloorMm = 12;  // about the floor: its noise
constexpr int kFeetPixelsMin = 10;
constexpr float kGroundMinMm = -60, kGroundBinMm = 5;
constexpr int kGroundBins = 64;
constexpr int kGroundLevelBins = 4;  // of a level

// Heights above the floor: toes, the front of the ankle, the shin above it.
constexpr float kToesFromMm = 15, kToesToMm = 50, kAnkleFromMm = 100, kAnkleToMm = 130, kShinFromMm = 170,
                kShinToMm = 230;
constexpr float kToesBinMm = 5, kToesBehindMm = 400;
constexpr float kToesFarthestShare = 0.97F;  // of their pixels lie behind
constexpr int kFootPixelsMin = 30;           // at each of the three heights, over all frames

constexpr float kAboveFromMm = 8, kAboveToMm = 90;  // the mask's topmost pixels are mixed with what is behind
constexpr float kBesideFromMm = 140, kBesideToMm = 260;
constexpr int kTopRows = 4;

constexpr float kHeadHalfMm = 150;
constexpr float kHeadLongMm = 120;
constexpr std::array<float, 3> kCrownBelowMm = {6, 12, 20};
constexpr int kHeadRowsMax = 256;

}  // namespace im2fit::surroundings_limits

namespace im2fit {

using namespace surroundings_limits;

namespace {

// Heights of ground about the feet, as areas seen from above.
struct GroundLevels {
  std::array<float, kGroundBins> area{};
  float all = 0;

  static float height_of(int bin) { return kGroundMinMm + (static_cast<float>(bin) + 0.5F) * kGroundBinMm; }
  void add(float height, float of_area) {
    const float place = (height - kGroundMinMm) / kGroundBinMm;
    if (!(place >= 0 && place < kGroundBins)) return;
    area[static_cast<std::size_t>(place)] += of_area;
    all += of_area;
  }
  float level(int first) const {
    float sum = 0;
    for (int i = first; i < first + kGroundLevelBins; ++i) sum += area[static_cast<std::size_t>(i)];
    return sum;
  }
  int main_level() const {
    int best = 0;
    for (int i = 1; i + kGroundLevelBins <= kGroundBins; ++i)
      if (level(i) > level(best)) best = i;
    return best;
  }
  float mean_height(int first) const {
    float moment = 0;
    for (int i = first; i < first + kGroundLevelBins; ++i) moment += area[static_cast<std::size_t>(i)] * height_of(i);
    return moment / level(first);
  }
  float at_floor() const {
    float sum = 0;
    for (int i = 0; i < kGroundBins; ++i)
      if (std::fabs(height_of(i)) < kGroundHalfFloorMm) sum += area[static_cast<std::size_t>(i)];
    return sum;
  }
};

Vec3f point_of(DepthView depth, const Intrinsics& k, int u, int v) {
  return unproject(k, static_cast<float>(u), static_cast<float>(v), static_cast<float>(depth.at(u, v)));
}

// The mask's pixels in a row, every `step`th.
template <class See>
void look_at_row(DepthView depth, MaskView mask, const Intrinsics& k, const Person& person, int step, int v,
                 const See& see) {
  for (int u = person.u_min; u <= person.u_max; u += step)
    if (mask.at(u, v) != 0 && depth.at(u, v) != 0) see(point_of(depth, k, u, v));
}

struct Feet {
  Vec3f sum;
  int count = 0;
};

// The mask above its own lowest point: the floor may lie far below. Of the lower half, where few rows have feet.
Feet feet_of(DepthView depth, MaskView mask, const Intrinsics& k, const Person& person, int step) {
  const FloorPlane& floor = person.floor;
  const int first = (person.v_min + person.v_max) / 2;
  constexpr float kNone = std::numeric_limits<float>::max();
  std::array<float, kGroundAcross> lowest_in{};  // of each row: a step makes them fewer
  float lowest = kNone;
  std::size_t row = 0;
  for (int v = first; v <= person.v_max && row < lowest_in.size(); v += step) {
    float in_row = kNone;
    look_at_row(depth, mask, k, person, step, v, [&](Vec3f p) { in_row = std::min(in_row, dot(floor.up, p)); });
    lowest_in[row++] = in_row;
    lowest = std::min(lowest, in_row);
  }
  Feet feet;
  row = 0;
  for (int v = first; v <= person.v_max && row < lowest_in.size(); v += step) {
    if (lowest_in[row++] > lowest + kFeetTopMm) continue;
    look_at_row(depth, mask, k, person, step, v, [&](Vec3f p) {
      if (dot(floor.up, p) > lowest + kFeetTopMm) return;
      feet.sum = feet.sum + p;
      ++feet.count;
    });
  }
  return feet;
}

// The middle of the upper half of the mask, without a pixel: 0.
Vec3f trunk_of(DepthView depth, MaskView mask, const Intrinsics& k, const Person& person, int step) {
  Vec3f sum;
  int count = 0;
  for (int v = person.v_min; v < (person.v_min + person.v_max) / 2; v += 2 * step)
    look_at_row(depth, mask, k, person, 2 * step, v, [&](Vec3f p) {
      sum = sum + p;
      ++count;
    });
  return count > 0 ? sum * (1.0F / static_cast<float>(count)) : sum;
}

// Share of the pixels without depth.
struct LostShare {
  int lost = 0, all = 0;
  void look(DepthView depth, int u_first, int u_last, int v_first, int v_end) {
    for (int v = std::max(0, v_first); v < std::min(depth.height, v_end); ++v)
      for (int u = std::max(0, u_first); u <= std::min(depth.width - 1, u_last); ++u) {
        ++all;
        lost += depth.at(u, v) == 0 ? 1 : 0;
      }
  }
  float share() const { return all > 0 ? static_cast<float>(lost) / static_cast<float>(all) : 0; }
};

}  // namespace

void Surroundings::reset() {
  sum_ = {};
  feet_ = {};
  bends_tried_ = bends_ = grounds_ = heads_ = 0;
}

void Surroundings::add(DepthView depth, MaskView mask, const Intrinsics& k, const Person& person, bool facing) {
  if (person.floor.known && bends_tried_ < kBendFrames) {
    ++bends_tried_;
    const FloorBend one = bend_.run(depth, mask, k, person.floor);
    if (one.known) {
      ++bends_;
      sum_.floor.bend += one.bend;
    }
  }
  if (person.floor.known) add_ground(depth, mask, k, person, facing);
  add_head(depth, mask, k, person);
}

void Surroundings::add_feet(DepthView depth, MaskView mask, const Intrinsics& k, const Person& person, int step,
                            Vec3f middle) {
  const FloorPlane& floor = person.floor;
  const Vec3f ahead = normalized(Vec3f{0, 0, 1} - floor.up * floor.up.z);
  const Vec3f aside = cross(ahead, floor.up);
  const auto see = [&](Vec3f p) {
    const float height = dot(floor.up, p) + floor.camera_height_mm;
    Foot& foot = feet_[dot(aside, p - middle) > 0 ? 1 : 0];
    const float forward = -dot(ahead, p - middle);
    if (height > kToesFromMm && height < kToesToMm) {
      const float bin = (forward + kToesBehindMm) / kToesBinMm;
      if (!(bin >= 0 && bin < kToesBins)) return;
      ++foot.toes[static_cast<std::size_t>(bin)];
      ++foot.toe_count;
    } else if (height > kAnkleFromMm && height < kAnkleToMm) {
      foot.ankle_sum += forward;
      ++foot.ankle_count;
    } else if (height > kShinFromMm && height < kShinToMm) {
      foot.shin_sum += forward;
      ++foot.shin_count;
    }
  };
  for (int v = (person.v_min + person.v_max) / 2; v <= person.v_max; v += step)
    look_at_row(depth, mask, k, person, step, v, see);
}

void Surroundings::judge_feet(SurroundingsSigns& out) const {
  for (const Foot& foot : feet_) {
    if (std::min({foot.toe_count, foot.ankle_count, foot.shin_count}) < kFootPixelsMin) return;
    const float shin = foot.shin_sum / static_cast<float>(foot.shin_count);
    int behind = 0, bin = 0;
    while (static_cast<float>(behind) < kToesFarthestShare * static_cast<float>(foot.toe_count))
      behind += static_cast<int>(foot.toes[static_cast<std::size_t>(bin++)]);
    const float toe = static_cast<float>(bin) * kToesBinMm - kToesBehindMm;
    out.toe_reach_mm += 0.5F * (toe - shin);
    out.ankle_ahead_mm += 0.5F * (foot.ankle_sum / static_cast<float>(foot.ankle_count) - shin);
  }
  out.feet_known = true;
}

void Surroundings::add_ground(DepthView depth, MaskView mask, const Intrinsics& k, const Person& person,
                              bool facing) {
  const FloorPlane& floor = person.floor;
  const int step = std::max(1, (std::max(depth.width, depth.height) + kGroundAcross / 2) / kGroundAcross);
  const Feet feet = feet_of(depth, mask, k, person, step);
  if (feet.count < kFeetPixelsMin) return;
  Vec3f middle = feet.sum * (1.0F / static_cast<float>(feet.count));
  // The front of a platform may be taken for the feet: then these are below the trunk.
  const Vec3f trunk = trunk_of(depth, mask, k, person, step);
  const Vec3f forward = normalized(floor.up * floor.up.z - Vec3f{0, 0, 1});
  const bool ahead = trunk.z > 0 && dot(forward, middle - trunk) > kFeetAheadMaxMm;
  if (ahead) middle = trunk + floor.up * dot(floor.up, middle - trunk);
  if (facing && !ahead) add_feet(depth, mask, k, person, step, middle);
  if (!(middle.z > kGroundReachMm)) return;
  const int reach = static_cast<int>(kGroundReachMm * k.fx / (middle.z - kGroundReachMm)) + 1;
  const int centre_u = static_cast<int>(k.cx + k.fx * middle.x / middle.z);
  const int centre_v = static_cast<int>(k.cy + k.fy * middle.y / middle.z);
  GroundLevels levels;
  // What stands on a high platform lies above its lowest point.
  const int above = ahead ? 2 * reach : reach;
  for (int v = std::max(0, centre_v - above); v <= std::min(depth.height - 1, centre_v + reach); v += step)
    for (int u = std::max(0, centre_u - reach); u <= std::min(depth.width - 1, centre_u + reach); u += step) {
      if (depth.at(u, v) == 0) continue;
      const Vec3f p = point_of(depth, k, u, v);
      const Vec3f away = p - middle;
      const Vec3f level = away - floor.up * dot(floor.up, away);
      if (dot(level, level) > kGroundReachMm * kGroundReachMm) continue;
      const float height = dot(floor.up, p) + floor.camera_height_mm;
      // A pixel of a level surface so high: z^2 / (fx fy) over the sine of the angle at which its ray meets it.
      const float below_camera = floor.camera_height_mm - height;
      if (below_camera > kGroundReachMm) levels.add(height, p.z * p.z * p.z / below_camera);
    }
  if (!(levels.all > 0)) return;
  const int main = levels.main_level();
  ++grounds_;
  sum_.ground_mm += levels.mean_height(main);
  sum_.ground_share += levels.level(main) / levels.all;
  sum_.floor_share += levels.at_floor() / levels.all;
}

void Surroundings::add_head(DepthView depth, MaskView mask, const Intrinsics& k, const Person& person) {
  int first = person.u_max, last = person.u_min;
  float z = 0;
  for (int v = person.v_min; v < std::min(person.v_min + kTopRows, mask.height); ++v)
    for (int u = person.u_min; u <= person.u_max; ++u) {
      if (mask.at(u, v) == 0 || depth.at(u, v) == 0) continue;
      first = std::min(first, u);
      last = std::max(last, u);
      z = static_cast<float>(depth.at(u, v));
    }
  if (!(z > 0)) return;
  const auto px = [&](float mm) { return static_cast<int>(mm * k.fx / z); };
  const int v_first = person.v_min - px(kAboveToMm), v_end = person.v_min - px(kAboveFromMm);
  LostShare above, beside;
  above.look(depth, first, last, v_first, v_end);
  const int middle = (first + last) / 2;
  beside.look(depth, middle - px(kBesideToMm), middle - px(kBesideFromMm), v_first, v_end);
  beside.look(depth, middle + px(kBesideFromMm), middle + px(kBesideToMm), v_first, v_end);
  if (above.all == 0 || beside.all == 0) return;
  ++heads_;
  sum_.lost_above_share += above.share();
  sum_.lost_beside_share += beside.share();
}

SurroundingsSigns Surroundings::signs() const {
  SurroundingsSigns out = sum_;
  const auto mean = [](float& sum, int count) { sum = count > 0 ? sum / static_cast<float>(count) : 0; };
  out.floor.known = bends_ > 0;
  mean(out.floor.bend, bends_);
  out.ground_known = grounds_ > 0;
  for (float* sum : {&out.ground_mm, &out.ground_share, &out.floor_share}) mean(*sum, grounds_);
  judge_feet(out);
  out.above_known = heads_ > 0;
  for (float* sum : {&out.lost_above_share, &out.lost_beside_share}) mean(*sum, heads_);
  return out;
}

float crown_flatness(ImageView<const std::uint16_t> depth_q4, MaskView mask, const Intrinsics& k,
                     const JointSet& joints, const FloorPlane& floor) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  const Vec3f head = joints[Joint::HE];
  const PersonFrame frame = person_frame(floor, joints[Joint::TO]);
  if (!(head.z > 0)) return kNaN;
  const float row_mm = head.z / k.fy;
  const int wanted = std::min(kHeadRowsMax, static_cast<int>(kHeadLongMm / row_mm) + 1);
  const float head_side = frame.side(head);
  std::array<float, kHeadRowsMax> breadth_mm{};
  int rows = 0;
  for (int v = 0; v < mask.height && rows < wanted; ++v) {
    int first = mask.width, last = -1;
    for (int u = 0; u < mask.width; ++u) {
      if (mask.at(u, v) == 0 || depth_q4.at(u, v) == 0) continue;
      const float z = static_cast<float>(depth_q4.at(u, v)) * (1.0F / 16);
      const Vec3f p = unproject(k, static_cast<float>(u), static_cast<float>(v), z);
      if (!(std::fabs(frame.side(p) - head_side) <= kHeadHalfMm)) continue;
      first = std::min(first, u);
      last = u;
    }
    if (last < 0 && rows == 0) continue;
    breadth_mm[static_cast<std::size_t>(rows++)] = static_cast<float>(std::max(0, last - first + 1)) * row_mm;
  }
  const auto row_at = [&](float mm) { return static_cast<std::size_t>(mm / row_mm); };
  if (rows <= static_cast<int>(row_at(kCrownBelowMm.back()))) return kNaN;
  float greatest = 0;
  for (std::size_t i = row_at(kCrownBelowMm.back()); i < static_cast<std::size_t>(rows); ++i)
    greatest = std::max(greatest, breadth_mm[i]);
  if (!(greatest > 0)) return kNaN;
  float sum = 0;
  for (const float below : kCrownBelowMm) sum += breadth_mm[row_at(below)];
  return sum / (static_cast<float>(kCrownBelowMm.size()) * greatest);
}

}  // namespace im2fit
