// SPDX-License-Identifier: Apache-2.0
// Workstation side: samples to .i2f bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/status.h"
#include "train/index/sample.h"

namespace im2fit::index {

struct BuildOptions {
  int dimensions = 0;               // 0: chosen by held-out error; else 1..16
  double held_out_fraction = 0.15;  // of subjects: one in 1/fraction folds is held out at a time
  std::uint64_t seed = 1;
  std::string provenance;                // free text stored in the file: command line, seeds, versions; <= 64 KiB
  std::vector<FeatureGroup> groups;      // empty: default_groups
  std::uint32_t population_version = 0;  // the meaning of the subjects' numbers (IndexedPerson)
  std::uint64_t population_seed = 0;
  std::uint32_t shape_key = 0;    // of the shape space behind the samples' fits (body/fit)
  std::uint32_t tracker_key = 0;  // of the joint model that saw the samples (JointModel::key); 0: unknown
  // Features of the first so many samples are held in memory: the choices are made on them (penalties, dimensions,
  // corrections, intervals). Every sample counts for the regression and becomes an entry.
  std::size_t chosen_on = 32768;
  std::size_t densify_to = 0;  // entries to reach by mixing real ones (train/index/densify.h); 0: none
  // Intervals are also to hold for makes of body that no sample is of: wider by kUnknownMakeWidening (calibration.h).
  bool for_unknown_makes = true;
  int threads = 1;  // refinements are learned side by side; the result does not depend on them
  // Called now and then: the stage, samples so far.
  std::function<void(const std::string& stage, std::size_t samples)> progress;
};

// Reads the source three times, a sample at a time: memory is bounded by chosen_on features, 16,384 samples that
// refine (14 kB each, and as much again while one refinement is learned, by each thread), about 100 bytes a sample
// and the file twice: 1.01 GiB for 5,000,000 entries. Deterministic: depends on the samples, their order and the
// options only; the sums behind the regression are exact, so that any order of adding them up gives the same bits.
// Errors: too few subjects (< 20), samples that disagree in size or are not finite, options out of range, errors of
// the source.
Result<std::vector<std::byte>> build_index(const BuildOptions& options, const SampleSource& source);

}  // namespace im2fit::index
