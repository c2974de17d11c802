// SPDX-License-Identifier: Apache-2.0
// The sensor's tables, and what of a view no noise changes.
#include "train/camera/depth_sensor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "train/common/simd_clones.h"

namespace im2fit::lab {
namespace {

constexpr std::int32_t kSurelyLost = 65536;
// Multipath: share of how far two walls part kMultipathReachPx (at 640 wide) from the corner.
constexpr float kMultipathShare = 0.1F;
constexpr float kMultipathMostMm = 20;
constexpr int kMultipathReachPx = 24;

double incidence(int cosine_byte) {
  constexpr double kMax = 87 * std::numbers::pi / 180;
  return std::min(std::acos(std::min(1.0, cosine_byte / 255.0)), kMax);
}
double grazing(double t) {
  const double rest = std::numbers::pi / 2 - t;
  return 0.1 * t * t / (rest * rest);
}
double ramp(double x, double low, double high) {
  return std::clamp((x - low) / (high - low), 0.0, 1.0);
}
// What one kind of sensor makes of a surface head-on and of a grazing one.
double head_on_sigma(SensorKind kind, double z_mm) {
  return kind == SensorKind::time_of_flight ? tof_sigma_mm(z_mm, 1) : axial_sigma_mm(z_mm, 1);
}
double graze_factor(SensorKind kind, double z_mm) {
  const double z = z_mm / 1000;
  return kind == SensorKind::time_of_flight ? z * std::sqrt(z) : 1 / std::sqrt(z);
}
std::int32_t chance_of(double p) {
  return static_cast<std::int32_t>(std::clamp(p, 0.0, 1.0) * 65535);
}

}  // namespace

SensorOptions kinect_sensor() {
  return {};
}
SensorOptions tof_sensor() {
  SensorOptions o;
  o.kind = SensorKind::time_of_flight;
  o.quantise = o.shadow = false;
  o.range_min_mm = 400;
  o.range_max_mm = 5000;
  return o;
}
SensorOptions exact_sensor() {
  SensorOptions o;
  o.noise = o.quantise = o.shadow = o.holes = false;
  o.range_min_mm = 0;
  o.range_max_mm = 65535;
  return o;
}

double raw_to_mm(int raw) {
  return 1 / ((kRawAtInfinity - raw) * kRawStepPerMm);
}

double axial_sigma_mm(double z_mm, double cosine) {
  const double z = z_mm / 1000;
  const double t = std::min(std::acos(std::clamp(cosine, 0.0, 1.0)), 87 * std::numbers::pi / 180);
  return 1.2 + 1.9 * (z - 0.4) * (z - 0.4) + grazing(t) / std::sqrt(z);
}

double tof_sigma_mm(double z_mm, double cosine) {
  const double z = z_mm / 1000;
  const double t = std::min(std::acos(std::clamp(cosine, 0.0, 1.0)), 87 * std::numbers::pi / 180);
  return 2.0 + 0.3 * z * z + grazing(t) * graze_factor(SensorKind::time_of_flight, z_mm);
}

DepthSensor::DepthSensor(const SensorOptions& options, const Intrinsics& k)
    : options_(options),
      k_(k),
      patch_px_(k.width > 400 ? kPatchMaxPx : 2),
      pixel_scale_(k.fx / kKinectFocalPx),
      source_(static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height)),
      edge_(source_.size()),
      step_(source_.size()),
      lattice_low_(static_cast<std::size_t>(k.width / patch_px_ + 2)),
      lattice_row_low_(lattice_low_.size()),
      lattice_row_high_(lattice_low_.size()),
      patch_(static_cast<std::size_t>(k.width)) {
  make_buffers();
  make_tables();
}

void DepthSensor::make_buffers() {
  if (in_steps()) {
    exact_.resize(source_.size());
    sigma_.resize(source_.size());
    lost_.resize(source_.size());
    step_row_.resize(static_cast<std::size_t>(k_.width));
    beside_.u.resize(step_row_.size());
    beside_.from.resize(step_row_.size());
    beside_.bits.resize(step_row_.size());
    beside_.sigma.resize(step_row_.size());
  }
}

void DepthSensor::make_tables() {
  tables_ = {};
  Tables& t = tables_;
  for (int raw = 0; raw < kRawCount; ++raw) {
    // Past the last finite step there is nothing to deliver; the tables keep the farthest's values.
    const double z_mm = raw_to_mm(std::min(raw, static_cast<int>(kRawAtInfinity)));
    const double step_mm = z_mm * z_mm * kRawStepPerMm;
    const double sigma = head_on_sigma(options_.kind, z_mm) / step_mm;
    const double quantiser = options_.quantise ? 1.0 / 12 : 0;
    t.sigma_raw.push_back(static_cast<float>(std::sqrt(std::max(0.0, sigma * sigma - quantiser))));
    t.graze_raw.push_back(static_cast<float>(graze_factor(options_.kind, z_mm) / step_mm));
    const double far_loss =
        options_.kind == SensorKind::time_of_flight ? 0.1 * ramp(z_mm, 4500, 5500) : 0.3 * ramp(z_mm, 4000, 5500);
    t.lost_by_raw.push_back(chance_of(3e-4 + far_loss));
  }
  for (int c = 0; c < 256; ++c) {
    const double angle = incidence(c);
    t.graze.push_back(static_cast<float>(grazing(angle)));
    t.lateral_px.push_back(static_cast<float>(0.8 + 0.035 * angle / (std::numbers::pi / 2 - angle)) * pixel_scale_);
    t.lost_by_cosine.push_back(chance_of(0.7 * std::pow(ramp(angle * 180 / std::numbers::pi, 70, 88), 2)));
  }
  scale_depth(options_.depth_scale);
}

void DepthSensor::scale_depth(float depth_scale) {
  options_.depth_scale = depth_scale;
  tables_.mm.clear();
  for (int raw = 0; raw < kRawCount; ++raw) {
    const double delivered = raw_to_mm(std::min(raw, static_cast<int>(kRawAtInfinity))) * depth_scale;
    const bool inside = delivered >= options_.range_min_mm && delivered <= options_.range_max_mm && delivered < 65535;
    tables_.mm.push_back(inside ? static_cast<std::uint16_t>(std::lround(delivered)) : std::uint16_t{0});
  }
  tables_.mm.push_back(0);  // of kRawCount, no data
}

void DepthSensor::change(const SensorOptions& options) {
  SensorOptions alike = options;
  alike.depth_scale = options_.depth_scale;
  alike.box_margin_px = options_.box_margin_px;
  const bool same = alike == options_;
  options_ = options;
  if (same) {
    scale_depth(options.depth_scale);
    return;
  }
  make_buffers();
  make_tables();
}

IM2FIT_SIMD_CLONES void DepthSensor::shadow_rows(const CleanView& view, int v0, int v1) {
  const std::size_t first = view.at(0, v0), width = static_cast<std::size_t>(k_.width);
  const float* in = &view.inverse_depth[first];
  float* out = &source_[first];
  if (!options_.shadow) {
    std::copy_n(in, width * static_cast<std::size_t>(v1 - v0), out);
    return;
  }
  // Column in the projector's picture: u - f b / z. Seen from the right, columns must fall; one that does not is
  // behind something the projector meets first. Half a pixel of grace for surfaces seen edge-on. Along a row each
  // pixel waits for the one before it, so rows go side by side.
  const float disparity = k_.fx * kProjectorBaselineMm;
  const auto several = [&]<std::size_t kRows>(std::array<float, kRows> lowest) {
    for (std::size_t u = width; u-- > 0;)
      for (std::size_t r = 0; r < kRows; ++r) {
        const float q = in[r * width + u];
        const float column = static_cast<float>(u) - disparity * q;
        out[r * width + u] = column > lowest[r] + 0.5F ? 0 : q;
        lowest[r] = q > 0 ? std::min(lowest[r], column) : lowest[r];
      }
    in += kRows * width;
    out += kRows * width;
  };
  int v = v0;
  constexpr float kFar = 1e30F;
  for (; v + 4 <= v1; v += 4) several(std::array{kFar, kFar, kFar, kFar});
  for (; v < v1; ++v) several(std::array{kFar});
}

IM2FIT_SIMD_CLONES void DepthSensor::edge_rows(const CleanView& view, int v0, int v1) {
  const int w = k_.width;
  const int first = std::max(0, v0 - kEdgeReachPx);
  const int last = std::min(k_.height, v1 + kEdgeReachPx);
  for (int v = first; v < last; ++v) {
    const float* q = &view.inverse_depth[view.at(0, v)];
    const float* below = v + 1 < k_.height ? q + w : q;
    std::uint8_t* step = &step_[view.at(0, v)];
    for (int u = 0; u < w; ++u) {
      const float right = u + 1 < w ? q[u + 1] : q[u];
      const float limit = kDepthStep * q[u];
      step[u] = static_cast<std::uint8_t>((std::fabs(right - q[u]) > limit) | (std::fabs(below[u] - q[u]) > limit));
    }
  }
  for (int v = v0; v < v1; ++v) {
    std::uint8_t* edge = &edge_[view.at(0, v)];
    std::fill_n(edge, w, std::uint8_t{0});
    // A step lies between a pixel and its right or lower neighbour: reach one less on the far side.
    const int to = std::min(k_.height - 1, v + kEdgeReachPx - 1);
    for (int r = std::max(0, v - kEdgeReachPx); r <= to; ++r) {
      const std::uint8_t* step = &step_[view.at(0, r)];
      for (int u = 0; u < w; ++u) edge[u] = static_cast<std::uint8_t>(edge[u] | step[u]);
    }
    std::uint8_t previous[kEdgeReachPx] = {};
    for (int u = 0; u < w; ++u) {
      const std::uint8_t here = edge[u];
      const std::uint8_t next = u + 1 < w ? edge[u + 1] : std::uint8_t{0};
      edge[u] = static_cast<std::uint8_t>(here | next | previous[0] | previous[1]);
      previous[1] = previous[0];
      previous[0] = here;
    }
  }
}

// 1/z is affine over a plane's picture and convex across a concave corner: its second difference is zero away from
// corners and grows towards them. Room only: on anything else it would mark outlines.
void DepthSensor::bias_rows(const CleanView& view, int v0, int v1) {
  const int reach = std::max(2, static_cast<int>(std::lround(kMultipathReachPx * pixel_scale_)));
  const auto bend = [&](std::size_t low, std::size_t here, std::size_t high) {
    if (view.label[low] != kRoom || view.label[high] != kRoom) return 0.0F;
    return std::max(0.0F, view.inverse_depth[low] + view.inverse_depth[high] - 2 * view.inverse_depth[here]);
  };
  for (int v = v0; v < v1; ++v) {
    for (int u = 0; u < k_.width; ++u) {
      const std::size_t at = view.at(u, v);
      const float q = view.inverse_depth[at];
      if (view.label[at] != kRoom || q <= 0) continue;
      float sum = 0;
      if (u >= reach && u + reach < k_.width) sum += bend(view.at(u - reach, v), at, view.at(u + reach, v));
      if (v >= reach && v + reach < k_.height) sum += bend(view.at(u, v - reach), at, view.at(u, v + reach));
      if (sum * 1e3F < q) continue;  // rounding
      const float z = 1 / q;
      source_[at] = 1 / (z + std::min(kMultipathMostMm, kMultipathShare * sum * z * z));
    }
  }
}

void DepthSensor::prepare(const CleanView& view, const PixelBox& box) {
  if (box.empty()) return;
  // Displaced samples come from up to kEdgeReachPx rows away.
  const int v0 = std::max(0, box.v0 - kEdgeReachPx);
  const int v1 = std::min(k_.height, box.v1 + kEdgeReachPx);
  shadow_rows(view, v0, v1);
  if (options_.noise && options_.kind == SensorKind::time_of_flight) bias_rows(view, v0, v1);
  if (options_.noise) edge_rows(view, box.v0, box.v1);
  if (in_steps()) expect_rows(view, v0, v1);
}

// All of deliver() that no noise changes, so that frames of a scene that stands still share it.
IM2FIT_SIMD_CLONES void DepthSensor::expect_rows(const CleanView& view, int v0, int v1) {
  const std::size_t first = view.at(0, v0);
  const auto count = static_cast<int>(view.at(0, v1) - first);
  const float* __restrict source = &source_[first];
  const std::uint8_t* __restrict cosine = &view.cosine[first];
  float* __restrict exact = &exact_[first];
  float* __restrict sigma = &sigma_[first];
  std::int32_t* __restrict lost = &lost_[first];
  const float* __restrict sigma_raw = tables_.sigma_raw.data();
  const float* __restrict graze_raw = tables_.graze_raw.data();
  const float* __restrict graze = tables_.graze.data();
  const std::int32_t* __restrict lost_by_raw = tables_.lost_by_raw.data();
  const std::int32_t* __restrict lost_by_cosine = tables_.lost_by_cosine.data();
  const std::int32_t heard = options_.holes ? -1 : 0;
  // In passes over short blocks, with comparisons and not std::min: the vectoriser can handle these.
  constexpr int kBlock = 128;
  constexpr auto kLast = static_cast<float>(kRawCount - 1);
  std::int32_t index[kBlock], angle[kBlock];
  for (int at = 0; at < count; at += kBlock) {
    const int n = count - at < kBlock ? count - at : kBlock;
    for (int i = 0; i < n; ++i) angle[i] = cosine[at + i];
    for (int i = 0; i < n; ++i) {
      const float raw = static_cast<float>(kRawAtInfinity) - source[at + i] * kRawPerInverseMm;
      const float positive = raw > 0 ? raw : 0;
      exact[at + i] = raw;
      index[i] = static_cast<std::int32_t>(positive < kLast ? positive : kLast);
    }
    for (int i = 0; i < n; ++i) sigma[at + i] = sigma_raw[index[i]] + graze_raw[index[i]] * graze[angle[i]];
    for (int i = 0; i < n; ++i) {
      const std::int32_t by_cosine = lost_by_cosine[angle[i]], by_raw = lost_by_raw[index[i]];
      const std::int32_t likely = (by_cosine > by_raw ? by_cosine : by_raw) & heard;
      lost[at + i] = source[at + i] > 0 ? likely : kSurelyLost;
    }
  }
}

}  // namespace im2fit::lab
