// SPDX-License-Identifier: Apache-2.0
#include "perception/segment/advice.h"

#include <algorithm>
#include <cmath>

// The thresholds of this file: what each bounds and where it comes from. What breaks when one moves by 20 %:
// docs/notebook/perception.md. Sources:
//   [near]  of scenes with a person nearer than a metre 9 of 20 were right before, 98 of 100 after, all changes
//           together (commit 2a687e0)
//   [codes] docs/tracker.md, Guidance: what the codes promise
//   [rooms] chosen on synthetic rooms, no measurement on record
namespace im2fit::segment::advice_limits {

// What a code promises.
constexpr float kNearMm = 1000.0F;          // nearer is TOO_NEAR; [codes]
constexpr float kHoleShareMax = 0.30F;      // of the person's pixels without data: more is TOO_NOISY; [codes]
constexpr float kFeetMissingMm = 220.0F;    // lowest visible part above the floor: more is FEET_CUT; [codes]
constexpr float kWholeBodyMinMm = 1250.0F;  // of a body seen without a floor: less is FEET_CUT; [codes]
constexpr int kDeadBorderPx = 12;  // at 640 px: columns at the border that sensors leave without data; [codes]

// A person too near to be found: a trunk, or a head over shoulders.
constexpr int kNearShare = 8;              // of the picture, an eighth at least is near; [near]
constexpr float kNearHalfMm = 180.0F;      // either side of a trunk's middle; [near]
constexpr float kNearDepthMm = 300.0F;     // from the nearest: still the same surface; [near]
constexpr int kNearRowsMin = 16;           // of a trunk, least; [near]
constexpr float kNearBulgeMinMm = 15.0F;   // middle before the edges, least; [near]
constexpr float kNearBulgeMaxMm = 140.0F;  // and most; [near]
constexpr float kNearRoundMin = 0.6F;      // of that half way out, least; a corner 0.5, a circle 0.75; [near]
constexpr float kHeadWideMinMm = 90.0F;    // width, least; [near]
constexpr float kHeadWideMaxMm = 290.0F;   // and most; [near]
constexpr float kHeadTallMinMm = 50.0F;    // of a head seen, least; [near]
constexpr float kHeadRimMinMm = 20.0F;     // its rim behind its middle, least; [near]
constexpr float kShoulderReachMm = 45.0F;  // beyond the head on both sides, least; [near]

// A person joined with other things, or not whole.
constexpr float kPersonAreaM2 = 1.4F;  // seen of a person, most; [rooms]
constexpr float kLegsHalfMm = 200.0F;  // either side of the head's middle: the legs; [rooms]
constexpr float kAnkleMm = 150.0F;     // above the floor, where they end; [rooms]
constexpr int kLegCellsMin = 200;      // least, to judge; [rooms]
constexpr int kLegsShare = 3;          // one in so many of them without depth, least: legs fill half; [rooms]

}  // namespace im2fit::segment::advice_limits

namespace im2fit::segment {

using namespace advice_limits;

namespace {

GuidanceSet bit(Guidance g) {
  return static_cast<GuidanceSet>(g);
}

// Pixels without data of the cells from column c_first to before c_end.
int count_lost(const Grid& grid, DepthView depth, int r, int c_first, int c_end) {
  int lost = 0;
  for (int v = r * grid.step; v < (r + 1) * grid.step; ++v) {
    const std::uint16_t* row = depth.row(v);
    for (int u = c_first * grid.step; u < c_end * grid.step; ++u) lost += row[u] == 0 ? 1 : 0;
  }
  return lost;
}

// Share of the person's pixels without data, counting lost cells with the person on two sides.
float hole_share(const Grid& grid, DepthView depth, std::span<const std::uint8_t> chosen) {
  int total = 0;
  int lost = 0;
  const auto is_person = [&](int c, int r) {
    return c >= 0 && r >= 0 && c < grid.width && r < grid.height && chosen[at(grid.index(c, r))] != 0;
  };
  const auto counts = [&](int c, int r) {
    const auto cell = at(grid.index(c, r));
    if (chosen[cell] != 0) return true;
    if (grid.depth[cell] != 0) return false;
    const bool across = (is_person(c - 1, r) || is_person(c - 2, r)) && (is_person(c + 1, r) || is_person(c + 2, r));
    return across && (is_person(c, r - 1) || is_person(c, r - 2)) && (is_person(c, r + 1) || is_person(c, r + 2));
  };
  for (int r = 0; r < grid.height; ++r) {
    // Beside the row's outermost cells of the person none counts.
    const std::uint8_t* row = chosen.data() + grid.index(0, r);
    const std::uint8_t* leftmost = std::find_if(row, row + grid.width, [](std::uint8_t own) { return own != 0; });
    if (leftmost == row + grid.width) continue;
    int end = grid.width;
    while (row[end - 1] == 0) --end;
    const int begin = static_cast<int>(leftmost - row);
    for (int first = begin, c = begin; c <= end; ++c) {
      if (c < end && counts(c, r)) continue;
      if (c > first) lost += count_lost(grid, depth, r, first, c);
      total += (c - first) * grid.step * grid.step;
      first = c + 1;
    }
  }
  return total > 0 ? static_cast<float>(lost) / static_cast<float>(total) : 1.0F;
}

// A person too near shows a trunk and little else: rounded across. In inverse depth a wall is straight over the
// picture's rows, however it is turned, and a box has one corner: whichever side of the middle that is on, half way
// out on the other side a corner rises half as far over its chord as in the middle, and a circle three quarters.
bool round_body(const Grid& grid, const Blob& blob) {
  const float z_mm = blob.centroid_mm.z;
  const float mm = cell_mm(grid, z_mm);
  const int half = std::max(2, static_cast<int>(kNearHalfMm / mm));
  const float u = blob.centroid_mm.x / z_mm * grid.intrinsics.fx + grid.intrinsics.cx;
  const int middle = std::clamp(static_cast<int>(u / static_cast<float>(grid.step)), 0, grid.width - 1);
  int rows = 0;
  float centres = 0;
  float lefts = 0;
  float rights = 0;
  for (int r = blob.r_min; r <= blob.r_max; ++r) {
    const auto inside = [&](int c) {
      if (c < 0 || c >= grid.width) return false;
      const float z = static_cast<float>(grid.depth[at(grid.index(c, r))]);
      return z > z_mm - kNearDepthMm && z < z_mm + kNearDepthMm;
    };
    if (!inside(middle)) continue;
    int lo = middle;
    int hi = middle;
    while (middle - lo < half && inside(lo - 1)) --lo;
    while (hi - middle < half && inside(hi + 1)) ++hi;
    const int width = hi - lo + 1;
    if (width < half) continue;  // a head, or a neck
    const int part = std::max(1, width / 6);
    const auto nearness = [&](int first) {
      float sum = 0;
      for (int i = 0; i < part; ++i) sum += 1.0F / static_cast<float>(grid.depth[at(grid.index(first + i, r))]);
      return sum / static_cast<float>(part);
    };
    const int quarter = (width - part) / 4;
    const int last = hi + 1 - part;
    const float left = nearness(lo);
    const float right = nearness(last);
    const auto over_chord = [&](int first) {
      const float share = static_cast<float>(first - lo) / static_cast<float>(last - lo);
      return nearness(first) - (left + share * (right - left));
    };
    centres += over_chord(lo + (width - part) / 2);
    lefts += over_chord(lo + quarter);
    rights += over_chord(last - quarter);
    ++rows;
  }
  if (rows < kNearRowsMin) return false;
  const float bulge_mm = centres / static_cast<float>(rows) * z_mm * z_mm;
  return bulge_mm > kNearBulgeMinMm && bulge_mm < kNearBulgeMaxMm &&
         std::min(lefts, rights) > kNearRoundMin * centres;
}

// A head over shoulders that reach out on both sides of it, and round: its rim lies behind what is nearest in the row
// (the nose may be too near to be seen at all).
bool head_over_shoulders(const Grid& grid, const Blob& blob) {
  const float cell = cell_mm(grid, blob.centroid_mm.z);
  const auto cells = [&](float mm) { return static_cast<int>(mm / cell); };
  int rows = 0;
  int head_lo = grid.width;
  int head_hi = -1;
  float rim = 0;
  for (int r = blob.r_min; r <= blob.r_max; ++r) {
    int lo = -1;
    int hi = -1;
    std::uint16_t nearest = kDepthMaxMm;
    for (int c = blob.c_min; c <= blob.c_max; ++c) {
      const std::uint16_t z = grid.depth[at(grid.index(c, r))];
      if (z == 0 || std::fabs(static_cast<float>(z) - blob.centroid_mm.z) > kNearDepthMm) continue;
      lo = lo < 0 ? c : lo;
      hi = c;
      nearest = std::min(nearest, z);
    }
    if (lo < 0) continue;
    const int width = hi - lo + 1;
    if (rows >= cells(kHeadTallMinMm)) {
      const bool shoulders = head_lo - lo >= cells(kShoulderReachMm) && hi - head_hi >= cells(kShoulderReachMm);
      if (shoulders) return rim >= kHeadRimMinMm * static_cast<float>(rows);
    }
    if (width < cells(kHeadWideMinMm) || width > cells(kHeadWideMaxMm) || lo == 0 || hi == grid.width - 1) continue;
    const auto z_at = [&](int c) { return static_cast<float>(grid.depth[at(grid.index(c, r))]); };
    rim += 0.5F * (z_at(lo) + z_at(hi)) - static_cast<float>(nearest);
    head_lo = std::min(head_lo, lo);
    head_hi = std::max(head_hi, hi);
    ++rows;
  }
  return false;
}

// Whether nothing of the person is seen near the floor, or, without one, too little of a body.
bool feet_hidden(const Grid& grid, const Person& person, DepthView depth, MaskView mask) {
  const Vec3f up = person.floor.up;
  float lowest = 1e9F;
  float highest = -1e9F;
  for (int v = person.v_max; v >= person.v_min; --v) {
    for (int u = person.u_min; u <= person.u_max; u += grid.step) {
      if (mask.at(u, v) == 0) continue;
      const float h = dot(up, unproject(grid.intrinsics, static_cast<float>(u), static_cast<float>(v),
                                        static_cast<float>(depth.at(u, v))));
      lowest = std::min(lowest, h);
      highest = std::max(highest, h);
    }
    if (person.floor.known && lowest + person.floor.camera_height_mm <= kFeetMissingMm) return false;
  }
  return person.floor.known || highest - lowest < kWholeBodyMinMm;
}

// A head over a trunk that ends in the air, where between it and the floor most of the trunk's columns give no depth
// for a stretch: legs in dark cloth. Below a coat on a hook or a picture is the wall, and before legs behind a table
// is the table.
bool depth_ends(const Grid& grid, const FloorPlane& floor, const Blobs& found, const Head& head) {
  const Blob& blob = found.blobs[at(head.blob)];
  if (!floor.known || blob.height_min_mm < kFloatingMm || blob.r_max >= grid.height - 1) return false;
  const float z_mm = blob.centroid_mm.z;
  const int half = static_cast<int>(kLegsHalfMm / cell_mm(grid, z_mm));
  const int c_first = std::max(0, head.c - half), c_last = std::min(grid.width - 1, head.c + half);
  int lost = 0;
  int count = 0;
  for (int r = blob.r_max + 1; r < grid.height; ++r) {
    // What stands at the person's distance in this row.
    const float height_mm = (floor.up.y * grid.ray_y[at(r)] + floor.up.z) * z_mm + floor.camera_height_mm;
    if (height_mm < kAnkleMm) break;
    for (int c = c_first; c <= c_last; ++c) lost += grid.depth[at(grid.index(c, r))] == 0 ? 1 : 0;
    count += c_last - c_first + 1;
  }
  return count >= kLegCellsMin && lost * kLegsShare >= count;
}

}  // namespace

void mark_dead_borders(const Grid& grid, int image_width, int image_height, Person& person) {
  const auto row_has_data = [&](int r) {
    const auto first = grid.depth.begin() + grid.index(0, r);
    return std::any_of(first, first + grid.width, [](std::uint16_t z) { return z != 0; });
  };
  const auto column_has_data = [&](int c) {
    int r = 0;
    while (r < grid.height && grid.depth[at(grid.index(c, r))] == 0) ++r;
    return r < grid.height;
  };
  int c_min = 0;
  int c_max = grid.width - 1;
  int r_min = 0;
  int r_max = grid.height - 1;
  while (r_min <= r_max && !row_has_data(r_min)) ++r_min;
  while (r_max > r_min && !row_has_data(r_max)) --r_max;
  while (c_min <= c_max && !column_has_data(c_min)) ++c_min;
  while (c_max > c_min && !column_has_data(c_max)) --c_max;
  const int dead = std::max(2, kDeadBorderPx * grid.step / 4);
  const auto ends = [&](int gap_px, int distance_px) { return gap_px <= dead && distance_px < grid.step; };
  const int left = c_min * grid.step;
  const int right = (c_max + 1) * grid.step - 1;
  const int top = r_min * grid.step;
  const int bottom = (r_max + 1) * grid.step - 1;
  if (ends(left, person.u_min - left)) person.cut_left = true;
  if (ends(image_width - 1 - right, right - person.u_max)) person.cut_right = true;
  if (ends(top, person.v_min - top)) person.cut_top = true;
  if (ends(image_height - 1 - bottom, bottom - person.v_max)) person.cut_bottom = true;
}

GuidanceSet advise(const Grid& grid, const Person& person, DepthView depth, MaskView mask,
                   std::span<const std::uint8_t> chosen, bool disturbed) {
  GuidanceSet out = 0;
  if (person.centroid_mm.z < kNearMm) out |= bit(Guidance::too_near);
  if (person.centroid_mm.z > kTooFarMm) out |= bit(Guidance::too_far);
  if (person.cut_top) out |= bit(Guidance::head_cut);
  if (person.cut_left || person.cut_right) out |= bit(Guidance::side_cut);
  if (disturbed) out |= bit(Guidance::several_people);
  const float pixel_m2 =
      person.centroid_mm.z * person.centroid_mm.z * 1e-6F / (grid.intrinsics.fx * grid.intrinsics.fy);
  if (static_cast<float>(person.pixel_count) * pixel_m2 > kPersonAreaM2) out |= bit(Guidance::step_to_the_middle);
  if (hole_share(grid, depth, chosen) > kHoleShareMax) out |= bit(Guidance::too_noisy);
  if (person.cut_bottom || feet_hidden(grid, person, depth, mask)) out |= bit(Guidance::feet_cut);
  return out;
}

GuidanceSet advise_none_found(const Grid& grid, const FloorPlane& floor, const Blobs& found,
                              const PersonTracker& people) {
  for (const Blob& blob : found.list()) {
    const bool large = blob.cell_count * kNearShare > static_cast<int>(grid.depth.size());
    if (large && blob.centroid_mm.z < kNearMm && (round_body(grid, blob) || head_over_shoulders(grid, blob)))
      return bit(Guidance::too_near);
  }
  for (int h = 0; h < found.head_count; ++h) {
    const Head& head = found.heads[at(h)];
    if (!head.seen || head.vague || head.top_mm.z > kTooFarMm || people.leaves_out(head, floor)) continue;
    const Blob& blob = found.blobs[at(head.blob)];
    if (blob.area_m2 >= kPersonAreaMaxM2) return bit(Guidance::step_to_the_middle);
    if (depth_ends(grid, floor, found, head)) return bit(Guidance::depth_missing);
  }
  return bit(Guidance::no_person);
}

}  // namespace im2fit::segment
