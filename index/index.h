// SPDX-License-Identifier: Apache-2.0
// Features -> supervised, noise-aware projection -> quantised codes -> nanoflann -> k neighbours -> local regression.
// The file is a .i2f (base/container.h, docs/formats.md): mapped, never read past its end.
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
  float low = 0;   // 95 % interval
  float high = 0;
};

struct Answer {
  std::array<Estimate, kMeasurementCount> measurements;
  float female = 0.5F;            // probability
  std::uint32_t nearest = 0;      // entry number
  float nearest_distance = 0;     // in the projected space
  // For the evaluation: the same query answered without our learning.
  MeasurementValues nearest_values{};   // the nearest entry's own measurements
};

struct QueryOptions {
  int neighbour_count = 32;
  int frame_count = 1;  // frames fused behind the feature: widens the interval when few
};

class Index {
 public:
  static Result<Index> open(const std::string& path);
  Index(Index&&) noexcept;
  Index& operator=(Index&&) noexcept;
  ~Index();

  std::size_t size() const;
  int dimensions() const;            // of the projected space
  std::size_t feature_size() const;
  // Memory one query needs; made once, reused. Not shareable between threads; the index is.
  class Scratch;
  std::unique_ptr<Scratch, void (*)(Scratch*)> make_scratch() const;
  // No allocation. NaN in the feature means "not measured" and is imputed by the training mean.
  Answer query(std::span<const float> feature, const QueryOptions& options, Scratch& scratch) const;
  // The body parameters of an entry, as stored by the builder (an opaque blob of body_size() floats).
  std::vector<float> body_of(std::uint32_t entry) const;

 private:
  Index();
  struct Data;
  std::unique_ptr<Data> data_;
};

// One training subject seen once. Several rows may share a subject (different pose, noise, distance).
struct Sample {
  std::uint64_t subject = 0;
  std::vector<float> feature;
  MeasurementValues truth{};
  bool woman = false;
  std::vector<float> body;  // parameters to regenerate the mesh; the same size in every sample
};

struct BuildOptions {
  int dimensions = 0;             // 0: chosen by held-out error
  double held_out_fraction = 0.15;  // of subjects, for calibration of intervals and choice of weights
  std::uint64_t seed = 1;
  std::string provenance;         // free text stored in the file: command line, seeds, versions
};

// Streams samples: `add` any number, then `finish` to .i2f bytes. Deterministic in the order of adding.
class IndexBuilder {
 public:
  explicit IndexBuilder(const BuildOptions& options);
  ~IndexBuilder();
  void add(const Sample& sample);
  Result<std::vector<std::byte>> finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace im2fit::index
