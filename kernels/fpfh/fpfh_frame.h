// SPDX-License-Identifier: Apache-2.0
// What the float tiers share: the compacted cloud, candidates from the picture's rows, the careful pairs, and the
// descriptor made of the counts. Tiers differ only in how they count the pairs of a source.
//
// Counts of a point: kFpfhSize integers, one histogram after the other, each pair of the point adding one to each of
// the three. Hence the sum of any of the three is the number of its pairs.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "kernels/fpfh/fpfh.h"
#include "kernels/fpfh/fpfh_pair.h"

namespace im2fit::fpfh_detail {

// A point lies within half a pixel of its own; two hundredths more cover float rounding of the bounds.
inline constexpr float kPixelReach = 0.52F;
inline constexpr float kSlackM = 2e-5F;    // rounding of positions and chords: below 16 m an ulp is <= 1e-6 m
inline constexpr float kNearestM = 1e-3F;  // nearer than this, a sphere's outline in the picture is unbounded

struct Radius {
  float metres, squared;
};
inline Radius radius_of(float radius_mm) {
  const double metres = double{radius_mm} / 1000.0;
  return {static_cast<float>(metres), static_cast<float>(metres * metres)};
}

inline int clamp_to_int(float value, int low, int high) {
  if (!(value > static_cast<float>(low))) return low;
  return value >= static_cast<float>(high) ? high : static_cast<int>(value);
}

class FpfhFrame {
 public:
  FpfhFrame(const OrganisedCloud& cloud, Radius radius, FpfhWorkspace& work);

  // Marks the points within the radius of every finite keypoint.
  void mark_needed(std::span<const Vec3f> keypoints_mm);
  // From finished counts; zeros for a keypoint that is not finite.
  void describe(std::span<const Vec3f> keypoints_mm, std::span<float> out) const;

  const Intrinsics& intrinsics() const { return k_; }
  float radius_squared() const { return radius_.squared; }
  int point_count() const { return point_count_; }
  int row_first(int v) const { return work_.row_table[static_cast<std::size_t>(v * (k_.width + 1))]; }
  int row_end(int v) const { return work_.row_table[static_cast<std::size_t>(v * (k_.width + 1) + k_.width)]; }
  bool needed(int i) const { return work_.needed[static_cast<std::size_t>(i)] != 0; }
  bool has_normal(int i) const { return work_.has_normal[static_cast<std::size_t>(i)] != 0; }
  Vec3f position(int i) const {
    const auto n = static_cast<std::size_t>(i);
    return {work_.x[n], work_.y[n], work_.z[n]};
  }
  Vec3f normal(int i) const {
    const auto n = static_cast<std::size_t>(i);
    return {work_.nx[n], work_.ny[n], work_.nz[n]};
  }
  std::int32_t* counts(int i) const { return work_.counts.get() + static_cast<std::ptrdiff_t>(i) * kFpfhSize; }

  // Calls visit(begin, end) with ranges of compact points, rows >= first_row, that together hold every point within
  // the radius of p.
  template <class Visit>
  void visit_candidates(Vec3f p, int first_row, Visit visit) const;

  // Both views of a pair that the fast arithmetic leaves aside.
  void count_careful(int i, int j);
  // Both views of a pair with one normal missing or both. A blank point counts in bin 0, the other in bin 0 of f1
  // and f2 while f3 is known; if the two coincide, both in the middle.
  void count_blank(int i, int j);

 private:
  void compact(const OrganisedCloud& cloud);
  template <class Visit>
  void visit_neighbours(Vec3f p, Visit visit) const;
  void describe_one(Vec3f keypoint_m, float* out) const;

  Intrinsics k_;
  Radius radius_;
  FpfhWorkspace& work_;
  float inverse_fy_;
  int point_count_ = 0;
};

// Row v holds only points whose ray's slope y/z is that of row v within kPixelReach, so the sphere meets them in a
// chord at least the slab's distance dy from its centre.
template <class Visit>
void FpfhFrame::visit_candidates(Vec3f p, int first_row, Visit visit) const {
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

}  // namespace im2fit::fpfh_detail
