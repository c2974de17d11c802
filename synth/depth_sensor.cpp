// SPDX-License-Identifier: Apache-2.0
#include "synth/depth_sensor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <numbers>

#include "synth/clones.h"

namespace im2fit::synth {
namespace {

// 1/z = (7.5 - m)/9000, m = ((raw - 800)/4 - 0.375) 0.1042: the formula of the device's own driver.
constexpr double kRawAtInfinity = 7.5 / 0.1042 * 4 + 800 + 1.5;
constexpr float kRawPerInverseMm = static_cast<float>(1 / kRawStepPerMm);
constexpr float kDepthStep = 0.02F;  // relative: a jump of 40 mm at 2 m is an edge
constexpr int kEdgeReachPx = 2;
constexpr float kPatchShare = 0.5F;  // of the axial variance
constexpr float kTofPatchShare = 0.25F;
constexpr std::int32_t kSurelyLost = 65536;
constexpr double kFlyingShare = 0.45;  // of pixels at an edge: both surfaces
constexpr double kGivenUpShare = 0.15;
// Multipath: share of how far two walls part kMultipathReachPx (at 640 wide) from the corner.
constexpr float kMultipathShare = 0.1F;
constexpr float kMultipathMostMm = 20;
constexpr int kMultipathReachPx = 24;

enum Stream : std::uint64_t { kPixels = 0x5E01, kLattice = 0x5E02, kBlobs = 0x5E03, kHairPattern = 0x5E04 };

// Counter-based: any row or pixel of any frame can be had without the ones before it.
std::uint64_t row_seed(std::uint64_t seed, Stream stream, std::uint64_t frame, int v) {
  return Rng::for_item(seed, stream + (static_cast<std::uint64_t>(v) << 16), frame).next();
}
std::uint64_t draw(std::uint64_t row, int k) {
  return Rng(row + kRowStep * static_cast<std::uint64_t>(k)).next();
}

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
// Whether of the next kTogether pixels none is at an edge and none hair.
constexpr int kTogether = 8;
bool plain(const std::uint8_t* edges, const std::uint8_t* labels) {
  std::uint64_t edge = 0, label = 0;
  std::memcpy(&edge, edges, kTogether);
  std::memcpy(&label, labels, kTogether);
  static_assert(kHair == 0x81);  // a byte's highest bit and its lowest, seven lower
  return edge == 0 && (label & (label << 7) & 0x8080808080808080ULL) == 0;
}

// people[u] = the label's mask_value where there is depth; without branches, for the vectoriser.
void mark_people(const std::uint8_t* __restrict labels, const std::uint16_t* __restrict depth, int count,
                 std::uint8_t* __restrict people) {
  for (int u = 0; u < count; ++u) {
    const auto person = static_cast<std::uint8_t>(255 - ((labels[u] & 0x7F) >> 1));
    const auto seen = static_cast<std::uint8_t>(depth[u] != 0 && labels[u] >= kPerson ? 255 : 0);
    people[u] = static_cast<std::uint8_t>(person & seen);
  }
}

// Of a displacement.
inline int whole_pixels(float d) {
  return std::clamp(static_cast<int>(d + std::copysign(0.5F, d)), -kEdgeReachPx, kEdgeReachPx);
}

std::uint16_t chance_of(double p) {
  return static_cast<std::uint16_t>(std::clamp(p, 0.0, 1.0) * 65535);
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
      patch_px_(k.width > 400 ? 4 : 2),
      pixel_scale_(k.fx / kKinectFocalPx),
      source_(static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height)),
      edge_(source_.size()),
      step_(source_.size()),
      lattice_low_(static_cast<std::size_t>(k.width / patch_px_ + 2)),
      lattice_row_low_(lattice_low_.size()),
      lattice_row_high_(lattice_low_.size()),
      patch_(static_cast<std::size_t>(k.width)) {
  if (in_steps()) {
    exact_.resize(source_.size());
    sigma_.resize(source_.size());
    lost_.resize(source_.size());
    step_row_.resize(static_cast<std::size_t>(k.width));
    beside_.u.resize(step_row_.size());
    beside_.from.resize(step_row_.size());
    beside_.bits.resize(step_row_.size());
    beside_.sigma.resize(step_row_.size());
  }
  Tables& t = tables_;
  for (int raw = 0; raw < kRawCount; ++raw) {
    // Past the last finite step there is nothing to deliver; the tables keep the farthest's values.
    const double z_mm = raw_to_mm(std::min(raw, static_cast<int>(kRawAtInfinity)));
    const double step_mm = z_mm * z_mm * kRawStepPerMm;
    const double sigma = head_on_sigma(options.kind, z_mm) / step_mm;
    const double quantiser = options.quantise ? 1.0 / 12 : 0;
    t.sigma_raw.push_back(static_cast<float>(std::sqrt(std::max(0.0, sigma * sigma - quantiser))));
    t.graze_raw.push_back(static_cast<float>(graze_factor(options.kind, z_mm) / step_mm));
    const double far_loss =
        options.kind == SensorKind::time_of_flight ? 0.1 * ramp(z_mm, 4500, 5500) : 0.3 * ramp(z_mm, 4000, 5500);
    t.lost_by_raw.push_back(chance_of(3e-4 + far_loss));
  }
  for (int c = 0; c < 256; ++c) {
    const double angle = incidence(c);
    t.graze.push_back(static_cast<float>(grazing(angle)));
    t.lateral_px.push_back(static_cast<float>(0.8 + 0.035 * angle / (std::numbers::pi / 2 - angle)) * pixel_scale_);
    t.lost_by_cosine.push_back(chance_of(0.7 * std::pow(ramp(angle * 180 / std::numbers::pi, 70, 88), 2)));
  }
  scale_depth(options.depth_scale);
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
  if (!(alike == options_)) {
    *this = DepthSensor(options, k_);
    return;
  }
  options_ = options;
  scale_depth(options.depth_scale);
}

IM2FIT_CLONES void DepthSensor::shadow_rows(const CleanView& view, int v0, int v1) {
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

IM2FIT_CLONES void DepthSensor::edge_rows(const CleanView& view, int v0, int v1) {
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
// corners and grows towards them. Room only: on anything else it speaks of outlines.
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
IM2FIT_CLONES void DepthSensor::expect_rows(const CleanView& view, int v0, int v1) {
  const std::size_t end = view.at(0, v1);
  for (std::size_t at = view.at(0, v0); at < end; ++at) {
    const float q = source_[at];
    const float exact = static_cast<float>(kRawAtInfinity) - q * kRawPerInverseMm;
    const auto index = static_cast<std::size_t>(std::clamp(exact, 0.0F, static_cast<float>(kRawCount - 1)));
    const std::uint8_t cosine = view.cosine[at];
    exact_[at] = exact;
    sigma_[at] = tables_.sigma_raw[index] + tables_.graze_raw[index] * tables_.graze[cosine];
    const int lost = std::max(tables_.lost_by_cosine[cosine], tables_.lost_by_raw[index]);
    lost_[at] = !(q > 0) ? kSurelyLost : options_.holes ? lost : 0;
  }
}

IM2FIT_CLONES void DepthSensor::lattice_row(std::uint64_t seed, std::uint64_t frame, int cell,
                                            std::vector<float>& out) {
  const std::uint64_t row = row_seed(seed, kLattice, frame, cell);
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = normal_of_bits(draw(row, static_cast<int>(i)));
}

// Rows of a frame from top to bottom: those of one cell share the lattice's two rows.
IM2FIT_CLONES void DepthSensor::patch_row(std::uint64_t seed, std::uint64_t frame, int v) {
  const int cell = v / patch_px_;
  if (cell != lattice_cell_) {
    if (cell == lattice_cell_ + 1 && lattice_cell_ >= 0)
      lattice_row_low_.swap(lattice_row_high_);
    else
      lattice_row(seed, frame, cell, lattice_row_low_);
    lattice_row(seed, frame, cell + 1, lattice_row_high_);
    lattice_cell_ = cell;
  }
  // Interpolated normals keep unit variance when divided by the length of their weights.
  const auto weights = [&](int phase, float& near_weight, float& far_weight) {
    const float x = (static_cast<float>(phase) + 0.5F) / static_cast<float>(patch_px_);
    const float length = std::sqrt(x * x + (1 - x) * (1 - x));
    near_weight = (1 - x) / length;
    far_weight = x / length;
  };
  float a = 0, b = 0;
  weights(v % patch_px_, a, b);
  for (std::size_t i = 0; i < lattice_low_.size(); ++i)
    lattice_low_[i] = a * lattice_row_low_[i] + b * lattice_row_high_[i];
  for (int phase = 0; phase < patch_px_; ++phase) {
    weights(phase, a, b);
    for (int i = 0, u = phase; u < k_.width; ++i, u += patch_px_)
      patch_[static_cast<std::size_t>(u)] =
          a * lattice_low_[static_cast<std::size_t>(i)] + b * lattice_low_[static_cast<std::size_t>(i) + 1];
  }
}

// Whose value a pixel beside a step delivers.
std::size_t DepthSensor::displaced(const CleanView& view, int u, int v, std::uint64_t bits) const {
  const float sigma = tables_.lateral_px[view.cosine[view.at(u, v)]];
  const int du = whole_pixels(normal_of_bits(bits) * sigma);
  const int dv = whole_pixels(normal_of_bits(Rng(bits).next()) * sigma);
  return view.at(std::clamp(u + du, 0, k_.width - 1), std::clamp(v + dv, 0, k_.height - 1));
}

// A pixel beside a step sees its neighbour's surface, too.
DepthSensor::Sample DepthSensor::flying(const CleanView& view, int u, int v, std::uint64_t bits) const {
  static constexpr std::array<std::array<int, 2>, 4> kBeside = {{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};
  const std::size_t at = view.at(u, v);
  const Sample own{source_[at], view.cosine[at], view.label[at]};
  Sample other = own;
  float step = kDepthStep;
  for (const auto& [du, dv] : kBeside) {
    const int x = u + du, y = v + dv;
    if (x < 0 || y < 0 || x >= k_.width || y >= k_.height) continue;
    const std::size_t there = view.at(x, y);
    if (source_[there] <= 0 || own.inverse_depth <= 0) continue;
    const float jump = std::fabs(own.inverse_depth / source_[there] - 1);
    if (jump <= step) continue;
    step = jump;
    other = {source_[there], view.cosine[there], view.label[there]};
  }
  if (step == kDepthStep) return own;
  Rng rng(bits);
  const double kind = rng.uniform();
  if (kind < kGivenUpShare) return {};
  if (kind > kGivenUpShare + kFlyingShare) return own;
  // Half of the way at most: the pixel's own surface fills more of it.
  const auto mix = static_cast<float>(rng.uniform(0, 0.5));
  const float own_z = 1 / own.inverse_depth, other_z = 1 / other.inverse_depth;
  Sample mixed = own;
  mixed.inverse_depth = 1 / (own_z + mix * (other_z - own_z));
  return mixed;
}

// Without steps.
std::uint16_t DepthSensor::deliver(const Sample& s, float noise, std::uint32_t chance) const {
  const float exact = static_cast<float>(kRawAtInfinity) - s.inverse_depth * kRawPerInverseMm;
  const auto index = static_cast<std::size_t>(std::clamp(exact, 0.0F, static_cast<float>(kRawCount - 1)));
  if (options_.holes && (chance < tables_.lost_by_cosine[s.cosine] || chance < tables_.lost_by_raw[index])) return 0;
  const float sigma = tables_.sigma_raw[index] + tables_.graze_raw[index] * tables_.graze[s.cosine];
  const float raw = exact + sigma * noise;
  const float q = (static_cast<float>(kRawAtInfinity) - raw) * static_cast<float>(kRawStepPerMm);
  const float z = noise == 0 ? options_.depth_scale / s.inverse_depth : options_.depth_scale / q;
  if (!(z >= options_.range_min_mm && z <= options_.range_max_mm && z < 65535)) return 0;
  const float up = z + 0.5F;  // positive: cut, it is the nearest; lround would be a call a pixel
  return static_cast<std::uint16_t>(up);
}

bool DepthSensor::hair_lost(std::uint64_t seed, std::uint64_t frame, int u, int v) const {
  // Patches that stay with the scene and flicker a little: two lattices of 6 px (at 640 wide), bilinear.
  const int cell = std::max(2, static_cast<int>(std::lround(6 * pixel_scale_)));
  Rng person = Rng::for_item(seed, kHairPattern, 0);
  const float darkness = static_cast<float>(person.uniform(-3.0, 0.4));  // most heads answer, some in patches only
  const float x = static_cast<float>(u % cell) / static_cast<float>(cell);
  const float y = static_cast<float>(v % cell) / static_cast<float>(cell);
  const auto corner = [&](int du, int dv) {
    const std::uint64_t still = row_seed(seed, kHairPattern, 0, v / cell + dv + 1);
    const std::uint64_t flicker = row_seed(seed, kHairPattern, frame + 1, v / cell + dv + 1);
    return normal_of_bits(draw(still, u / cell + du)) + 0.4F * normal_of_bits(draw(flicker, u / cell + du));
  };
  const float pattern =
      (1 - y) * ((1 - x) * corner(0, 0) + x * corner(1, 0)) + y * ((1 - x) * corner(0, 1) + x * corner(1, 1));
  return pattern + darkness > 0.3F;
}

void DepthSensor::expose(const CleanView& view, const PixelBox& box, std::uint64_t seed, std::uint64_t frame,
                         DepthImage out, std::uint8_t* person) {
  lattice_cell_ = -1;
  for (int v = box.v0; v < box.v1 && box.u0 < box.u1; ++v) {
    const std::uint64_t row = row_seed(seed, kPixels, frame, v);
    if (options_.noise) patch_row(seed, frame, v);
    const RowOfFrame where{v, box.u0, box.u1, row, seed, frame};
    if (in_steps())
      expose_steps(view, where, out.row(v), person);
    else
      expose_smooth(view, where, out.row(v), person);
  }
  if (options_.holes) punch_blobs(box, seed, frame, out, person);
}

IM2FIT_CLONES void DepthSensor::expose_steps(const CleanView& view, const RowOfFrame& where, std::uint16_t* pixels,
                                             std::uint8_t* person) {
  const std::size_t first = view.at(where.u0, where.v);
  const float own = options_.noise ? std::sqrt(1 - kPatchShare) : 0.0F;
  const float shared = options_.noise ? std::sqrt(kPatchShare) : 0.0F;
  const RawRow row{where.row + kRowStep * static_cast<std::uint64_t>(where.u0),
                   &exact_[first],
                   &sigma_[first],
                   &lost_[first],
                   &patch_[static_cast<std::size_t>(where.u0)],
                   own,
                   shared};
  raw_row_(row, where.u1 - where.u0, step_row_.data());
  for (int u = where.u0; u < where.u1; ++u)
    pixels[u] = tables_.mm[static_cast<std::size_t>(step_row_[static_cast<std::size_t>(u - where.u0)])];
  const std::uint8_t* labels = &view.label[view.at(0, where.v)];
  std::uint8_t* people = person != nullptr ? person + view.at(0, where.v) : nullptr;
  if (people != nullptr) mark_people(labels + where.u0, pixels + where.u0, where.u1 - where.u0, people + where.u0);

  const std::uint8_t* edges = &edge_[view.at(0, where.v)];
  beside_.count = 0;
  for (int u = where.u0; u < where.u1; ++u) {
    if (u + kTogether <= where.u1 && plain(edges + u, labels + u)) {
      u += kTogether - 1;
      continue;
    }
    if (options_.noise && edges[u] != 0)
      beside_.u[beside_.count++] = u;
    else if (options_.holes && is_hair(labels[u]) && hair_lost(where.seed, where.frame, u, where.v))
      pixels[u] = 0;
    if (people != nullptr && pixels[u] == 0) people[u] = 0;
  }
  displace(view, where);
  for (std::size_t i = 0; i < beside_.count; ++i) {
    const auto u = static_cast<std::size_t>(beside_.u[i]);
    const auto from = static_cast<std::size_t>(beside_.from[i]);
    std::int32_t step = raw_step({beside_.bits[i], exact_[from], sigma_[from], lost_[from], patch_[u], own, shared});
    const std::uint8_t label = view.label[from];
    if (options_.holes && is_hair(label) && hair_lost(where.seed, where.frame, beside_.u[i], where.v))
      step = kRawCount;
    pixels[u] = tables_.mm[static_cast<std::size_t>(step)];
    if (people != nullptr) people[u] = pixels[u] != 0 ? mask_value(label) : std::uint8_t{0};
  }
}

// Whose value each of the pixels beside a step delivers: displaced() of them all, in passes for the vectoriser.
IM2FIT_CLONES void DepthSensor::displace(const CleanView& view, const RowOfFrame& where) {
  const auto count = static_cast<int>(beside_.count);
  const std::int32_t* u = beside_.u.data();
  std::uint64_t* __restrict bits = beside_.bits.data();
  float* __restrict sigma = beside_.sigma.data();
  std::int32_t* __restrict from = beside_.from.data();
  const std::uint8_t* cosine = &view.cosine[view.at(0, where.v)];
  for (int i = 0; i < count; ++i) sigma[i] = tables_.lateral_px[cosine[u[i]]];
  for (int i = 0; i < count; ++i) bits[i] = draw(where.row, u[i]);
  const int width = k_.width, height = k_.height, v = where.v;
  for (int i = 0; i < count; ++i) {
    const std::uint64_t first = bits[i] ^ kRowStep;
    const int du = whole_pixels(normal_of_bits(first) * sigma[i]);
    const int dv = whole_pixels(normal_of_bits(Rng(first).next()) * sigma[i]);
    from[i] = std::clamp(v + dv, 0, height - 1) * width + std::clamp(u[i] + du, 0, width - 1);
  }
}

void DepthSensor::expose_smooth(const CleanView& view, const RowOfFrame& where, std::uint16_t* pixels,
                                std::uint8_t* person) {
  const bool tof = options_.kind == SensorKind::time_of_flight;
  const float shared = tof ? kTofPatchShare : kPatchShare;
  const float white_share = std::sqrt(1 - shared);
  const float patch_share = std::sqrt(shared);
  for (int u = where.u0; u < where.u1; ++u) {
    const std::size_t at = view.at(u, where.v);
    const std::uint64_t bits = draw(where.row, u);
    Sample sample{source_[at], view.cosine[at], view.label[at]};
    if (options_.noise && edge_[at] != 0) {
      if (tof) {
        sample = flying(view, u, where.v, bits ^ kRowStep);
      } else {
        const std::size_t from = displaced(view, u, where.v, bits ^ kRowStep);
        sample = {source_[from], view.cosine[from], view.label[from]};
      }
    }
    std::uint16_t depth = 0;
    if (sample.inverse_depth > 0) {
      const float noise = options_.noise
                              ? white_share * normal_of_bits(bits) + patch_share * patch_[static_cast<std::size_t>(u)]
                              : 0.0F;
      const auto chance = static_cast<std::uint32_t>(chance_of_bits(bits));
      const bool lost = options_.holes && is_hair(sample.label) && hair_lost(where.seed, where.frame, u, where.v);
      if (!lost) depth = deliver(sample, noise, chance);
    }
    pixels[u] = depth;
    if (person != nullptr) person[at] = depth != 0 ? mask_value(sample.label) : std::uint8_t{0};
  }
}

void DepthSensor::punch_blobs(const PixelBox& box, std::uint64_t seed, std::uint64_t frame, DepthImage out,
                              std::uint8_t* person) const {
  Rng rng = Rng::for_item(seed, kBlobs, frame);
  const int count = rng.index(7);
  for (int i = 0; i < count; ++i) {
    const int u = rng.index(k_.width);
    const int v = rng.index(k_.height);
    const float a = static_cast<float>(rng.uniform(1.5, 6)) * pixel_scale_;
    const float b = static_cast<float>(rng.uniform(1.0, 3)) * pixel_scale_;
    const int reach = static_cast<int>(a + 1);
    const PixelBox blob = intersect(box, {u - reach, v - reach, u + reach + 1, v + reach + 1});
    for (int y = blob.v0; y < blob.v1; ++y) {
      for (int x = blob.u0; x < blob.u1; ++x) {
        const float dx = static_cast<float>(x - u) / a;
        const float dy = static_cast<float>(y - v) / b;
        if (dx * dx + dy * dy > 1) continue;
        out.at(x, y) = 0;
        if (person != nullptr)
          person[static_cast<std::size_t>(y) * static_cast<std::size_t>(k_.width) + static_cast<std::size_t>(x)] = 0;
      }
    }
  }
}

}  // namespace im2fit::synth
