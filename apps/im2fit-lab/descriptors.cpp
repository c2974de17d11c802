// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include <cmath>
#include <string_view>

#include "apps/common/paths.h"
#include "apps/common/text_table.h"
#include "apps/im2fit-lab/commands.h"
#include "apps/im2fit-lab/descriptor_study.h"
#include "apps/im2fit-lab/parallel.h"

namespace im2fit::apps {
namespace {

struct DescriptorsCommand {
  DescriptorStudyOptions study;
  std::string body = default_body_path();
  std::string tracker = default_tracker_path();
};

// Mean over the people of the way's error less the exact descriptor's, with a 95 % interval.
template <class Pick>
std::string paired(const DescriptorStudy& study, std::size_t way, Pick pick) {
  const auto& ours = study.errors[way];
  const auto& exact = study.errors[kExactWay];
  const auto count = static_cast<double>(ours.size());
  double sum = 0, squares = 0;
  for (std::size_t i = 0; i < ours.size(); ++i) {
    const double difference = pick(ours[i]) - pick(exact[i]);
    sum += difference;
    squares += difference * difference;
  }
  const double mean = sum / count;
  const double reach = 1.96 * std::sqrt((squares / count - mean * mean) / (count - 1));
  return fmt::format("{:+.2f} [{:+.2f}, {:+.2f}]", mean, mean - reach, mean + reach);
}

template <class Pick>
std::vector<std::string> row_of(const DescriptorStudy& study, std::string name, Pick pick) {
  std::vector<std::string> row = {std::move(name)};
  for (const auto& errors : study.errors) {
    double sum = 0;
    for (const MeasurementValues& error : errors) sum += pick(error);
    row.push_back(number(sum / static_cast<double>(errors.size()), 2));
  }
  for (std::size_t way = 0; way < kDescriptorWays.size(); ++way)
    if (way != kExactWay) row.push_back(paired(study, way, pick));
  return row;
}

bool is_girth(std::size_t measurement) {
  return std::string_view(kMeasurementTable[measurement].id).ends_with("girth");
}

double mean_girth(const MeasurementValues& error) {
  double sum = 0;
  int count = 0;
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    if (!is_girth(m)) continue;
    sum += static_cast<double>(error[m]);
    ++count;
  }
  return sum / count;
}

Result<int> run_descriptors(const DescriptorsCommand& options) {
  const auto model = load_body(options.body);
  if (!model) return model.error();
  const auto tracker = Tracker::load(options.tracker);
  if (!tracker) return tracker.error();
  const auto study = study_descriptors(*model, tracker->model(), options.study);
  if (!study) return study.error();
  if (study->errors[0].size() < 2)
    return Error{ErrorCode::invalid_argument, "descriptors: fewer than two people could be described; ask for more"};

  std::vector<std::string> header = {"mean abs. error, synthetic"};
  for (const DescriptorWay& way : kDescriptorWays) header.emplace_back(way.name);
  for (std::size_t way = 0; way < kDescriptorWays.size(); ++way)
    if (way != kExactWay) header.push_back(fmt::format("{} less exact", kDescriptorWays[way].name));
  TextTable table(header);
  for (std::size_t m = 0; m < kMeasurementCount; ++m)
    table.add(row_of(*study, std::string(kMeasurementTable[m].id),
                     [m](const MeasurementValues& error) { return static_cast<double>(error[m]); }));
  table.add(row_of(*study, "mean of the girths", mean_girth));
  fmt::print("{} training samples, {} held-out people, paired by person, 95 % intervals\n{}", study->samples,
             study->errors[0].size(), table.text());
  return kExitOk;
}

}  // namespace

void add_descriptors(CLI::App& app, Command& chosen) {
  auto options = std::make_shared<DescriptorsCommand>();
  options->study.threads = default_threads();
  auto* sub = add_command<DescriptorsCommand>(
      app, chosen, "descriptors", "Compare the device's descriptor with the exact one and others, by end accuracy",
      "  im2fit-lab descriptors --train 3000 --people 400", options, run_descriptors);
  sub->add_option("--train", options->study.training_subjects, "Training subjects behind each index")
      ->check(CLI::Range(100, 1000000))
      ->capture_default_str();
  sub->add_option("--people", options->study.people, "Held-out people, those of eval")
      ->check(CLI::Range(2, 100000))
      ->capture_default_str();
  sub->add_option("--seed", options->study.seed, "Seed of the training subjects")->capture_default_str();
  sub->add_option("--threads", options->study.threads, "Threads; the result does not depend on them")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  sub->add_option("--body", options->body, "Body file")->type_name("FILE")->capture_default_str();
  sub->add_option("--tracker", options->tracker, "Tracker file")->type_name("FILE")->capture_default_str();
}

}  // namespace im2fit::apps
