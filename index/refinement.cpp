// SPDX-License-Identifier: Apache-2.0
#include "index/refinement.h"

#include <algorithm>
#include <limits>

namespace im2fit::index {

namespace {

std::vector<float> floats_of(std::span<const std::uint16_t> uppers) {
  std::vector<float> out;
  for (const std::uint16_t upper : uppers) out.push_back(float_of_upper(upper));
  return out;
}

}  // namespace

std::string section_of(Refinement kind, const char* name) {
  constexpr std::array<const char*, kRefinementCount> kPrefix = {"fitted.", "turned.", "cloth1.", "cloth2."};
  return kPrefix[static_cast<std::size_t>(kind)] + std::string(name);
}

void refined_values(Refinement kind, const Seen& seen, const FitLayout& layout, std::span<float> out) {
  const bool back = sees_back(kind);
  auto at = std::copy(seen.front.begin(), seen.front.end(), out.begin());
  if (back) at = std::copy(seen.back.begin(), seen.back.end(), at);
  const std::span<const float> fit = back ? seen.fit_both : seen.fit;
  const std::size_t shapes = layout.shapes;
  at = std::copy_n(fit.begin(), shapes, at);
  if (back) at = std::copy_n(seen.fit.begin(), shapes, at);
  const std::size_t squared = std::min(shapes, kSquaredMax);
  for (std::size_t i = 0; i < squared; ++i)
    for (std::size_t j = i; j < squared; ++j) *at++ = fit[i] * fit[j];
  const std::size_t views = back ? 2 : 1;
  const auto patches = fit.subspan(shapes, layout.patches * views);
  at = std::copy(patches.begin(), patches.end(), at);
  const auto limbs = fit.subspan(shapes + std::size_t{2} * layout.patches, layout.limbs * views);
  at = std::copy(limbs.begin(), limbs.end(), at);
  *at = seen.frame_count > 0 ? 1.0F / static_cast<float>(seen.frame_count) : std::numeric_limits<float>::quiet_NaN();
}

ValueMap::ValueMap(Refinement kind, const FitLayout& fit, const ValueMapContents& contents, std::size_t feature_size)
    : kind_(kind),
      fit_(fit),
      feature_size_(feature_size),
      mean_(floats_of(contents.mean)),
      scale_(floats_of(contents.scale)),
      regressor_(contents.weights, contents.unit, contents.bias) {}

ValueMap::Work::Work(const ValueMap& map) : values(map.mean_.size()), standardised(map.regressor_.padded_size()) {}

bool ValueMap::applies(const Seen& seen) const {
  return seen.front.size() == feature_size_ && seen.fit.size() == fit_.size() &&
         (!sees_back(kind_) || (seen.back.size() == feature_size_ && seen.fit_both.size() == fit_.size()));
}

Targets ValueMap::operator()(const Seen& seen, Work& work) const {
  refined_values(kind_, seen, fit_, work.values);
  standardise(work.values.data(), mean_.data(), scale_.data(), static_cast<int>(work.values.size()),
              work.standardised.data());
  return regressor_(work.standardised);
}

// Whole numbers: the same in any order. A value that was not seen is 0, and hardly one that was.
double ValueMap::novelty(const Work& work) {
  constexpr double kOne = std::int64_t{1} << StandardFeature::kFractionBits;
  std::int64_t sum = 0, count = 0;
  for (const std::int16_t raw : work.standardised) {
    sum += std::int64_t{raw} * raw;
    count += raw != 0 ? 1 : 0;
  }
  return count > 0 ? static_cast<double>(sum) / (kOne * kOne * static_cast<double>(count)) : 0;
}

Refiner::Refiner(Refinement kind, const RefinementContents& contents, std::size_t feature_size)
    : contents_(contents), map_(kind, contents.record.fit, contents.map, feature_size) {}

void Refiner::apply(const Seen& seen, ValueMap::Work& work, Targets& targets) const {
  const Targets refined = map_(seen, work);
  for (std::size_t t = 0; t < kTargetMin; ++t)
    targets[t] += static_cast<double>(contents_.record.share[t]) * (refined[t] - targets[t]);
}

}  // namespace im2fit::index
