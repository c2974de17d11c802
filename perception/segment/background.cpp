// SPDX-License-Identifier: Apache-2.0
#include "perception/segment/background.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "perception/segment/person_tracker.h"

// The thresholds of this file: what each bounds and where it comes from. What breaks when one moves by 20 %:
// docs/notebook/perception.md. Sources:
//   [still] came with the background (commit c186dfc); single frames are unchanged by it, no other measurement
//           on record
namespace im2fit::segment::background_limits {

constexpr int kLearnedFrames = 60;         // two seconds: longer than people stand unrecognised; [still]
constexpr int kEvidenceMax = 240;          // frames that something nearer must stay to become the background; [still]
constexpr float kKeepoutMm = 350.0F;       // beside people and before them nothing is learned; [still]
constexpr float kKeepoutDepthMm = 700.0F;  // of them in depth; [still]
constexpr int kKnownMin = 1000;            // cells, least, to decide whether the camera moved; [still]
constexpr float kTurnMax = 0.02F;          // of the floor's normal: 1.1 degrees; [still]
constexpr float kLiftMaxMm = 40.0F;        // of the camera above the floor; [still]

}  // namespace im2fit::segment::background_limits

namespace im2fit::segment {

using namespace background_limits;

namespace {

// Noise and rounding of a still surface, mm: 10 and some more than a disparity step.
int tolerance_mm(std::uint16_t z) {
  return 10 + static_cast<int>((std::uint32_t{z} * z) >> 16 >> 2);
}

// The whole depths that are less than kKeepoutDepthMm from z_mm.
struct Depths {
  int first = 0, count = 0;
};
Depths depths_about(float z_mm) {
  constexpr int kMost = std::numeric_limits<std::uint16_t>::max();
  const auto near = [&](int depth) { return std::fabs(static_cast<float>(depth) - z_mm) < kKeepoutDepthMm; };
  if (!(z_mm > -kKeepoutDepthMm && z_mm < static_cast<float>(kMost) + kKeepoutDepthMm)) return {};
  // Not farther off than a rounded difference is.
  int first = std::clamp(static_cast<int>(z_mm - kKeepoutDepthMm) - 1, 0, kMost);
  int last = std::clamp(static_cast<int>(z_mm + kKeepoutDepthMm) + 1, 0, kMost);
  while (first <= last && !near(first)) ++first;
  while (last >= first && !near(last)) --last;
  return {first, last - first + 1};
}

}  // namespace

Background::Background(const Grid& grid)
    : depth_(grid.depth.size()),
      evidence_(grid.depth.size()),
      kept_out_(grid.depth.size()),
      shown_(grid.depth.size()) {}

void Background::reset() {
  std::fill(depth_.begin(), depth_.end(), std::uint16_t{0});
  std::fill(evidence_.begin(), evidence_.end(), std::uint8_t{0});
  std::fill(shown_.begin(), shown_.end(), std::uint8_t{0});
  floor_ = {};
}

bool Background::floor_moved(const FloorPlane& floor) const {
  return floor.known && floor_.known &&
         (norm(floor.up - floor_.up) > kTurnMax ||
          std::fabs(floor.camera_height_mm - floor_.camera_height_mm) > kLiftMaxMm);
}

// Finds the cells that show the background. True when the far field moved: of the cells known and seen, a third shows
// something else, nearer or farther.
bool Background::compare(const Grid& grid) {
  const std::uint16_t *z = grid.depth.data(), *known_z = depth_.data();
  const std::uint8_t *evidence = evidence_.data(), *kept_out = kept_out_.data();
  std::uint8_t* shown = shown_.data();
  int known = 0;
  int other = 0;
  for (std::size_t i = 0, count = depth_.size(); i < count; ++i) {
    const int away = std::abs(z[i] - (known_z[i] >> 2));
    const int learned = evidence[i] >= kLearnedFrames;
    const int same = away <= tolerance_mm(z[i]);
    const int counts = learned & (z[i] != 0) & (kept_out[i] == 0);
    shown[i] = static_cast<std::uint8_t>(learned & same);
    known += counts;
    other += counts & (same ^ 1);
  }
  return known >= kKnownMin && other * 3 > known;
}

void Background::keep_out(const Grid& grid, std::span<const Keepout> keepouts) {
  std::fill(kept_out_.begin(), kept_out_.end(), std::uint8_t{0});
  for (const Keepout& k : keepouts) {
    const int beside = static_cast<int>(kKeepoutMm * grid.intrinsics.fx / (static_cast<float>(grid.step) * k.z_mm));
    const int c_min = std::max(0, k.c_min - beside);
    const int c_max = std::min(grid.width - 1, k.c_max + beside);
    const Depths kept = depths_about(k.z_mm);
    if (kept.count == 0) continue;
    const auto first = static_cast<std::uint16_t>(kept.first), last = static_cast<std::uint16_t>(kept.count - 1);
    for (int r = 0; r < grid.height; ++r) {
      const std::uint16_t* depth = grid.depth.data() + grid.index(0, r);
      std::uint8_t* __restrict out = kept_out_.data() + grid.index(0, r);
      for (int c = c_min; c <= c_max; ++c)
        out[c] = static_cast<std::uint8_t>(out[c] | (static_cast<std::uint16_t>(depth[c] - first) <= last ? 1 : 0));
    }
  }
}

void Background::observe(const Grid& grid, const FloorPlane& floor) {
  if (compare(grid) || floor_moved(floor)) reset();
  if (!floor_.known) floor_ = floor;
}

void Background::learn(const Grid& grid, std::span<const Keepout> keepouts, std::span<const std::uint8_t> taken) {
  keep_out(grid, keepouts);
  const std::uint16_t* seen = grid.depth.data();
  const std::uint8_t *is_taken = taken.data(), *kept_out = kept_out_.data();
  std::uint16_t* __restrict depth = depth_.data();
  std::uint8_t* __restrict evidence = evidence_.data();
  // All ones or all zeros, chosen from with & and |: branches, even those between two values, stop the vectoriser.
  const auto pick = [](int mask, int a, int b) { return (a & mask) | (b & ~mask); };
  for (std::size_t i = 0, count = depth_.size(); i < count; ++i) {
    const int z = seen[i], before = depth[i], evidence_before = evidence[i];
    const int off = z * 4 - before;
    const int away = off < 0 ? -off : off;
    const int same = -static_cast<int>(away <= 4 * tolerance_mm(seen[i]));
    const int gone = -static_cast<int>((off > 0) | (evidence_before == 0));  // what stood there
    const int own = -static_cast<int>((z != 0) & (is_taken[i] != 0));
    const int learns = -static_cast<int>((z != 0) & (is_taken[i] == 0) & (kept_out[i] == 0));
    const int more = evidence_before + static_cast<int>(evidence_before < kEvidenceMax);
    const int learned = pick(same, more, pick(gone, 1, evidence_before - 1));
    const int learned_z = pick(same, before + off / 8, pick(gone, z * 4, before));
    depth[i] = static_cast<std::uint16_t>(pick(learns, learned_z, before));
    evidence[i] = static_cast<std::uint8_t>(pick(learns, learned, evidence_before & ~own));
  }
}

}  // namespace im2fit::segment
