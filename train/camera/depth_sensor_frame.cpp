// SPDX-License-Identifier: Apache-2.0
// One frame of a prepared view: noise, displaced and flying pixels, holes.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>

#include "train/camera/depth_sensor.h"
#include "train/common/simd_clones.h"

namespace im2fit::lab {
namespace {

constexpr float kPatchShare = 0.5F;  // of the axial variance
constexpr float kTofPatchShare = 0.25F;
constexpr double kFlyingShare = 0.45;  // of pixels at an edge: both surfaces
constexpr double kGivenUpShare = 0.15;

enum Stream : std::uint64_t { kPixels = 0x5E01, kLattice = 0x5E02, kBlobs = 0x5E03, kHairPattern = 0x5E04 };

// Counter-based: any row or pixel of any frame can be had without the ones before it.
std::uint64_t row_seed(std::uint64_t seed, Stream stream, std::uint64_t frame, int v) {
  return Rng::for_item(seed, stream + (static_cast<std::uint64_t>(v) << 16), frame).next();
}
std::uint64_t draw(std::uint64_t row, int k) {
  return Rng(row + kRowStep * static_cast<std::uint64_t>(k)).next();
}

// Whether none of the next kTogether pixels is at an edge or is hair.
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

// Between lattice points, kPx pixels apart.
template <int kPx>
inline __attribute__((always_inline)) void spread(const float* __restrict lattice, const float* near_weights,
                                                  const float* far_weights, int width, float* __restrict out) {
  float near[kPx], far[kPx];
  for (int p = 0; p < kPx; ++p) {
    near[p] = near_weights[p];
    far[p] = far_weights[p];
  }
  const int cells = width / kPx;
  for (int i = 0; i < cells; ++i)
    for (int p = 0; p < kPx; ++p) out[kPx * i + p] = near[p] * lattice[i] + far[p] * lattice[i + 1];
  for (int p = 0; p < width % kPx; ++p) out[kPx * cells + p] = near[p] * lattice[cells] + far[p] * lattice[cells + 1];
}

}  // namespace

IM2FIT_SIMD_CLONES void DepthSensor::lattice_row(std::uint64_t seed, std::uint64_t frame, int cell,
                                                 std::vector<float>& out) {
  const std::uint64_t row = row_seed(seed, kLattice, frame, cell);
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = normal_of_bits(draw(row, static_cast<int>(i)));
}

// Rows of a frame from top to bottom: those of one cell share the lattice's two rows.
IM2FIT_SIMD_CLONES void DepthSensor::patch_row(std::uint64_t seed, std::uint64_t frame, int v) {
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
  std::array<float, kPatchMaxPx> near{}, far{};
  for (int phase = 0; phase < patch_px_; ++phase)
    weights(phase, near[static_cast<std::size_t>(phase)], far[static_cast<std::size_t>(phase)]);
  if (patch_px_ == kPatchMaxPx)
    spread<kPatchMaxPx>(lattice_low_.data(), near.data(), far.data(), k_.width, patch_.data());
  else
    spread<2>(lattice_low_.data(), near.data(), far.data(), k_.width, patch_.data());
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
  // Halfway at most: the pixel's own surface fills more of it.
  const auto mix = static_cast<float>(rng.uniform(0, 0.5));
  const float own_z = 1 / own.inverse_depth, other_z = 1 / other.inverse_depth;
  Sample mixed = own;
  mixed.inverse_depth = 1 / (own_z + mix * (other_z - own_z));
  mixed.mixed = std::fabs(mix * (other_z - own_z)) > kMixedMm;
  return mixed;
}

// Without steps.
std::uint16_t DepthSensor::deliver(const Sample& s, float noise, std::int32_t chance) const {
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

IM2FIT_SIMD_CLONES void DepthSensor::expose_steps(const CleanView& view, const RowOfFrame& where,
                                                  std::uint16_t* pixels, std::uint8_t* person) {
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
IM2FIT_SIMD_CLONES void DepthSensor::displace(const CleanView& view, const RowOfFrame& where) {
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
      const auto chance = static_cast<std::int32_t>(chance_of_bits(bits));
      const bool lost = options_.holes && is_hair(sample.label) && hair_lost(where.seed, where.frame, u, where.v);
      if (!lost) depth = deliver(sample, noise, chance);
    }
    pixels[u] = depth;
    if (person == nullptr) continue;
    const std::uint8_t whose = sample.mixed ? mixed_mask_value(sample.label) : mask_value(sample.label);
    person[at] = depth != 0 ? whose : std::uint8_t{0};
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

}  // namespace im2fit::lab
