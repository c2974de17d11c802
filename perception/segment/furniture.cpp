// SPDX-License-Identifier: Apache-2.0
#include "perception/segment/furniture.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

// The thresholds of this file: what each bounds and where it comes from. What breaks when one moves by 20 %:
// docs/notebook/perception.md. Sources:
//   [cut]   came with the cut of furniture; measured together, not one by one: IoU p5 of 200 people in two
//           fresh scenes each 0.877 -> 0.927 (commit 5651a96)
//   [posts] came with the cut of chair legs; together: IoU p5 of 240 full scenes, seed 8101, 0.927 -> 0.944,
//           seated 0.856 -> 0.910 (commit deeed50)
//   [legs]  came with bent people keeping their legs; no measurement of masks on record (commit 3db21d5)
//   [stay]  came with ankles, sleeves and hands that stay; together: IoU p5 of 520 frames of seeds 70707, 60611
//           and 909090; only the figures before are on record: 0.9476, 0.9465, 0.9532 (commit cb455a6)
// None of them has a measurement of its own on record: the values were chosen on synthetic rooms.
namespace im2fit::segment::furniture_limits {

// Where a ledge, the level upper edge of a piece of furniture, may be.
constexpr float kLedgeLowMm = 130.0F;          // above the floor, least; shoes are lower; [cut]
constexpr float kLedgeHighMm = 800.0F;         // above the floor, most; hands hang above; 700 before [posts]
constexpr float kLedgeShare = 0.5F;            // most, of a standing person's height; 0.45 before [posts]
constexpr float kClearMm = 80.0F;              // above a ledge with nothing of the person; [cut]
constexpr float kLevelStepMm = 28.0F;          // height difference from column to column, most; [cut]
constexpr float kLevelMm = 50.0F;              // height difference along a ledge, most; [cut]
constexpr float kLedgeMinMm = 110.0F;          // length, least; shorter edges stay on the person; [cut]
constexpr float kTopFaceMm = 30.0F;            // below the edge: still the upper face, seen from above; [cut]
constexpr int kFrontCells = 4;                 // averaged for the distance of a front; [cut]
constexpr int kEdgeCells = 2;                  // of either face, mixed at an edge; [cut]
constexpr float kFrontToleranceMm = 14.0F;     // a front leaves its distance by, most; [cut]
constexpr float kFrontToleranceQuanta = 0.8F;  // and by so many disparity steps; [cut]
constexpr float kFlatBaseMm = 50.0F;           // either side of a column; calves bulge by 25 mm over both; [cut]
constexpr float kFlatBulgeMm = 7.0F;           // over that base, most; boxes have none, calves 25; [cut]
constexpr float kFlatBulgeQuanta = 0.4F;       // and so many disparity steps, which noise adds; [cut]
constexpr float kBandMm = 60.0F;               // off a front's distance, in the floor band; [cut]

// A front that goes on beside its ledge.
constexpr float kBesideMm = 200.0F;             // as far as that; [cut]
constexpr float kBesideToleranceMm = 10.0F;     // off the front's line, most; [cut]
constexpr float kBesideToleranceQuanta = 0.4F;  // and so many disparity steps; [cut]

// Whether the person sits.
constexpr float kSeatedShare = 0.33F;     // ledges of the height as seated: the thighs are higher; [cut]
constexpr float kSeatShare = 0.36F;       // seats, between the thighs, of the same height; [cut]
constexpr float kSeatedMaxMm = 1450.0F;   // height of most who sit; [cut]
constexpr float kSeatedTallMm = 1600.0F;  // height of the tallest who sit, as high as others stand; [stay]
constexpr float kSeatedAheadMm = 250.0F;  // shins before the trunk of these: a step is shorter; [stay]
constexpr float kBendsMm = 60.0F;         // shins behind the trunk: a person who bends; [legs]
constexpr float kTrunkLow = 0.55F;        // the trunk begins, of a seated person's height; [cut]
constexpr float kTrunkHigh = 0.8F;        // and ends; [cut]
constexpr float kDistanceBinMm = 10.0F;   // of the histogram its median distance is read from; resolution
constexpr int kDistanceBins = 1000;       // of it: to 10 m, where depth ends; follows from kDepthMaxMm

// Seats and chair backs, of who sits.
constexpr float kPartMm = 22.0F;        // depth jump that parts a row, and a disparity step; [cut]
constexpr int kFlatCellsMin = 4;        // across a part of a row, to see its shape; [cut]
constexpr float kRowFlatMm = 5.0F;      // bulge of a flat part, most; [cut]
constexpr float kRowRoundMm = 10.0F;    // bulge of a shin, least; [posts]
constexpr float kRowQuanta = 0.4F;      // and so many disparity steps, of both; [cut]
constexpr float kBehindMm = 150.0F;     // a backrest behind the trunk's front: trunks are 230 deep; [cut]
constexpr float kArmBehindMm = 150.0F;  // beyond that an arm reaches, most; [stay]
constexpr float kArmStepMm = 8.0F;      // depth step within an arm's surface, most; [stay]
constexpr float kArmStepQuanta = 0.5F;  // and so many disparity steps; [stay]

// Legs of chairs, and shins that are none.
constexpr float kPostMm = 50.0F;           // width, most; shins are wider; [posts]
constexpr float kPostLowMm = 200.0F;       // above the floor, least: ankles are as narrow; [posts]
constexpr float kPostTallMm = 60.0F;       // height, least: ankles seen that narrow are shorter; [stay]
constexpr float kShinThickMinMm = 70.0F;   // area over height of a shin on its own, least; [stay]
constexpr float kShinThickMaxMm = 125.0F;  // and most; [stay]
constexpr float kShinTallMinMm = 120.0F;   // height of a shin on its own, least; [stay]

}  // namespace im2fit::segment::furniture_limits

namespace im2fit::segment {

using namespace furniture_limits;

namespace {

constexpr std::int32_t kNarrow = -1;  // in island_: a cell of a row narrower than a shin

float front_tolerance_mm(float z) {
  return kFrontToleranceMm + kFrontToleranceQuanta * quantum_mm(z);
}

}  // namespace

FurnitureCutter::FurnitureCutter(const Grid& grid)
    : cut_(grid.depth.size()),
      top_(at(grid.width)),
      bottom_(at(grid.width)),
      front_mm_(at(grid.width)),
      island_(grid.depth.size()),
      stack_(grid.depth.size()),
      distances_(at(kDistanceBins)) {}

// The uppermost cell of each column that begins low, in the open.
void FurnitureCutter::find_tops(const Grid& grid, float limit_mm, std::span<const std::uint8_t> chosen) {
  for (int c = 0; c < grid.width; ++c) {
    top_[at(c)] = bottom_[at(c)] = -1;
    int last = -grid.height;  // row of the person's last cell above
    for (int r = 0; r < grid.height; ++r) {
      const auto i = at(grid.index(c, r));
      if (chosen[i] == 0) continue;
      const float z = static_cast<float>(grid.depth[i]);
      const float clear = static_cast<float>(r - last) * cell_mm(grid, z);
      const bool low = grid.height_mm[i] > kLedgeLowMm && grid.height_mm[i] < limit_mm;
      last = r;
      if (!low || r == 0 || clear < kClearMm) continue;
      const float above = static_cast<float>(grid.depth[i - at(grid.width)]);
      // Hidden by something nearer, which is not furniture.
      if (above > 0 && above < z - depth_step_mm(z) && cut_[i - at(grid.width)] == 0) continue;
      top_[at(c)] = r;
      break;
    }
  }
}

// From column c on: columns that begin at one height; empty where there is none at c.
FurnitureCutter::Ledge FurnitureCutter::next_ledge(const Grid& grid, int c) const {
  Ledge ledge = {c, c - 1};
  if (top_[at(c)] < 0) return ledge;
  float height = grid.height_mm[at(grid.index(c, top_[at(c)]))];
  float low = height;
  float high = height;
  ledge.c_last = c;
  for (int next = c + 1; next < grid.width && next <= ledge.c_last + 2; ++next) {
    if (top_[at(next)] < 0) continue;
    const float h = grid.height_mm[at(grid.index(next, top_[at(next)]))];
    if (std::fabs(h - height) > kLevelStepMm || std::max(high, h) - std::min(low, h) > kLevelMm) break;
    low = std::min(low, h);
    high = std::max(high, h);
    height = h;
    ledge.c_last = next;
  }
  return ledge;
}

// Down the upper face, then down the front as long as its distance along the floor stays.
void FurnitureCutter::follow_down(const Grid& grid, Vec3f ahead, const Ledge& ledge,
                                  std::span<const std::uint8_t> chosen) {
  for (int c = ledge.c_first; c <= ledge.c_last; ++c) {
    const int top = top_[at(c)];
    if (top < 0) continue;
    const float height = grid.height_mm[at(grid.index(c, top))];
    int r = top;
    float away = 0;
    while (r < grid.height && chosen[at(grid.index(c, r))] != 0 &&
           grid.height_mm[at(grid.index(c, r))] > height - kTopFaceMm) {
      away = dot(ahead, grid.point(c, r));
      ++r;
    }
    float sum = 0;
    int count = 0;
    int restarts = kEdgeCells;
    for (; r < grid.height && chosen[at(grid.index(c, r))] != 0; ++r) {
      away = dot(ahead, grid.point(c, r));
      const float z = static_cast<float>(grid.depth[at(grid.index(c, r))]);
      if (count > 0 &&
          std::fabs(away * static_cast<float>(count) - sum) > front_tolerance_mm(z) * static_cast<float>(count)) {
        if (restarts-- == 0) break;
        sum = 0;
        count = 0;
      }
      if (count >= kFrontCells) {
        restarts = 0;
        continue;
      }
      sum += away;
      ++count;
    }
    bottom_[at(c)] = r - 1;
    front_mm_[at(c)] = count > 0 ? sum / static_cast<float>(count) : away;
  }
}

// No rounder than noise makes it.
bool FurnitureCutter::flat(const Grid& grid, const Ledge& ledge) const {
  const auto first = at(grid.index(ledge.c_first, top_[at(ledge.c_first)]));
  const float z = static_cast<float>(grid.depth[first]);
  const float mm = cell_mm(grid, z);
  const int columns = ledge.c_last - ledge.c_first + 1;
  const int base = std::max(1, static_cast<int>(kFlatBaseMm / mm + 0.5F));
  if (static_cast<float>(columns) * mm < kLedgeMinMm || columns < 2 * base + 1) return false;
  int flat = 0;
  int total = 0;
  for (int c = ledge.c_first + base; c + base <= ledge.c_last; ++c) {
    if (top_[at(c)] < 0 || top_[at(c - base)] < 0 || top_[at(c + base)] < 0) continue;
    const float bulge = 0.5F * (front_mm_[at(c - base)] + front_mm_[at(c + base)]) - front_mm_[at(c)];
    ++total;
    flat += std::fabs(bulge) < kFlatBulgeMm + kFlatBulgeQuanta * quantum_mm(z) ? 1 : 0;
  }
  return total > 0 && flat * 2 > total;
}

// Also what the floor band holds of the front: feet must not grow into it.
void FurnitureCutter::take(const Grid& grid, Vec3f ahead, const Ledge& ledge, std::span<std::uint8_t> chosen) {
  for (int c = ledge.c_first; c <= ledge.c_last; ++c) {
    if (top_[at(c)] < 0) continue;
    for (int r = top_[at(c)]; r <= bottom_[at(c)]; ++r) {
      const auto i = at(grid.index(c, r));
      chosen[i] = 0;
      cut_[i] = 1;
    }
    for (int r = bottom_[at(c)] + 1; r < grid.height; ++r) {
      const auto i = at(grid.index(c, r));
      if (chosen[i] != 0 || std::fabs(dot(ahead, grid.point(c, r)) - front_mm_[at(c)]) > kBandMm) break;
      cut_[i] = 1;
    }
  }
}

// The front goes on under the person's outline where a leg hides the ledge: along the line the front has.
void FurnitureCutter::take_beside(const Grid& grid, Vec3f ahead, const Ledge& ledge, std::span<std::uint8_t> chosen) {
  float count = 0, c_sum = 0, z_sum = 0, cc_sum = 0, cz_sum = 0;
  for (int c = ledge.c_first; c <= ledge.c_last; ++c) {
    if (top_[at(c)] < 0) continue;
    const float x = static_cast<float>(c - ledge.c_first);
    count += 1;
    c_sum += x;
    z_sum += front_mm_[at(c)];
    cc_sum += x * x;
    cz_sum += x * front_mm_[at(c)];
  }
  const float spread = count * cc_sum - c_sum * c_sum;
  if (spread <= 0) return;
  const float slope = (count * cz_sum - c_sum * z_sum) / spread;
  const float start = (z_sum - slope * c_sum) / count;
  const auto first = at(grid.index(ledge.c_first, top_[at(ledge.c_first)]));
  const float mm = cell_mm(grid, static_cast<float>(grid.depth[first]));
  const int reach = static_cast<int>(kBesideMm / mm);
  for (const int side : {-1, 1}) {
    const int edge = side < 0 ? ledge.c_first : ledge.c_last;
    for (int r = top_[at(edge)]; r <= bottom_[at(edge)]; ++r) {
      for (int step = 1; step <= reach; ++step) {
        const int c = edge + side * step;
        if (c < 0 || c >= grid.width) break;
        const auto i = at(grid.index(c, r));
        const Vec3f p = grid.point(c, r);
        const float line = start + slope * static_cast<float>(c - ledge.c_first);
        if (chosen[i] == 0 ||
            std::fabs(dot(ahead, p) - line) > kBesideToleranceMm + kBesideToleranceQuanta * quantum_mm(p.z))
          break;
        chosen[i] = 0;
        cut_[i] = 1;
      }
    }
  }
}

// A row of one surface in the picture may be several in space: parted where depth jumps. Shins are before the seat:
// what is behind its neighbours on both sides, or on one and flat, is the seat's front or the chair's.
void FurnitureCutter::cut_row(const Grid& grid, int row, float limit_mm, std::span<std::uint8_t> chosen) {
  const auto cell = [&](int c) { return at(grid.index(c, row)); };
  const auto z = [&](int c) { return static_cast<float>(grid.depth[cell(c)]); };
  const auto mine = [&](int c) {
    return c >= 0 && c < grid.width && chosen[cell(c)] != 0 && grid.height_mm[cell(c)] < limit_mm;
  };
  int behind_left = 0;  // 1: the part begins behind the one before it, -1: before it, 0: in the open
  for (int first = 0; first < grid.width;) {
    if (!mine(first)) {
      ++first;
      behind_left = 0;
      continue;
    }
    int last = first;
    const auto jump = [&](int c) { return z(c + 1) - z(c); };
    const auto parted = [&](int c) { return std::fabs(jump(c)) > kPartMm + quantum_mm(z(c)); };
    while (mine(last + 1) && !parted(last)) ++last;
    const int behind_right = !mine(last + 1) ? 0 : jump(last) > 0 ? -1 : 1;
    const int middle = (first + last) / 2;
    const float bulge = 0.5F * (z(first) + z(last)) - z(middle);
    const bool flat =
        last - first + 1 >= kFlatCellsMin && std::fabs(bulge) < kRowFlatMm + kRowQuanta * quantum_mm(z(middle));
    const bool shin = last - first + 1 >= kFlatCellsMin && bulge > kRowRoundMm + kRowQuanta * quantum_mm(z(middle));
    const bool between = behind_left > 0 && behind_right > 0 && !shin;
    const bool beside = behind_left + behind_right == 1 && flat;
    if (between || beside)
      for (int c = first; c <= last; ++c) cut_[cell(c)] = 1;
    behind_left = -behind_right;
    first = last + 1;
  }
}

// Legs of chairs, in a row: narrower than shins. A hole of one cell parts nothing.
void FurnitureCutter::find_posts(const Grid& grid, int row, float limit_mm, std::span<const std::uint8_t> chosen) {
  const auto mine = [&](int c) { return c >= 0 && c < grid.width && chosen[at(grid.index(c, row))] != 0; };
  const auto z = [&](int c) { return static_cast<float>(grid.depth[at(grid.index(c, row))]); };
  const auto goes_on = [&](int c, int next) {
    return mine(next) && std::fabs(z(next) - z(c)) < kPartMm + quantum_mm(z(c));
  };
  for (int first = 0; first < grid.width; ++first) {
    if (!mine(first)) continue;
    int last = first;
    while (goes_on(last, last + 1) || goes_on(last, last + 2)) last += goes_on(last, last + 1) ? 1 : 2;
    const float height = grid.height_mm[at(grid.index(first, row))];
    const float wide = static_cast<float>(last - first + 1) * cell_mm(grid, z(first));
    if (wide < kPostMm && height > kPostLowMm && height < limit_mm)
      for (int c = first; c <= last; ++c)
        if (mine(c)) island_[at(grid.index(c, row))] = kNarrow;
    first = last;
  }
}

// Those that stay so narrow for longer than an ankle.
void FurnitureCutter::cut_posts(const Grid& grid, float limit_mm, std::span<const std::uint8_t> chosen) {
  std::fill(island_.begin(), island_.end(), 0);
  for (int r = 0; r < grid.height; ++r) find_posts(grid, r, limit_mm, chosen);
  const auto narrow = [&](int c, int r) {
    for (int beside = std::max(0, c - 1); beside <= std::min(grid.width - 1, c + 1); ++beside)
      if (island_[at(grid.index(beside, r))] == kNarrow) return true;
    return false;
  };
  for (int c = 0; c < grid.width; ++c) {
    for (int first = 0; first < grid.height; ++first) {
      if (!narrow(c, first)) continue;
      int last = first;
      while (last + 1 < grid.height && narrow(c, last + 1)) ++last;
      int count = 0;
      float mm = 0;
      for (int r = first; r <= last; ++r) {
        const auto i = at(grid.index(c, r));
        if (island_[i] != kNarrow) continue;
        ++count;
        mm = cell_mm(grid, static_cast<float>(grid.depth[i]));
      }
      if (count > 0 && static_cast<float>(last - first + 1) * mm > kPostTallMm)
        for (int r = first; r <= last; ++r)
          if (island_[at(grid.index(c, r))] == kNarrow) cut_[at(grid.index(c, r))] = 1;
      first = last + 1;
    }
  }
}

// The legs under a seat's edge and its upper face.
void FurnitureCutter::cut_below_and_above(const Grid& grid, Vec3f ahead, int c, int r,
                                          std::span<std::uint8_t> chosen) {
  const auto start = at(grid.index(c, r));
  const float away = dot(ahead, grid.point(c, r));
  for (int below = r + 1; below < grid.height; ++below) {
    const auto i = at(grid.index(c, below));
    const float off = dot(ahead, grid.point(c, below)) - away;
    if (chosen[i] == 0 || std::fabs(off) > front_tolerance_mm(static_cast<float>(grid.depth[i]))) break;
    chosen[i] = 0;
    cut_[i] = 1;
  }
  for (int above = r - 1; above >= 0; --above) {
    const auto i = at(grid.index(c, above));
    if (chosen[i] == 0 || grid.height_mm[i] > grid.height_mm[start] + kTopFaceMm) break;
    chosen[i] = 0;
    cut_[i] = 1;
  }
}

void FurnitureCutter::cut_seat(const Grid& grid, Vec3f ahead, float limit_mm, std::span<std::uint8_t> chosen) {
  for (int r = 0; r < grid.height; ++r) cut_row(grid, r, limit_mm, chosen);
  cut_posts(grid, limit_mm, chosen);
  for (std::size_t i = 0; i < chosen.size(); ++i) chosen[i] = static_cast<std::uint8_t>(chosen[i] & (cut_[i] ^ 1));
  for (int r = 0; r < grid.height; ++r)
    for (int c = 0; c < grid.width; ++c)
      if (cut_[at(grid.index(c, r))] != 0) cut_below_and_above(grid, ahead, c, r, chosen);
}

// Median distance of what is between two heights.
float FurnitureCutter::distance_between(const Grid& grid, Vec3f ahead, float low_mm, float high_mm,
                                        std::span<const std::uint8_t> chosen) {
  std::fill(distances_.begin(), distances_.end(), 0);
  int count = 0;
  for (int r = 0; r < grid.height; ++r) {
    for (int c = 0; c < grid.width; ++c) {
      const auto i = at(grid.index(c, r));
      if (chosen[i] == 0 || grid.height_mm[i] < low_mm || grid.height_mm[i] > high_mm) continue;
      const int bin = static_cast<int>(dot(ahead, grid.point(c, r)) * (1.0F / kDistanceBinMm));
      ++distances_[at(std::clamp(bin, 0, kDistanceBins - 1))];
      ++count;
    }
  }
  int median = 0;
  for (int below = distances_[0]; below * 2 < count; below += distances_[at(median)]) ++median;
  return kDistanceBinMm * static_cast<float>(median);
}

// A seated person has the shins before the trunk; a bending person is as low, but has them behind.
float FurnitureCutter::shins_before_trunk_mm(const Grid& grid, Vec3f ahead, float tall_mm,
                                             std::span<const std::uint8_t> chosen) {
  return distance_between(grid, ahead, kTrunkLow * tall_mm, kTrunkHigh * tall_mm, chosen) -
         distance_between(grid, ahead, kLedgeLowMm, kSeatShare * tall_mm, chosen);
}

// The backrest and the legs under it: further away than the sides of the trunk. Arms and hands beside it are as far,
// but the surface goes on to them without a step.
void FurnitureCutter::cut_behind(const Grid& grid, Vec3f ahead, float tall_mm, std::span<std::uint8_t> chosen) {
  const float limit = distance_between(grid, ahead, kTrunkLow * tall_mm, kTrunkHigh * tall_mm, chosen) + kBehindMm;
  const auto beyond = [&](int cell) {
    const Vec3f p = grid.point(cell);
    return dot(ahead, p) - limit - quantum_mm(p.z);
  };
  const auto suspect = [&](int cell) {
    return chosen[at(cell)] != 0 && grid.height_mm[at(cell)] < kTrunkHigh * tall_mm && beyond(cell) >= 0;
  };
  std::fill(island_.begin(), island_.end(), 0);
  const int cells = grid.width * grid.height;
  int size = 0;
  for (int cell = 0; cell < cells; ++cell) {
    if (chosen[at(cell)] == 0 || suspect(cell) || grid.height_mm[at(cell)] < kTrunkLow * tall_mm) continue;
    stack_[at(size++)] = cell;
    island_[at(cell)] = 1;
  }
  for (int done = 0; done < size; ++done) {
    const int cell = stack_[at(done)];
    const float z = static_cast<float>(grid.depth[at(cell)]);
    const int c = cell % grid.width;
    for (const int step : {-1, 1, -grid.width, grid.width}) {
      const int other = cell + step;
      if (other < 0 || other >= cells || (step == -1 && c == 0) || (step == 1 && c + 1 == grid.width)) continue;
      if (island_[at(other)] != 0 || !suspect(other) || beyond(other) > kArmBehindMm) continue;
      if (std::fabs(static_cast<float>(grid.depth[at(other)]) - z) > kArmStepMm + kArmStepQuanta * quantum_mm(z))
        continue;
      island_[at(other)] = 1;
      stack_[at(size++)] = other;
    }
  }
  for (int cell = 0; cell < cells; ++cell) {
    if (island_[at(cell)] != 0 || !suspect(cell)) continue;
    chosen[at(cell)] = 0;
    cut_[at(cell)] = 1;
  }
}

// What hung on the person by what was taken: islands beside it, all of them low. Not a seated person's shin, parted
// from the thigh by a hem.
void FurnitureCutter::drop_loose(const Grid& grid, float limit_mm, bool seated, std::span<std::uint8_t> chosen) {
  std::fill(island_.begin(), island_.end(), 0);
  const int cells = grid.width * grid.height;
  for (int start = 0; start < cells; ++start) {
    if (chosen[at(start)] == 0 || island_[at(start)] != 0) continue;
    int size = 0;
    stack_[at(size++)] = start;
    island_[at(start)] = start + 1;
    bool low = true;
    bool beside = false;
    float lowest = 1e9F;
    float highest = 0;
    float area_mm2 = 0;
    for (int done = 0; done < size; ++done) {
      const int cell = stack_[at(done)];
      low = low && grid.height_mm[at(cell)] < limit_mm;
      lowest = std::min(lowest, grid.height_mm[at(cell)]);
      highest = std::max(highest, grid.height_mm[at(cell)]);
      const float mm = cell_mm(grid, static_cast<float>(grid.depth[at(cell)]));
      area_mm2 += mm * mm;
      const int c = cell % grid.width;
      const int r = cell / grid.width;
      for (int rr = std::max(0, r - 1); rr <= std::min(grid.height - 1, r + 1); ++rr) {
        for (int cc = std::max(0, c - 1); cc <= std::min(grid.width - 1, c + 1); ++cc) {
          const int other = grid.index(cc, rr);
          beside = beside || cut_[at(other)] != 0;
          if (chosen[at(other)] == 0 || island_[at(other)] != 0) continue;
          const float z = static_cast<float>(grid.depth[at(cell)]);
          if (std::fabs(static_cast<float>(grid.depth[at(other)]) - z) > depth_step_mm(z)) continue;
          island_[at(other)] = start + 1;
          stack_[at(size++)] = other;
        }
      }
    }
    const float tall = highest - lowest;
    const bool shin = seated && lowest < kLedgeLowMm && tall > kShinTallMinMm && area_mm2 > kShinThickMinMm * tall &&
                      area_mm2 < kShinThickMaxMm * tall;
    if (!low || !beside || shin) continue;
    for (int i = 0; i < size; ++i) {
      chosen[at(stack_[at(i)])] = 0;
      cut_[at(stack_[at(i)])] = 1;
    }
  }
}

bool FurnitureCutter::cut_ledges(const Grid& grid, Vec3f ahead, float limit_mm, std::span<std::uint8_t> chosen) {
  bool any = false;
  find_tops(grid, limit_mm, chosen);
  for (int c = 0; c < grid.width; ++c) {
    const Ledge ledge = next_ledge(grid, c);
    if (ledge.c_last < ledge.c_first) continue;
    follow_down(grid, ahead, ledge, chosen);
    if (!flat(grid, ledge)) continue;
    take(grid, ahead, ledge, chosen);
    take_beside(grid, ahead, ledge, chosen);
    any = true;
    c = ledge.c_last;
  }
  return any;
}

void FurnitureCutter::run(const Grid& grid, const FloorPlane& floor, std::span<std::uint8_t> chosen) {
  std::fill(cut_.begin(), cut_.end(), std::uint8_t{0});
  if (!floor.known) return;
  float tall_mm = 0;
  for (std::size_t i = 0; i < chosen.size(); ++i)
    tall_mm = std::max(tall_mm, chosen[i] != 0 ? grid.height_mm[i] : 0.0F);
  const float limit_mm = std::min(kLedgeHighMm, (tall_mm > kSeatedMaxMm ? kLedgeShare : kSeatedShare) * tall_mm);
  const Vec3f ahead = Vec3f{0, 0, 1} - floor.up * floor.up.z;
  const bool seated = tall_mm < kSeatedTallMm && shins_before_trunk_mm(grid, ahead, tall_mm, chosen) >
                                                     (tall_mm < kSeatedMaxMm ? -kBendsMm : kSeatedAheadMm);
  if (seated) {
    cut_seat(grid, ahead, kSeatShare * tall_mm, chosen);
    cut_behind(grid, ahead, tall_mm, chosen);
  }
  // Twice: what was taken may have stood before more of it.
  bool any = seated;
  for (int pass = 0; pass < 2 && cut_ledges(grid, ahead, limit_mm, chosen); ++pass) any = true;
  if (any) drop_loose(grid, limit_mm, seated, chosen);
}

}  // namespace im2fit::segment
