// SPDX-License-Identifier: Apache-2.0
// Index samples from synthetic people: what dataset, index and eval share.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "apps/common/program.h"
#include "person/data_files.h"
#include "train/dataset/dataset.h"

namespace im2fit::lab {}

namespace im2fit::apps {

using namespace lab;  // what commands are about

struct SampleOptions {
  int subjects = 20000;
  int captures = 1;
  std::uint64_t seed = 1;
  int threads = 1;
  std::string work_dir;  // shards live here and are used again
  int chunk = 0;         // people in a shard; 0: as noted in work_dir for the same run, else 1000
  int part = 0;          // make this part of so many alone
  int part_count = 1;
  std::string body;
  std::string tracker;
};

// Defaults of this machine.
SampleOptions default_samples();
void add_sample_options(cli::App& sub, SampleOptions& options);

// Makes or reuses the samples, in order, with progress on a terminal, and notes in `work_dir` how they were made.
Result<lab::DatasetReport> make_samples(const SampleOptions& options,
                                        const std::function<void(const index::Sample&)>& sink);

// All samples of one run from any number of folders, in the order of subjects, one shard in memory at a time. Nothing
// is made: shards that are damaged, of other runs, doubled or missing are errors that name them. How many subjects
// there must be stands in the folders' notes.
Result<lab::DatasetReport> read_samples(const std::vector<std::string>& folders,
                                        const std::function<bool(const index::Sample&)>& take);
// The same without reading more than the shards' heads.
Result<lab::ShardSet> check_samples(const std::vector<std::string>& folders);

// JointModel::key() of the tracker behind a run.
std::uint32_t tracker_key_of(std::uint64_t input_key);

// The samples an index was built from, as noted in `work_dir`; an error when there is no note.
Result<SampleOptions> noted_samples(const std::string& work_dir);

// One paragraph for people: how many samples, the rate, the refusals.
std::string summary_of(const lab::DatasetReport& report);

}  // namespace im2fit::apps
