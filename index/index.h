// SPDX-License-Identifier: Apache-2.0
// Features -> supervised, noise-aware projection -> quantised codes -> nanoflann -> k neighbours -> local regression.
// The file is a .i2f (base/container.h, docs/formats-index.md): mapped, never read past its end.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/status.h"
#include "kernels/core/measurement.h"

namespace im2fit::index {

struct Estimate {
  float value = 0;
  float low = 0;  // 95 % interval
  float high = 0;
};

struct Answer {
  std::array<Estimate, kMeasurementCount> measurements;
  float female = 0.5F;         // probability
  std::uint32_t nearest = 0;   // entry number: the stored body closest to the estimate
  float nearest_distance = 0;  // in the projected space, whose unit is one standard deviation of the error
  // For the evaluation: the nearest entry's own measurements, without the regression that follows.
  MeasurementValues nearest_values{};
};

struct QueryOptions {
  int neighbour_count = 0;  // 0: what the builder found best; otherwise clamped to 1..512
  int frame_count = 1;      // frames fused behind the feature: widens the interval when few
};

// What the builder learned and measured, for people to read. Every error is cross-fitted: the subject asked about
// had no part in the regression that answered.
struct Info {
  struct Group {
    std::string name;
    std::uint32_t first = 0;  // first feature
    std::uint32_t count = 0;
    float weight = 0;         // scaling relative to the heaviest group: 1 heaviest, 0 left out
    float error_without = 0;  // mean absolute error, in standard deviations of people, when left out
  };
  std::string provenance;
  std::uint32_t subject_count = 0;  // = entries
  std::uint32_t sample_count = 0;   // captures
  std::vector<Group> groups;
  float error_with_all = 0;           // to compare Group::error_without with
  std::vector<float> dimension_bits;  // information of each projected dimension about the body
  std::string method;                 // what follows the ridge regression
  int neighbour_count = 0;
  MeasurementValues prior_mae{};    // mean of all subjects
  MeasurementValues ridge_mae{};    // regression alone
  MeasurementValues nearest_mae{};  // nearest entry in the projected space
  MeasurementValues answer_mae{};   // what query() answers
  MeasurementValues coverage{};     // share of subjects inside the 95 % interval, 0..1
  float sex_accuracy = 0;           // 0..1
};

class Index {
 public:
  static Result<Index> open(const std::string& path);
  // The same from memory; `what` names it in errors.
  static Result<Index> parse(std::vector<std::byte> bytes, const std::string& what);
  Index(Index&&) noexcept;
  Index& operator=(Index&&) noexcept;
  ~Index();

  std::size_t size() const;
  int dimensions() const;  // of the projected space
  std::size_t feature_size() const;
  std::size_t body_size() const;
  const Info& info() const;
  // Memory one query needs; made once, reused. Not shareable between threads; the index is.
  class Scratch;
  std::unique_ptr<Scratch, void (*)(Scratch*)> make_scratch() const;
  // No allocation. NaN in the feature means "not measured" and is imputed by the training mean; a feature of
  // another size than feature_size() is read as if all of it were NaN.
  Answer query(std::span<const float> feature, const QueryOptions& options, Scratch& scratch) const;
  // The body parameters of an entry, as stored by the builder (an opaque blob of body_size() floats, each within
  // 1/65534 of its column's range). Empty for an entry that does not exist.
  std::vector<float> body_of(std::uint32_t entry) const;
  // A body whose measurements follow the answer's: the stored bodies around it, by local linear regression. Closer
  // than body_of(answer.nearest), for it need not have stood in the index. body_size() values; may lie a little
  // outside the sliders' ranges (body/params_vector.h clamps).
  std::vector<float> body_for(std::span<const float> feature, const QueryOptions& options, Scratch& scratch) const;
  // Truth of an entry, as given to the builder. `entry` < size().
  MeasurementValues measurements_of(std::uint32_t entry) const;

  struct Data;

 private:
  Index();
  std::unique_ptr<Data> data_;
};

// One training subject seen once. Several rows may share a subject (different pose, noise, distance).
struct Sample {
  std::uint64_t subject = 0;
  std::vector<float> feature;
  MeasurementValues truth{};
  bool woman = false;
  std::vector<float> body;  // parameters to regenerate the mesh; the same size in every sample
  int frame_count = 1;      // frames fused behind the feature
  // Not learned from and no entry: only the intervals are fitted to such subjects, so that they also hold for people
  // unlike the index' own. Used when there are at least 200 of them.
  bool calibrate_only = false;
};

// Features that share one regularisation. Groups cover the feature in order.
struct FeatureGroup {
  std::string name;  // up to 23 characters
  std::uint32_t count = 0;
};
// Lengths, ratios, FPFH and profile of kernels/observe for a feature of at least 501 values; else one group.
std::vector<FeatureGroup> default_groups(std::size_t feature_size);

struct BuildOptions {
  int dimensions = 0;               // 0: chosen by held-out error; else 1..16
  double held_out_fraction = 0.15;  // of subjects: one in 1/fraction folds is held out at a time
  std::uint64_t seed = 1;
  std::string provenance;            // free text stored in the file: command line, seeds, versions; <= 64 KiB
  std::vector<FeatureGroup> groups;  // empty: default_groups
};

// Takes samples: `add` any number, then `finish` to .i2f bytes. Deterministic in the order of adding. Workstation
// code: allocates about (4 x feature_size) bytes a sample.
class IndexBuilder {
 public:
  explicit IndexBuilder(const BuildOptions& options);
  ~IndexBuilder();
  // A sample whose sizes differ from the first one's, or with a truth that is not finite, makes finish() fail.
  void add(const Sample& sample);
  std::size_t sample_count() const;  // without those that only calibrate
  // Errors: too few subjects (< 20), samples that disagree in size, options out of range. Call once.
  Result<std::vector<std::byte>> finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace im2fit::index
