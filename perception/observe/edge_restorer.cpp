// SPDX-License-Identifier: Apache-2.0
#include "perception/observe/edge_restorer.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

// The thresholds of this file.
namespace im2fit::edge_restorer_limits {

// The floor below a camera at height h recedes by z z/(f h) from pixel to pixel. A surface that recedes faster than
// the floor of a camera at this height is not a surface people stand on.
constexpr int kCameraHeightLeastMm = 800;
constexpr int kSlopeLeastMm = 24;   // a pixel: noise of any sensor within 3 m stays below three quarters of it
constexpr int kFarthestMm = 20000;  // farther, the same: its square must fit

// A step that is repaired: less than a trunk's half depth, so that arms before the trunk count.
constexpr int kStepMinMm = 150;
// A step that is judged: the skin's own recession beside an outline, 55 mm in the last pixel of 256 across, is then
// less than the eighth below which a value is not called a bridge.
constexpr int kJudgedMinMm = 450;
constexpr int kBridgeEighths = 1;
// From surface to surface, in parts of the picture's long side: 10 px of 256. 5x5 pixels blended make five, a
// bilinear picture of a quarter of the resolution four, the skin's recession two more.
constexpr int kReachAcross = 25, kReachLeastPx = 8;
// Of them without data: four where 3x3 pixels were dropped beside flying ones.
constexpr int kGapAcross = 42, kGapLeastPx = 6;

constexpr int kSkinMm = 40;  // off its surface: as far as a mask follows it (kernels/membership)

// What lies between surfaces, as an angle: 3x3 pixels of 256 across blended make 2.1 px or 0.009, 5x5 4 px or 0.017,
// a hand at 2.3 m is 0.035 to 0.05 wide. Dropped beside time of flight's own flying pixels 3.7 px or 0.016, the same
// after a blend of 3x3 4.6 px or 0.020. im2fit-lab eval, 12 people a condition (docs/notebook/phones.md).
constexpr float kBridgeMostRad = 0.0125F, kGapMostRad = 0.0178F;

constexpr int kLineStep = 4;              // every fourth row and column is judged
constexpr std::uint32_t kJudgedMin = 60;  // steps, before a decision: the rate is then within 0.1
// Every frame is judged until so many steps, which give rates within 0.03, or so many frames, 2 s, were seen. Then
// only a changed driver setting remains to be noticed, and judging costs 2.9 M instructions (AArch64, 640x480).
constexpr std::uint32_t kJudgedEnough = 1024, kJudgedFrames = 60;
constexpr std::uint32_t kJudgeEvery = 8;
constexpr std::uint32_t kJudgedMany = 4096;  // then old ones count half: a driver's setting may change

}  // namespace im2fit::edge_restorer_limits

namespace im2fit {

using namespace edge_restorer_limits;

namespace {

// A row or column.
template <class T>
struct Line {
  T* pixels;
  std::ptrdiff_t step;
  int count;
  T& operator[](int i) const { return pixels[i * step]; }
};

// What a step is in a picture.
struct StepRules {
  int focal_px, reach_px, gap_px;
  // Of a surface that near, from pixel to pixel.
  int steep_mm(int z_mm) const {
    const int z = std::min(z_mm, kFarthestMm);
    return std::max(kSlopeLeastMm, z * z / (focal_px * kCameraHeightLeastMm));
  }
};

StepRules rules_of(DepthView depth, float focal_px) {
  const int side = std::max(depth.width, depth.height);
  return {std::max(1, static_cast<int>(focal_px)), std::max(kReachLeastPx, side / kReachAcross),
          std::max(kGapLeastPx, side / kGapAcross)};
}

// The pixel and the next have data and lie no farther apart than any surface's may: no stretch goes over both.
template <class T>
bool level(const Line<T>& line, int i) {
  return line[i] != 0 && line[i + 1] != 0 && std::abs(line[i + 1] - line[i]) <= kSlopeLeastMm;
}

// Calls f(first, last) for every stretch of a line that rises or falls steeply from pixel to pixel, over pixels
// without data too, by kStepMinMm and more. `first` and `last` have data. Looks at stretches that begin at `first` or
// behind it, before `end`; gives where the next would begin.
template <class T, class F>
int for_each_step(const Line<T>& line, const StepRules& rules, int first, int end, F&& f) {
  while (first < end) {
    if (line[first] == 0) {
      ++first;
      continue;
    }
    int last = first, way = 0, next = first + 1;
    // Nearly all pixels: no steeper than any surface is allowed to be.
    if (next < line.count && level(line, first)) {
      first = next;
      continue;
    }
    while (true) {
      while (next < line.count && line[next] == 0) ++next;
      if (next >= line.count || next - last > rules.gap_px + 1 || next - first > rules.reach_px) break;
      const int rise = line[next] - line[last];
      const int steep = rules.steep_mm(std::min<int>(line[next], line[last])) * (next - last);
      if (std::abs(rise) <= steep || (way != 0 && (rise > 0) != (way > 0))) break;
      way = rise;
      last = next++;
    }
    if (last != first && std::abs(line[last] - line[first]) >= kStepMinMm) f(first, last);
    first = last == first ? next : last;
  }
  return first;
}

// Nearest, without pixels without data, and farthest of a part of a line.
struct Extent {
  int nearest_mm = 1 << 16, farthest_mm = 0;
};
Extent extent_of(const Line<const std::uint16_t>& line, int first, int end) {
  std::uint16_t nearest = 0xFFFF, farthest = 0;  // the nearest less 1: without data is the farthest then
  for (int i = first; i < end; ++i) {
    nearest = std::min(nearest, static_cast<std::uint16_t>(line[i] - 1));
    farthest = std::max(farthest, line[i]);
  }
  return {nearest + 1, farthest};
}

// Calls f(first, end) for parts of a line, in order, in which alone steps of kJudgedMinMm may be.
template <class F>
void for_each_deep_part(const Line<const std::uint16_t>& line, const StepRules& rules, F&& f) {
  const int block = (rules.reach_px + 7) / 8 * 8;  // no stretch is longer: it ends in its block or in the next
  Extent before;
  for (int first = 0; first < line.count; first += block) {
    const int end = std::min(first + block, line.count);
    const Extent here = extent_of(line, first, end);
    if (std::max(before.farthest_mm, here.farthest_mm) - std::min(before.nearest_mm, here.nearest_mm) >= kJudgedMinMm)
      f(std::max(first - block, 0), end);
    before = here;
  }
}

// Every other pixel's step on a line counts once; `before`: where the nearer surface comes first.
void count_steps(const Line<const std::uint16_t>& line, const StepRules& rules, EdgeCounts& counts,
                 EdgeCounts::Side& before, EdgeCounts::Side& after) {
  const auto count = [&](int first, int last) {
    const int nearer = std::min(line[first], line[last]), step = std::abs(line[last] - line[first]);
    if (step < kJudgedMinMm) return;
    int bridges = 0, lost = 0;
    for (int i = first + 1; i < last; ++i) {
      const int eighths = (line[i] - nearer) * 8;
      if (line[i] == 0)
        ++lost;
      else if (eighths > step * kBridgeEighths && eighths < step * (8 - kBridgeEighths))
        ++bridges;
    }
    ++counts.steps;
    counts.bridged += bridges > 0 ? 1 : 0;
    counts.bridge_px += static_cast<std::uint32_t>(bridges);
    EdgeCounts::Side& side = line[first] < line[last] ? before : after;
    ++side.steps;
    side.gaps += lost > 0 ? 1 : 0;
    side.gap_px += static_cast<std::uint32_t>(lost);
  };
  int next = 0;
  for_each_deep_part(line, rules, [&](int first, int end) {
    // Whatever came before, a stretch begins behind two level pixels.
    while (first > next && !level(line, first - 1)) --first;
    next = for_each_step(line, rules, std::max(first, next), end, count);
  });
}

// Calls set(i, surface_mm, step_mm) for each pixel of a step that is neither surface's.
template <class F>
void restore_steps(const Line<const std::uint16_t>& line, const StepRules& rules, F&& set) {
  for_each_step(line, rules, 0, line.count, [&](int first, int last) {
    const int start = line[first], end = line[last], middle = (start + end) / 2;
    const auto starts = [&](int z) { return start < end ? z < middle : z > middle; };
    int split = first;  // the last pixel of the first surface
    while (split + 1 < last && line[split + 1] != 0 && starts(line[split + 1])) ++split;
    int next = split + 1;
    while (next < last && line[next] == 0) ++next;
    // The one in the middle goes to either in turns, so that outlines neither grow nor shrink.
    const int lost = next - split - 1;
    split += (lost + next % 2) / 2;
    for (int i = first + 1; i < last; ++i) {
      const int surface = i <= split ? start : end;
      if (line[i] == 0 || std::abs(line[i] - surface) > kSkinMm) set(i, surface, std::abs(end - start));
    }
  });
}

// Calls set(i, surface_mm, 1) for the pixels without data next to a seen surface, where no step spans them.
template <class F>
void grow(const Line<const std::uint16_t>& line, const StepRules& rules, int half_gap_px, F&& set) {
  int i = 0;
  while (i < line.count) {
    if (line[i] != 0) {
      ++i;
      continue;
    }
    const int first = i;
    while (i < line.count && line[i] == 0) ++i;
    const int before = first > 0 ? line[first - 1] : 0, after = i < line.count ? line[i] : 0, count = i - first;
    if (before != 0 && after != 0 && count <= rules.gap_px && std::abs(before - after) >= kStepMinMm) continue;
    const bool both = before != 0 && after != 0;
    const int most = both ? count / 2 : count;
    for (int k = 0; k < std::min(half_gap_px, most); ++k) {
      if (before != 0) set(first + k, before, 1);
      if (after != 0) set(i - 1 - k, after, 1);
    }
  }
}

}  // namespace

void EdgeRestorer::judge(DepthView depth, float focal_px) {
  const StepRules rules = rules_of(depth, focal_px);
  if (counts_.steps >= kJudgedMany) {
    counts_.steps /= 2;
    counts_.bridged /= 2;
    counts_.bridge_px /= 2;
    for (EdgeCounts::Side& side : counts_.sides) {
      side.steps /= 2;
      side.gaps /= 2;
      side.gap_px /= 2;
    }
  }
  auto& sides = counts_.sides;
  for (int v = 0; v < depth.height; v += kLineStep)
    count_steps({depth.row(v), 1, depth.width}, rules, counts_, sides[0], sides[1]);
  for (int u = 0; u < depth.width; u += kLineStep)
    count_steps({depth.pixels + u, depth.stride, depth.height}, rules, counts_, sides[2], sides[3]);
  if (counts_.steps < kJudgedMin) return;
  blends_ = counts_.bridged * 4 >= counts_.steps * 3;
  const auto gapped = [](const EdgeCounts::Side& side) { return side.gaps * 10 >= side.steps * 8; };
  drops_ = gapped(sides[0]) && gapped(sides[1]);
  const auto wider = [&](std::uint32_t px, std::uint32_t count, float most_rad) {
    return static_cast<float>(px) > most_rad * focal_px * static_cast<float>(count);
  };
  wide_ = (blends_ && wider(counts_.bridge_px, counts_.bridged, kBridgeMostRad)) ||
          (drops_ && wider(gap_px(), gaps(), kGapMostRad));
}

std::uint32_t EdgeRestorer::gaps() const {
  std::uint32_t sum = 0;
  for (const EdgeCounts::Side& side : counts_.sides) sum += side.gaps;
  return sum;
}

std::uint32_t EdgeRestorer::gap_px() const {
  std::uint32_t sum = 0;
  for (const EdgeCounts::Side& side : counts_.sides) sum += side.gap_px;
  return sum;
}

void EdgeRestorer::restore(DepthImage depth, float focal_px) {
  const StepRules rules = rules_of(depth, focal_px);
  const int width = depth.width, height = depth.height,
            half_gap = gaps() > 0 ? static_cast<int>((gap_px() + gaps()) / (2 * gaps())) : 0;
  for (int v = 0; v < height; ++v) std::copy_n(depth.row(v), width, before_.data() + std::ptrdiff_t{v} * width);
  std::fill(step_mm_.begin(), step_mm_.end(), std::uint16_t{0});
  const DepthView before(before_.data(), width, height);
  const DepthImage steps(step_mm_.data(), width, height);
  const auto set = [&](int u, int v, int surface_mm, int step_mm) {
    if (step_mm <= steps.at(u, v)) return;
    steps.at(u, v) = static_cast<std::uint16_t>(step_mm);
    depth.at(u, v) = static_cast<std::uint16_t>(surface_mm);
  };
  for (int v = 0; v < height; ++v) {
    const Line<const std::uint16_t> row{before.row(v), 1, width};
    const auto set_row = [&](int u, int surface_mm, int step_mm) { set(u, v, surface_mm, step_mm); };
    restore_steps(row, rules, set_row);
    if (drops_) grow(row, rules, half_gap, set_row);
  }
  for (int u = 0; u < width; ++u) {
    const Line<const std::uint16_t> column{before.row(0) + u, width, height};
    const auto set_column = [&](int v, int surface_mm, int step_mm) { set(u, v, surface_mm, step_mm); };
    restore_steps(column, rules, set_column);
    if (drops_) grow(column, rules, half_gap, set_column);
  }
}

void EdgeRestorer::run(DepthImage depth, float focal_px) {
  const bool new_here = frames_ < kJudgedFrames && counts_.steps < kJudgedEnough;
  if (new_here || frames_ % kJudgeEvery == 0) judge(depth, focal_px);
  ++frames_;
  if (restored()) restore(depth, focal_px);
}

void EdgeRestorer::reset() {
  counts_ = {};
  frames_ = 0;
  blends_ = drops_ = wide_ = false;
}

EdgeRestorer::EdgeRestorer(int width, int height)
    : before_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)), step_mm_(before_.size()) {}

}  // namespace im2fit
