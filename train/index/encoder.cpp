// SPDX-License-Identifier: Apache-2.0
#include "train/index/encoder.h"

#include <algorithm>
#include <cmath>

namespace im2fit::index {

Position Encoder::place_of(const Targets& targets) const {
  return project(targets, target_count, projection, dimensions);
}

void Encoder::encode_place(const Position& place, std::span<std::int8_t> codes) const {
  for (std::size_t d = 0; d < codes.size(); ++d)
    codes[d] = static_cast<std::int8_t>(std::lround(std::clamp(place[d] / (grid_unit * steps[d]), -127.0, 127.0)));
}

Position Encoder::place_of_codes(std::span<const std::int8_t> codes) const {
  Position out{};
  for (std::size_t d = 0; d < codes.size(); ++d) out[d] = grid_unit * (codes[d] * steps[d]);
  return out;
}

void Encoder::encode_residual(const Position& error, std::span<std::uint8_t> out) const {
  std::fill(out.begin(), out.end(), std::uint8_t{0});
  for (std::size_t d = 0; d < static_cast<std::size_t>(dimensions); ++d) {
    const double steps_off = std::clamp(error[d] / static_cast<double>(residual_scale[d]),
                                        -static_cast<double>(kResidualMax), static_cast<double>(kResidualMax));
    const auto half = static_cast<unsigned>(std::lround(steps_off) + kResidualMax + 1);
    out[d / 2] = static_cast<std::uint8_t>(out[d / 2] | half << (d % 2 * 4));
  }
}

void Entries::add(const Position& regressed, const Position& truth) {
  std::array<std::int8_t, kDimensionMax> code{};
  std::array<std::uint8_t, residual_bytes(kDimensionMax)> residual{};
  const auto used = std::span(code).first(static_cast<std::size_t>(encoder.dimensions));
  const auto packed = std::span(residual).first(residual_bytes(encoder.dimensions));
  encoder.encode_place(regressed, used);
  const Position stands = encoder.place_of_codes(used);
  const Surface surface = encoder.surface();
  const Position shift = surface.shift_of(surface.targets_at(stands));
  Position error{};
  for (std::size_t d = 0; d < used.size(); ++d) error[d] = truth[d] - stands[d] - shift[d];
  encoder.encode_residual(error, packed);
  codes.insert(codes.end(), used.begin(), used.end());
  residuals.insert(residuals.end(), packed.begin(), packed.end());
}

std::vector<std::uint8_t> in_order(const std::vector<std::uint8_t>& residuals, int dimensions,
                                   std::span<const std::uint32_t> order) {
  const std::size_t size = residual_bytes(dimensions);
  std::vector<std::uint8_t> out;
  out.reserve(residuals.size());
  for (const std::uint32_t row : order) {
    const auto from = residuals.begin() + static_cast<std::ptrdiff_t>(row * size);
    out.insert(out.end(), from, from + static_cast<std::ptrdiff_t>(size));
  }
  return out;
}

}  // namespace im2fit::index
