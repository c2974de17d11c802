// SPDX-License-Identifier: Apache-2.0
// Dataset and index in one go.
#include <fmt/core.h>

#include <filesystem>

#include "apps/common/paths.h"
#include "apps/common/progress.h"
#include "apps/im2fit-lab/commands.h"
#include "apps/im2fit-lab/index_inspect.h"
#include "apps/im2fit-lab/samples.h"
#include "core/file.h"
#include "person/data_files.h"
#include "train/dataset/dataset.h"
#include "train/dataset/features.h"
#include "train/index/builder.h"
#include "train/population/drawn_people.h"

namespace im2fit::apps {
namespace {

struct IndexCommand {
  SampleOptions samples = default_samples();
  int dimensions = 0;
  std::size_t densify_to = 0;
  std::vector<std::string> from;
  std::string out = made_index_path();
};

// All samples, in order: of folders made elsewhere, or made now (and read again from the shards of just this run).
Status each_sample(const IndexCommand& options, const SampleOptions& samples,
                   const std::function<bool(const index::Sample&)>& take) {
  if (!options.from.empty()) {
    const auto read = read_samples(options.from, take);
    return read ? Status(Ok{}) : Status(read.error());
  }
  bool going = true;
  const auto made = make_samples(samples, [&](const index::Sample& sample) { going = going && take(sample); });
  return made ? Status(Ok{}) : Status(made.error());
}

Result<int> run_build(const IndexCommand& options) {
  if (const auto made = make_directory(std::filesystem::absolute(options.out).parent_path().string()); !made)
    return made.error();
  index::BuildOptions build;
  build.threads = options.samples.threads;
  SampleOptions samples = options.samples;
  if (samples.work_dir.empty()) samples.work_dir = options.out + ".samples";
  std::uint64_t samples_version = dataset_version();
  if (options.from.empty()) {
    const auto report = make_samples(samples, [](const index::Sample&) {});
    if (!report) return report.error();
    fmt::print("{}", summary_of(*report));
    build.shape_key = report->shape_key;
    build.tracker_key = tracker_key_of(report->input_key);
  } else {
    const auto noted = noted_samples(options.from.front());
    if (!noted) return noted.error();
    samples.subjects = noted->subjects;
    samples.captures = noted->captures;
    samples.seed = noted->seed;
    const auto set = check_samples(options.from);
    if (!set) return set.error();
    samples_version = set->run().dataset_version;
    build.shape_key = set->run().shape_key;
    build.tracker_key = tracker_key_of(set->run().input_key);
  }
  build.dimensions = options.dimensions;
  build.seed = samples.seed;
  build.groups = lab::feature_groups();
  build.provenance = fmt::format("im2fit-lab index --subjects {} --captures {} --seed {}", samples.subjects,
                                 samples.captures, samples.seed);
  if (options.densify_to > 0) build.provenance += fmt::format(" --densify {}", options.densify_to);
  build.provenance += ", " + dataset_version_text(samples_version);
  build.densify_to = options.densify_to;
  build.population_version = body::kPopulationVersion;
  build.population_seed = samples.seed;
  Progress progress("entries", 0);
  build.progress = [&](const std::string& stage, std::size_t done) { progress.update(done, stage); };
  const auto bytes = index::build_index(build, [&](const std::function<bool(const index::Sample&)>& take) {
    return each_sample(options, samples, take);
  });
  if (!bytes) return bytes.error();
  if (const auto written = write_file_atomically(options.out, *bytes); !written) return written.error();
  const auto index = load_index(options.out);
  if (!index) return index.error();
  fmt::print("{}: {} entries of {} people, {:.1f} MB, {:.1f} bytes an entry\n", options.out, index->size(),
             index->info().subject_count, static_cast<double>(bytes->size()) / 1e6,
             static_cast<double>(bytes->size()) / static_cast<double>(index->size()));
  return kExitOk;
}

}  // namespace

void add_index(cli::App& app, Command& chosen) {
  auto options = std::make_shared<IndexCommand>();
  auto* sub = add_command<IndexCommand>(
      app, chosen, "index", "Build an index (.i2f) from synthetic people, or inspect one",
      "  im2fit-lab index --subjects 20000 --out index.i2f\n  im2fit-lab index inspect index.i2f\n"
      "  im2fit-lab index --subjects 50000 --densify 5000000 --out large.i2f   # for measuring speed",
      options, run_build);
  add_sample_options(*sub, options->samples);
  sub->add_option("--samples", options->samples.work_dir, "Folder of shards to use or make (default: OUT.samples)")
      ->type_name("DIR");
  sub->add_option("--from", options->from,
                  "Folders of shards of one run, made elsewhere: nothing is made, all of them are read as one")
      ->type_name("DIR")
      ->excludes("--samples");
  sub->add_option("--dimensions", options->dimensions, "Of the projected space; 0: chosen by held-out error")
      ->range(0, 16)
      ->capture_default_str();
  sub->add_option("--densify", options->densify_to,
                  "Entries to reach by mixing pairs of real ones: for measuring speed and size only")
      ->range(0, 16'000'000)
      ->type_name("N");
  sub->add_option("--out", options->out, "Index file to write")->type_name("FILE")->capture_default_str();

  // A parent's callback runs after its subcommand's: it may only choose where none of them did.
  add_index_inspect(*sub, chosen);
  sub->callback([&chosen, options, sub] {
    if (!sub->any_subcommand()) chosen = [options] { return run_build(*options); };
  });
}

}  // namespace im2fit::apps
