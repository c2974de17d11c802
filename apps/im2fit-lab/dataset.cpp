// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include "apps/im2fit-lab/commands.h"
#include "apps/im2fit-lab/samples.h"

namespace im2fit::apps {
namespace {

Result<int> run_dataset(const SampleOptions& options) {
  const auto report = make_samples(options, [](const index::Sample&) {});
  if (!report) return report.error();
  fmt::print("{}: {}", options.work_dir, summary_of(*report));
  return kExitOk;
}

}  // namespace

void add_dataset(CLI::App& app, Command& chosen) {
  auto options = std::make_shared<SampleOptions>(default_samples());
  auto* sub = add_command<SampleOptions>(
      app, chosen, "dataset", "Synthetic people to features and labels, in shards; resumes where it stopped",
      "  im2fit-lab dataset --subjects 20000 --out samples\n"
      "  im2fit-lab index --samples samples --subjects 20000 --out index.i2f",
      options, run_dataset);
  add_sample_options(*sub, *options);
  sub->add_option("--out", options->work_dir, "Folder of shards")->required()->type_name("DIR");
}

}  // namespace im2fit::apps
