// SPDX-License-Identifier: Apache-2.0
// im2fit compare BEFORE AFTER: what has changed between two captures of one person.
#include <fmt/core.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/im2fit/commands.h"
#include "core/text.h"
#include "formats/json_file.h"
#include "person/comparison.h"
#include "report/text_table.h"

namespace im2fit::apps {
namespace {

using Json = nlohmann::ordered_json;

struct CompareOptions {
  std::string before, after;
  bool json = false;
};

const char* verdict(const Comparison& all, const MeasureChange& one) {
  if (all.two_people) return "not judged";
  return one.changed() ? "changed" : "no change";
}

Json rounded(float value, double steps) {
  const double whole = std::floor(static_cast<double>(value) * steps + 0.5);
  return whole == 0 ? 0.0 : whole / steps;  // no minus zero
}

Json comparison_json(const Comparison& all, const Capture& before, const Capture& after) {
  Json changes = Json::object();
  for (const MeasureChange& one : all.changes) {
    if (!std::isfinite(one.difference)) continue;
    const MeasurementInfo& info = kMeasurementTable[measurement_index(one.measurement)];
    const double steps = info.unit == "kg" ? 100 : 10;
    changes[std::string(info.id)] = {{"before", rounded(one.before, steps)},
                                     {"after", rounded(one.after, steps)},
                                     {"difference", rounded(one.difference, steps)},
                                     {"unit", std::string(info.unit)},
                                     {"interval", Json::array({rounded(one.difference - one.half, steps),
                                                               rounded(one.difference + one.half, steps)})},
                                     {"verdict", verdict(all, one)}};
  }
  return {{"schema", "im2fit.comparison/1"},
          {"before", before.path},
          {"after", after.path},
          {"two_people", all.two_people},
          {"rests_on", all.wider.empty() ? "repeated captures" : "independent errors"},
          {"wider", all.wider},
          {"differences", changes}};
}

std::string comparison_table(const Comparison& all) {
  TextTable table({"measurement", "before", "after", "difference", "+-", ""});
  for (const MeasureChange& one : all.changes) {
    if (!std::isfinite(one.difference)) continue;
    const MeasurementInfo& info = kMeasurementTable[measurement_index(one.measurement)];
    const int decimals = info.unit == "kg" ? 1 : 0;
    // Rounded here, so that what is next to nothing has no minus.
    const double difference = rounded(one.difference, decimals == 0 ? 1 : 10).get<double>();
    table.add({fmt::format("{} {}", info.id, info.unit), fmt::format("{:.{}f}", one.before, decimals),
               fmt::format("{:.{}f}", one.after, decimals), fmt::format("{:+.{}f}", difference, decimals),
               fmt::format("{:.{}f}", one.half, decimals), verdict(all, one)});
  }
  return table.text();
}

Result<int> run_compare(const CompareOptions& options) {
  const auto before = read_capture(options.before);
  if (!before) return before.error();
  const auto after = read_capture(options.after);
  if (!after) return after.error();
  const Comparison all = compare(*before, *after);
  if (options.json) {
    fmt::print("{}\n", json_text(comparison_json(all, *before, *after), 2));
    return kExitOk;
  }
  fmt::print("{}", comparison_table(all));
  if (all.two_people)
    fmt::print("Two people: the statures differ by more than both intervals and a day allow. No change is judged.\n");
  for (const std::string& reason : all.wider) fmt::print("Wider intervals: {}\n", printable(reason));
  return kExitOk;
}

}  // namespace

void add_compare(cli::App& app, Command& chosen) {
  auto options = std::make_shared<CompareOptions>();
  auto* sub = add_command<CompareOptions>(
      app, chosen, "compare", "Report changes between two captures of one person",
      "  im2fit compare may/result.json june/result.json\n  im2fit compare may june --json", options, run_compare);
  sub->add_option("BEFORE", options->before,
                  "A result.json, or a folder that contains one: a session, or the folder of measure --out")
      ->required();
  sub->add_option("AFTER", options->after, "The result of the later capture, as for BEFORE")->required();
  sub->add_flag("--json", options->json, "As JSON");
}

}  // namespace im2fit::apps
