// SPDX-License-Identifier: Apache-2.0
// What an index is learned from.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/fit_layout.h"
#include "core/measurement.h"
#include "core/status.h"

namespace im2fit::index {

inline constexpr std::uint8_t kClothesKindMax = 8;

// One training subject seen once. Several samples may share a subject (different pose, noise, distance); they must
// follow each other.
struct Sample {
  std::uint64_t subject = 0;  // its number in the population, below 2^32
  std::vector<float> feature;
  MeasurementValues truth{};
  bool woman = false;
  float age_years = 0;
  std::vector<float> body;  // parameters of the mesh, the same size in every sample: shape beyond the measurements
  int frame_count = 1;      // frames fused behind the feature
  int distance_mm = 0;      // camera to person, as perception/observe sees it; 0: not known
  // No entry, and the regression behind the entries does not learn from it: the intervals are fitted to such
  // subjects, so that they also hold for people unlike the index' own. Used when there are at least 200 of them.
  bool calibrate_only = false;
  // Seen in clothes: no entry; answers to people in clothes are learned from it, and nothing else.
  bool clothed = false;
  // Which clothes, where some are worn: samples of one number wear clothes of one kind, below kClothesKindMax.
  // Answers by regressions that met none of a kind tell how far off those of unknown clothes are.
  std::uint8_t clothes_kind = 0;
  // Seen once more, as undressed or as dressed as in an earlier sample of the subject: no entry and nothing the plain
  // answer learns from, but refined answers learn from it, and that it is the same body.
  bool again = false;
  // More that was seen of some subjects, for index/refinement.h; else empty. The same sizes in every sample that has
  // them.
  std::vector<float> fit;       // shape fitted to the front, in the order of fit_layout
  std::vector<float> back;      // the feature of a view from behind
  std::vector<float> fit_both;  // shape fitted to front and back
  FitLayout fit_layout;         // of either fit
  int back_frame_count = 0;     // frames fused behind `back`
  int back_distance_mm = 0;
  bool refines() const { return !fit.empty(); }
  bool is_entry() const { return !calibrate_only && !clothed && !again; }
};

// Features that share one regularisation. Groups cover the feature in order.
struct FeatureGroup {
  std::string name;  // up to 23 characters
  std::uint32_t count = 0;
};
// Lengths, ratios, FPFH, profile and, of a whole feature, the sensor's traits of perception/observe for one of at
// least 501 values; else one group.
std::vector<FeatureGroup> default_groups(std::size_t feature_size);

// Hands over all samples, the same in the same order each time it is called, until there are no more or `take`
// returns false.
using SampleSource = std::function<Status(const std::function<bool(const Sample&)>& take)>;
// Of samples in memory, which must outlive it.
SampleSource source_of(const std::vector<Sample>& samples);

}  // namespace im2fit::index
