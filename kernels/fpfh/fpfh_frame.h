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

// A point lies within half a pixel of its own; three hundredths more cover float rounding of the bounds.
inline constexpr float kPixelReach = 0.53F;
inline constexpr float kSlackM = 2e-5F;    // rounding of positions and chords: below 16 m an ulp is <= 1e-6 m
inline constexpr float kNearestM = 0.02F;  // a sphere nearer than this has no useful outline in the picture
// Ranges of candidates less than this apart are one: a block of pairs that runs over the end of one then meets no
// point of the next, only points out of reach.
inline constexpr int kMergedGap = 16;

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
  void describe(std::span<const Vec3f> keypoints_mm, std::span<float> out);

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

  // Ranges [begin, end) of compact points that together hold every point >= first within the radius of p, whose row
  // is `row` or a later one. In order, at least kMergedGap apart; in work.ranges, begin and end in turn. Returns how
  // many.
  int find_ranges(Vec3f p, int row, int first);

  // Both views of a pair that the fast arithmetic leaves aside.
  void count_careful(int i, int j);
  // Both views of a pair that a tier leaves to portable code, for any reason: portable's own decision.
  void count_aside(int i, int j);
  // Both views of a pair with one normal missing or both. A blank point counts in bin 0, the other in bin 0 of f1
  // and f2 while f3 is known; if the two coincide, both in the middle.
  void count_blank(int i, int j);

 private:
  void compact(const OrganisedCloud& cloud);
  struct Outline;
  Outline outline(Vec3f p) const;
  void find_columns(const Outline& outline, int v0, int v1);
  template <class Visit>
  void visit_neighbours(Vec3f p, Visit visit);
  void describe_one(Vec3f keypoint_m, float* out);

  Intrinsics k_;
  Radius radius_;
  FpfhWorkspace& work_;
  int point_count_ = 0;
};

}  // namespace im2fit::fpfh_detail
