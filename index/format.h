// SPDX-License-Identifier: Apache-2.0
// The sections of a .i2f (docs/formats-index.md) and their validation: what parse_contents accepts can be queried
// without reading out of bounds, dividing by zero or recursing deeply. The sections with a value per entry
// (`code`, `residual`, `person`, `age`) are checked against their checksums when they are read, not when the file is
// opened: any value in them is in range.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "core/status.h"
#include "index/clothing_estimate.h"
#include "index/code_tree.h"
#include "index/noise_model.h"
#include "index/refinement.h"
#include "index/regression.h"

namespace im2fit::index {

inline constexpr char kMagic[] = "I2FX";
inline constexpr std::uint32_t kVersion = 14;
inline constexpr std::uint32_t kFeatureMax = 16384;
inline constexpr std::uint32_t kEntryMax = 1U << 24;
inline constexpr std::uint32_t kGroupMax = 16;
inline constexpr std::size_t kProvenanceMax = 65536;
inline constexpr std::size_t kScoreTableSize = 129;  // scores -2 .. 2
inline constexpr double kScoreMax = 2.0;
// An age is stored as its half years completed and read as the middle of its half year, which preserves age groups.
constexpr std::uint8_t age_step(float years) {
  return static_cast<std::uint8_t>(years > 0 ? (years < 127 ? 2 * years : 254) : 0);
}
constexpr float age_of_step(std::uint8_t step) {
  return 0.5F * static_cast<float>(step) + 0.25F;
}

// Of a table of kScoreTableSize, between its places.
float probability_at(std::span<const float> table, double score);

enum class IntervalKind : std::uint32_t { constant, local_spread };

struct MetaRecord {
  std::uint32_t feature_size = 0;
  std::uint32_t target_count = 0;
  std::uint32_t dimensions = 0;
  std::uint32_t entry_count = 0;
  std::uint32_t subject_count = 0;
  std::uint32_t leaf_count = 0;
  std::uint32_t group_count = 0;  // of features
  std::uint32_t local_method = 0;
  std::uint32_t neighbour_count = 0;
  std::uint32_t quadratic = 0;  // 1: the quadratic section is applied
  std::uint32_t interval_kind = 0;
  std::uint32_t local_targets = 0;  // bit t: the local correction applies to target t
  double grid_unit = 1;             // projected space per grid step
  double intercept_penalty = 0;
  double slope_penalty = 0;
  NoiseModel noise;
  std::uint64_t population_seed = 0;
  std::uint32_t population_version = 0;
  std::uint32_t densified_count = 0;  // of the entries
  std::uint32_t tracker_key = 0;      // 0: unknown
  std::uint32_t reserved = 0;
};
static_assert(sizeof(MetaRecord) == 136);

struct GroupRecord {
  char name[24] = {};
  std::uint32_t first = 0;
  std::uint32_t count = 0;
  float weight = 0;
  float error_without = 0;
};
static_assert(sizeof(GroupRecord) == 40);

struct ReportRecord {
  MeasurementValues prior_mae{};
  MeasurementValues ridge_mae{};
  MeasurementValues nearest_mae{};
  MeasurementValues answer_mae{};
  MeasurementValues coverage{};
  float sex_accuracy = 0;
  float error_with_all = 0;
  std::array<float, kDimensionMax> dimension_bits{};
};
static_assert(sizeof(ReportRecord) == 4 * (5 * 11 + 2 + 16));

// Views into the file. Per-entry sections (PagedBytes): check that they are intact before reading them.
struct Contents {
  MetaRecord meta;
  ReportRecord report;
  std::span<const GroupRecord> groups;
  std::span<const char> provenance;
  std::span<const float> feature_mean;     // feature_size
  std::span<const float> feature_scale;    // feature_size
  std::span<const std::int16_t> ridge;     // target_count x feature_size
  std::span<const float> ridge_unit;       // target_count: standardised target per weight and feature
  std::span<const float> ridge_bias;       // target_count
  std::span<const float> target_mean;      // target_count
  std::span<const float> target_scale;     // target_count: units per standardised unit
  std::span<const float> projection;       // dimensions x target_count
  std::span<const float> inverse_spread;   // dimensions
  std::span<const float> quadratic;        // target_count x quadratic_term_count
  CodeTree tree;                           // entries, where the regression puts them
  std::span<const std::uint8_t> residual;  // entry_count x residual_bytes: truth less regression, there
  PagedBytes residual_pages;
  std::span<const float> residual_scale;  // dimensions: projected space per residual step
  std::span<const float> error_map;       // target_count x dimensions: targets' error per projected error
  std::span<const float> place_map;       // target_count x dimensions: targets at a projected place
  std::span<const std::uint8_t> person;   // entry_count x person_bytes: number in the population, low byte first
  std::size_t person_bytes = 4;           // 2, 3 or 4
  PagedBytes person_pages;
  std::span<const std::uint8_t> age;  // entry_count: half years
  PagedBytes age_pages;
  std::span<const float> interval;      // kMeasurementCount x {low, high} in units of the spread
  std::span<const float> spread_floor;  // kMeasurementCount, standardised units
  std::span<const float> sex_table;     // kScoreTableSize probabilities, rising
  std::array<std::optional<RefinementContents>, kRefinementCount> refinements;
  std::array<std::optional<ClothingContents>, kClothingViews.size()> clothing;  // as kClothingViews

  LocalData local_data() const;
  Surface surface() const;
  // Where in its section an entry's residuals and person lie.
  ByteRange residual_of(std::uint32_t entry) const {
    const std::size_t size = residual_bytes(static_cast<int>(meta.dimensions));
    return {entry * size, size};
  }
  ByteRange number_of(std::uint32_t entry) const { return {entry * person_bytes, person_bytes}; }
  std::uint32_t person_of(std::uint32_t entry) const;
  // The place of an entry's code, and the regression's error there: with the surface's shift at that place they add
  // up to the truth.
  Position code_place(std::uint32_t entry) const;
  Position error_of(std::uint32_t entry) const;
  // At the truth of an entry, to within the rounding of its codes.
  MeasurementValues measurements_of_entry(std::uint32_t entry) const;
};

Result<Contents> parse_contents(std::span<const std::byte> bytes, const std::string& what);

}  // namespace im2fit::index
