// SPDX-License-Identifier: Apache-2.0
#include "perception/segment/floor.h"

#include <algorithm>
#include <cmath>

// The thresholds of this file: what each bounds and where it comes from. What breaks when one moves by 20 %:
// docs/notebook/perception.md. Sources:
//   [mount] how a camera may stand: the engine's promise, not a measurement
//   [steep] cameras that look down by 25 to 40 degrees found no floor before (commit c186dfc); no figures on
//           record
//   [rooms] chosen on synthetic rooms, no measurement on record
namespace im2fit::segment::floor_limits {

// How a camera may stand.
constexpr float kUpXMax = 0.22F;  // sine of its roll: 12 degrees; [mount]
constexpr float kUpZMax = 0.42F;  // sine of its pitch: 25 degrees; [mount]
constexpr float kSteepUpZMax =
    0.64F;  // 40 degrees, where nothing else is found: seats and laps are level then; [steep]
constexpr float kCameraHeightMinMm = 420.0F;   // above the floor; [mount]
constexpr float kCameraHeightMaxMm = 2500.0F;  // and most; [mount]

// An accelerometer at rest is right to 1 degree, a plane through noisy cells to a few: 6 degrees; [rooms]
constexpr float kLevelCosineMin = 0.9945F;

// Level cells, and the search among them.
constexpr float kLevelSlope = 0.5F;       // rise over run in the picture's axes, most; [rooms]
constexpr float kSteepSlope = 0.9F;       // the same under a steep camera; [steep]
constexpr float kLevelRiseMm = 8.0F;      // and so much rise, which noise makes; [rooms]
constexpr float kLevelRunMaxMm = 800.0F;  // run, most: beyond, it is another surface; [rooms]
constexpr int kHypothesisCount = 120;     // planes tried; [rooms]
constexpr int kScoredCount = 400;         // cells that vote on each; [rooms]
constexpr float kBelowMm = 60.0F;         // and a disparity step, below a plane: speaks against it; [rooms]

// What a floor needs.
constexpr int kSupportMin = 60;             // cells, least; [rooms]
constexpr float kSupportWidthMm = 450.0F;   // across, least; [rooms]
constexpr float kSupportLengthMm = 250.0F;  // in depth, least; [rooms]
constexpr float kGateMm = 12.0F;            // off the plane, most; [rooms]
constexpr float kGateQuanta = 0.8F;         // and so many disparity steps, as heights; [rooms]
constexpr float kFirstPassShare = 1.5F;     // of the gate, in the pass that centres it; [rooms]
constexpr float kJumpMm = 12.0F;            // of the height at the feet, between frames: the camera moved; [rooms]
constexpr float kBandMm = 60.0F;            // from the coarse floor: cells of the precise fit; [rooms]
constexpr double kFrameKeep = 0.85;         // weight the frames before keep: about seven frames' worth; [rooms]
constexpr float kWeightMin = 30.0F;         // of the precise fit's cells, least; [rooms]

// A plane known is kept as long as cells lie on it: while no more than one in so many of those of its fit is lost, it
// is the floor. Once the average holds what it ever will (kFrameKeep^kWholeFrames = 0.2 is missing), a frame refines
// it with one in kRefineParts rows of cells, in turn, and keeps kFrameKeep^(1/kRefineParts) of those before, so that
// each row counts as much as ever.
constexpr int kKeepParts = 20;  // cells on a floor change by 1 % from frame to frame; [rooms]
constexpr int kWholeFrames = 10;
constexpr int kRefineParts = 4;
constexpr double kPartKeep = 0.9601845;

}  // namespace im2fit::segment::floor_limits

namespace im2fit::segment {

using namespace floor_limits;

namespace {

// Whether the rays of a row of cells all look up from the floor: what they meet is far above it.
bool looks_up(const Grid& grid, const FloorPlane& plane, int row) {
  const float up = plane.up.y * grid.ray_y[at(row)] + plane.up.z;
  return plane.up.x * grid.ray_x.front() + up > 0 && plane.up.x * grid.ray_x.back() + up > 0;
}

float height_of(const FloorPlane& plane, Vec3f p) {
  return dot(plane.up, p) + plane.camera_height_mm;
}

// Depth noise seen as height: a ray meets the floor at the slope camera_height / z.
float height_gate_mm(const FloorPlane& plane, float z) {
  return kGateMm + kGateQuanta * quantum_mm(1.0F) * z * plane.camera_height_mm;
}

bool plausible(const FloorPlane& plane, float up_z_max = kSteepUpZMax) {
  return plane.up.y < 0 && std::fabs(plane.up.x) <= kUpXMax && std::fabs(plane.up.z) <= up_z_max &&
         plane.camera_height_mm >= kCameraHeightMinMm && plane.camera_height_mm <= kCameraHeightMaxMm;
}

bool plane_through(Vec3f a, Vec3f b, Vec3f c, float up_z_max, FloorPlane& out) {
  Vec3f n = cross(b - a, c - a);
  const float length = norm(n);
  if (!(length > 1.0e4F)) return false;  // mm^2: three points in a line span no plane
  n = n * (1.0F / length);
  if (n.y > 0) n = -n;
  out.known = true;
  out.up = n;
  out.camera_height_mm = -dot(n, a);
  return plausible(out, up_z_max);
}

}  // namespace

void FloorEquations::blend(const FloorEquations& older, double share) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] += share * older.a[i];
  for (std::size_t i = 0; i < b.size(); ++i) b[i] += share * older.b[i];
  weight += share * older.weight;
}

bool FloorEquations::solve_plane(std::array<double, 3>& q) const {
  const double c00 = a[3] * a[5] - a[4] * a[4];
  const double c01 = a[2] * a[4] - a[1] * a[5];
  const double c02 = a[1] * a[4] - a[2] * a[3];
  const double det = a[0] * c00 + a[1] * c01 + a[2] * c02;
  const double scale = weight * weight * weight;
  if (!(det > 1e-12 * scale)) return false;
  const double c11 = a[0] * a[5] - a[2] * a[2];
  const double c12 = a[1] * a[2] - a[0] * a[4];
  const double c22 = a[0] * a[3] - a[1] * a[1];
  q[0] = (c00 * b[0] + c01 * b[1] + c02 * b[2]) / det;
  q[1] = (c01 * b[0] + c11 * b[1] + c12 * b[2]) / det;
  q[2] = (c02 * b[0] + c12 * b[1] + c22 * b[2]) / det;
  return true;
}

bool FloorEquations::solve(FloorPlane& out) const {
  std::array<double, 3> q{};
  if (!solve_plane(q)) return false;
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2]);
  if (!(length > 1e-6)) return false;
  out.known = true;
  out.up = {static_cast<float>(q[0] / length), static_cast<float>(q[1] / length), static_cast<float>(q[2] / length)};
  out.camera_height_mm = static_cast<float>(1.0 / length);
  return plausible(out);
}

FloorFinder::FloorFinder(const Grid& grid)
    : level_(at(grid.width)),
      near_cells_(grid.depth.size()),
      away_(grid.depth.size()),
      pixel_ray_x_(at(grid.width * grid.step)),
      pixel_ray_y_(at(grid.height * grid.step)),
      row_up_(pixel_ray_y_.size()) {
  Candidates& c = candidates_;
  for (std::vector<float>* v : {&c.x, &c.y, &c.z, &c.ray_x, &c.ray_y, &c.inverse_z}) v->resize(grid.depth.size());
  c.on.resize(grid.depth.size());
}

void FloorFinder::reset() {
  tracked_ = {};
  has_accumulated_ = kept_ = false;
  part_ = 0;
}

// A level cell: two cells further up the picture the surface has gone away from the camera, not up.
void FloorFinder::collect_level_cells(const Grid& grid, float slope) {
  Candidates& out = candidates_;
  const std::size_t width = level_.size();
  const float* ray_x = grid.ray_x.data();
  float *x = out.x.data(), *y = out.y.data(), *depth = out.z.data();
  std::uint8_t* level = level_.data();
  std::size_t count = 0;
  for (int r = 2; r < grid.height; ++r) {
    const std::uint16_t* here = grid.depth.data() + grid.index(0, r);
    const std::uint16_t* above = grid.depth.data() + grid.index(0, r - 2);
    const float ry = grid.ray_y[at(r)], above_ry = grid.ray_y[at(r - 2)];
    for (std::size_t c = 0; c < width; ++c) {
      const float z = static_cast<float>(here[c]), above_z = static_cast<float>(above[c]);
      const float dz = above_z - z, dy = above_ry * above_z - ry * z;
      // A cell above without data makes dz negative; this one may have none.
      level[c] = static_cast<std::uint8_t>((dz > 0) & (std::fabs(dy) < slope * dz + kLevelRiseMm) &
                                           (dz < kLevelRunMaxMm) & (z > 0));
    }
    for (std::size_t c = 0; c < width; ++c) {
      if (c % kTogether == 0 && c + kTogether <= width && none(level + c)) {
        c += kTogether - 1;
        continue;
      }
      const float z = static_cast<float>(here[c]);
      x[count] = ray_x[c] * z;
      y[count] = ry * z;
      depth[count] = z;
      count += level[c];
    }
  }
  out.count = count;
  float *over_x = out.ray_x.data(), *over_y = out.ray_y.data(), *over_one = out.inverse_z.data();
  for (std::size_t i = 0; i < count; ++i) over_x[i] = x[i] / depth[i];
  for (std::size_t i = 0; i < count; ++i) over_y[i] = y[i] / depth[i];
  for (std::size_t i = 0; i < count; ++i) over_one[i] = 1.0F / depth[i];
}

FloorPlane FloorFinder::search(const Grid& grid, float up_z_max) const {
  FloorPlane best;
  const int count = static_cast<int>(candidates_.count);
  if (count < kSupportMin) return best;
  const auto candidate = [&](int i) { return candidates_.point(at(i)); };
  const int stride = std::max(1, count / kScoredCount);
  const int cells = static_cast<int>(grid.depth.size());
  const int cell_stride = std::max(1, cells / kScoredCount) | 1;  // odd: walks all columns
  int best_score = 0;
  std::uint32_t state = 0x2545F491U;
  const auto draw = [&] {
    state = state * 1664525U + 1013904223U;
    return static_cast<int>((static_cast<std::uint64_t>(state) * static_cast<std::uint64_t>(count)) >> 32);
  };
  for (int h = 0; h < kHypothesisCount; ++h) {
    FloorPlane plane;
    const int i = draw();
    const int j = draw();
    const int k = draw();
    if (!plane_through(candidate(i), candidate(j), candidate(k), up_z_max, plane) || !level(plane)) continue;
    int score = 0;
    for (int n = 0; n < count; n += stride) {
      const Vec3f p = candidate(n);
      if (std::fabs(height_of(plane, p)) < height_gate_mm(plane, p.z)) ++score;
    }
    if (score <= best_score) continue;
    // Tables are level too; the floor is the level plane with nothing under it.
    for (int n = 0; n < cells; n += cell_stride) {
      if (grid.depth[at(n)] == 0) continue;
      const Vec3f p = grid.point(n);
      if (height_of(plane, p) < -kBelowMm - quantum_mm(p.z)) score -= 3;
    }
    if (score <= best_score) continue;
    best_score = score;
    best = plane;
  }
  return best;
}

void FloorFinder::mark_on(const FloorPlane& plane, float share) {
  const float *x = candidates_.x.data(), *y = candidates_.y.data(), *z = candidates_.z.data();
  const FloorPlane p = plane;
  std::uint8_t* on = candidates_.on.data();
  for (std::size_t i = 0, count = candidates_.count; i < count; ++i)
    on[i] = static_cast<std::uint8_t>(std::fabs(height_of(p, {x[i], y[i], z[i]})) <= share * height_gate_mm(p, z[i]));
}

FloorPlane FloorFinder::fit_cells(FloorPlane plane) {
  const Candidates& all = candidates_;
  for (int pass = 0; pass < 3 && plane.known; ++pass) {
    mark_on(plane, pass == 0 ? kFirstPassShare : 1.0F);
    PointSums sums;
    for (std::size_t i = 0; i < all.count; ++i)
      if (all.on[i] != 0) sums.add(all.ray_x[i], all.ray_y[i], all.inverse_z[i]);
    FloorPlane next;
    if (!sums.equations().solve(next)) return {};
    plane = next;
  }
  return plane;
}

bool FloorFinder::supported(const Grid& grid, const FloorPlane& plane) {
  if (!plane.known || !plausible(plane) || !level(plane)) return false;
  const Candidates& all = candidates_;
  mark_on(plane, 1.0F);
  int count = 0;
  float x_min = 1e9F;
  float x_max = -1e9F;
  float z_min = 1e9F;
  float z_max = -1e9F;
  for (std::size_t i = 0; i < all.count; ++i) {
    if (all.on[i] == 0) continue;
    ++count;
    x_min = std::min(x_min, all.x[i]);
    x_max = std::max(x_max, all.x[i]);
    z_min = std::min(z_min, all.z[i]);
    z_max = std::max(z_max, all.z[i]);
  }
  on_count_ = count;
  if (count < kSupportMin || x_max - x_min < kSupportWidthMm || z_max - z_min < kSupportLengthMm) return false;
  int below = 0;
  for (int r = 0; r < grid.height; ++r) {
    if (looks_up(grid, plane, r)) continue;
    const std::uint16_t* depth = grid.depth.data() + grid.index(0, r);
    const float ry = grid.ray_y[at(r)];
    for (int c = 0; c < grid.width; ++c) {
      const float z = static_cast<float>(depth[c]);
      const Vec3f p = {grid.ray_x[at(c)] * z, ry * z, z};
      below += ((z > 0) & (height_of(plane, p) < -kBelowMm - quantum_mm(z))) ? 1 : 0;
    }
  }
  return below * 20 <= grid.valid_count && below <= 3 * count;
}

// As far as gravity says so.
bool FloorFinder::level(const FloorPlane& plane) const {
  return !up_ || dot(plane.up, *up_) >= kLevelCosineMin;
}

FloorPlane FloorFinder::find(const Grid& grid, const std::optional<Vec3f>& up) {
  up_ = up;
  FloorPlane found = follow_or_search(grid);
  if (!found.known && up) found.up = *up;
  return found;
}

// As many cells lie on the plane of the frame before as when it was fitted, but for some that people hide.
bool FloorFinder::still_there(const Grid& grid) {
  return supported(grid, tracked_) && on_count_ * kKeepParts >= fitted_on_count_ * (kKeepParts - 1);
}

FloorPlane FloorFinder::follow_or_search(const Grid& grid) {
  kept_ = false;
  if (tracked_.known) {
    collect_level_cells(grid, plausible(tracked_, kUpZMax) ? kLevelSlope : kSteepSlope);
    kept_ = still_there(grid);
    if (kept_) return tracked_;
    const FloorPlane followed = fit_cells(tracked_);
    if (supported(grid, followed)) return fitted(followed);
  }
  has_accumulated_ = false;
  collect_level_cells(grid, kLevelSlope);
  tracked_ = fit_cells(search(grid, kUpZMax));
  if (supported(grid, tracked_)) return fitted(tracked_);
  collect_level_cells(grid, kSteepSlope);
  tracked_ = fit_cells(search(grid, kSteepUpZMax));
  if (!supported(grid, tracked_)) return tracked_ = {};
  return fitted(tracked_);
}

FloorPlane FloorFinder::fitted(const FloorPlane& plane) {
  fitted_on_count_ = on_count_;
  return tracked_ = plane;
}

// Cells of the floor near the feet, in reading order, every fourth pixel of each.
int FloorFinder::list_cells(const Grid& grid, const FloorPlane& plane, Vec3f feet,
                            std::span<const std::uint8_t> taken, int first_row, int row_step) {
  const int stride = grid.step > 1 ? 2 : 1;
  int count = 0;
  for (int r = first_row; r < grid.height; r += row_step) {
    if (looks_up(grid, plane, r)) continue;
    for (int c = 0; c < grid.width; ++c) {
      const auto i = at(grid.index(c, r));
      if (grid.depth[i] == 0 || taken[i] != 0 || std::fabs(grid.height_mm[i]) > kBandMm) continue;
      const Vec3f p = grid.point(c, r);
      const float away_x = p.x - feet.x;
      const float away_z = p.z - feet.z;
      const float away = (away_x * away_x + away_z * away_z) * (1.0F / (500.0F * 500.0F));
      if (away > 25.0F) continue;
      away_[at(count)] = away;
      near_cells_[at(count++)] = {static_cast<std::uint16_t>(c * grid.step),
                                  static_cast<std::uint16_t>(r * grid.step), static_cast<std::uint16_t>(stride),
                                  static_cast<float>(stride * stride) / (1.0F + away)};
    }
  }
  return count;
}

// Every pixel of those listed, but for far cells, which count little.
void FloorFinder::list_more_pixels(const Grid& grid, int count) {
  if (grid.step == 1) return;
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    const bool near = !(away_[i] > 2.0F);
    near_cells_[i].stride = near ? 1 : 2;
    near_cells_[i].weight *= near ? 0.25F : 1.0F;
  }
}

// Those listed that are near the plane say where it is.
bool FloorFinder::fit_pixels(const Grid& grid, DepthView depth, float gate_share, int count, FloorPlane& plane,
                             FloorEquations& equations) {
  for (std::size_t v = 0; v < row_up_.size(); ++v) row_up_[v] = plane.up.y * pixel_ray_y_[v] + plane.up.z;
  const FloorGate gate = {plane.up.x,           plane.camera_height_mm,
                          gate_share * kGateMm, gate_share * kGateQuanta * quantum_mm(1.0F) * plane.camera_height_mm,
                          pixel_ray_x_.data(),  pixel_ray_y_.data(),
                          row_up_.data()};
  PlaneSums sums;
  floor_sums(depth, grid.step, gate, near_cells_.data(), count, sums);
  equations = FloorEquations(sums);
  return equations.solve(plane);
}

bool FloorFinder::refine_whole(const Grid& grid, DepthView depth, Vec3f feet, std::span<const std::uint8_t> taken,
                               FloorPlane& plane, FloorEquations& equations) {
  const int count = list_cells(grid, plane, feet, taken);
  // The first pass only centres the gate.
  if (!fit_pixels(grid, depth, kFirstPassShare, count, plane, equations) || equations.weight < kWeightMin)
    return false;
  list_more_pixels(grid, count);
  return fit_pixels(grid, depth, 1.0F, count, plane, equations) && equations.weight >= kWeightMin;
}

// The gate is centred already.
bool FloorFinder::refine_part(const Grid& grid, DepthView depth, Vec3f feet, std::span<const std::uint8_t> taken,
                              FloorPlane& plane, FloorEquations& equations) {
  if (!kept_ || !has_accumulated_ || accumulated_count_ < kWholeFrames) return false;
  const int count = list_cells(grid, plane, feet, taken, part_, kRefineParts);
  part_ = (part_ + 1) % kRefineParts;
  list_more_pixels(grid, count);
  return fit_pixels(grid, depth, 1.0F, count, plane, equations) && equations.weight * kRefineParts >= kWeightMin &&
         near_accumulated(plane, feet);
}

// Else the camera moved.
bool FloorFinder::near_accumulated(const FloorPlane& plane, Vec3f feet) const {
  FloorPlane before;
  return accumulated_.solve(before) && std::fabs(height_of(before, feet) - height_of(plane, feet)) < kJumpMm;
}

FloorPlane FloorFinder::refine(const Grid& grid, DepthView depth, const FloorPlane& coarse, Vec3f feet,
                               std::span<const std::uint8_t> taken) {
  const Intrinsics& k = grid.intrinsics;
  const float inverse_fx = 1.0F / k.fx;
  const float inverse_fy = 1.0F / k.fy;
  for (std::size_t u = 0; u < pixel_ray_x_.size(); ++u) pixel_ray_x_[u] = (static_cast<float>(u) - k.cx) * inverse_fx;
  for (std::size_t v = 0; v < pixel_ray_y_.size(); ++v) pixel_ray_y_[v] = (static_cast<float>(v) - k.cy) * inverse_fy;
  FloorPlane plane = coarse;
  FloorEquations equations;
  const bool part = refine_part(grid, depth, feet, taken, plane, equations);
  if (!part) {
    plane = coarse;
    if (!refine_whole(grid, depth, feet, taken, plane, equations)) return coarse;
  }
  if (has_accumulated_ && (part || near_accumulated(plane, feet))) {
    equations.blend(accumulated_, part ? kPartKeep : kFrameKeep);
    if (!equations.solve(plane)) return coarse;
    accumulated_count_ = std::min(accumulated_count_ + 1, kWholeFrames);
  } else {
    accumulated_count_ = 1;
  }
  accumulated_ = equations;
  has_accumulated_ = true;
  return tracked_ = plane;
}

}  // namespace im2fit::segment
