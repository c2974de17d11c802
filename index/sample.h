// SPDX-License-Identifier: Apache-2.0
// What an index is learned from.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "base/status.h"
#include "kernels/core/measurement.h"

namespace im2fit::index {

// What a fit is told by (body/fit/shape_fitter.h): coefficients of the shape, then how far off each patch of the skin
// is, of the front and of the back. NaN: not seen, or a fit to the front alone.
struct FitLayout {
  std::uint32_t shapes = 0;
  std::uint32_t patches = 0;  // of a view
  std::size_t size() const { return shapes + std::size_t{2} * patches; }
  bool operator==(const FitLayout&) const = default;
};

// One training subject seen once. Several samples may share a subject (different pose, noise, distance); they must
// follow each other.
struct Sample {
  std::uint64_t subject = 0;  // its number in the population, below 2^32
  std::vector<float> feature;
  MeasurementValues truth{};
  bool woman = false;
  std::vector<float> body;  // parameters of the mesh, the same size in every sample: shape beyond the measurements
  int frame_count = 1;      // frames fused behind the feature
  int distance_mm = 0;      // camera to person, as kernels/observe sees it; 0: not known
  // No entry, and the regression behind the entries does not learn from it: the intervals are fitted to such
  // subjects, so that they also hold for people unlike the index' own. Used when there are at least 200 of them.
  bool calibrate_only = false;
  // Seen in clothes: no entry; answers to people in clothes are learned from it, and nothing else.
  bool clothed = false;
  // Seen once more, as undressed or as dressed as in an earlier sample of the subject: no entry and nothing the plain
  // answer learns from, but refined answers learn from it, and that it is the same body.
  bool again = false;
  // More that was seen of some subjects, for index/refinement.h; else empty. The same sizes in every sample that has
  // them.
  std::vector<float> fit;         // shape fitted to the front, as FitLayout says
  std::vector<float> back;        // the feature of a view from behind
  std::vector<float> fit_both;    // shape fitted to front and back
  std::uint32_t fit_patches = 0;  // of either fit
  int back_frame_count = 0;       // frames fused behind `back`
  int back_distance_mm = 0;
  bool refines() const { return !fit.empty(); }
  FitLayout fit_layout() const {
    return {static_cast<std::uint32_t>(fit.size() - std::min<std::size_t>(fit.size(), 2 * fit_patches)), fit_patches};
  }
  bool is_entry() const { return !calibrate_only && !clothed && !again; }
};

// Features that share one regularisation. Groups cover the feature in order.
struct FeatureGroup {
  std::string name;  // up to 23 characters
  std::uint32_t count = 0;
};
// Lengths, ratios, FPFH, profile and, of a whole feature, the sensor's traits of kernels/observe for one of at least
// 501 values; else one group.
std::vector<FeatureGroup> default_groups(std::size_t feature_size);

// Hands over all samples, the same in the same order each time it is called, until there are no more or `take` says
// false.
using SampleSource = std::function<Status(const std::function<bool(const Sample&)>& take)>;
// Of samples in memory, which must outlive it.
SampleSource source_of(const std::vector<Sample>& samples);

}  // namespace im2fit::index
