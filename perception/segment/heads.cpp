// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "perception/segment/blobs.h"

// The thresholds of this file: what each bounds and where it comes from. What breaks when one moves by 20 %:
// docs/notebook/perception.md. Sources:
//   [250]    each keeps 95 % of 250 dressed people's heads in furnished rooms (commit 1e3516a)
//   [corner] no second person in cupboard corners: SEVERAL_PEOPLE in 6 of 150 furnished rooms before, 0 or 1
//            after, all changes together (commit 37059cc)
//   [coats]  excludes coats on stands (commit 78a99e4): chosen on synthetic rooms, no measurement on
//            record
//   [rooms]  chosen on synthetic rooms, no measurement on record
//   [children] came with children of 1.0 to 1.1 m: of 12 of 1.0 to 1.37 m 3 were not found before
namespace im2fit::segment::heads_limits {

// Rows below the crown, mm, and what is measured in them.
constexpr float kGapBelowTopMm = 20.0F;    // a missing row so close to the top is noise; [rooms]
constexpr float kHeadBeginMm = 55.0F;      // the head is measured from here; [rooms]
constexpr float kHeadEndMm = 165.0F;       // to here, where the neck begins; [rooms]
constexpr float kCentreEndMm = 170.0F;     // the head's middle follows its rows down to here; [rooms]
constexpr float kNeckEndMm = 280.0F;       // the neck ends; [rooms]
constexpr float kTrunkBeginMm = 270.0F;    // the trunk and the shoulders begin; [250]
constexpr float kShouldersEndMm = 430.0F;  // the shoulders end; [rooms]
constexpr float kTrunkEndMm = 650.0F;      // the trunk is read to here; [coats]
constexpr float kHeadDepthMm = 280.0F;     // depth from the head's within which a row belongs to it; [rooms]
constexpr float kTrunkHalfMm = 180.0F;     // either side of the trunk's middle, where its bulge is read; [coats]

// Limits a head must keep.
constexpr float kHeadHeightMinMm = 1100.0F;  // above the floor, least: a seated adult's; [rooms]
constexpr float kHeadOnLegsMinMm = 900.0F;   // and of one who stands on legs, a child's of 1 m; [children]
constexpr float kLegsStatureMm = 1500.0F;  // of those whose legs the limits are of: a child's are thinner; [children]
constexpr float kNarrowestMinMm = 85.0F;   // width of its narrowest row, least; [250]
constexpr float kWidestMaxMm = 330.0F;     // of its widest row, most; [250]
constexpr float kWidthMinMm = 105.0F;      // mean width, least; [250]
constexpr float kWidthMaxMm = 270.0F;      // and most; [250]
constexpr float kNarrowestShareMin =
    0.45F;                                 // narrowest row over widest: below, it is cut in two or a corner; [corner]
constexpr float kNeckWidthMinMm = 90.0F;   // a neck below is a pole's; [rooms]
constexpr float kNeckShareMax = 1.25F;     // neck over head: above, it widens as a cupboard's top does; [corner]
constexpr float kShouldersMinMm = 220.0F;  // width of the shoulders, least; [250]
constexpr float kShouldersShareMin = 1.2F;      // over the head's, least; [250]
constexpr float kShoulderReachMinMm = 40.0F;    // beyond the head, least on the wider side; [250]
constexpr float kShoulderLackShareMax = 0.25F;  // of the head's width that one side may lack; [250]
constexpr float kHeadReliefMinMm =
    33.0F;  // heads recede by 50 to 65 mm to their outline, cupboard corners by 20; [corner]
constexpr float kHeadReliefQuanta = 0.2F;  // less so many disparity steps; [corner]
constexpr float kBackBulgeMinMm = 10.0F;   // of the trunk, rms, least: some backs are as flat as a coat; [coats]
constexpr float kBackBulgeQuanta = 0.35F;  // and so many disparity steps; [coats]

// Misfit: by how much limits that most people keep are missed, summed in units of a spread.
constexpr float kMisfitMax = 1.0F;              // most; [250]
constexpr float kMisfitOnLegsMax = 3.0F;        // most of a surface that has legs; [250]
constexpr float kUsualWidthMm = 192.0F;         // heads are narrower, mostly; [250]
constexpr float kUsualNeckMm = 150.0F;          // necks are narrower, mostly; [250]
constexpr float kSpreadMm = 25.0F;              // unit of both; [250]
constexpr float kUsualShouldersShare = 2.2F;    // shoulders over head are more, mostly; [250]
constexpr float kShouldersShareSpread = 0.25F;  // unit of that; [250]

// Which heads count.
constexpr float kVagueMm = 4500.0F;        // distance beyond which a head counts only without a better one; [corner]
constexpr float kVagueBulgeMm = 14.0F;     // trunk bulge below which it counts so; [rooms]
constexpr float kVagueBulgeQuanta = 0.5F;  // and so many disparity steps; [rooms]
constexpr float kPeakReachMm = 90.0F;      // a head's top is highest within that; [rooms]
constexpr float kHeadApartMm = 320.0F;     // between two heads of one surface, least; [rooms]

}  // namespace im2fit::segment::heads_limits

namespace im2fit::segment {

using namespace heads_limits;

namespace {

// Below a top, where a head may be. Columns of cells.
struct HeadShape {
  int centre = 0;
  int lo = 0, hi = 0;                        // of its last row
  float width_mm = 0;                        // mean, 55..165 mm below the top
  float narrowest_mm = 1e9F, widest_mm = 0;  // there
  float neck_mm = 1e9F;                      // narrowest, 165..280 mm below
  float shoulders_mm = 0;                    // widest, 270..430 mm below
  float left_mm = 0, right_mm = 0;           // what they reach beyond the head
  float relief_mm = 0;                       // of the head's middle before its edges
  float bulge_mm = 0;                        // of the trunk, rms
  bool cut = false;                          // by the picture's left or right border
};

// Widths and depths of rows from a top downwards: of the head, the neck, the shoulders and the trunk.
class HeadProbe {
 public:
  HeadProbe(const Grid& grid, std::span<const std::uint16_t> labels, int blob, int c, int r, float z_mm)
      : grid_(grid),
        labels_(labels),
        label_(static_cast<std::uint16_t>(blob + 1)),
        r_(r),
        z_mm_(z_mm),
        cell_mm_(cell_mm(grid, z_mm)) {
    shape_.centre = shape_.lo = shape_.hi = c;
  }
  // False where no head can be: the rows end above the shoulders, or the neck is a pole.
  bool measure();
  const HeadShape& shape() const { return shape_; }

 private:
  struct Run {
    int row = 0;
    int lo = 0, hi = -1;  // columns, inclusive
    float below_mm = 0;   // the top
    float width_mm = 0;
  };
  bool inside(int col, int row) const {
    const auto cell = at(grid_.index(col, row));
    return labels_[cell] == label_ && std::fabs(static_cast<float>(grid_.depth[cell]) - z_mm_) < kHeadDepthMm;
  }
  float z_at(int col, int row) const { return static_cast<float>(grid_.depth[at(grid_.index(col, row))]); }
  bool find_run(int row, Run& run) const;
  void add_head(const Run& run);
  void add_shoulders(const Run& run);
  void add_bulge(const Run& run);

  const Grid& grid_;
  std::span<const std::uint16_t> labels_;
  std::uint16_t label_;
  int r_;
  float z_mm_;
  float cell_mm_;
  HeadShape shape_;
  int head_rows_ = 0;
  int border_rows_ = 0;
  int bulge_rows_ = 0;
};

// The run of the row under the head's middle, across gaps of one cell; false: there is none.
bool HeadProbe::find_run(int row, Run& run) const {
  const int centre = shape_.centre;
  int start = centre;
  for (int away = 1; away <= 3 && !inside(start, row); ++away) {
    if (centre - away >= 0 && inside(centre - away, row))
      start = centre - away;
    else if (centre + away < grid_.width && inside(centre + away, row))
      start = centre + away;
  }
  if (!inside(start, row)) return false;
  int lo = start;
  int hi = start;
  while (lo > 0 && (inside(lo - 1, row) || (lo > 1 && inside(lo - 2, row)))) --lo;
  while (hi + 1 < grid_.width && (inside(hi + 1, row) || (hi + 2 < grid_.width && inside(hi + 2, row)))) ++hi;
  run = {row, lo, hi, static_cast<float>(row - r_) * cell_mm_, static_cast<float>(hi - lo + 1) * cell_mm_};
  return true;
}

void HeadProbe::add_head(const Run& run) {
  shape_.narrowest_mm = std::min(shape_.narrowest_mm, run.width_mm);
  shape_.widest_mm = std::max(shape_.widest_mm, run.width_mm);
  shape_.width_mm += run.width_mm;
  if (inside(run.lo, run.row) && inside(run.hi, run.row) && inside(shape_.centre, run.row))
    shape_.relief_mm += 0.5F * (z_at(run.lo, run.row) + z_at(run.hi, run.row)) - z_at(shape_.centre, run.row);
  shape_.lo = run.lo;
  shape_.hi = run.hi;
  border_rows_ += run.lo == 0 || run.hi == grid_.width - 1 ? 1 : 0;
  ++head_rows_;
}

void HeadProbe::add_shoulders(const Run& run) {
  shape_.shoulders_mm = std::max(shape_.shoulders_mm, run.width_mm);
  shape_.left_mm = std::max(shape_.left_mm, static_cast<float>(shape_.lo - run.lo) * cell_mm_);
  shape_.right_mm = std::max(shape_.right_mm, static_cast<float>(run.hi - shape_.hi) * cell_mm_);
}

// How far the middle lies before the line between its sides.
void HeadProbe::add_bulge(const Run& run) {
  const int centre = shape_.centre;
  const int half = std::max(1, static_cast<int>(kTrunkHalfMm / cell_mm_));
  const int left = std::max(run.lo + 1, centre - half);
  const int right = std::min(run.hi - 1, centre + half);
  const bool across = left < centre && centre < right;
  if (!across || !inside(left, run.row) || !inside(right, run.row) || !inside(centre, run.row)) return;
  const float share = static_cast<float>(centre - left) / static_cast<float>(right - left);
  const float z_left = z_at(left, run.row);
  const float bulge = z_left + share * (z_at(right, run.row) - z_left) - z_at(centre, run.row);
  shape_.bulge_mm += bulge * bulge;
  ++bulge_rows_;
}

bool HeadProbe::measure() {
  for (int row = r_; row < grid_.height; ++row) {
    const float below = static_cast<float>(row - r_) * cell_mm_;
    if (below > kTrunkEndMm) break;
    Run run;
    if (!find_run(row, run)) {
      if (below < kNeckEndMm && below > kGapBelowTopMm) return false;
      continue;
    }
    if (below <= kCentreEndMm) shape_.centre = (run.lo + run.hi) / 2;
    if (below >= kHeadBeginMm && below <= kHeadEndMm) add_head(run);
    if (below >= kHeadEndMm && below < kNeckEndMm) {
      if (run.width_mm < kNeckWidthMinMm - cell_mm_) return false;
      shape_.neck_mm = std::min(shape_.neck_mm, run.width_mm);
    }
    if (below >= kTrunkBeginMm) add_bulge(run);
    if (below >= kTrunkBeginMm && below <= kShouldersEndMm) add_shoulders(run);
  }
  if (head_rows_ == 0) return false;
  shape_.width_mm /= static_cast<float>(head_rows_);
  shape_.relief_mm /= static_cast<float>(head_rows_);
  shape_.cut = border_rows_ * 2 > head_rows_;
  shape_.bulge_mm = bulge_rows_ > 0 ? std::sqrt(shape_.bulge_mm / static_cast<float>(bulge_rows_)) : 1e9F;
  return true;
}

// A head: 85..330 mm wide over a hand's breadth below its top, rounded, with shoulders wider than it under it.
// A raised hand fails at the wrist, a box at its missing shoulders, a hat over a coat at the stand's thin
// pole or the coat's flat front.
bool head_at(const Grid& grid, const Blobs& found, int blob, int c, int r, Head& out) {
  const auto label = static_cast<std::uint16_t>(blob + 1);
  if (r < 1 || r + 3 >= grid.height) return false;
  int probe = grid.index(c, r + 2);
  if (found.labels[at(probe)] != label) probe = grid.index(c, r);
  if (found.labels[at(probe)] != label) return false;
  const float z_head = static_cast<float>(grid.depth[at(probe)]);
  const float mm = cell_mm(grid, z_head);
  HeadProbe rows(grid, found.labels, blob, c, r, z_head);
  if (!rows.measure()) return false;
  const HeadShape& head = rows.shape();
  const float width = head.width_mm;
  if (head.cut || head.narrowest_mm < kNarrowestShareMin * head.widest_mm)
    return false;  // cut in two; a cupboard's corner
  if (head.neck_mm > kNeckShareMax * width + mm)
    return false;  // widens steadily, as a cupboard's top seen over its corner
  if (head.narrowest_mm < kNarrowestMinMm - mm || head.widest_mm > kWidestMaxMm + mm || width < kWidthMinMm ||
      width > kWidthMaxMm + 0.5F * mm)
    return false;
  if (head.shoulders_mm < std::max(kShouldersMinMm, kShouldersShareMin * width)) return false;
  if (std::max(head.left_mm, head.right_mm) < kShoulderReachMinMm ||
      std::min(head.left_mm, head.right_mm) < -kShoulderLackShareMax * width)
    return false;
  if (head.relief_mm < kHeadReliefMinMm - kHeadReliefQuanta * quantum_mm(z_head)) return false;
  // Some backs are as flat as a coat.
  if (head.bulge_mm < kBackBulgeMinMm + kBackBulgeQuanta * quantum_mm(z_head)) return false;
  // Each limit keeps 95 % of 250 dressed people's heads in furnished rooms; hats on chairs and stands miss several.
  const int trunk_first = r + static_cast<int>(kTrunkBeginMm / mm);
  const int trunk_last = r + static_cast<int>(kTrunkEndMm / mm);
  const float misfit =
      trunk_misfit(trunk_shape(grid, found.labels, blob, head.centre, trunk_first, trunk_last, z_head)) +
      std::max(0.0F, (width - kUsualWidthMm) / kSpreadMm) +
      std::max(0.0F, (head.neck_mm - kUsualNeckMm) / kSpreadMm) +
      std::max(0.0F, (kUsualShouldersShare - head.shoulders_mm / width) / kShouldersShareSpread);
  if (misfit > kMisfitMax && (misfit > kMisfitOnLegsMax || !has_legs(grid, found, blob))) return false;
  out.vague = head.bulge_mm < kVagueBulgeMm + kVagueBulgeQuanta * quantum_mm(z_head) || z_head > kVagueMm;
  out.blob = blob;
  out.c = head.centre;
  out.r = r;
  out.top_mm = grid.point(probe);
  out.width_mm = width;
  return true;
}

}  // namespace

void find_heads(const Grid& grid, const FloorPlane& floor, int b, Blobs& found) {
  const Blob& blob = found.blobs[at(b)];
  const auto label = static_cast<std::uint16_t>(b + 1);
  std::fill(found.top.begin(), found.top.end(), static_cast<std::int16_t>(grid.height));
  for (int c = blob.c_min; c <= blob.c_max; ++c)
    for (int r = blob.r_min; r <= blob.r_max; ++r)
      if (found.labels[at(grid.index(c, r))] == label) {
        found.top[at(c)] = static_cast<std::int16_t>(r);
        break;
      }
  for (int c = blob.c_min; c <= blob.c_max; ++c) {
    const int r = found.top[at(c)];
    if (r >= grid.height) continue;
    const float z = static_cast<float>(grid.depth[at(grid.index(c, r))]);
    const int reach = std::max(1, static_cast<int>(kPeakReachMm / cell_mm(grid, z)));
    bool peak = true;
    for (int d = -reach; d <= reach && peak; ++d) {
      const int other = c + d;
      if (d == 0 || other < blob.c_min || other > blob.c_max) continue;
      if (found.top[at(other)] < r || (found.top[at(other)] == r && d < 0)) peak = false;  // leftmost of a flat top
    }
    if (!peak) continue;
    int flat = c;  // middle of a flat top
    while (flat + 1 <= blob.c_max && found.top[at(flat + 1)] == r && flat - c < reach) ++flat;
    Head head;
    if (!head_at(grid, found, b, (c + flat) / 2, r, head)) continue;
    if (floor.known) {
      const float height = grid.height_mm[at(grid.index((c + flat) / 2, r))];
      if (height < kHeadOnLegsMinMm || height > kHeadHeightMaxMm) continue;
      if (height < kHeadHeightMinMm && !has_legs(grid, found, b, height / kLegsStatureMm)) continue;
    }
    bool apart = true;
    for (int h = 0; h < found.head_count; ++h) {
      const Vec3f d = found.heads[at(h)].top_mm - head.top_mm;
      if (found.heads[at(h)].blob == b && d.x * d.x + d.z * d.z < kHeadApartMm * kHeadApartMm) apart = false;
    }
    if (apart && found.head_count < kHeadCountMax) found.heads[at(found.head_count++)] = head;
  }
}

}  // namespace im2fit::segment
