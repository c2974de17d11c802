// SPDX-License-Identifier: Apache-2.0
// Workstation side: the places of an entry's codes, and the errors of the encoding.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "index/code_tree.h"
#include "index/regression.h"

namespace im2fit::index {

struct Encoder {
  int target_count = 0;
  int dimensions = 0;
  std::vector<float> projection;  // dimensions x target_count
  double grid_unit = 1;
  Coordinates steps{};
  std::vector<float> inverse_spread;  // dimensions
  std::vector<float> quadratic;       // target_count x quadratic_term_count; empty: none
  std::vector<float> residual_scale;  // dimensions

  Position place_of(const Targets& targets) const;
  void encode_place(const Position& place, std::span<std::int8_t> codes) const;
  Position place_of_codes(std::span<const std::int8_t> codes) const;
  Surface surface() const { return {projection, inverse_spread, quadratic, target_count, dimensions}; }
  // `error`: truth less where the surface puts the codes' place; residual_bytes(dimensions) out.
  void encode_residual(const Position& error, std::span<std::uint8_t> out) const;
};

// Entries before they are written: codes and residuals, in the order they came.
struct Entries {
  explicit Entries(const Encoder& encoder) : encoder(encoder) {}
  const Encoder& encoder;
  std::vector<std::int8_t> codes;       // dimensions each
  std::vector<std::uint8_t> residuals;  // residual_bytes each
  void add(const Position& regressed, const Position& truth);
};

// Residuals in the order of a tree.
std::vector<std::uint8_t> in_order(const std::vector<std::uint8_t>& residuals, int dimensions,
                                   std::span<const std::uint32_t> order);

}  // namespace im2fit::index
