// SPDX-License-Identifier: Apache-2.0
// Many subjects to index samples: both cores, resumable, the same for a seed at any thread count.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "body/model.h"
#include "core/status.h"
#include "train/dataset/dataset_shard.h"
#include "train/dataset/features.h"
#include "train/index/sample.h"

namespace im2fit::lab {

struct DatasetOptions {
  int subject_count = 20000;  // 1 .. 1,000,000,000
  std::uint64_t first_subject = 0;
  int captures_per_subject = 1;  // 1 .. 64
  Family family = Family::training;
  std::uint64_t seed = 1;
  CaptureVariety variety;
  // Every n-th subject is out of distribution (train/population/ood_subjects.h): no model, but intervals are fitted
  // on them and refined answers learn from them, the better the more there are. Training family only, and only
  // subjects numbered below `ood_below`; 0: none.
  int ood_every = 3;  // odd: both sexes
  std::uint32_t ood_below = 14336;
  // Of every n-th pair of a man and a woman, and of every OOD subject, the sample also has the view from behind and
  // the fitted shapes; 0: of none. Needs a body file with a shape space. Only subjects numbered below `turn_below`:
  // learning from these needs thousands of people, not millions, and a rule by number lets a run grow.
  int turn_every = 2;
  // Of every n-th pair, counted from the second, and of every OOD subject there is another sample in clothes, with
  // the view from behind and the fitted shapes; 0: of none. The same people as above only.
  int clothed_every = 2;
  std::uint32_t turn_below = 14336;
  // Of these, subjects numbered below have a repeat capture, in another pose, place, room and outfit and in as many
  // frames as a device takes: answers learn from it the effects of pose and outfit, intervals the gain by frames.
  std::uint32_t again_below = 2048;
  int thread_count = 2;  // does not change the result
  // Resuming: finished chunks are kept in `work_dir` ("" = none) as shards and used again when they were made with
  // the same options (thread_count aside) and the same `input_key`, e.g. a checksum of the body and tracker files.
  std::string work_dir;
  std::uint64_t input_key = 0;
  int chunk_size = 1000;  // subjects in a file
  // Part `part` of `part_count` alone: an even share of the chunks, so that the files of all parts together are those
  // of a run that is not parted.
  int part = 0;
  int part_count = 1;
};

struct DatasetProgress {
  int done = 0;  // subjects, those found in shards included
  int total = 0;
  double subjects_per_second = 0;  // of those made now
  double seconds_left = 0;
};

struct DatasetReport {
  int subjects = 0;  // with at least one sample
  int samples = 0;
  int subjects_drawn = 0;    // with those without a sample
  int subjects_reused = 0;   // of these, from shards
  int captures_failed = 0;   // gave too few frames; drawn anew up to twice
  int captures_missing = 0;  // failed three times: no sample
  std::int64_t frames_seen = 0;
  std::array<std::int64_t, kGuidanceCount> refused{};  // frames by guidance code
  double seconds = 0;
  CaptureCost cost;             // summed over threads
  std::uint32_t shape_key = 0;  // of the run
  std::uint64_t input_key = 0;

  void add(const ChunkCounts& counts, const SubjectRange& range);
};

// Whether these options make this subject of the training family out of distribution.
bool is_ood(std::uint64_t number, int ood_every, std::uint32_t ood_below);
// How many subjects, from 0 on, hold `models` that are in distribution.
int subjects_with(int models, int ood_every, std::uint32_t ood_below);

// By which rules the code makes samples, and how an index's provenance names the rules of its samples.
std::uint64_t dataset_version();
std::string dataset_version_text(std::uint64_t version);  // "dataset version 22"
// Nothing: `provenance` does not name it.
std::optional<std::uint64_t> dataset_version_in(std::string_view provenance);

// What shards of these options are recognised by.
RunKey run_key_of(const body::BodyModel& model, const DatasetOptions& options);

// `progress` is called from worker threads, one at a time, a few times a second; `sink` from the calling thread, in
// the order of subjects. Memory: the samples of one chunk. Errors: options out of range, work_dir that cannot be
// written. A shard that is damaged or of another run is made again.
Result<DatasetReport> make_dataset(const body::BodyModel& model, const JointModel& joint_model,
                                   const DatasetOptions& options,
                                   const std::function<void(const DatasetProgress&)>& progress,
                                   const std::function<void(const index::Sample&)>& sink);

}  // namespace im2fit::lab
