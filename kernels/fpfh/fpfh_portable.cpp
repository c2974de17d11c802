// SPDX-License-Identifier: Apache-2.0
// FPFH in float32: the same neighbours and, up to rounding at bin edges, the same counts as PCL 1.13.
//
// What makes it cheap, none of which changes the descriptor:
// - candidates come from the picture's rows, then the exact r^2 test decides;
// - an SPFH is computed once for all keypoints, and only where a keypoint wants it;
// - PCL's swap rule makes the pair (p, q) and (q, p) fall into the same bins, bit for bit (all that differs is d's
//   sign, and negation is exact), so each unordered pair is computed once and counted twice. The exceptions, near
//   ties of |a1| and |a2|, take the careful path once from each side;
// - no acos, no atan2, integer counts;
// - a point without a normal needs no arithmetic: its own pairs all count in bin 0.
//
// Determinism: + - * / sqrt on floats in written order, integer counts (any order), double sums in row order.
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>

#include "kernels/fpfh/fpfh.h"
#include "kernels/fpfh/fpfh_pair.h"

namespace im2fit {
namespace {

using fpfh_detail::PairBins;

constexpr int kBlock = 16;           // pairs computed together: a fixed trip count the compiler can vectorise
constexpr int kCandidateBlock = 64;  // candidates tested together
// A point lies within half a pixel of its own; two hundredths more cover float rounding of the bounds.
constexpr float kPixelReach = 0.52F;
constexpr float kSlackM = 2e-5F;    // rounding of positions and chords: coordinates below 16 m have ulp <= 1e-6 m
constexpr float kNearestM = 1e-3F;  // nearer than this, a sphere's outline in the picture is unbounded
// Below this 1 - a^2 the difference of squares has lost too many digits (float: 24 bits, 10 gone here).
constexpr float kNearlyParallel = 1e-3F;

struct Radius {
  float metres, squared;
};

class PortableFpfh {
 public:
  PortableFpfh(const OrganisedCloud& cloud, Radius radius, FpfhWorkspace& work)
      : k_(cloud.intrinsics), radius_(radius), work_(work), inverse_fy_(1.0F / k_.fy) {
    compact(cloud);
  }

  void mark_needed(Vec3f keypoint_m);
  void count_pairs();
  void describe(Vec3f keypoint_m, float* out);

 private:
  void compact(const OrganisedCloud& cloud);
  int row_first(int v) const { return work_.row_table[static_cast<std::size_t>(v * (k_.width + 1))]; }
  int row_end(int v) const { return work_.row_table[static_cast<std::size_t>(v * (k_.width + 1) + k_.width)]; }
  template <class Visit>
  void visit_candidates(Vec3f p, int first_row, Visit visit) const;
  template <class Visit>
  void visit_neighbours(Vec3f p, Visit visit) const;
  void collect(int i, int row);
  void count_blank_source(int i);
  void count_blank_targets(int i);
  void count_valid_pairs(int i);
  void block_bins(int i, const std::int32_t* js, std::int32_t* codes) const;
  void count_slow(int i, int j);
  void finish_blank_counts();

  Vec3f position(int i) const {
    const auto n = static_cast<std::size_t>(i);
    return {work_.x[n], work_.y[n], work_.z[n]};
  }
  Vec3f normal(int i) const {
    const auto n = static_cast<std::size_t>(i);
    return {work_.nx[n], work_.ny[n], work_.nz[n]};
  }
  std::int32_t* counts(int i) const { return work_.counts.get() + static_cast<std::ptrdiff_t>(i) * kFpfhSize; }
  static void add(std::int32_t* counts, PairBins bins) {
    ++counts[bins.f1];
    ++counts[kFpfhBins + bins.f2];
    ++counts[2 * kFpfhBins + bins.f3];
  }

  Intrinsics k_;
  Radius radius_;
  FpfhWorkspace& work_;
  float inverse_fy_;
  int point_count_ = 0;
  int near_count_ = 0;
  int blank_count_ = 0;
};

void PortableFpfh::compact(const OrganisedCloud& cloud) {
  std::size_t n = 0;
  std::size_t pixel = 0;
  std::size_t entry = 0;
  for (int v = 0; v < k_.height; ++v) {
    for (int u = 0; u < k_.width; ++u, ++pixel) {
      work_.row_table[entry++] = static_cast<std::int32_t>(n);
      const float x = cloud.x[pixel], y = cloud.y[pixel], z = cloud.z[pixel];
      if (!(std::isfinite(x) && std::isfinite(y) && std::isfinite(z) && z > 0.0F)) continue;
      work_.x[n] = x * 0.001F;
      work_.y[n] = y * 0.001F;
      work_.z[n] = z * 0.001F;
      work_.nx[n] = cloud.nx[pixel];
      work_.ny[n] = cloud.ny[pixel];
      work_.nz[n] = cloud.nz[pixel];
      work_.has_normal[n] = !(std::isnan(work_.nx[n]) || std::isnan(work_.ny[n]) || std::isnan(work_.nz[n]));
      ++n;
    }
    work_.row_table[entry++] = static_cast<std::int32_t>(n);
  }
  point_count_ = static_cast<int>(n);
  const auto count = static_cast<std::ptrdiff_t>(n);
  std::fill_n(work_.needed.begin(), count, std::uint8_t{0});
  std::fill_n(work_.neighbour_count.begin(), count, 1);
  std::fill_n(work_.counts.get(), count * kFpfhSize, 0);
}

int clamp_to_int(float value, int low, int high) {
  if (!(value > static_cast<float>(low))) return low;
  return value >= static_cast<float>(high) ? high : static_cast<int>(value);
}

// Calls visit(begin, end) with ranges of compact points, rows >= first_row, that together hold every point within
// the radius of p. Row v holds only points whose ray's slope y/z is that of row v within kPixelReach, so the sphere
// meets them in a chord at least the slab's distance dy from its centre.
template <class Visit>
void PortableFpfh::visit_candidates(Vec3f p, int first_row, Visit visit) const {
  const float r = radius_.metres + kSlackM;
  const float z_near = std::max(p.z - r, kNearestM);
  const float z_far = std::max(p.z + r, kNearestM);
  const bool unbounded = !(p.z - r > kNearestM);
  const float y_low = p.y - r, y_high = p.y + r;
  const float row_low = y_low / (y_low >= 0.0F ? z_far : z_near) * k_.fy + k_.cy - kPixelReach;
  const float row_high = y_high / (y_high >= 0.0F ? z_near : z_far) * k_.fy + k_.cy + kPixelReach;
  const int v0 = unbounded ? first_row : std::max(first_row, clamp_to_int(row_low, 0, k_.height));
  const int v1 = unbounded ? k_.height - 1 : clamp_to_int(row_high, -1, k_.height - 1);

  for (int v = v0; v <= v1; ++v) {
    const std::int32_t* row = work_.row_table.data() + static_cast<std::ptrdiff_t>(v) * (k_.width + 1);
    if (row[0] == row[k_.width]) continue;
    if (unbounded) {
      visit(row[0], row[k_.width]);
      continue;
    }
    const float slope_low = (static_cast<float>(v) - kPixelReach - k_.cy) * inverse_fy_;
    const float slope_high = (static_cast<float>(v) + kPixelReach - k_.cy) * inverse_fy_;
    const float slab_low = slope_low * (slope_low >= 0.0F ? z_near : z_far);
    const float slab_high = slope_high * (slope_high >= 0.0F ? z_far : z_near);
    const float dy = std::max(0.0F, std::max(slab_low - p.y, p.y - slab_high));
    const float chord_squared = r * r - dy * dy;
    if (!(chord_squared > 0.0F)) continue;
    const float h = std::sqrt(chord_squared) + kSlackM;
    const float inverse_near = 1.0F / std::max(p.z - h, kNearestM);
    const float inverse_far = 1.0F / (p.z + h);
    const float x_low = p.x - h, x_high = p.x + h;
    const float column_low = x_low * (x_low >= 0.0F ? inverse_far : inverse_near) * k_.fx + k_.cx - kPixelReach;
    const float column_high = x_high * (x_high >= 0.0F ? inverse_near : inverse_far) * k_.fx + k_.cx + kPixelReach;
    const int begin = row[clamp_to_int(column_low, 0, k_.width)];
    const int end = row[clamp_to_int(column_high, -1, k_.width - 1) + 1];
    if (begin < end) visit(begin, end);
  }
}

// Calls visit(j, distance squared) for each point within the radius of p, in row order.
template <class Visit>
void PortableFpfh::visit_neighbours(Vec3f p, Visit visit) const {
  visit_candidates(p, 0, [&](int begin, int end) {
    for (int j = begin; j < end; ++j) {
      const Vec3f d = p - position(j);
      const float d2 = dot(d, d);
      if (d2 < radius_.squared) visit(j, d2);
    }
  });
}

void PortableFpfh::mark_needed(Vec3f keypoint_m) {
  visit_neighbours(keypoint_m, [&](int j, float) { work_.needed[static_cast<std::size_t>(j)] = 1; });
}

// Neighbours j > i whose pair with i anyone needs, parted by whether they have a normal.
void PortableFpfh::collect(int i, int row) {
  near_count_ = 0;
  blank_count_ = 0;
  const Vec3f p = position(i);
  const std::uint8_t anyone = work_.needed[static_cast<std::size_t>(i)];
  visit_candidates(p, row, [&](int range_begin, int range_end) {
    for (int begin = std::max(range_begin, i + 1); begin < range_end; begin += kCandidateBlock) {
      const int count = std::min(kCandidateBlock, range_end - begin);
      const float* x = work_.x.data() + begin;
      const float* y = work_.y.data() + begin;
      const float* z = work_.z.data() + begin;
      std::array<float, kCandidateBlock> d2;
      for (int t = 0; t < count; ++t) {
        const float dx = x[t] - p.x, dy = y[t] - p.y, dz = z[t] - p.z;
        d2[static_cast<std::size_t>(t)] = dx * dx + dy * dy + dz * dz;
      }
      const std::uint8_t* needed = work_.needed.data() + begin;
      const std::uint8_t* has_normal = work_.has_normal.data() + begin;
      for (int t = 0; t < count; ++t) {
        const int inside = (d2[static_cast<std::size_t>(t)] < radius_.squared ? 1 : 0) & (anyone | needed[t]);
        work_.near_list[static_cast<std::size_t>(near_count_)] = begin + t;
        near_count_ += inside & has_normal[t];
        work_.blank_list[static_cast<std::size_t>(blank_count_)] = begin + t;
        blank_count_ += inside & (has_normal[t] ^ 1);
      }
    }
  });
}

// Bins of the pairs (i, js[0..kBlock)), packed f1 | f2 << 8 | f3 << 16, or -1 where the careful path must decide.
//
// With d = q - p unnormalised and unit normals n1, n2, let A be +-n.d of the source the swap rule picks and T that of
// the target, c = n1.n2. Then |d x source|^2 = d2 - A^2 =: s, v.target = d.(n1 x n2)/sqrt(s) whichever is the source,
// and w.target = (T - A c)/sqrt(s).
void PortableFpfh::block_bins(int i, const std::int32_t* js, std::int32_t* codes) const {
  constexpr std::size_t n = kBlock;
  std::array<float, n> x, y, z, mx, my, mz;
  for (std::size_t t = 0; t < n; ++t) {
    const auto j = static_cast<std::size_t>(js[t]);
    x[t] = work_.x[j];
    y[t] = work_.y[j];
    z[t] = work_.z[j];
    mx[t] = work_.nx[j];
    my[t] = work_.ny[j];
    mz[t] = work_.nz[j];
  }
  const Vec3f p = position(i), u = normal(i);
  for (std::size_t t = 0; t < n; ++t) {
    const float dx = x[t] - p.x, dy = y[t] - p.y, dz = z[t] - p.z;
    const float d2 = dx * dx + dy * dy + dz * dz;
    const float along1 = u.x * dx + u.y * dy + u.z * dz;
    const float along2 = mx[t] * dx + my[t] * dy + mz[t] * dz;
    const float c = u.x * mx[t] + u.y * my[t] + u.z * mz[t];
    const float triple =
        (dy * u.z - dz * u.y) * mx[t] + (dz * u.x - dx * u.z) * my[t] + (dx * u.y - dy * u.x) * mz[t];
    const float size1 = std::fabs(along1), size2 = std::fabs(along2);
    const bool swap = size1 < size2;
    const float source = swap ? -along2 : along1;
    const float target = swap ? -along1 : along2;
    const float s = d2 - source * source;
    const float v_length = std::sqrt(s > 0.0F ? s : 0.0F);
    const float d_length = std::sqrt(d2);
    const float inverse = 1.0F / (v_length * d_length);
    const float tie = fpfh_detail::kNearTie * d_length;
    const float f2 = triple * d_length * inverse * 5.5F + 5.5F;
    const float f3 = source * v_length * inverse * 5.5F + 5.5F;
    const float wt = target - source * c;
    const float across = std::fabs(wt);
    const float cl = c * v_length;
    int passed = 0;
    for (std::size_t k = 0; k < fpfh_detail::kEdgeCount; ++k) {
      passed += (across * fpfh_detail::kEdgeCos[k] - cl * fpfh_detail::kEdgeSin[k] > 0.0F) ? 1 : 0;
    }
    const int b1 = wt < 0.0F ? 5 - passed : 5 + passed;
    // max(0, .) first: a NaN from 0/0 becomes 0 and stays in range; such pairs are careful ones anyway.
    const float low2 = f2 > 0.0F ? f2 : 0.0F, low3 = f3 > 0.0F ? f3 : 0.0F;
    const int b2 = static_cast<int>(low2 < 10.0F ? low2 : 10.0F);
    const int b3 = static_cast<int>(low3 < 10.0F ? low3 : 10.0F);
    const int careful = (s > kNearlyParallel * d2 ? 0 : -1) | (std::fabs(size1 - size2) <= tie ? -1 : 0);
    codes[t] = (b1 | (b2 << 8) | (b3 << 16)) | careful;
  }
}

void PortableFpfh::count_slow(int i, int j) {
  add(counts(i), fpfh_detail::pair_bins(position(i), normal(i), position(j), normal(j)));
  add(counts(j), fpfh_detail::pair_bins(position(j), normal(j), position(i), normal(i)));
}

void PortableFpfh::count_valid_pairs(int i) {
  if (near_count_ == 0) return;
  std::int32_t* list = work_.near_list.data();
  std::fill_n(list + near_count_, kBlock, list[near_count_ - 1]);
  std::int32_t* own = counts(i);
  for (int begin = 0; begin < near_count_; begin += kBlock) {
    std::array<std::int32_t, kBlock> codes;
    block_bins(i, list + begin, codes.data());
    const int count = std::min(kBlock, near_count_ - begin);
    for (int t = 0; t < count; ++t) {
      const std::int32_t code = codes[static_cast<std::size_t>(t)];
      const int j = list[begin + t];
      ++work_.neighbour_count[static_cast<std::size_t>(j)];
      if (code < 0) {
        count_slow(i, j);
        continue;
      }
      const PairBins bins = {code & 0xFF, (code >> 8) & 0xFF, code >> 16};
      add(own, bins);
      add(counts(j), bins);
    }
  }
  work_.neighbour_count[static_cast<std::size_t>(i)] += near_count_;
}

// i has a normal, the target does not: f1 and f2 are NaN and count in bin 0, f3 is known. The target's own view is
// all bin 0, filled in at the end, unless the two coincide.
void PortableFpfh::count_blank_targets(int i) {
  const Vec3f p = position(i), u = normal(i);
  std::int32_t* own = counts(i);
  for (int t = 0; t < blank_count_; ++t) {
    const int j = work_.blank_list[static_cast<std::size_t>(t)];
    ++work_.neighbour_count[static_cast<std::size_t>(j)];
    const Vec3f d = position(j) - p;
    const float length = norm(d);
    if (length == 0.0F) {
      add(own, fpfh_detail::kDegenerateBins);
      add(counts(j), fpfh_detail::kDegenerateBins);
    } else {
      add(own, {0, 0, fpfh_detail::cosine_bin(dot(u, d) / length)});
    }
  }
  work_.neighbour_count[static_cast<std::size_t>(i)] += blank_count_;
}

void PortableFpfh::count_blank_source(int i) {
  const Vec3f p = position(i);
  const auto count_one = [&](int j, bool target_has_normal) {
    ++work_.neighbour_count[static_cast<std::size_t>(j)];
    const Vec3f d = p - position(j);
    const float length = norm(d);
    if (length == 0.0F) {
      add(counts(i), fpfh_detail::kDegenerateBins);
      add(counts(j), fpfh_detail::kDegenerateBins);
    } else if (target_has_normal) {
      add(counts(j), {0, 0, fpfh_detail::cosine_bin(dot(normal(j), d) / length)});
    }
  };
  for (int t = 0; t < near_count_; ++t) count_one(work_.near_list[static_cast<std::size_t>(t)], true);
  for (int t = 0; t < blank_count_; ++t) count_one(work_.blank_list[static_cast<std::size_t>(t)], false);
  work_.neighbour_count[static_cast<std::size_t>(i)] += near_count_ + blank_count_;
}

// A point without a normal counted only its coincident neighbours so far; all others are in bin 0.
void PortableFpfh::finish_blank_counts() {
  for (int i = 0; i < point_count_; ++i) {
    if (work_.has_normal[static_cast<std::size_t>(i)]) continue;
    const int pairs = work_.neighbour_count[static_cast<std::size_t>(i)] - 1;
    for (int group = 0; group < 3; ++group) {
      std::int32_t* bins = counts(i) + group * kFpfhBins;
      bins[0] = pairs - bins[kFpfhBins / 2];
    }
  }
}

void PortableFpfh::count_pairs() {
  for (int v = 0; v < k_.height; ++v) {
    for (int i = row_first(v); i < row_end(v); ++i) {
      collect(i, v);
      if (work_.has_normal[static_cast<std::size_t>(i)]) {
        count_valid_pairs(i);
        count_blank_targets(i);
      } else {
        count_blank_source(i);
      }
    }
  }
  finish_blank_counts();
}

void PortableFpfh::describe(Vec3f keypoint_m, float* out) {
  std::array<double, kFpfhSize> sum{};
  visit_neighbours(keypoint_m, [&](int j, float d2) {
    const int pairs = work_.neighbour_count[static_cast<std::size_t>(j)] - 1;
    if (d2 == 0.0F || pairs == 0) return;
    const double weight = double{1.0F / d2} / pairs;
    const std::int32_t* bins = counts(j);
    for (std::size_t b = 0; b < kFpfhSize; ++b) sum[b] += weight * bins[b];
  });
  for (std::size_t group = 0; group < 3; ++group) {
    double total = 0;
    for (std::size_t b = 0; b < kFpfhBins; ++b) total += sum[group * kFpfhBins + b];
    const double scale = total > 0 ? 100.0 / total : 0.0;
    for (std::size_t b = 0; b < kFpfhBins; ++b) {
      out[group * kFpfhBins + b] = static_cast<float>(sum[group * kFpfhBins + b] * scale);
    }
  }
}

}  // namespace

void fpfh_portable(const OrganisedCloud& cloud, std::span<const Vec3f> keypoints, float radius_mm,
                   FpfhWorkspace& work, std::span<float> out) {
  assert(out.size() == keypoints.size() * kFpfhSize);
  assert(work.x.size() >=
         static_cast<std::size_t>(cloud.intrinsics.width) * static_cast<std::size_t>(cloud.intrinsics.height));
  const double radius_m = double{radius_mm} / 1000.0;
  PortableFpfh kernel(cloud, {static_cast<float>(radius_m), static_cast<float>(radius_m * radius_m)}, work);
  const auto finite = [](Vec3f p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); };
  for (const Vec3f& keypoint : keypoints) {
    if (finite(keypoint)) kernel.mark_needed(keypoint * 0.001F);
  }
  kernel.count_pairs();
  for (std::size_t k = 0; k < keypoints.size(); ++k) {
    float* descriptor = out.data() + k * kFpfhSize;
    std::fill_n(descriptor, kFpfhSize, 0.0F);
    if (finite(keypoints[k])) kernel.describe(keypoints[k] * 0.001F, descriptor);
  }
}

}  // namespace im2fit
