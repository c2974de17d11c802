// SPDX-License-Identifier: Apache-2.0
#include "kernels/fpfh/fpfh_blocks.h"

#include <cassert>
#include <cstddef>

#include "kernels/fpfh/fpfh_frame.h"

namespace im2fit::fpfh_detail {
namespace {

constexpr Increments make_increments() {
  Increments t{};
  for (int f1 = 0; f1 < kFpfhBins; ++f1) {
    for (int f2 = 0; f2 < kFpfhBins; ++f2) {
      for (int f3 = 0; f3 < kFpfhBins; ++f3) {
        std::uint8_t* entry = t.bytes + ((f1 * kFpfhBins + f2) * kFpfhBins + f3) * kCountBytes;
        entry[f1] = 1;
        entry[kFpfhBins + f2] = 1;
        if (f3 < kFpfhBins - 1) entry[2 * kFpfhBins + f3] = 1;
      }
    }
  }
  return t;
}

constexpr VectorConstants make_constants() {
  static_assert(kEdgeCount == 5);
  VectorConstants c{};
  for (int k = 0; k < kEdgeCount; ++k) {
    for (int t = 0; t < 8; ++t) c.cosine[k][t] = kEdgeCosine[k], c.sine[k][t] = kEdgeSine[k];
    c.lanes[k] = kEdgeCosine[k];
    c.lanes[kEdgeCount + k] = kEdgeSine[k];
  }
  c.lanes[10] = kNearTie;
  c.lanes[11] = kNearlyParallel;
  return c;
}

class BlockCounter {
 public:
  BlockCounter(FpfhFrame& frame, FpfhWorkspace& work, const PairCounters& counters)
      : frame_(frame), work_(work), counters_(counters) {
    std::fill_n(work_.count_bytes.get(), static_cast<std::ptrdiff_t>(frame.point_count() + kSlack) * kCountBytes,
                std::uint8_t{0});
    task_ = {work_.x.data(),
             work_.y.data(),
             work_.z.data(),
             work_.nx.data(),
             work_.ny.data(),
             work_.nz.data(),
             work_.needed.data(),
             work_.count_bytes.get(),
             frame.counts(0),
             0,
             false,
             frame.radius_squared(),
             work_.ranges.data(),
             0,
             work_.near_list.data(),
             0};
  }

  void count_all() {
    for (int v = 0; v < frame_.intrinsics().height; ++v) {
      for (int i = frame_.row_first(v); i < frame_.row_end(v); ++i) {
        task_.range_count = frame_.find_ranges(frame_.position(i), v, i + 1);
        if (task_.range_count == 0) continue;
        touched_end_ = std::max(touched_end_, task_.ranges[2 * task_.range_count - 1]);
        count_source(i);
      }
    }
    flush();
    complete();
  }

 private:
  void count_source(int i) {
    task_.source = i;
    task_.source_needed = frame_.needed(i);
    task_.aside_count = 0;
    (frame_.has_normal(i) ? counters_.with_normal : counters_.blank)(task_);
    for (int t = 0; t < task_.aside_count; ++t) frame_.count_aside(i, task_.aside_list[t]);
    if (++sources_ == kLanesUntilOverflow) {
      flush();
      touched_begin_ = i + 1;
    }
  }

  void flush() {
    for (int j = touched_begin_; j < touched_end_; ++j) {
      std::uint8_t* bytes = work_.count_bytes.get() + static_cast<std::ptrdiff_t>(j) * kCountBytes;
      std::int32_t* counts = frame_.counts(j);
      for (int b = 0; b < kCountBytes; ++b) counts[b] += bytes[b];
      for (int b = 0; b < kCountBytes; ++b) bytes[b] = 0;
    }
    sources_ = 0;
  }

  // The bin that has no byte.
  void complete() {
    for (int i = 0; i < frame_.point_count(); ++i) {
      std::int32_t* counts = frame_.counts(i);
      int last = 0;
      for (int b = 0; b < kFpfhBins; ++b) last += counts[b];
      for (int b = 0; b < kFpfhBins - 1; ++b) last -= counts[2 * kFpfhBins + b];
      counts[kFpfhSize - 1] = last;
    }
  }

  FpfhFrame& frame_;
  FpfhWorkspace& work_;
  const PairCounters& counters_;
  PairTask task_{};
  int sources_ = 0;  // since the bytes were emptied
  int touched_begin_ = 0, touched_end_ = 0;
};

}  // namespace

constinit const Increments kIncrements = make_increments();
constinit const VectorConstants kVectorConstants = make_constants();

void fpfh_in_blocks(const OrganisedCloud& cloud, std::span<const Vec3f> keypoints, float radius_mm,
                    FpfhWorkspace& work, std::span<float> out, const PairCounters& counters) {
  assert(out.size() == keypoints.size() * kFpfhSize);
  assert(work.needed.size() >=
         static_cast<std::size_t>(cloud.intrinsics.width) * static_cast<std::size_t>(cloud.intrinsics.height));
  FpfhFrame frame(cloud, radius_of(radius_mm), work);
  frame.mark_needed(keypoints);
  BlockCounter(frame, work, counters).count_all();
  frame.describe(keypoints, out);
}

}  // namespace im2fit::fpfh_detail
