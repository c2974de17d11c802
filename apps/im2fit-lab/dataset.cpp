// SPDX-License-Identifier: Apache-2.0
// Shards of samples: making them, all or one part of many, and checking that a run is whole.
#include <fmt/core.h>

#include <charconv>

#include "apps/im2fit-lab/commands.h"
#include "apps/im2fit-lab/samples.h"

namespace im2fit::apps {
namespace {

struct DatasetCommand {
  SampleOptions samples = default_samples();
  std::string shard;
};

// "I/N" with 0 <= I < N.
bool parse_shard(const std::string& text, int& part, int& part_count) {
  const char* end = text.data() + text.size();
  const auto number = std::from_chars(text.data(), end, part);
  if (number.ec != std::errc() || number.ptr == end || *number.ptr != '/') return false;
  const auto count = std::from_chars(number.ptr + 1, end, part_count);
  return count.ec == std::errc() && count.ptr == end && part >= 0 && part < part_count;
}

Result<int> run_dataset(const DatasetCommand& options) {
  SampleOptions samples = options.samples;
  if (!options.shard.empty()) (void)parse_shard(options.shard, samples.part, samples.part_count);
  const auto report = make_samples(samples, [](const index::Sample&) {});
  if (!report) return report.error();
  fmt::print("{}: {}", samples.work_dir, summary_of(*report));
  return kExitOk;
}

Result<int> run_check(const std::vector<std::string>& folders) {
  const auto set = check_samples(folders);
  if (!set) return set.error();
  const auto report = read_samples(folders, [](const index::Sample&) { return true; });
  if (!report) return report.error();
  fmt::print("whole: {} samples of {} synthetic people in {} shards\n{}", report->samples, report->subjects,
             set->shards().size(), set->run().text());
  return kExitOk;
}

}  // namespace

void add_dataset(cli::App& app, Command& chosen) {
  auto options = std::make_shared<DatasetCommand>();
  auto* sub = add_command<DatasetCommand>(
      app, chosen, "dataset",
      "Make features and labels of synthetic people, in shards; resumes after an interruption",
      "  im2fit-lab dataset --subjects 20000 --out samples\n"
      "  im2fit-lab dataset --subjects 5000000 --out samples --shard 7/100\n"
      "  im2fit-lab dataset check samples\n"
      "  im2fit-lab index --samples samples --subjects 20000 --out index.i2f",
      options, run_dataset);
  add_sample_options(*sub, options->samples);
  auto* out = sub->add_option("--out", options->samples.work_dir, "Folder of shards")->type_name("DIR");
  sub->add_option("--chunk", options->samples.chunk, "People per shard (default: as in the folder, or 1000)")
      ->range(1, 1'000'000);
  sub->add_option("--shard", options->shard,
                  "Make only part I of N, counted from 0, for a job array; all parts together equal one run")
      ->type_name("I/N")
      ->check([](const std::string& text) {
        int part = 0, part_count = 0;
        return parse_shard(text, part, part_count) ? std::string()
                                                   : "expected I/N with 0 <= I < N, like 0/10, not " + text;
      });

  auto folders = std::make_shared<std::vector<std::string>>();
  auto* check = sub->add_subcommand("check", "Check that shards are intact and a run is complete; reads all of them");
  check->add_option("DIR", *folders, "Folders of shards of one run")->required();
  // A parent's callback runs after its subcommand's, so the choice between them is made there.
  sub->callback([&chosen, options, check, folders, out] {
    if (check->parsed()) {
      chosen = [folders] { return run_check(*folders); };
      return;
    }
    if (out->count() == 0) cli::App::missing("--out");
    chosen = [options] { return run_dataset(*options); };
  });
}

}  // namespace im2fit::apps
