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

class BlockCounter {
 public:
  BlockCounter(FpfhFrame& frame, FpfhWorkspace& work, CountPairsFunction* count_pairs)
      : frame_(frame), work_(work), count_pairs_(count_pairs) {
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
             nullptr,
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
        if (frame_.has_normal(i)) {
          count_source(i);
        } else {
          count_blank_source(i);
        }
      }
    }
    flush();
    complete();
  }

 private:
  void count_source(int i) {
    task_.source = i;
    task_.source_needed = frame_.needed(i);
    task_.own_counts = frame_.counts(i);
    task_.aside_count = 0;
    count_pairs_(task_);
    for (int t = 0; t < task_.aside_count; ++t) frame_.count_aside(i, task_.aside_list[t]);
    if (++sources_ == kLanesUntilOverflow) {
      flush();
      touched_begin_ = i + 1;
    }
  }

  void count_blank_source(int i) {
    const Vec3f p = frame_.position(i);
    for (int r = 0; r < task_.range_count; ++r) {
      for (int j = task_.ranges[2 * r]; j < task_.ranges[2 * r + 1]; ++j) {
        const Vec3f d = frame_.position(j) - p;
        if (d.x * d.x + d.y * d.y + d.z * d.z < task_.radius_squared && (frame_.needed(i) || frame_.needed(j)))
          frame_.count_blank(i, j);
      }
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
  CountPairsFunction* count_pairs_;
  PairTask task_{};
  int sources_ = 0;  // since the bytes were emptied
  int touched_begin_ = 0, touched_end_ = 0;
};

}  // namespace

constinit const Increments kIncrements = make_increments();

void fpfh_in_blocks(const OrganisedCloud& cloud, std::span<const Vec3f> keypoints, float radius_mm,
                    FpfhWorkspace& work, std::span<float> out, CountPairsFunction* count_pairs) {
  assert(out.size() == keypoints.size() * kFpfhSize);
  assert(work.needed.size() >=
         static_cast<std::size_t>(cloud.intrinsics.width) * static_cast<std::size_t>(cloud.intrinsics.height));
  FpfhFrame frame(cloud, radius_of(radius_mm), work);
  frame.mark_needed(keypoints);
  BlockCounter(frame, work, count_pairs).count_all();
  frame.describe(keypoints, out);
}

}  // namespace im2fit::fpfh_detail
