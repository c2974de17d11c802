// SPDX-License-Identifier: Apache-2.0
#include "kernels/segment/blobs.h"

#include <algorithm>
#include <cmath>

namespace im2fit::segment {
namespace {

constexpr float kFloorBandMm = 35.0F;
constexpr float kFarthestMm = 6500.0F;
constexpr int kSpeckCells = 12;
constexpr int kWallHypothesisCount = 60;
constexpr int kWallScoredCount = 400;
constexpr float kWallWidthMinMm = 1300.0F;
constexpr float kWallAreaMinM2 = 1.2F;       // more than a person with both arms out
constexpr float kHeadHeightMinMm = 1200.0F;  // above the floor: a seated adult's
constexpr float kHeadHeightMaxMm = 2400.0F;
constexpr float kHeadReliefMinMm = 33.0F;  // heads recede by 50 to 65 mm to their outline, cupboard corners by 20
constexpr float kVagueMm = 4500.0F;
constexpr float kFloatingMm = 450.0F;
constexpr float kTorsoMm = 1000.0F;
constexpr float kShinLowMm = 200.0F;  // above the floor
constexpr float kThighMm = 900.0F;
constexpr float kLegWidthMinMm = 80.0F;
constexpr float kNeckEndMm = 280.0F;  // below the crown
constexpr float kNeckWidthMinMm = 90.0F;
constexpr float kTrunkEndMm = 650.0F;  // below the crown
constexpr float kTrunkHalfMm = 180.0F;
constexpr float kHeadApartMm = 320.0F;  // two heads side by side

// Depth noise lifts floor cells by noise x slope of the ray; the band widens with it, up to a shoe's height.
float floor_band_mm(const FloorPlane& floor, float z) {
  return std::min(70.0F, kFloorBandMm + 0.7F * quantum_mm(z) * floor.camera_height_mm / z);
}

float cell_mm(const Grid& grid, float z) {
  return static_cast<float>(grid.step) * z / grid.intrinsics.fx;
}

std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

// Depth at which a ray meets the plane q.r = -1/z; 0 when it does not.
float plane_depth(const std::array<double, 3>& q, float rx, float ry) {
  const float inverse = -(static_cast<float>(q[0]) * rx + static_cast<float>(q[1]) * ry + static_cast<float>(q[2]));
  return inverse > 1e-5F ? 1.0F / inverse : 0.0F;
}

}  // namespace

BlobFinder::BlobFinder(const Grid& grid)
    : open_(grid.depth.size()),
      parent_(grid.depth.size()),
      size_(grid.depth.size()),
      labels_(grid.depth.size()),
      top_(at(grid.width)),
      planes_(at(kBlobCountMax)) {}

std::int32_t BlobFinder::root(std::int32_t cell) {
  while (parent_[at(cell)] != cell) {
    parent_[at(cell)] = parent_[at(parent_[at(cell)])];
    cell = parent_[at(cell)];
  }
  return cell;
}

void BlobFinder::unite(std::int32_t a, std::int32_t b) {
  a = root(a);
  b = root(b);
  if (a == b) return;
  if (a > b) std::swap(a, b);  // the earliest cell is the root: labels come in reading order
  parent_[at(b)] = a;
}

// A wall is a wide upright plane with next to nothing behind it. Removing it first keeps whatever leans on it apart.
void BlobFinder::remove_wall(const Grid& grid, const FloorPlane& floor) {
  int open_count = 0;
  for (const std::uint8_t o : open_) open_count += o;
  if (open_count < 400) return;
  const int cells = static_cast<int>(open_.size());
  const int stride = std::max(1, cells / kWallScoredCount) | 1;
  const Vec3f up = floor.known ? floor.up : Vec3f{0, -1, 0};
  std::uint32_t state = 0x9E3779B9U;
  const auto draw = [&] {
    for (int tries = 0; tries < 32; ++tries) {
      state = state * 1664525U + 1013904223U;
      const int i = static_cast<int>((static_cast<std::uint64_t>(state) * static_cast<std::uint64_t>(cells)) >> 32);
      if (open_[at(i)] != 0) return i;
    }
    return -1;
  };
  std::array<double, 3> best{};
  int best_support = 0;
  for (int h = 0; h < kWallHypothesisCount; ++h) {
    const int i = draw();
    const int j = draw();
    const int k = draw();
    if (i < 0 || j < 0 || k < 0) continue;
    const Vec3f a = grid.point(i);
    Vec3f n = cross(grid.point(j) - a, grid.point(k) - a);
    const float length = norm(n);
    if (!(length > 4.0e4F)) continue;
    n = n * (1.0F / length);
    const float offset = -dot(n, a);
    if (std::fabs(dot(n, up)) > 0.25F || std::fabs(offset) < 300.0F) continue;
    const std::array<double, 3> q = {static_cast<double>(n.x / offset), static_cast<double>(n.y / offset),
                                     static_cast<double>(n.z / offset)};
    int support = 0;
    int behind = 0;
    int looked = 0;
    for (int cell = 0; cell < cells; cell += stride) {
      if (open_[at(cell)] == 0) continue;
      ++looked;
      const float z = static_cast<float>(grid.depth[at(cell)]);
      const float wall = plane_depth(q, grid.ray_x[at(cell % grid.width)], grid.ray_y[at(cell / grid.width)]);
      const float q_mm = quantum_mm(z);
      if (wall > 0 && std::fabs(z - wall) < 20.0F + q_mm) ++support;
      if (wall > 0 && z > wall + 80.0F + 2.0F * q_mm) ++behind;
    }
    if (support * 6 < looked || behind * 16 > looked || support <= best_support) continue;
    best_support = support;
    best = q;
  }
  if (best_support == 0) return;
  float x_min = 1e9F;
  float x_max = -1e9F;
  float area_m2 = 0;
  const float cell_area =
      static_cast<float>(grid.step * grid.step) / (grid.intrinsics.fx * grid.intrinsics.fy) * 1e-6F;
  for (int pass = 0; pass < 2; ++pass) {
    FloorEquations equations;
    area_m2 = 0;
    for (int cell = 0; cell < cells; ++cell) {
      if (open_[at(cell)] == 0) continue;
      const Vec3f p = grid.point(cell);
      const float rx = grid.ray_x[at(cell % grid.width)];
      const float ry = grid.ray_y[at(cell / grid.width)];
      const float wall = plane_depth(best, rx, ry);
      if (!(wall > 0) || std::fabs(p.z - wall) > 20.0F + quantum_mm(p.z)) continue;
      equations.add(rx, ry, 1.0F / p.z, 1.0F);
      x_min = std::min(x_min, p.x);
      x_max = std::max(x_max, p.x);
      area_m2 += cell_area * p.z * p.z;
    }
    if (equations.weight < 100.0 || !equations.solve_plane(best)) return;
  }
  if (x_max - x_min < kWallWidthMinMm || area_m2 < kWallAreaMinM2) return;
  for (int cell = 0; cell < cells; ++cell) {
    if (open_[at(cell)] == 0) continue;
    const float z = static_cast<float>(grid.depth[at(cell)]);
    const float wall = plane_depth(best, grid.ray_x[at(cell % grid.width)], grid.ray_y[at(cell / grid.width)]);
    if (wall > 0 && z > wall - 45.0F - 2.0F * quantum_mm(z)) open_[at(cell)] = 0;
  }
}

void BlobFinder::join(const Grid& grid) {
  for (std::size_t i = 0; i < parent_.size(); ++i) parent_[i] = static_cast<std::int32_t>(i);
  const auto near = [&](int a, int b) {
    const float za = static_cast<float>(grid.depth[at(a)]);
    const float zb = static_cast<float>(grid.depth[at(b)]);
    return std::fabs(za - zb) < depth_step_mm(std::min(za, zb));
  };
  for (int r = 0; r < grid.height; ++r) {
    for (int c = 0; c < grid.width; ++c) {
      const int here = grid.index(c, r);
      if (open_[at(here)] == 0) continue;
      if (c + 1 < grid.width) {
        const int right = here + 1;
        if (open_[at(right)] != 0) {
          if (near(here, right)) unite(here, right);
        } else if (c + 2 < grid.width && grid.depth[at(right)] == 0 && open_[at(here + 2)] != 0 &&
                   near(here, here + 2)) {
          unite(here, here + 2);  // across a hole of one cell
        }
      }
      if (r + 1 >= grid.height) continue;
      const int down = here + grid.width;
      if (open_[at(down)] != 0) {
        if (near(here, down)) unite(here, down);
      } else if (r + 2 < grid.height && grid.depth[at(down)] == 0 && open_[at(down + grid.width)] != 0 &&
                 near(here, down + grid.width)) {
        unite(here, down + grid.width);
      }
      if (c > 0 && open_[at(down - 1)] != 0 && near(here, down - 1)) unite(here, down - 1);
      if (c + 1 < grid.width && open_[at(down + 1)] != 0 && near(here, down + 1)) unite(here, down + 1);
    }
  }
}

void BlobFinder::number(const Grid& grid) {
  const int cells = static_cast<int>(grid.depth.size());
  std::fill(size_.begin(), size_.end(), 0);
  std::fill(labels_.begin(), labels_.end(), std::uint16_t{0});
  for (int i = 0; i < cells; ++i)
    if (open_[at(i)] != 0) ++size_[at(root(i))];
  blob_count_ = 0;
  for (int i = 0; i < cells; ++i) {
    if (open_[at(i)] == 0) continue;
    const int top = root(i);
    if (size_[at(top)] < kSpeckCells) continue;
    if (top == i) {  // first cell in reading order
      if (blob_count_ == kBlobCountMax) continue;
      labels_[at(i)] = static_cast<std::uint16_t>(++blob_count_);
    } else {
      labels_[at(i)] = labels_[at(top)];
    }
  }
}

void BlobFinder::describe(const Grid& grid) {
  for (int b = 0; b < blob_count_; ++b) {
    Blob blob;
    blob.c_min = grid.width;
    blob.r_min = grid.height;
    blob.c_max = blob.r_max = -1;
    blob.height_min_mm = 1e9F;
    blob.height_max_mm = -1e9F;
    blobs_[at(b)] = blob;
    planes_[at(b)] = {};
  }
  const float cell_area =
      static_cast<float>(grid.step * grid.step) / (grid.intrinsics.fx * grid.intrinsics.fy) * 1e-6F;
  for (int r = 0; r < grid.height; ++r) {
    for (int c = 0; c < grid.width; ++c) {
      const int cell = grid.index(c, r);
      if (labels_[at(cell)] == 0) continue;
      const int b = labels_[at(cell)] - 1;
      Blob& blob = blobs_[at(b)];
      const Vec3f p = grid.point(cell);
      ++blob.cell_count;
      blob.area_m2 += cell_area * p.z * p.z;
      blob.c_min = std::min(blob.c_min, c);
      blob.c_max = std::max(blob.c_max, c);
      blob.r_min = std::min(blob.r_min, r);
      blob.r_max = std::max(blob.r_max, r);
      blob.height_min_mm = std::min(blob.height_min_mm, grid.height_mm[at(cell)]);
      blob.height_max_mm = std::max(blob.height_max_mm, grid.height_mm[at(cell)]);
      blob.centroid_mm = blob.centroid_mm + p;
      planes_[at(b)].add(grid.ray_x[at(c)], grid.ray_y[at(r)], 1.0F / p.z, 1.0F);
    }
  }
  std::array<std::array<double, 3>, kBlobCountMax> q{};
  for (int b = 0; b < blob_count_; ++b) {
    Blob& blob = blobs_[at(b)];
    if (blob.cell_count == 0) continue;
    blob.centroid_mm = blob.centroid_mm * (1.0F / static_cast<float>(blob.cell_count));
    if (!planes_[at(b)].solve_plane(q[at(b)])) q[at(b)] = {0, 0, -1.0 / static_cast<double>(blob.centroid_mm.z)};
  }
  for (int cell = 0; cell < static_cast<int>(labels_.size()); ++cell) {
    if (labels_[at(cell)] == 0) continue;
    const int b = labels_[at(cell)] - 1;
    const float z = static_cast<float>(grid.depth[at(cell)]);
    const float fitted = plane_depth(q[at(b)], grid.ray_x[at(cell % grid.width)], grid.ray_y[at(cell / grid.width)]);
    const float off = fitted > 0 ? std::clamp(z - fitted, -500.0F, 500.0F) : 500.0F;
    blobs_[at(b)].relief_mm += off * off;
  }
  for (int b = 0; b < blob_count_; ++b) {
    Blob& blob = blobs_[at(b)];
    if (blob.cell_count > 0) blob.relief_mm = std::sqrt(blob.relief_mm / static_cast<float>(blob.cell_count));
  }
}

// A head: 85..330 mm wide over a hand's breadth below its top, rounded, with shoulders wider than it under it.
// A raised hand fails at the wrist, a box at its missing shoulders, a hat over a coat at the stand's thin
// pole or the coat's flat front.
bool BlobFinder::head_at(const Grid& grid, int blob, int c, int r, Head& out) const {
  const auto label = static_cast<std::uint16_t>(blob + 1);
  if (r < 1 || r + 3 >= grid.height) return false;
  int probe = grid.index(c, r + 2);
  if (labels_[at(probe)] != label) probe = grid.index(c, r);
  if (labels_[at(probe)] != label) return false;
  const float z_head = static_cast<float>(grid.depth[at(probe)]);
  const float mm = cell_mm(grid, z_head);
  float narrowest = 1e9F;
  float widest = 0;
  float width_sum = 0;
  float relief_sum = 0;
  int row_count = 0;
  int at_border = 0;
  float neck = 1e9F;
  float shoulders = 0;
  float left_reach = 0;
  float right_reach = 0;
  float bulge_square_sum = 0;
  int bulge_count = 0;
  int head_lo = c;
  int head_hi = c;
  int centre = c;
  for (int row = r; row < grid.height; ++row) {
    const float below = static_cast<float>(row - r) * mm;
    if (below > kTrunkEndMm) break;
    const auto inside = [&](int col) {
      const int cell = grid.index(col, row);
      return labels_[at(cell)] == label && std::fabs(static_cast<float>(grid.depth[at(cell)]) - z_head) < 280.0F;
    };
    int start = centre;
    for (int away = 1; away <= 3 && !inside(start); ++away) {
      if (centre - away >= 0 && inside(centre - away))
        start = centre - away;
      else if (centre + away < grid.width && inside(centre + away))
        start = centre + away;
    }
    if (!inside(start)) {
      if (below < kNeckEndMm && below > 20.0F) return false;
      continue;
    }
    int lo = start;
    int hi = start;
    while (lo > 0 && (inside(lo - 1) || (lo > 1 && inside(lo - 2)))) --lo;
    while (hi + 1 < grid.width && (inside(hi + 1) || (hi + 2 < grid.width && inside(hi + 2)))) ++hi;
    const float width = static_cast<float>(hi - lo + 1) * mm;
    if (below <= 170.0F) centre = (lo + hi) / 2;
    if (below >= 55.0F && below <= 165.0F) {
      narrowest = std::min(narrowest, width);
      widest = std::max(widest, width);
      width_sum += width;
      const auto z_at = [&](int col) { return static_cast<float>(grid.depth[at(grid.index(col, row))]); };
      if (inside(lo) && inside(hi) && inside(centre)) relief_sum += 0.5F * (z_at(lo) + z_at(hi)) - z_at(centre);
      head_lo = lo;
      head_hi = hi;
      at_border += lo == 0 || hi == grid.width - 1 ? 1 : 0;
      ++row_count;
    }
    if (below >= 165.0F && below < kNeckEndMm) {
      if (width < kNeckWidthMinMm - mm) return false;
      neck = std::min(neck, width);
    }
    if (below >= 270.0F) {
      const int half = std::max(1, static_cast<int>(kTrunkHalfMm / mm));
      const int left = std::max(lo + 1, centre - half);
      const int right = std::min(hi - 1, centre + half);
      if (left < centre && centre < right && inside(left) && inside(right) && inside(centre)) {
        const auto z_at = [&](int col) { return static_cast<float>(grid.depth[at(grid.index(col, row))]); };
        const float share = static_cast<float>(centre - left) / static_cast<float>(right - left);
        const float bulge = z_at(left) + share * (z_at(right) - z_at(left)) - z_at(centre);
        bulge_square_sum += bulge * bulge;
        ++bulge_count;
      }
    }
    if (below >= 270.0F && below <= 430.0F) {
      shoulders = std::max(shoulders, width);
      left_reach = std::max(left_reach, static_cast<float>(head_lo - lo) * mm);
      right_reach = std::max(right_reach, static_cast<float>(hi - head_hi) * mm);
    }
  }
  if (row_count == 0) return false;
  const float width = width_sum / static_cast<float>(row_count);
  if (at_border * 2 > row_count || narrowest < 0.45F * widest) return false;  // cut in two; a cupboard's corner
  if (neck > 1.25F * width + mm) return false;  // widens steadily, as a cupboard's top seen over its corner
  if (narrowest < 85.0F - mm || widest > 330.0F + mm || width < 105.0F || width > 270.0F + 0.5F * mm) return false;
  if (shoulders < std::max(220.0F, 1.2F * width)) return false;
  if (std::max(left_reach, right_reach) < 40.0F || std::min(left_reach, right_reach) < -0.25F * width) return false;
  const float round = kHeadReliefMinMm - 0.2F * quantum_mm(z_head);
  if (relief_sum < round * static_cast<float>(row_count)) return false;
  // Some backs are as flat as a coat.
  const float bulge = bulge_count > 0 ? std::sqrt(bulge_square_sum / static_cast<float>(bulge_count)) : 1e9F;
  if (bulge < 10.0F + 0.35F * quantum_mm(z_head)) return false;
  out.vague = bulge < 14.0F + 0.5F * quantum_mm(z_head) || z_head > kVagueMm;
  out.blob = blob;
  out.c = centre;
  out.r = r;
  out.top_mm = grid.point(probe);
  out.width_mm = width;
  return true;
}

void BlobFinder::find_heads(const Grid& grid, int b, const FloorPlane& floor) {
  const Blob& blob = blobs_[at(b)];
  const auto label = static_cast<std::uint16_t>(b + 1);
  std::fill(top_.begin(), top_.end(), static_cast<std::int16_t>(grid.height));
  for (int c = blob.c_min; c <= blob.c_max; ++c)
    for (int r = blob.r_min; r <= blob.r_max; ++r)
      if (labels_[at(grid.index(c, r))] == label) {
        top_[at(c)] = static_cast<std::int16_t>(r);
        break;
      }
  for (int c = blob.c_min; c <= blob.c_max; ++c) {
    const int r = top_[at(c)];
    if (r >= grid.height) continue;
    const float z = static_cast<float>(grid.depth[at(grid.index(c, r))]);
    const int reach = std::max(1, static_cast<int>(90.0F / cell_mm(grid, z)));
    bool peak = true;
    for (int d = -reach; d <= reach && peak; ++d) {
      const int other = c + d;
      if (d == 0 || other < blob.c_min || other > blob.c_max) continue;
      if (top_[at(other)] < r || (top_[at(other)] == r && d < 0)) peak = false;  // leftmost of a flat top
    }
    if (!peak) continue;
    int flat = c;  // middle of a flat top
    while (flat + 1 <= blob.c_max && top_[at(flat + 1)] == r && flat - c < reach) ++flat;
    Head head;
    if (!head_at(grid, b, (c + flat) / 2, r, head)) continue;
    if (floor.known) {
      const float height = grid.height_mm[at(grid.index((c + flat) / 2, r))];
      if (height < kHeadHeightMinMm || height > kHeadHeightMaxMm) continue;
    }
    bool apart = true;
    for (int h = 0; h < head_count_; ++h) {
      const Vec3f d = heads_[at(h)].top_mm - head.top_mm;
      if (heads_[at(h)].blob == b && d.x * d.x + d.z * d.z < kHeadApartMm * kHeadApartMm) apart = false;
    }
    if (apart && head_count_ < kHeadCountMax) heads_[at(head_count_++)] = head;
  }
}

// People whose hands or shoulders touch are one surface: each cell goes with the head it is nearest to.
void BlobFinder::split_between_heads(const Grid& grid) {
  bool split = false;
  const int before = blob_count_;
  for (int b = 0; b < before; ++b) {
    int first = -1;
    std::array<int, kHeadCountMax> mine{};
    int count = 0;
    for (int h = 0; h < head_count_; ++h)
      if (heads_[at(h)].blob == b) mine[at(count++)] = h;
    if (count < 2) continue;
    first = mine[0];
    for (int i = 1; i < count; ++i) {
      if (blob_count_ == kBlobCountMax) return;
      heads_[at(mine[at(i)])].blob = blob_count_++;
      split = true;
    }
    const auto old_label = static_cast<std::uint16_t>(b + 1);
    for (int cell = 0; cell < static_cast<int>(labels_.size()); ++cell) {
      if (labels_[at(cell)] != old_label) continue;
      const Vec3f p = grid.point(cell);
      float best = 1e30F;
      int owner = first;
      for (int i = 0; i < count; ++i) {
        const Vec3f d = p - heads_[at(mine[at(i)])].top_mm;
        const float cost = std::fabs(d.x) + 0.7F * std::fabs(d.z);
        if (cost < best) {
          best = cost;
          owner = mine[at(i)];
        }
      }
      labels_[at(cell)] = static_cast<std::uint16_t>(heads_[at(owner)].blob + 1);
    }
  }
  if (split) describe(grid);
}

// Ends in the air with only farther things below: a coat, a picture on the wall. A person's legs may be hidden by
// something nearer.
bool BlobFinder::floats(const Grid& grid, int b, const FloorPlane& floor) const {
  const Blob& blob = blobs_[at(b)];
  if (!floor.known || blob.height_min_mm < kFloatingMm || blob.r_max >= grid.height - 2) return false;
  const auto label = static_cast<std::uint16_t>(b + 1);
  int hidden = 0;
  int open = 0;
  for (int c = blob.c_min; c <= blob.c_max; ++c) {
    int r = blob.r_max;
    while (r >= blob.r_min && labels_[at(grid.index(c, r))] != label) --r;
    if (r < blob.r_min || r + 3 >= grid.height) continue;
    const float z = static_cast<float>(grid.depth[at(grid.index(c, r))]);
    float below = 0;
    for (int d = 1; d <= 3 && below == 0; ++d) below = static_cast<float>(grid.depth[at(grid.index(c, r + d))]);
    (below > 0 && below < z + 0.5F * depth_step_mm(z) ? hidden : open) += 1;
  }
  return hidden < open;
}

// Stands on something thinner than a leg.
bool BlobFinder::on_pole(const Grid& grid, int b, const FloorPlane& floor) const {
  const Blob& blob = blobs_[at(b)];
  if (!floor.known || blob.height_min_mm > kShinLowMm) return false;
  const auto label = static_cast<std::uint16_t>(b + 1);
  int thin_rows = 0;  // in succession
  for (int r = blob.r_min; r <= blob.r_max; ++r) {
    // The whole row's width: cut at a height, the slanting edge of a thigh would look thin.
    float width = 0;
    bool low = false;
    for (int c = blob.c_min; c <= blob.c_max; ++c) {
      const auto cell = at(grid.index(c, r));
      if (labels_[cell] != label) continue;
      low = low || (grid.height_mm[cell] > kShinLowMm && grid.height_mm[cell] < kThighMm);
      width += cell_mm(grid, static_cast<float>(grid.depth[cell]));
    }
    thin_rows = low && width < kLegWidthMinMm ? thin_rows + 1 : 0;
    if (thin_rows == 3) return true;
  }
  return false;
}

// An arm held across the body cuts the trunk off below it: what lies under a head that ends in the air, at its depth
// and partly behind it, is joined to it.
void BlobFinder::join_trunks(const Grid& grid, const FloorPlane& floor) {
  bool joined = false;
  for (int h = 0; h < head_count_; ++h) {
    const int b = heads_[at(h)].blob;
    const Blob& blob = blobs_[at(b)];
    const bool in_air =
        floor.known ? blob.height_min_mm > kFloatingMm : blob.height_max_mm - blob.height_min_mm < kTorsoMm;
    if (!in_air || blob.r_max >= grid.height - 2) continue;
    const auto label = static_cast<std::uint16_t>(b + 1);
    std::array<std::int16_t, kBlobCountMax> contact{};
    for (int r = blob.r_min; r <= blob.r_max; ++r) {
      for (int c = blob.c_min; c <= blob.c_max; ++c) {
        if (labels_[at(grid.index(c, r))] != label) continue;
        for (int d = 1; d <= 2 && r + d < grid.height; ++d) {
          const std::uint16_t other = labels_[at(grid.index(c, r + d))];
          if (other == label) break;
          if (other != 0) {
            ++contact[at(other - 1)];
            break;
          }
        }
      }
    }
    const Vec3f top = heads_[at(h)].top_mm;
    for (int o = 0; o < blob_count_; ++o) {
      const Blob& other = blobs_[at(o)];
      const Vec3f d = other.centroid_mm - top;
      const bool fits = contact[at(o)] >= 4 && other.area_m2 > 0.05F && std::fabs(d.x) < 350.0F &&
                        std::fabs(d.z) < 350.0F && other.relief_mm > 14.0F + 0.4F * quantum_mm(top.z);
      if (!fits || o == b) continue;
      bool has_head = false;
      for (int i = 0; i < head_count_; ++i) has_head = has_head || heads_[at(i)].blob == o;
      if (has_head) continue;
      for (std::uint16_t& cell : labels_)
        if (cell == static_cast<std::uint16_t>(o + 1)) cell = label;
      joined = true;
    }
  }
  if (joined) describe(grid);
}

void BlobFinder::judge(const Grid& grid, const FloorPlane& floor) {
  bool any_head = false;
  for (const bool vague : {false, true}) {
    if (any_head) break;
    for (int h = 0; h < head_count_; ++h) {
      if (heads_[at(h)].vague != vague) continue;
      const int b = heads_[at(h)].blob;
      Blob& blob = blobs_[at(b)];
      const float tall = blob.height_max_mm - blob.height_min_mm;
      const bool sized = blob.area_m2 > 0.06F && blob.area_m2 < 2.2F && tall > 300.0F;
      if (!sized || floats(grid, b, floor) || on_pole(grid, b, floor)) continue;
      blob.person = blob.has_head = true;
      any_head = true;
    }
  }
  for (int h = 0; h < head_count_; ++h)
    if (blobs_[at(heads_[at(h)].blob)].has_head && !heads_[at(h)].vague) return;
  // Heads cut off by the upper border, or hidden by raised arms: person-sized, neither flat nor filling its box.
  for (int b = 0; b < blob_count_; ++b) {
    Blob& blob = blobs_[at(b)];
    if (blob.person || blob.cell_count == 0) continue;
    const float mm = cell_mm(grid, blob.centroid_mm.z);
    const float wide = static_cast<float>(blob.c_max - blob.c_min + 1) * mm;
    const float tall = blob.height_max_mm - blob.height_min_mm;
    const int box = (blob.c_max - blob.c_min + 1) * (blob.r_max - blob.r_min + 1);
    const bool top_cut = blob.r_min <= 1;
    const float fill = static_cast<float>(blob.cell_count) / static_cast<float>(box);
    const float relief_min = 14.0F + 0.5F * quantum_mm(blob.centroid_mm.z);
    const bool stands = !floor.known || blob.height_min_mm < 250.0F || blob.r_max >= grid.height - 2;
    if (blob.relief_mm < relief_min || blob.relief_mm > 220.0F || !stands) continue;
    if (top_cut) {
      blob.person = tall > 600.0F && wide > 250.0F && wide < 1500.0F && blob.area_m2 > 0.18F && blob.area_m2 < 1.6F &&
                    fill < 0.86F && fill > 0.25F;
    } else {
      blob.person = tall > 1250.0F && tall < 2500.0F && wide > 250.0F && wide < 1700.0F && blob.area_m2 > 0.22F &&
                    blob.area_m2 < 1.3F && fill < 0.72F && fill > 0.18F;
    }
  }
}

void BlobFinder::run(const Grid& grid, const FloorPlane& floor) {
  for (std::size_t i = 0; i < open_.size(); ++i) {
    const float z = static_cast<float>(grid.depth[i]);
    const bool floor_cell = floor.known && grid.height_mm[i] < floor_band_mm(floor, z);
    open_[i] = z > 0 && z < kFarthestMm && !floor_cell ? 1 : 0;
  }
  remove_wall(grid, floor);
  join(grid);
  number(grid);
  describe(grid);
  head_count_ = 0;
  for (int b = 0; b < blob_count_; ++b) {
    const Blob& blob = blobs_[at(b)];
    if (blob.area_m2 > 0.05F && blob.height_max_mm - blob.height_min_mm > 300.0F) find_heads(grid, b, floor);
  }
  join_trunks(grid, floor);
  split_between_heads(grid);
  judge(grid, floor);
}

}  // namespace im2fit::segment
