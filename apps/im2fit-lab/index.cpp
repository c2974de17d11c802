// SPDX-License-Identifier: Apache-2.0
// Dataset and index in one go, and a look into an index.
#include <fmt/core.h>

#include <filesystem>

#include "apps/common/paths.h"
#include "apps/common/text_table.h"
#include "apps/im2fit-lab/commands.h"
#include "apps/im2fit-lab/samples.h"
#include "base/file.h"
#include "body/population.h"
#include "index/builder.h"
#include "synth/features.h"

namespace im2fit::apps {
namespace {

struct IndexCommand {
  SampleOptions samples = default_samples();
  int dimensions = 0;
  std::string out = default_index_path();
};

Result<int> run_build(const IndexCommand& options) {
  if (const auto made = make_directory(std::filesystem::absolute(options.out).parent_path().string()); !made)
    return made.error();
  SampleOptions samples = options.samples;
  if (samples.work_dir.empty()) samples.work_dir = options.out + ".samples";
  index::BuildOptions build;
  build.dimensions = options.dimensions;
  build.seed = samples.seed;
  build.groups = synth::feature_groups();
  build.provenance = fmt::format("im2fit-lab index --subjects {} --captures {} --seed {}", samples.subjects,
                                 samples.captures, samples.seed);
  build.population_version = body::kPopulationVersion;
  build.population_seed = samples.seed;
  const auto report = make_samples(samples, [](const index::Sample&) {});
  if (!report) return report.error();
  const auto bytes = index::build_index(build, [&](const std::function<bool(const index::Sample&)>& take) -> Status {
    bool going = true;
    const auto read = make_samples(samples, [&](const index::Sample& s) { going = going && take(s); });
    if (!read) return read.error();
    return Ok{};
  });
  if (!bytes) return bytes.error();
  if (const auto written = write_file_atomically(options.out, *bytes); !written) return written.error();
  fmt::print("{}{}: {:.1f} MB, {:.1f} bytes a model\n", summary_of(*report), options.out,
             static_cast<double>(bytes->size()) / 1e6,
             static_cast<double>(bytes->size()) / static_cast<double>(std::max(1, report->subjects)));
  return kExitOk;
}

Result<int> run_inspect(const std::string& path) {
  const auto index = load_index(path);
  if (!index) return index.error();
  const index::Info& info = index->info();
  fmt::print("{}\n  models      {} in {} entries\n  dimensions  {}, then {} over {} neighbours\n", path,
             info.subject_count, index->size(), index->dimensions(), info.method, info.neighbour_count);
  fmt::print("  feature     {} values\n  made by     {}\n  sex         {:.1f} % right (synthetic, cross-fitted)\n\n",
             index->feature_size(), info.provenance, 100 * info.sex_accuracy);
  TextTable groups({"group", "values", "weight", "error without"});
  for (const auto& group : info.groups)
    groups.add({group.name, std::to_string(group.count), number(group.weight, 3),
                number(group.error_without / info.error_with_all, 3)});
  TextTable errors({"mean abs. error, synthetic", "answer", "ridge", "nearest", "prior", "in interval %"});
  for (std::size_t i = 0; i < kMeasurementCount; ++i)
    errors.add({fmt::format("{} {}", kMeasurementTable[i].id, kMeasurementTable[i].unit),
                number(info.answer_mae[i], 1), number(info.ridge_mae[i], 1), number(info.nearest_mae[i], 1),
                number(info.prior_mae[i], 1), number(100 * info.coverage[i], 1)});
  fmt::print("{}\n{}", groups.text(), errors.text());
  return kExitOk;
}

}  // namespace

void add_index(CLI::App& app, Command& chosen) {
  auto options = std::make_shared<IndexCommand>();
  auto* sub = add_command<IndexCommand>(
      app, chosen, "index", "Build an index (.i2f) from synthetic people, or look into one",
      "  im2fit-lab index --subjects 20000 --out index.i2f\n  im2fit-lab index inspect index.i2f", options,
      run_build);
  add_sample_options(*sub, options->samples);
  sub->add_option("--samples", options->samples.work_dir, "Folder of shards to use or make (default: OUT.samples)")
      ->type_name("DIR");
  sub->add_option("--dimensions", options->dimensions, "Of the projected space; 0: chosen by held-out error")
      ->check(CLI::Range(0, 64))
      ->capture_default_str();
  sub->add_option("--out", options->out, "Index file to write")->type_name("FILE")->capture_default_str();

  auto path = std::make_shared<std::string>();
  auto* inspect = sub->add_subcommand("inspect", "What is in an index");
  inspect->add_option("FILE", *path, "Index file")->required();
  // A parent's callback runs after its subcommand's, so the choice between them is made there.
  sub->callback([&chosen, options, inspect, path] {
    if (inspect->parsed())
      chosen = [path] { return run_inspect(*path); };
    else
      chosen = [options] { return run_build(*options); };
  });
}

}  // namespace im2fit::apps
