// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include <filesystem>

#include "apps/common/paths.h"
#include "apps/common/progress.h"
#include "apps/im2fit-lab/commands.h"
#include "core/file.h"
#include "person/data_files.h"
#include "train/common/parallel.h"
#include "train/tracker/train_tracker.h"

namespace im2fit::apps {
namespace {

struct TrainCommand {
  lab::TrainOptions train;
  std::string body = made_body_path();
  std::string out = made_tracker_path();
};

Result<int> run_train(const TrainCommand& options) {
  const auto model = load_body(options.body);
  if (!model) return model.error();
  if (const auto made = make_directory(std::filesystem::absolute(options.out).parent_path().string()); !made)
    return made.error();
  constexpr std::uint64_t kSteps = 1000;
  Progress progress("training, steps of a thousand", kSteps);
  const auto bytes = lab::train_tracker(*model, options.train, [&](double share, std::string_view stage) {
    progress.update(static_cast<std::uint64_t>(share * static_cast<double>(kSteps)), std::string(stage));
  });
  if (!bytes) return bytes.error();
  if (const auto written = write_file_atomically(options.out, *bytes); !written) return written.error();
  fmt::print("{}: {:.1f} MB\n", options.out, static_cast<double>(bytes->size()) / 1e6);
  return kExitOk;
}

}  // namespace

void add_train(cli::App& app, Command& chosen) {
  auto options = std::make_shared<TrainCommand>();
  options->train.thread_count = default_threads();
  auto* sub =
      add_command<TrainCommand>(app, chosen, "train", "Train the joint tracker (.i2t) on renders of synthetic people",
                                "  im2fit-lab train\n  im2fit-lab train --images 2500 --level-trees 250 --out "
                                "small.i2t   a quick one, for tests",
                                options, run_train);
  sub->add_option("--images", options->train.image_count, "Number of training renders")
      ->range(40, 200000)
      ->capture_default_str();
  sub->add_option("--seed", options->train.seed, "Seed")->capture_default_str();
  sub->add_option("--threads", options->train.thread_count, "Threads; the result does not depend on them")
      ->range(1, 256)
      ->capture_default_str();
  sub->add_option("--levels", options->train.level_count, "Levels of the cascade")
      ->range(1, 32)
      ->capture_default_str();
  sub->add_option("--level-trees", options->train.level_tree_count,
                  "Trees per level; the file has 1.2 kB for each of levels x trees, plus the forest")
      ->range(1, 4096)
      ->capture_default_str();
  sub->add_option("--body", options->body, "Body file")->type_name("FILE")->capture_default_str();
  sub->add_option("--out", options->out, "Tracker file to write")->type_name("FILE")->capture_default_str();
}

}  // namespace im2fit::apps
