// SPDX-License-Identifier: Apache-2.0
// A second answer, from more than the feature of the front: from a shape fitted to the depth (body/fit), and from a
// view from behind. One linear map each, learned on the samples that have all of these values, from
//   feature of the front | feature of the back | coefficients of the fit | of the fit to the front, where there is a
//   back | products of the fit's strongest coefficients | distances of patches of the skin | directions of limbs |
//   one over the frames
// to measurements and sex. The products stand for girths growing with width times depth; the patches for shapes that
// none of the people behind the shape space had; the limbs for the effect of raised shoulders on a chest; the frames
// for the noise added to widths, above all of people in clothes. A fit's total error is not used: with more frames or
// pixels it falls, and would then read as tighter clothes on a person seen well. The answer is a
// mixture of this and the plain one, in shares learned on people that neither was trained on: the plain one was
// trained on more people. It was trained on none in clothes: their answer is the refined one alone.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/clothing.h"
#include "core/fit_layout.h"
#include "index/noise_model.h"
#include "index/regression.h"

namespace im2fit::index {

// The front with its fit; front and back with theirs; the same of people in clothes.
enum class Refinement { fitted, turned, clothed, clothed_turned };
inline constexpr std::size_t kRefinementCount = 4;
inline constexpr std::array kRefinements = {Refinement::fitted, Refinement::turned, Refinement::clothed,
                                            Refinement::clothed_turned};
constexpr bool sees_back(Refinement kind) {
  return kind == Refinement::turned || kind == Refinement::clothed_turned;
}
constexpr bool is_of_clothed(Refinement kind) {
  return kind == Refinement::clothed || kind == Refinement::clothed_turned;
}
inline constexpr std::size_t kSquaredMax = 16;  // coefficients whose products count
inline constexpr std::size_t kFitMax = 512;     // values of a fit

constexpr std::size_t squared_count(std::size_t shapes) {
  const std::size_t n = shapes < kSquaredMax ? shapes : kSquaredMax;
  return n * (n + 1) / 2;
}
constexpr std::size_t refined_size(Refinement kind, std::size_t feature_size, const FitLayout& fit) {
  const std::size_t views = sees_back(kind) ? 2 : 1;
  return (feature_size + fit.shapes + fit.patches + fit.limbs) * views + squared_count(fit.shapes) + 1;
}

// What is known of a person. `back` and the fits may be empty; `fit` is to the front alone, and needed
// with fit_both as well.
struct Seen {
  std::span<const float> front;
  std::span<const float> fit;
  std::span<const float> back;
  std::span<const float> fit_both;
  ClothingGiven clothing = ClothingGiven::bare;
  int frame_count = 0;  // fused, of the side with fewer; 0: not known
};
// Puts the values in order. out: refined_size(); the fits are of `layout`.
void refined_values(Refinement kind, const Seen& seen, const FitLayout& layout, std::span<float> out);

// Name of a section of the file: "fitted.mean", of people in clothes "cloth1.mean" and, from both sides,
// "cloth2.mean".
std::string section_of(Refinement kind, const char* name);

// Of the file; fixed layout.
struct RefinementRecord {
  FitLayout fit;
  std::uint32_t sample_count = 0;  // learned from
  std::uint32_t interval_kind = 0;
  std::uint32_t penalty_millionths = 0;  // of the ridge, of the values' variance
  std::uint32_t shape_key = 0;           // of the shape space that fits must be of
  std::uint32_t reserved = 0;
  NoiseModel noise;
  std::array<float, kTargetMin> share{};  // of the refined in the answer, 0..1; the rest is the plain one's
  MeasurementValues mae{};                // of answers to people it was not learned from
  MeasurementValues coverage{};           // of the 95 % intervals
};
static_assert(sizeof(RefinementRecord) == 72 + 4 * kTargetMin + 8 * kMeasurementCount);

// The nearest float whose lower half is zero, and its upper half: three digits, enough to standardise by.
constexpr std::uint16_t upper_of_float(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  return static_cast<std::uint16_t>((bits + 0x7FFFU + (bits >> 16 & 1U)) >> 16);
}
constexpr float float_of_upper(std::uint16_t upper) {
  return std::bit_cast<float>(std::uint32_t{upper} << 16);
}

// A linear map from refined_values() to targets; views into the file.
struct ValueMapContents {
  std::span<const std::uint16_t> mean, scale;  // of the values: upper halves of floats
  std::span<const std::int16_t> weights;       // a row of values for each target
  std::span<const float> unit, bias;           // a target each: its unit per weight and value; constant
};

// Applies one. Its bytes must outlive it. Shareable between threads; `work` is not.
class ValueMap {
 public:
  ValueMap(Refinement kind, const FitLayout& fit, const ValueMapContents& contents, std::size_t feature_size);
  struct Work {
    explicit Work(const ValueMap& map);
    std::vector<float> values;
    std::vector<std::int16_t> standardised;
  };
  // Whether all values it needs are present, in the right sizes, independent of clothing.
  bool applies(const Seen& seen) const;
  Targets operator()(const Seen& seen, Work& work) const;  // no allocation
  // Of what `work` was used for last: the mean square of the values that were seen, in standard deviations of the
  // people learned from. About 1 for people like these, more for clothes of a cut that none of them wore.
  static double novelty(const Work& work);
  Refinement kind() const { return kind_; }

 private:
  Refinement kind_;
  FitLayout fit_;
  std::size_t feature_size_;
  std::vector<float> mean_, scale_;
  Regressor regressor_;
};

// Views into the file.
struct RefinementContents {
  RefinementRecord record;
  ValueMapContents map;                 // to kTargetMin standardised targets
  std::span<const float> interval;      // kMeasurementCount x {low, high} in units of the spread
  std::span<const float> spread_floor;  // kMeasurementCount, standardised
  std::span<const float> sex_table;     // kScoreTableSize
};

// Applies one. As ValueMap.
class Refiner {
 public:
  Refiner(Refinement kind, const RefinementContents& contents, std::size_t feature_size);
  const ValueMap& map() const { return map_; }
  // Mixes its answer into the plain one: standardised measurements and sex, the first kTargetMin of `targets`.
  // No allocation.
  void apply(const Seen& seen, ValueMap::Work& work, Targets& targets) const;
  const RefinementContents& contents() const { return contents_; }

 private:
  RefinementContents contents_;
  ValueMap map_;
};

}  // namespace im2fit::index
