// SPDX-License-Identifier: Apache-2.0
#include "apps/im2fit-lab/samples.h"

#include <fmt/core.h>

#include <cstdlib>  // says whether this is glibc
#include <nlohmann/json.hpp>
#include <optional>

#include "apps/common/paths.h"
#include "apps/common/progress.h"
#include "core/crc32c.h"
#include "core/file.h"
#include "formats/json_file.h"
#include "train/common/parallel.h"

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace im2fit::apps {
namespace {

// Memory that is freed stays with the process, for programs that make meshes and pictures by the hundred kilobytes:
// handing them back to the system each time costs as many page faults as a third of a scene. Call once, before
// threads; glibc only, elsewhere nothing.
void keep_freed_memory() {
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, 1 << 30);
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
#endif
}

std::string note_path(const std::string& work_dir) {
  return work_dir + "/samples.json";
}

// So that shards made from another body or tracker are refused.
Result<std::uint64_t> key_of_files(const std::string& body, const std::string& tracker) {
  const auto a = MappedFile::open(body);
  if (!a) return a.error();
  const auto b = MappedFile::open(tracker);
  if (!b) return b.error();
  return static_cast<std::uint64_t>(crc32c(a->bytes())) << 32U | crc32c(b->bytes());
}

int chunk_of(const SampleOptions& options, int otherwise) {
  if (options.chunk > 0) return options.chunk;
  const auto noted = noted_samples(options.work_dir);
  const bool same = noted && noted->captures == options.captures && noted->seed == options.seed;
  return same && noted->chunk > 0 ? noted->chunk : otherwise;
}

}  // namespace

SampleOptions default_samples() {
  SampleOptions options;
  options.threads = default_threads();
  options.body = made_body_path();
  options.tracker = made_tracker_path();
  return options;
}

void add_sample_options(cli::App& sub, SampleOptions& options) {
  sub.add_option("--subjects", options.subjects,
                 "Number of synthetic people (models). Of the first 14,336, one in three is not in the index: these "
                 "train the estimates and the intervals")
      ->range(1, 900'000'000)
      ->capture_default_str();
  sub.add_option("--captures", options.captures, "Captures of each person, with other pose, place and noise")
      ->range(1, 64)
      ->capture_default_str();
  sub.add_option("--seed", options.seed, "Seed")->capture_default_str();
  sub.add_option("--threads", options.threads, "Threads; the result does not depend on them")
      ->range(1, 256)
      ->capture_default_str();
  sub.add_option("--body", options.body, "Body file")->type_name("FILE")->capture_default_str();
  sub.add_option("--tracker", options.tracker, "Tracker file")->type_name("FILE")->capture_default_str();
}

Result<lab::DatasetReport> make_samples(const SampleOptions& options,
                                        const std::function<void(const index::Sample&)>& sink) {
  const auto model = load_body(options.body);
  if (!model) return model.error();
  const auto tracker = Tracker::load(options.tracker);
  if (!tracker) return tracker.error();
  const auto key = key_of_files(options.body, options.tracker);
  if (!key) return key.error();
  if (const auto made = make_directory(options.work_dir); !made) return made.error();
  lab::DatasetOptions dataset;
  dataset.subject_count = lab::subjects_with(options.subjects, dataset.ood_every, dataset.ood_below);
  dataset.captures_per_subject = options.captures;
  dataset.seed = options.seed;
  dataset.thread_count = options.threads;
  dataset.work_dir = options.work_dir;
  dataset.input_key = *key;
  dataset.chunk_size = chunk_of(options, dataset.chunk_size);
  dataset.part = options.part;
  dataset.part_count = options.part_count;
  // First, so that a reader of the folder of a killed run can report how much is missing.
  const nlohmann::ordered_json note = {{"subjects", options.subjects},
                                       {"captures", options.captures},
                                       {"seed", options.seed},
                                       {"chunk", dataset.chunk_size}};
  if (const auto written = write_file_atomically(note_path(options.work_dir), note.dump() + "\n"); !written)
    return written.error();
  keep_freed_memory();
  std::optional<Progress> progress;  // a part's total is known to the dataset
  return lab::make_dataset(
      *model, tracker->model(), dataset,
      [&](const lab::DatasetProgress& p) {
        if (!progress) progress.emplace("subjects", static_cast<std::uint64_t>(p.total));
        progress->update(static_cast<std::uint64_t>(p.done));
      },
      sink);
}

std::uint32_t tracker_key_of(std::uint64_t input_key) {
  return static_cast<std::uint32_t>(input_key);
}

Result<lab::ShardSet> check_samples(const std::vector<std::string>& folders) {
  auto set = lab::ShardSet::find(folders);
  if (!set) return set.error();
  for (const std::string& folder : folders) {
    const auto note = noted_samples(folder);
    if (!note) return note.error();
    const lab::RunKey& run = set->run();
    const int people = lab::subjects_with(note->subjects, static_cast<int>(run.ood_every), run.ood_below);
    if (const auto whole = set->expect({0, static_cast<std::uint64_t>(people)}); !whole) return whole.error();
  }
  return set;
}

Result<lab::DatasetReport> read_samples(const std::vector<std::string>& folders,
                                        const std::function<bool(const index::Sample&)>& take) {
  const auto set = check_samples(folders);
  if (!set) return set.error();
  lab::DatasetReport report;
  for (const lab::ShardAbout& shard : set->shards()) report.add(shard.counts, shard.range);
  report.subjects_reused = report.subjects_drawn;
  report.shape_key = set->run().shape_key;
  Progress progress("samples", static_cast<std::uint64_t>(report.samples));
  std::uint64_t done = 0;
  const auto read = set->read([&](const index::Sample& sample) {
    progress.update(++done);
    return take(sample);
  });
  if (!read) return read.error();
  return report;
}

Result<SampleOptions> noted_samples(const std::string& work_dir) {
  const std::string path = note_path(work_dir);
  const auto read = read_json(path);
  if (!read) return read.error();
  const nlohmann::json& json = *read;
  if (!json.is_object() || !json.contains("subjects") || !json.contains("captures") || !json.contains("seed"))
    return Error{ErrorCode::corrupt,
                 path + ": expected subjects, captures and seed; make the samples again with im2fit-lab dataset"};
  SampleOptions options = default_samples();
  options.subjects = json["subjects"].get<int>();
  options.captures = json["captures"].get<int>();
  options.seed = json["seed"].get<std::uint64_t>();
  options.chunk = json.value("chunk", 0);
  options.work_dir = work_dir;
  return options;
}

std::string summary_of(const lab::DatasetReport& report) {
  std::string text =
      fmt::format("{} samples of {} synthetic people ({} from shards) in {:.0f} s; {} captures missing\n",
                  report.samples, report.subjects, report.subjects_reused, report.seconds, report.captures_missing);
  const lab::CaptureCost& cost = report.cost;
  const int made = report.subjects_drawn - report.subjects_reused;
  if (made > 0)
    text += fmt::format(
        "processor ms a person: {:.2f} = body {:.2f}, scene {:.2f}, frames {:.2f}, sense {:.2f}, fuse {:.2f}, "
        "describe {:.2f}, fit {:.2f}\n",
        1e3 * cost.sum() / made, 1e3 * cost.draw / made, 1e3 * cost.scene / made, 1e3 * cost.render / made,
        1e3 * cost.sense / made, 1e3 * cost.fuse / made, 1e3 * cost.describe / made, 1e3 * cost.fit / made);
  std::string refused;
  for (std::size_t g = 0; g < kGuidanceCount; ++g)
    if (report.refused[g] > 0) refused += fmt::format(" {} {}", kGuidanceNames[g], report.refused[g]);
  if (!refused.empty()) text += fmt::format("refused of {} frames:{}\n", report.frames_seen, refused);
  return text;
}

}  // namespace im2fit::apps
