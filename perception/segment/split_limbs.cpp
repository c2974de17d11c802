// SPDX-License-Identifier: Apache-2.0
#include "perception/segment/split_limbs.h"

#include <algorithm>
#include <cmath>

// The thresholds of this file: what each bounds and where it comes from. What breaks when one moves by 20 %:
// docs/notebook/perception.md. Sources:
//   [limbs]    came with legs under skirts and arms behind the trunk; tried on 250 furnished, dressed scenes,
//              no figures on record (commit 3dafe52)
//   [hands]    came with cut-off forearms: 4 of 100 free poses lost a limb or the person before (commit
//              9f75025)
//   [pointing] keeps hands that point at the camera, excludes cupboard corners as heads (commit 37059cc)
//   [flat]     excludes boxes on stools as hands, IoU p5 0.9476, 0.9465, 0.9532 before; no figures after (commit
//              cb455a6)
//   [rooms]    chosen on synthetic rooms, no measurement on record
namespace im2fit::segment::split_limbs_limits {

// Hands and forearms before the body.
constexpr float kIslandAreaMaxM2 = 0.12F;    // of any limb, most: a forearm pointing at the camera; [hands]
constexpr float kForearmMaxMm = 600.0F;      // length with the hand, most; [hands]
constexpr float kForearmThickMinMm = 70.0F;  // area over length, least: table tops are thinner; [rooms]
constexpr float kForearmAreaMaxM2 = 0.08F;   // area, most; [hands]
constexpr float kHandHeightMinMm = 400.0F;   // above the floor, least: below stand boxes and chairs; [rooms]
constexpr float kFlatAreaMinM2 = 0.02F;      // a flat island that large is not a palm; [flat]
constexpr float kFlatReliefMaxMm = 5.0F;     // relief below which it is flat; [flat]
constexpr float kFlatReliefQuanta = 0.3F;    // and so many disparity steps; [flat]
constexpr float kHandGapMaxMm = 280.0F;      // in space from the person, most: the forearm is hidden; [rooms]
constexpr float kPointingMm = 250.0F;        // before the body: may hide its whole arm; [pointing]
constexpr float kPointingGapMaxMm = 450.0F;  // gap then, most; [pointing]
constexpr float kHandMaxMm = 320.0F;         // length of a hand alone, most; [pointing]
constexpr float kElbowGapMaxMm = 100.0F;     // gap of others, most; [hands]
constexpr int kGapReachCells = 9;            // how far the person is searched about an island; [rooms]

// Arms and legs behind it.
constexpr float kLimbMinMm = 150.0F;       // length, least; [limbs]
constexpr float kLimbMaxMm = 900.0F;       // and most; [limbs]
constexpr float kLimbThickMinMm = 38.0F;   // area over length, least: legs of chairs are thinner; [limbs]
constexpr float kArmThickMaxMm = 95.0F;    // and most, of an arm; [limbs]
constexpr float kLegThickMaxMm = 120.0F;   // of a leg; [limbs]
constexpr float kLimbSlender = 1.6F;       // length over width, least; [limbs]
constexpr float kLimbReliefMinMm = 12.0F;  // from its best plane, least: fronts of boxes are flatter; [limbs]
constexpr float kArmGapMaxMm = 250.0F;     // in space, behind the trunk; [limbs]
constexpr float kLegGapMaxMm = 130.0F;     // behind the hem of a skirt; [limbs]
constexpr int kLimbTouchMin = 2;           // cells that touch the person, least; [limbs]
constexpr float kLegTopMaxMm = 1000.0F;    // a leg's top above the floor, most; [limbs]
constexpr float kLegEndMaxMm = 200.0F;     // and its end; [limbs]
constexpr float kArmEndMinMm = 350.0F;     // an arm's end above the floor, least; [limbs]

// Islands within the outline, and islands that lie on another surface.
constexpr float kEnclosedMinMm = 400.0F;  // above the floor, least: boxes stand between legs; [limbs]
constexpr float kHeldMm = 120.0F;         // most, depth step to the surface that holds it from below; [limbs]

}  // namespace im2fit::segment::split_limbs_limits

namespace im2fit::segment {

using namespace split_limbs_limits;

SplitLimbJoiner::SplitLimbJoiner()
    : touch_(at(kBlobCountMax)),
      border_(at(kBlobCountMax)),
      gap_mm_(at(kBlobCountMax)),
      gap_max_mm_(at(kBlobCountMax)),
      kind_(at(kBlobCountMax)),
      ends_(at(kBlobCountMax)),
      held_(at(kBlobCountMax)),
      tops_(at(kBlobCountMax)),
      hung_(at(kBlobCountMax)) {}

void SplitLimbJoiner::list_candidates(const Grid& grid, std::span<const Blob> list, bool floor_known, int person) {
  const Blob& body = list[at(person)];
  for (std::size_t b = 0; b < list.size(); ++b) {
    const Blob& other = list[b];
    const float z = other.centroid_mm.z;
    const float cell = cell_mm(grid, z);
    kind_[b] = Kind::no;
    if (other.person || b == at(person) || z < body.centroid_mm.z - 900.0F || z > body.centroid_mm.z + 500.0F)
      continue;
    const float wide = static_cast<float>(other.c_max - other.c_min + 1) * cell;
    const float tall = static_cast<float>(other.r_max - other.r_min + 1) * cell;
    const float long_mm = std::sqrt(wide * wide + tall * tall);
    const float thick_mm = other.area_m2 * 1e6F / long_mm;
    const bool slender = long_mm > kLimbMinMm && long_mm < kLimbMaxMm && thick_mm > kLimbThickMinMm &&
                         long_mm > kLimbSlender * thick_mm && other.relief_mm > kLimbReliefMinMm;
    const bool leg = other.height_min_mm < kLegEndMaxMm && other.height_max_mm < kLegTopMaxMm;
    if (slender && (leg || other.r_max >= grid.height - 2) && thick_mm < kLegThickMaxMm) {
      kind_[b] = Kind::leg;
      gap_max_mm_[b] = kLegGapMaxMm;
    } else if (slender && (!floor_known || other.height_min_mm > kArmEndMinMm) && thick_mm < kArmThickMaxMm) {
      kind_[b] = Kind::arm;
      gap_max_mm_[b] = kArmGapMaxMm;
    }
    if (other.area_m2 >= kIslandAreaMaxM2) continue;
    if (kind_[b] == Kind::no && (!floor_known || other.height_min_mm > kEnclosedMinMm)) kind_[b] = Kind::enclosed;
    const float reach = static_cast<float>(std::max(other.c_max - other.c_min, other.r_max - other.r_min)) * cell;
    const bool off_floor = !floor_known || other.height_min_mm > kHandHeightMinMm;
    // Boxes on stools are as large, but flat.
    const bool flat =
        other.area_m2 > kFlatAreaMinM2 && other.relief_mm < kFlatReliefMaxMm + kFlatReliefQuanta * quantum_mm(z);
    if (flat) {
      kind_[b] = Kind::no;
      continue;
    }
    const float before = body.centroid_mm.z - z;
    const bool hand = reach < kForearmMaxMm + 80.0F && other.area_m2 < kForearmAreaMaxM2 && off_floor &&
                      other.height_max_mm - other.height_min_mm > kForearmThickMinMm;
    if (!hand) continue;
    const float gap_max = before > kPointingMm && reach < kHandMaxMm ? kPointingGapMaxMm
                          : before > 60.0F && reach < kForearmMaxMm  ? kHandGapMaxMm
                                                                     : kElbowGapMaxMm;
    if (kind_[b] == Kind::arm && gap_max < kArmGapMaxMm) continue;
    kind_[b] = Kind::hand;
    gap_max_mm_[b] = gap_max;
  }
}

// An island that continues below as another surface, at the same depth, lies on that surface: boxes on stools. An
// island that begins under the person hangs from it: legs.
void SplitLimbJoiner::scan_along(const Grid& grid, std::span<const std::uint16_t> labels,
                                 std::span<const std::uint8_t> chosen, int r_first, int r_last) {
  std::fill(ends_.begin(), ends_.end(), 0);
  std::fill(held_.begin(), held_.end(), 0);
  std::fill(tops_.begin(), tops_.end(), 0);
  std::fill(hung_.begin(), hung_.end(), 0);
  const auto row = at(grid.width);
  for (int r = std::max(2, r_first); r <= std::min(grid.height - 4, r_last); ++r) {
    for (int c = 0; c < grid.width; ++c) {
      const auto i = at(grid.index(c, r));
      const std::uint16_t own = labels[i];
      if (own == 0 || kind_[at(own - 1)] == Kind::no) continue;
      if (labels[i - row] != own) {
        ++tops_[at(own - 1)];
        hung_[at(own - 1)] += chosen[i - row] | chosen[i - 2 * row];
      }
      if (labels[i + row] == own) continue;
      ++ends_[at(own - 1)];
      for (int d = 1; d <= 3; ++d) {
        const auto below = at(grid.index(c, r + d));
        if (labels[below] == own || chosen[below] != 0) break;
        if (labels[below] == 0) continue;
        const int away = static_cast<int>(grid.depth[below]) - static_cast<int>(grid.depth[i]);
        if (static_cast<float>(away) < kHeldMm) ++held_[at(own - 1)];
        break;
      }
    }
  }
}

bool SplitLimbJoiner::belongs(const Blob& blob, std::size_t index, const Blob& body) const {
  const Kind kind = kind_[index];
  const bool held = held_[index] * 2 > ends_[index];
  if (kind == Kind::no || held) return false;
  const auto touch = static_cast<float>(touch_[index]);
  const bool enclosed = blob.centroid_mm.z < body.centroid_mm.z + 130.0F && touch_[index] > 0 &&
                        touch >= 0.55F * static_cast<float>(border_[index]);
  if (enclosed) return true;
  if (kind == Kind::leg && hung_[index] * 3 < tops_[index]) return false;
  if (kind == Kind::leg || kind == Kind::arm)
    return touch_[index] >= kLimbTouchMin && gap_mm_[index] < gap_max_mm_[index];
  return kind == Kind::hand && gap_mm_[index] < gap_max_mm_[index];
}

// A hand or forearm held towards the camera is an island of its own: no larger than that, before the body, off the
// floor, and a short distance in space from what is already the person. So are legs below the hem of a skirt and arms
// behind the back: slender, beside the person in the picture, a short distance behind. Islands inside the outline
// belong as well.
void SplitLimbJoiner::run(const Grid& grid, const Blobs& found, bool floor_known, int person,
                          std::span<std::uint8_t> chosen) {
  const std::span<const std::uint16_t> labels = found.labels;
  const auto list = found.list();
  const auto label = static_cast<std::uint16_t>(person + 1);
  for (std::size_t i = 0; i < chosen.size(); ++i) chosen[i] = labels[i] == label ? 1 : 0;
  list_candidates(grid, list, floor_known, person);
  int r_first = grid.height;
  int r_last = -1;
  for (std::size_t b = 0; b < list.size(); ++b) {
    if (kind_[b] == Kind::no || list[b].cell_count == 0) continue;
    r_first = std::min(r_first, list[b].r_min);
    r_last = std::max(r_last, list[b].r_max);
  }
  if (r_last < 0) return;
  scan_along(grid, labels, chosen, r_first, r_last);
  for (int pass = 0; pass < 2; ++pass) {  // a hand may hang on a wrist that is an island itself
    std::fill(touch_.begin(), touch_.end(), 0);
    std::fill(border_.begin(), border_.end(), 0);
    std::fill(gap_mm_.begin(), gap_mm_.end(), 1e9F);
    for (int r = std::max(1, r_first); r <= std::min(grid.height - 2, r_last); ++r) {
      for (int c = 1; c + 1 < grid.width; ++c) {
        const int cell = grid.index(c, r);
        const std::uint16_t own = labels[at(cell)];
        if (own == 0 || chosen[at(cell)] != 0 || kind_[at(own - 1)] == Kind::no) continue;
        scan_around(grid, labels, chosen, c, r);
      }
    }
    for (std::size_t b = 0; b < list.size(); ++b) {
      const Blob& blob = list[b];
      if (kind_[b] == Kind::no || blob.cell_count == 0 || !belongs(blob, b, list[at(person)])) continue;
      for (int r = blob.r_min; r <= blob.r_max; ++r)
        for (int c = blob.c_min; c <= blob.c_max; ++c)
          if (labels[at(grid.index(c, r))] == b + 1) chosen[at(grid.index(c, r))] = 1;
    }
  }
}

// How much of a candidate's border faces the person, and how near in space it comes.
void SplitLimbJoiner::scan_around(const Grid& grid, std::span<const std::uint16_t> labels,
                                  std::span<const std::uint8_t> chosen, int c, int r) {
  const int cell = grid.index(c, r);
  const std::uint16_t own = labels[at(cell)];
  const auto b = at(own - 1);
  bool edge = false;
  for (const int step : {-1, 1, -grid.width, grid.width}) {
    int other = cell + step;
    if (labels[at(other)] == own) continue;
    edge = true;
    const int next = other + step;
    if (grid.depth[at(other)] == 0 && next >= 0 && next < static_cast<int>(labels.size())) other = next;
    ++border_[b];
    if (chosen[at(other)] != 0) ++touch_[b];
  }
  if (!edge || kind_[b] == Kind::enclosed) return;
  const Vec3f here = grid.point(cell);
  const int first = std::max(0, c - kGapReachCells), end = std::min(grid.width, c + kGapReachCells + 1);
  const int together = static_cast<int>(kTogether);
  for (int rr = std::max(0, r - kGapReachCells); rr <= std::min(grid.height - 1, r + kGapReachCells); ++rr) {
    for (int cc = first; cc < end; ++cc) {
      const int other = grid.index(cc, rr);
      if (cc + together <= end && none(&chosen[at(other)])) {
        cc += together - 1;
        continue;
      }
      if (chosen[at(other)] != 0) gap_mm_[b] = std::min(gap_mm_[b], norm(grid.point(other) - here));
    }
  }
}

}  // namespace im2fit::segment
