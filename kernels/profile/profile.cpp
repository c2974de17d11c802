// SPDX-License-Identifier: Apache-2.0
#include "kernels/profile/profile.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace im2fit {
namespace {

using L = ProfileLayout;
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kDepthScale = 1.0F / 16.0F;
constexpr float kStepMm = 70.0F;  // a larger jump from pixel to pixel ends a run: another limb behind or before
constexpr int kGapPx = 2;         // holes up to this wide do not end a run
constexpr float kHeightBinMm = 4.0F;
constexpr int kHeightBins = 700;  // -100 .. 2700 mm
constexpr float kHeightMinMm = -100.0F;
constexpr float kArmRadiusMm = 48.0F;

struct Band {
  int levels;
  float low, high;  // of stature
  int values;
};
constexpr Band kTrunkBand{L::kTrunkLevels, 0.44F, 0.84F, L::kTrunkValues};
constexpr Band kLegBand{L::kLegLevels, 0.05F, 0.45F, L::kLegValues};
constexpr Band kHeadBand{L::kHeadLevels, 0.82F, 0.98F, L::kHeadValues};
constexpr int kLevelFloats = L::kArms;  // trunk, legs and head lie before the arms in the layout

struct Scene {
  ImageView<const std::uint16_t> depth;
  MaskView mask;
  Intrinsics k;
  PersonFrame frame;
  const JointSet* joints;
  float stature_mm = 0;
  float base_mm = 0;  // height of the soles

  float z(int u, int v) const { return mask.at(u, v) != 0 ? static_cast<float>(depth.at(u, v)) * kDepthScale : 0.0F; }
  Vec3f point(float u, int v, float z_mm) const { return unproject(k, u, static_cast<float>(v), z_mm); }
  Vec3f joint(Joint j) const { return (*joints)[j]; }
};

struct Run {
  int begin = 0;  // first pixel
  int end = 0;    // last pixel, inclusive
};

int find_runs(const Scene& s, int v, std::span<Run> runs) {
  int count = 0;
  int last = -100;
  float last_z = 0;
  for (int u = 0; u < s.mask.width; ++u) {
    const float z = s.z(u, v);
    if (z <= 0) continue;
    const bool joins = count > 0 && u - last <= kGapPx + 1 && std::abs(z - last_z) < kStepMm;
    if (joins) {
      runs[static_cast<std::size_t>(count - 1)].end = u;
    } else {
      if (count == static_cast<int>(runs.size())) break;
      runs[static_cast<std::size_t>(count++)] = {u, u};
    }
    last = u;
    last_z = z;
  }
  return count;
}

// Depth at a pixel, looking a little sideways for a hole.
float z_near(const Scene& s, int u, int v) {
  for (int d = 0; d <= kGapPx; ++d) {
    if (u - d >= 0 && s.z(u - d, v) > 0) return s.z(u - d, v);
    if (u + d < s.mask.width && s.z(u + d, v) > 0) return s.z(u + d, v);
  }
  return 0;
}

float side_of_edge(const Scene& s, float u_edge, int u_inside, int v) {
  return s.frame.side(s.point(u_edge, v, z_near(s, u_inside, v)));
}

// Sideways position at height h of the polyline through joints ordered from high to low.
float line_side(const Scene& s, std::span<const Vec3f> line, float h) {
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const float h0 = s.frame.height(line[i]);
    const float h1 = s.frame.height(line[i + 1]);
    if (h > h1 && h0 > h1) {
      const float t = std::min(1.0F, (h - h1) / (h0 - h1));
      return s.frame.side(line[i + 1]) + t * (s.frame.side(line[i]) - s.frame.side(line[i + 1]));
    }
  }
  return s.frame.side(line.back());
}

// Pixel column where the row crosses sideways position `side`, at depth z.
float column_of_side(const Scene& s, float side, int v, float z_mm) {
  const Vec3f p = s.point(0, v, z_mm);
  const float per_px = z_mm / s.k.fx * s.frame.right.x;  // right is nearly the camera's x
  return (side - s.frame.side(p)) / per_px;
}

struct Row {
  int v = 0;
  float height_mm = 0;
  std::array<Run, 24> runs;
  int run_count = 0;
};

const Run* run_at(const Scene& s, const Row& row, float side) {
  const Run* best = nullptr;
  float best_gap = 60.0F;  // farther than this from every run: there is none
  for (int i = 0; i < row.run_count; ++i) {
    const Run& r = row.runs[static_cast<std::size_t>(i)];
    const float a = side_of_edge(s, static_cast<float>(r.begin) - 0.5F, r.begin, row.v);
    const float b = side_of_edge(s, static_cast<float>(r.end) + 0.5F, r.end, row.v);
    const float gap = side < a ? a - side : side > b ? side - b : 0.0F;
    if (gap < best_gap) {
      best_gap = gap;
      best = &r;
    }
  }
  return best;
}

// Mean depth (towards the camera) of up to five pixels about column u.
float relief_at(const Scene& s, float u, int v, const Run& run) {
  const int c = static_cast<int>(u + 0.5F);
  float sum = 0;
  int n = 0;
  for (int x = std::max(run.begin, c - 2); x <= std::min(run.end, c + 2); ++x) {
    const float z = s.z(x, v);
    if (z <= 0) continue;
    sum += s.frame.depth(s.point(static_cast<float>(x), v, z));
    ++n;
  }
  return n > 0 ? sum / static_cast<float>(n) : kNaN;
}

// The same at a sideways position in mm. The column depends on the depth there, so it is looked up twice.
float relief_at_side(const Scene& s, float side, int v, const Run& run) {
  const auto clamped = [&](float u) {
    return std::clamp(u, static_cast<float>(run.begin), static_cast<float>(run.end));
  };
  const float z_guess = z_near(s, (run.begin + run.end) / 2, v);
  if (z_guess <= 0) return kNaN;
  const float u = clamped(column_of_side(s, side, v, z_guess));
  const float z = z_near(s, static_cast<int>(u + 0.5F), v);
  return relief_at(s, z > 0 ? clamped(column_of_side(s, side, v, z)) : u, v, run);
}

// Adds a row's values to the two levels it lies between, by nearness.
void add_to_levels(const Scene& s, const Band& band, int first, float height_mm, std::span<const float> values,
                   ProfileWorkspace& work) {
  const float t = (height_mm - s.base_mm) / s.stature_mm;
  const float position = (t - band.low) / (band.high - band.low) * static_cast<float>(band.levels - 1);
  const float below = std::floor(position);
  for (int side = 0; side < 2; ++side) {
    const int level = static_cast<int>(below) + side;
    if (level < 0 || level >= band.levels) continue;
    const float weight = side == 0 ? 1.0F - (position - below) : position - below;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (std::isnan(values[i])) continue;
      const auto at = static_cast<std::size_t>(first + level * band.values) + i;
      work.level_sum[at] += weight * values[i];
      work.level_weight[at] += weight;
    }
  }
}

bool in_band(const Scene& s, const Band& band, float height_mm) {
  const float t = (height_mm - s.base_mm) / s.stature_mm;
  const float step = (band.high - band.low) / static_cast<float>(band.levels - 1);
  return t > band.low - step && t < band.high + step;
}

// Ends the trunk's run where an arm grows out of it: at the arm's centre line less its radius.
Run clip_arms(const Scene& s, const Row& row, Run run) {
  const std::array<Vec3f, 3> left = {s.joint(Joint::LS), s.joint(Joint::LE), s.joint(Joint::LA)};
  const std::array<Vec3f, 3> right = {s.joint(Joint::RS), s.joint(Joint::RE), s.joint(Joint::RA)};
  const float z = z_near(s, (run.begin + run.end) / 2, row.v);
  if (z <= 0) return run;
  const float shoulder_h = 0.5F * (s.frame.height(left[0]) + s.frame.height(right[0]));
  if (row.height_mm > shoulder_h + 20.0F) return run;
  const float u_left = column_of_side(s, line_side(s, left, row.height_mm), row.v, z);  // picture's right
  const float u_right = column_of_side(s, line_side(s, right, row.height_mm), row.v, z);
  const float radius_px = kArmRadiusMm * s.k.fx / z;
  if (static_cast<float>(run.end) > u_left) run.end = std::max(run.begin, static_cast<int>(u_left - radius_px));
  if (static_cast<float>(run.begin) < u_right)
    run.begin = std::min(run.end, static_cast<int>(u_right + radius_px) + 1);
  return run;
}

void add_trunk_row(const Scene& s, const Row& row, ProfileWorkspace& work) {
  const std::array<Vec3f, 3> spine = {s.joint(Joint::NE), s.joint(Joint::TO),
                                      (s.joint(Joint::LH) + s.joint(Joint::RH)) * 0.5F};
  const float axis = line_side(s, spine, row.height_mm);
  const Run* found = run_at(s, row, axis);
  if (found == nullptr) return;
  const Run run = clip_arms(s, row, *found);
  if (run.end - run.begin < 8) return;

  std::array<float, L::kTrunkValues> values{};
  const float a = side_of_edge(s, static_cast<float>(run.begin) - 0.5F, run.begin, row.v);
  const float b = side_of_edge(s, static_cast<float>(run.end) + 0.5F, run.end, row.v);
  values[0] = axis - a;
  values[1] = b - axis;
  const float half = 0.5F * (b - a);
  std::array<float, L::kReliefs> reliefs{};
  for (int i = 0; i < L::kReliefs; ++i)
    reliefs[static_cast<std::size_t>(i)] =
        relief_at_side(s, a + half * (1.0F + 0.2F * static_cast<float>(i - L::kReliefs / 2)), row.v, run);
  // Relative to the level's own front, so that leaning and distance do not matter.
  float front = 0;
  for (int i = 2; i <= 6; ++i) front += reliefs[static_cast<std::size_t>(i)] * 0.2F;
  float arc = 0;
  const float step = 0.1F * (b - a);
  for (std::size_t i = 0; i < reliefs.size(); ++i) {
    values[2 + i] = reliefs[i] - front;
    if (i > 0) {
      const float rise = reliefs[i] - reliefs[i - 1];
      arc += std::sqrt(step * step + rise * rise);
    }
  }
  values[2 + L::kReliefs] = arc;
  add_to_levels(s, kTrunkBand, L::kTrunk, row.height_mm, values, work);
}

void add_leg_row(const Scene& s, const Row& row, ProfileWorkspace& work) {
  const std::array<std::array<Vec3f, 3>, 2> lines = {{{s.joint(Joint::LH), s.joint(Joint::LK), s.joint(Joint::LF)},
                                                      {s.joint(Joint::RH), s.joint(Joint::RK), s.joint(Joint::RF)}}};
  std::array<float, 2> centre{};
  std::array<const Run*, 2> runs{};
  for (std::size_t leg = 0; leg < 2; ++leg) {
    centre[leg] = line_side(s, lines[leg], row.height_mm);
    runs[leg] = run_at(s, row, centre[leg]);
    if (runs[leg] == nullptr) return;
  }
  std::array<float, L::kLegValues> values{};
  for (std::size_t leg = 0; leg < 2; ++leg) {
    const Run& r = *runs[leg];
    float a = side_of_edge(s, static_cast<float>(r.begin) - 0.5F, r.begin, row.v);
    float b = side_of_edge(s, static_cast<float>(r.end) + 0.5F, r.end, row.v);
    if (runs[0] == runs[1]) {  // thighs touch: they meet half way
      const float middle = 0.5F * (centre[0] + centre[1]);
      (leg == 0 ? a : b) = middle;
    }
    values[leg] = b - a;
    const float z = z_near(s, (r.begin + r.end) / 2, row.v);
    const float u = z > 0 ? column_of_side(s, 0.5F * (a + b), row.v, z) : static_cast<float>(r.begin);
    values[2 + leg] = relief_at(s, u, row.v, r);
  }
  add_to_levels(s, kLegBand, L::kLegs, row.height_mm, values, work);
}

void add_head_row(const Scene& s, const Row& row, ProfileWorkspace& work) {
  const std::array<Vec3f, 2> line = {s.joint(Joint::HE), s.joint(Joint::NE)};
  const Run* run = run_at(s, row, line_side(s, line, row.height_mm));
  if (run == nullptr || run->end - run->begin < 4) return;
  std::array<float, L::kHeadValues> values{};
  values[0] = side_of_edge(s, static_cast<float>(run->end) + 0.5F, run->end, row.v) -
              side_of_edge(s, static_cast<float>(run->begin) - 0.5F, run->begin, row.v);
  const float centre_u = 0.5F * static_cast<float>(run->begin + run->end);
  const float half_u = 0.5F * static_cast<float>(run->end - run->begin);
  const float torso = s.frame.depth(s.joint(Joint::TO));
  for (int i = 0; i < 3; ++i)
    values[static_cast<std::size_t>(1 + i)] =
        relief_at(s, centre_u + half_u * 0.5F * static_cast<float>(i - 1), row.v, *run) - torso;
  add_to_levels(s, kHeadBand, L::kHead, row.height_mm, values, work);
}

// Width of a limb across the picture at pixel (u, v), along the unit direction (du, dv).
float width_across(const Scene& s, float u, float v, float du, float dv) {
  const auto z_at = [&](float x, float y) {
    const int iu = static_cast<int>(std::floor(x + 0.5F));
    const int iv = static_cast<int>(std::floor(y + 0.5F));
    if (iu < 0 || iv < 0 || iu >= s.mask.width || iv >= s.mask.height) return 0.0F;
    return s.z(iu, iv);
  };
  const float centre = z_at(u, v);
  if (centre <= 0) return kNaN;
  const float limit_px = 130.0F * s.k.fx / centre;
  float total = 0;
  for (int sign = -1; sign <= 1; sign += 2) {
    float t = 0.5F;
    while (t < limit_px) {
      const float z = z_at(u + du * t * static_cast<float>(sign), v + dv * t * static_cast<float>(sign));
      if (z <= 0 || std::abs(z - centre) > kStepMm) break;
      t += 0.5F;
    }
    total += t - 0.25F;
  }
  return total * centre / s.k.fx;
}

void arm_widths(const Scene& s, std::span<float> out) {
  const std::array<std::array<Joint, 2>, 4> bones = {
      {{Joint::LS, Joint::LE}, {Joint::LE, Joint::LA}, {Joint::RS, Joint::RE}, {Joint::RE, Joint::RA}}};
  std::size_t at = 0;
  for (const auto& bone : bones) {
    const Vec3f a = s.joint(bone[0]);
    const Vec3f b = s.joint(bone[1]);
    for (int q = 1; q <= 3; ++q, ++at) {
      out[at] = kNaN;
      const Vec3f p = a + (b - a) * (0.25F * static_cast<float>(q));
      if (a.z <= 0 || b.z <= 0 || p.z <= 0) continue;
      const float du = s.k.fx * (b.x / b.z - a.x / a.z);
      const float dv = s.k.fy * (b.y / b.z - a.y / a.z);
      const float length = std::sqrt(du * du + dv * dv);
      if (length < 4.0F) continue;
      out[at] = width_across(s, s.k.fx * p.x / p.z + s.k.cx, s.k.fy * p.y / p.z + s.k.cy, -dv / length, du / length);
    }
  }
}

// Height below (from the top) or above (from the bottom) which `area_mm2` of the histogram lies.
float height_at_area(std::span<const float> histogram, float area_mm2, bool from_top) {
  float sum = 0;
  const int n = static_cast<int>(histogram.size());
  for (int i = 0; i < n; ++i) {
    const int bin = from_top ? n - 1 - i : i;
    const float here = histogram[static_cast<std::size_t>(bin)];
    if (here > 0 && sum + here >= area_mm2) {
      const float part = (area_mm2 - sum) / here;
      const float edge = from_top ? static_cast<float>(bin + 1) - part : static_cast<float>(bin) + part;
      return kHeightMinMm + kHeightBinMm * edge;
    }
    sum += here;
  }
  return kNaN;
}

// Area by height, of head pixels (from the top) or of all (from the bottom).
template <class Keep>
void height_histogram(const Scene& s, int row_begin, int row_end, ProfileWorkspace& work, Keep keep) {
  std::fill(work.height_area.begin(), work.height_area.end(), 0.0F);
  const float scale = 1.0F / (s.k.fx * s.k.fy);
  for (int v = row_begin; v < row_end; ++v) {
    for (int u = 0; u < s.mask.width; ++u) {
      const float z = s.z(u, v);
      if (z <= 0) continue;
      const Vec3f p = s.point(static_cast<float>(u), v, z);
      if (!keep(p)) continue;
      const int bin = static_cast<int>((s.frame.height(p) - kHeightMinMm) / kHeightBinMm);
      if (bin >= 0 && bin < kHeightBins) work.height_area[static_cast<std::size_t>(bin)] += z * z * scale;
    }
  }
}

float lowest_height(const Scene& s, int row_begin, int row_last) {
  float lowest = std::numeric_limits<float>::max();
  for (int v = std::max(0, row_begin); v <= row_last; ++v)
    for (int u = 0; u < s.mask.width; ++u)
      if (const float z = s.z(u, v); z > 0)
        lowest = std::min(lowest, s.frame.height(s.point(static_cast<float>(u), v, z)));
  return lowest < std::numeric_limits<float>::max() ? lowest : 0.0F;
}

// Sets the soles as the zero of heights where no floor is known.
void crown_and_soles(Scene& s, bool floor_known, ProfileWorkspace& work, std::span<float> crown,
                     std::span<float> soles) {
  int first = 0;
  int last = s.mask.height - 1;
  const auto empty = [&](int v) {
    for (int u = 0; u < s.mask.width; ++u)
      if (s.mask.at(u, v) != 0) return false;
    return true;
  };
  while (first < last && empty(first)) ++first;
  while (last > first && empty(last)) --last;
  const int span = last - first + 1;
  if (!floor_known) s.frame.camera_height_mm -= lowest_height(s, last - span / 8, last);

  const float head_side = s.frame.side(s.joint(Joint::HE));
  height_histogram(s, first, first + span / 5, work,
                   [&](Vec3f p) { return std::abs(s.frame.side(p) - head_side) < 140.0F; });
  constexpr std::array<float, L::kCrownValues> kCrownAreas = {150.0F, 500.0F, 1500.0F, 4000.0F, 9000.0F};
  for (std::size_t i = 0; i < crown.size(); ++i) crown[i] = height_at_area(work.height_area, kCrownAreas[i], true);

  height_histogram(s, last - span / 5, last + 1, work, [](Vec3f) { return true; });
  constexpr std::array<float, L::kSoleValues> kSoleAreas = {400.0F, 1500.0F, 5000.0F, 12000.0F};
  for (std::size_t i = 0; i < soles.size(); ++i) soles[i] = height_at_area(work.height_area, kSoleAreas[i], false);
}

void joints_and_bones(const Scene& s, std::span<float> positions, std::span<float> bones) {
  const Vec3f torso = s.joint(Joint::TO);
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const Vec3f p = s.joints->position_mm[j];
    positions[3 * j] = s.frame.side(p) - s.frame.side(torso);
    positions[3 * j + 1] = s.frame.height(p);
    positions[3 * j + 2] = s.frame.depth(p) - s.frame.depth(torso);
  }
  using enum Joint;
  constexpr std::array<std::array<Joint, 2>, L::kBones> kPairs = {{{HE, NE},
                                                                   {NE, TO},
                                                                   {NE, LS},
                                                                   {NE, RS},
                                                                   {LS, LE},
                                                                   {RS, RE},
                                                                   {LE, LA},
                                                                   {RE, RA},
                                                                   {LS, RS},
                                                                   {LH, RH},
                                                                   {LH, LK},
                                                                   {RH, RK},
                                                                   {LK, LF},
                                                                   {RK, RF}}};
  for (std::size_t i = 0; i < kPairs.size(); ++i) bones[i] = norm(s.joint(kPairs[i][0]) - s.joint(kPairs[i][1]));
}

// What the picture's geometry adds to widths and heights; lets the projection take it out again.
void scene_values(const Scene& s, std::span<float> out) {
  float area = 0;
  float count = 0;
  float mean_z = 0;
  for (int v = 0; v < s.mask.height; ++v) {
    float row_area = 0;
    for (int u = 0; u < s.mask.width; ++u) {
      const float z = s.z(u, v);
      if (z <= 0) continue;
      row_area += z * z;
      mean_z += z;
      count += 1.0F;
    }
    area += row_area / (s.k.fx * s.k.fy);
  }
  const Vec3f shoulders = s.joint(Joint::LS) - s.joint(Joint::RS);
  const Vec3f hips = s.joint(Joint::LH) - s.joint(Joint::RH);
  out[0] = count > 0 ? mean_z / count : kNaN;
  out[1] = area;
  out[2] = area / s.stature_mm;
  out[3] = s.frame.camera_height_mm;
  out[4] = s.frame.up.z;
  out[5] = dot(s.frame.toward, normalized(shoulders));
  out[6] = dot(s.frame.toward, normalized(hips));
  out[7] = s.base_mm;
}

}  // namespace

ProfileWorkspace::ProfileWorkspace()
    : height_area(kHeightBins), level_sum(kLevelFloats), level_weight(kLevelFloats) {}

void section_profile(ImageView<const std::uint16_t> depth_q4, MaskView mask, const Intrinsics& intrinsics,
                     const JointSet& joints, const FloorPlane& floor, ProfileWorkspace& work, std::span<float> out) {
  std::fill(out.begin(), out.end(), kNaN);
  Scene s{depth_q4, mask, intrinsics, person_frame(floor, joints[Joint::TO]), &joints};
  const auto part = [&](int first, int size) {
    return out.subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(size));
  };

  const auto crown = part(L::kCrown, L::kCrownValues);
  const auto soles = part(L::kSoles, L::kSoleValues);
  crown_and_soles(s, floor.known, work, crown, soles);
  if (std::isnan(crown[1]) || std::isnan(soles[1])) return;
  if (!floor.known) s.base_mm = soles[0];
  s.stature_mm = crown[1] - s.base_mm;
  if (s.stature_mm < 800.0F || s.stature_mm > 2600.0F) return;

  std::fill(work.level_sum.begin(), work.level_sum.end(), 0.0F);
  std::fill(work.level_weight.begin(), work.level_weight.end(), 0.0F);
  const float torso_side = s.frame.side(joints[Joint::TO]);
  Row row;
  for (int v = 0; v < mask.height; ++v) {
    row.v = v;
    row.run_count = find_runs(s, v, row.runs);
    if (row.run_count == 0) continue;
    const Run* centre = run_at(s, row, torso_side);
    const Run& any = centre != nullptr ? *centre : row.runs[0];
    const int u = (any.begin + any.end) / 2;
    row.height_mm = s.frame.height(
        s.point(static_cast<float>(u), v, z_near(s, u, v) > 0 ? z_near(s, u, v) : z_near(s, any.begin, v)));
    if (in_band(s, kTrunkBand, row.height_mm)) add_trunk_row(s, row, work);
    if (in_band(s, kLegBand, row.height_mm)) add_leg_row(s, row, work);
    if (in_band(s, kHeadBand, row.height_mm)) add_head_row(s, row, work);
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(L::kArms); ++i)
    if (work.level_weight[i] > 0.3F) out[i] = work.level_sum[i] / work.level_weight[i];

  arm_widths(s, part(L::kArms, L::kArmValues));
  joints_and_bones(s, part(L::kJoints, 3 * static_cast<int>(kJointCount)), part(L::kBoneLengths, L::kBones));
  scene_values(s, part(L::kSceneValues, L::kScene));
  if (!floor.known) {
    for (float& h : crown) h -= s.base_mm;
    for (float& h : soles) h -= s.base_mm;
  }
}

}  // namespace im2fit
