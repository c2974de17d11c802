// SPDX-License-Identifier: Apache-2.0
#include "kernels/fpfh/fpfh_frame.h"

#include <array>
#include <limits>

namespace im2fit::fpfh_detail {
namespace {

void add(std::int32_t* counts, PairBins bins) {
  ++counts[bins.f1];
  ++counts[kFpfhBins + bins.f2];
  ++counts[2 * kFpfhBins + bins.f3];
}

bool finite(Vec3f p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

}  // namespace

FpfhFrame::FpfhFrame(const OrganisedCloud& cloud, Radius radius, FpfhWorkspace& work)
    : k_(cloud.intrinsics), radius_(radius), work_(work), inverse_fy_(1.0F / k_.fy) {
  compact(cloud);
}

void FpfhFrame::compact(const OrganisedCloud& cloud) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  std::size_t n = 0;
  std::size_t pixel = 0;
  std::size_t entry = 0;
  for (int v = 0; v < k_.height; ++v) {
    for (int u = 0; u < k_.width; ++u, ++pixel) {
      work_.row_table[entry++] = static_cast<std::int32_t>(n);
      const float x = cloud.x[pixel], y = cloud.y[pixel], z = cloud.z[pixel];
      if (!(finite({x, y, z}) && z > 0.0F)) continue;
      const Vec3f normal = {cloud.nx[pixel], cloud.ny[pixel], cloud.nz[pixel]};
      const bool has_normal = !(std::isnan(normal.x) || std::isnan(normal.y) || std::isnan(normal.z));
      work_.x[n] = x * 0.001F;
      work_.y[n] = y * 0.001F;
      work_.z[n] = z * 0.001F;
      work_.nx[n] = has_normal ? normal.x : kNan;
      work_.ny[n] = has_normal ? normal.y : kNan;
      work_.nz[n] = has_normal ? normal.z : kNan;
      work_.has_normal[n] = has_normal ? 1 : 0;
      ++n;
    }
    work_.row_table[entry++] = static_cast<std::int32_t>(n);
  }
  point_count_ = static_cast<int>(n);
  const auto count = static_cast<std::ptrdiff_t>(n);
  std::fill_n(work_.needed.begin(), count, std::uint8_t{0});
  std::fill_n(work_.counts.get(), count * kFpfhSize, 0);
}

// Calls visit(j, distance squared) for each point within the radius of p, in row order.
template <class Visit>
void FpfhFrame::visit_neighbours(Vec3f p, Visit visit) const {
  visit_candidates(p, 0, [&](int begin, int end) {
    for (int j = begin; j < end; ++j) {
      const Vec3f d = p - position(j);
      const float d2 = dot(d, d);
      if (d2 < radius_.squared) visit(j, d2);
    }
  });
}

void FpfhFrame::mark_needed(std::span<const Vec3f> keypoints_mm) {
  for (const Vec3f& keypoint : keypoints_mm) {
    if (!finite(keypoint)) continue;
    visit_neighbours(keypoint * 0.001F, [&](int j, float) { work_.needed[static_cast<std::size_t>(j)] = 1; });
  }
}

void FpfhFrame::count_careful(int i, int j) {
  add(counts(i), pair_bins(position(i), normal(i), position(j), normal(j)));
  add(counts(j), pair_bins(position(j), normal(j), position(i), normal(i)));
}

void FpfhFrame::count_blank(int i, int j) {
  const Vec3f d = position(j) - position(i);
  const float length = norm(d);
  if (length == 0.0F) {
    add(counts(i), kDegenerateBins);
    add(counts(j), kDegenerateBins);
    return;
  }
  add(counts(i), {0, 0, has_normal(i) ? cosine_bin(dot(normal(i), d) / length) : 0});
  add(counts(j), {0, 0, has_normal(j) ? cosine_bin(dot(normal(j), -d) / length) : 0});
}

void FpfhFrame::describe(std::span<const Vec3f> keypoints_mm, std::span<float> out) const {
  for (std::size_t k = 0; k < keypoints_mm.size(); ++k) {
    float* descriptor = out.data() + k * kFpfhSize;
    std::fill_n(descriptor, kFpfhSize, 0.0F);
    if (finite(keypoints_mm[k])) describe_one(keypoints_mm[k] * 0.001F, descriptor);
  }
}

void FpfhFrame::describe_one(Vec3f keypoint_m, float* out) const {
  std::array<double, kFpfhSize> sum{};
  visit_neighbours(keypoint_m, [&](int j, float d2) {
    const std::int32_t* bins = counts(j);
    int pairs = 0;
    for (int b = 0; b < kFpfhBins; ++b) pairs += bins[b];
    if (d2 == 0.0F || pairs == 0) return;
    const double weight = double{1.0F / d2} / pairs;
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

}  // namespace im2fit::fpfh_detail
