// SPDX-License-Identifier: Apache-2.0
#include "kernels/fpfh/fpfh_frame.h"

#include <array>
#include <limits>

#include "kernels/fpfh/fpfh_lane.h"

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
    : k_(cloud.intrinsics), radius_(radius), work_(work) {
  compact(cloud);
  for (int v = 0; v < k_.height; ++v) {
    const auto row = static_cast<std::size_t>(v);
    const float slope = (static_cast<float>(v) - k_.cy) / k_.fy;
    work_.row_slope[row] = slope;
    work_.row_norm[row] = std::sqrt(1.0F + slope * slope);
    work_.row_inverse_norm[row] = 1.0F / work_.row_norm[row];
  }
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
  // What a block reads past the last point is out of everyone's reach.
  std::fill_n(work_.x.begin() + count, kMergedGap, kNan);
  std::fill_n(work_.needed.begin(), count, std::uint8_t{0});
  std::fill_n(work_.counts.get(), count * kFpfhSize, 0);
}

// The sphere about p as the camera sees it. Seen along a row, whose rays have the slope s = y/z, it is a circle: with
// D the distance of p from the row's plane and rho that from the x axis, the circle's radius is h = sqrt(r^2 - D^2)
// and its centre lies t = sqrt(rho^2 - D^2) away along the row's middle ray. The tangents from the camera have
// x/t' = (p.x t -+ h sqrt(|p|^2 - r^2)) / (rho^2 - r^2), where t' = z sqrt(1 + s^2): D cancels in both differences.
struct FpfhFrame::Outline {
  bool unbounded = true;
  Vec3f p;
  float r = 0;
  float rho_turn = 0;  // how much D changes within a row
  float t_turn = 0;    // |p.x| times how much t does
  float rim = 0;       // sqrt(|p|^2 - r^2)
  float scale = 0;     // fx / (rho^2 - r^2)
  float turn = 0;      // slopes within a row, which bounds the angles between its rays' planes
  int v0 = 0, v1 = 0;  // rows, both included
};

FpfhFrame::Outline FpfhFrame::outline(Vec3f p) const {
  Outline o;
  o.p = p;
  o.r = radius_.metres + kSlackM;
  o.v1 = k_.height - 1;
  if (!(p.z - o.r > kNearestM)) return o;
  o.unbounded = false;
  const float rho_squared = p.y * p.y + p.z * p.z;
  const float beyond = rho_squared - o.r * o.r;
  o.turn = kPixelReach / k_.fy;
  o.rho_turn = std::sqrt(rho_squared) * o.turn;
  // t = rho cos(angle), and D = rho sin(angle) is at most r + rho_turn where the sphere is met.
  o.t_turn = std::fabs(p.x) * (o.r + 1.5F * o.rho_turn) * o.turn;
  o.rim = std::sqrt(p.x * p.x + beyond);
  o.scale = k_.fx / beyond;
  const float steep = o.r * std::sqrt(beyond), inverse = 1.0F / (p.z * p.z - o.r * o.r);
  o.v0 = clamp_to_int((p.y * p.z - steep) * inverse * k_.fy + k_.cy - kPixelReach, 0, k_.height);
  o.v1 = clamp_to_int((p.y * p.z + steep) * inverse * k_.fy + k_.cy + kPixelReach, -1, k_.height - 1);
  return o;
}

// First and last column of rows v0..v1, to work_.columns_low and columns_high; low > high where there is none.
void FpfhFrame::find_columns(const Outline& o, int v0, int v1) {
  const float* slope = work_.row_slope.data();
  const float* norm = work_.row_norm.data();
  const float* inverse_norm = work_.row_inverse_norm.data();
  std::int32_t* low = work_.columns_low.data();
  std::int32_t* high = work_.columns_high.data();
  const float width = static_cast<float>(k_.width), cx = k_.cx, r_squared = o.r * o.r;
  for (int v = v0; v <= v1; ++v) {
    const float across = std::fabs(o.p.y - slope[v] * o.p.z) * inverse_norm[v] - o.rho_turn;
    const float distance = across > 0.0F ? across : 0.0F;
    const float h_squared = r_squared - distance * distance;
    const float h = std::sqrt(h_squared > 0.0F ? h_squared : 0.0F);
    const float middle = o.p.x * ((o.p.y * slope[v] + o.p.z) * inverse_norm[v]);
    const float to_columns = norm[v] * o.scale;
    const float first = (middle - h * o.rim) * to_columns, last = (middle + h * o.rim) * to_columns;
    const float reach = kPixelReach + o.t_turn * to_columns;
    float a = first - std::fabs(first) * o.turn + cx - reach;
    float b = last + std::fabs(last) * o.turn + cx + reach;
    a = a > 0.0F ? a : 0.0F;
    b = b > -1.0F ? b : -1.0F;
    a = a < width ? a : width;
    b = b < width - 1.0F ? b : width - 1.0F;
    low[v] = static_cast<std::int32_t>(a);
    high[v] = h_squared > 0.0F ? static_cast<std::int32_t>(b) : -1;
  }
}

int FpfhFrame::find_ranges(Vec3f p, int row, int first) {
  const Outline o = outline(p);
  const int v0 = std::max(row, o.v0);
  if (!o.unbounded) find_columns(o, v0, o.v1);
  std::int32_t* const ranges = work_.ranges.data();
  std::int32_t* out = ranges;
  for (int v = v0; v <= o.v1; ++v) {
    const auto n = static_cast<std::size_t>(v);
    const int low = o.unbounded ? 0 : work_.columns_low[n];
    const int high = o.unbounded ? k_.width - 1 : work_.columns_high[n];
    if (low > high) continue;
    const std::int32_t* table = work_.row_table.data() + static_cast<std::ptrdiff_t>(v) * (k_.width + 1);
    const int begin = std::max(table[low], first), end = table[high + 1];
    if (begin >= end) continue;
    if (out != ranges && begin - out[-1] < kMergedGap) {
      out[-1] = end;
    } else {
      *out++ = begin;
      *out++ = end;
    }
  }
  return static_cast<int>(out - ranges) / 2;
}

// Calls visit(j, distance squared) for each point within the radius of p, in row order.
template <class Visit>
void FpfhFrame::visit_neighbours(Vec3f p, Visit visit) {
  const int count = find_ranges(p, 0, 0);
  const std::int32_t* ranges = work_.ranges.data();
  for (int r = 0; r < count; ++r) {
    for (int j = ranges[2 * r]; j < ranges[2 * r + 1]; ++j) {
      const Vec3f d = p - position(j);
      const float d2 = dot(d, d);
      if (d2 < radius_.squared) visit(j, d2);
    }
  }
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

void FpfhFrame::count_aside(int i, int j) {
  if (!has_normal(i) || !has_normal(j)) {
    count_blank(i, j);
    return;
  }
  const Vec3f d = position(j) - position(i);
  const std::int32_t code = pair_code(d.x, d.y, d.z, normal(i), normal(j));
  if (code < 0) {
    count_careful(i, j);
    return;
  }
  const PairBins bins = {code & 0xFF, (code >> 8) & 0xFF, code >> 16};
  add(counts(i), bins);
  add(counts(j), bins);
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

void FpfhFrame::describe(std::span<const Vec3f> keypoints_mm, std::span<float> out) {
  for (std::size_t k = 0; k < keypoints_mm.size(); ++k) {
    float* descriptor = out.data() + k * kFpfhSize;
    std::fill_n(descriptor, kFpfhSize, 0.0F);
    if (finite(keypoints_mm[k])) describe_one(keypoints_mm[k] * 0.001F, descriptor);
  }
}

void FpfhFrame::describe_one(Vec3f keypoint_m, float* out) {
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
