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
// - a point without a normal needs no arithmetic of its own: it counts in bin 0.
//
// Determinism: + - * / sqrt on floats in written order, integer counts (any order), double sums in row order.
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>

#include "kernels/fpfh/fpfh.h"
#include "kernels/fpfh/fpfh_blocks.h"
#include "kernels/fpfh/fpfh_frame.h"
#include "kernels/fpfh/fpfh_lane.h"

namespace im2fit {
namespace {

using fpfh_detail::FpfhFrame;

constexpr int kBlock = 16;           // pairs computed together: a fixed trip count the compiler can vectorise
constexpr int kCandidateBlock = 64;  // candidates tested together

class PairCounter {
 public:
  PairCounter(FpfhFrame& frame, FpfhWorkspace& work) : frame_(frame), work_(work) {}
  void count_all();

 private:
  void collect(int i, int row);
  void block_bins(int i, const std::int32_t* js, std::int32_t* codes) const;
  void count_near(int i);

  FpfhFrame& frame_;
  FpfhWorkspace& work_;
  int near_count_ = 0;
  int blank_count_ = 0;
};

// Neighbours j > i whose pair with i anyone needs, parted by whether they have a normal.
void PairCounter::collect(int i, int row) {
  near_count_ = 0;
  blank_count_ = 0;
  const float radius_squared = frame_.radius_squared();
  const Vec3f p = frame_.position(i);
  const std::uint8_t anyone = work_.needed[static_cast<std::size_t>(i)];
  const int range_count = frame_.find_ranges(p, row, i + 1);
  for (int r = 0; r < range_count; ++r) {
    const int range_begin = work_.ranges[static_cast<std::size_t>(2 * r)];
    const int range_end = work_.ranges[static_cast<std::size_t>(2 * r + 1)];
    for (int begin = range_begin; begin < range_end; begin += kCandidateBlock) {
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
        const int inside = (d2[static_cast<std::size_t>(t)] < radius_squared ? 1 : 0) & (anyone | needed[t]);
        work_.near_list[static_cast<std::size_t>(near_count_)] = begin + t;
        near_count_ += inside & has_normal[t];
        work_.blank_list[static_cast<std::size_t>(blank_count_)] = begin + t;
        blank_count_ += inside & (has_normal[t] ^ 1);
      }
    }
  }
}

// Codes of the pairs (i, js[0..kBlock)): see fpfh_lane.h.
void PairCounter::block_bins(int i, const std::int32_t* js, std::int32_t* codes) const {
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
  const Vec3f p = frame_.position(i), u = frame_.normal(i);
  for (std::size_t t = 0; t < n; ++t) {
    const float dx = x[t] - p.x, dy = y[t] - p.y, dz = z[t] - p.z;
    codes[t] = fpfh_detail::pair_code(dx, dy, dz, u, {mx[t], my[t], mz[t]});
  }
}

void PairCounter::count_near(int i) {
  if (near_count_ == 0) return;
  std::int32_t* list = work_.near_list.data();
  std::fill_n(list + near_count_, kBlock, list[near_count_ - 1]);
  const auto add = [](std::int32_t* counts, std::int32_t code) {
    ++counts[code & 0xFF];
    ++counts[kFpfhBins + ((code >> 8) & 0xFF)];
    ++counts[2 * kFpfhBins + (code >> 16)];
  };
  std::int32_t* own = frame_.counts(i);
  for (int begin = 0; begin < near_count_; begin += kBlock) {
    std::array<std::int32_t, kBlock> codes;
    block_bins(i, list + begin, codes.data());
    const int count = std::min(kBlock, near_count_ - begin);
    for (int t = 0; t < count; ++t) {
      const std::int32_t code = codes[static_cast<std::size_t>(t)];
      const int j = list[begin + t];
      if (code < 0) {
        frame_.count_careful(i, j);
        continue;
      }
      add(own, code);
      add(frame_.counts(j), code);
    }
  }
}

void PairCounter::count_all() {
  for (int v = 0; v < frame_.intrinsics().height; ++v) {
    for (int i = frame_.row_first(v); i < frame_.row_end(v); ++i) {
      collect(i, v);
      if (frame_.has_normal(i)) {
        count_near(i);
      } else {
        for (int t = 0; t < near_count_; ++t) frame_.count_blank(i, work_.near_list[static_cast<std::size_t>(t)]);
      }
      for (int t = 0; t < blank_count_; ++t) frame_.count_blank(i, work_.blank_list[static_cast<std::size_t>(t)]);
    }
  }
}

}  // namespace

FpfhWorkspace::FpfhWorkspace(int width, int height) {
  const std::size_t count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  constexpr std::size_t kSlack = 64;  // the slack lets a block of pairs be read past the end or padded in place
  for (LazyZeros<float>* v : {&x, &y, &z, &nx, &ny, &nz}) *v = LazyZeros<float>(count + kSlack);
  row_table = LazyZeros<std::int32_t>(static_cast<std::size_t>(width + 1) * static_cast<std::size_t>(height));
  has_normal = LazyZeros<std::uint8_t>(count);
  needed = LazyZeros<std::uint8_t>(count + kSlack);
  // Left as they come: nothing is read before it is written. (libc++ 14 has no make_unique_for_overwrite.)
  counts.reset(new std::int32_t[count * kFpfhSize]);
  count_bytes.reset(new std::uint8_t[(count + kSlack) * fpfh_detail::kCountBytes]);
  const auto rows = static_cast<std::size_t>(height);
  for (std::vector<float>* v : {&row_slope, &row_norm, &row_inverse_norm}) v->resize(rows);
  for (std::vector<std::int32_t>* v : {&columns_low, &columns_high}) v->resize(rows);
  ranges.resize(2 * rows);
  near_list = LazyZeros<std::int32_t>(count + kSlack);
  blank_list = LazyZeros<std::int32_t>(count + kSlack);
}

void fpfh_portable(const OrganisedCloud& cloud, std::span<const Vec3f> keypoints, float radius_mm,
                   FpfhWorkspace& work, std::span<float> out) {
  assert(out.size() == keypoints.size() * kFpfhSize);
  assert(work.x.size() >=
         static_cast<std::size_t>(cloud.intrinsics.width) * static_cast<std::size_t>(cloud.intrinsics.height));
  FpfhFrame frame(cloud, fpfh_detail::radius_of(radius_mm), work);
  frame.mark_needed(keypoints);
  PairCounter(frame, work).count_all();
  frame.describe(keypoints, out);
}

void fpfh(const OrganisedCloud& cloud, std::span<const Vec3f> keypoints, float radius_mm, FpfhWorkspace& work,
          std::span<float> out) {
  IM2FIT_CHOSEN_ONCE best = fastest(kFpfhKernels);
  best(cloud, keypoints, radius_mm, work, out);
}

}  // namespace im2fit
