// SPDX-License-Identifier: Apache-2.0
// Dataset and index in one go.
#include <fmt/core.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>

#include "apps/common/paths.h"
#include "apps/common/program.h"
#include "apps/common/progress.h"
#include "apps/im2fit-lab/commands.h"
#include "apps/im2fit-lab/samples.h"
#include "core/file.h"
#include "formats/json_file.h"
#include "person/data_files.h"
#include "report/text_table.h"
#include "train/dataset/dataset.h"
#include "train/dataset/features.h"
#include "train/index/builder.h"
#include "train/population/drawn_people.h"

namespace im2fit::apps {
namespace {

using namespace lab;  // what commands are about

using Json = nlohmann::ordered_json;

struct InspectOptions {
  std::string path = made_index_path();
  bool json = false;
  int trials = 1000;
  std::string features = "-";
  index::QueryOptions query;
};

std::string measurement_label(std::size_t i) {
  return fmt::format("{} {}", kMeasurementTable[i].id, kMeasurementTable[i].unit);
}

Json inspected(const index::Index& index) {
  const index::Info& info = index.info();
  Json json = {{"subjects", info.subject_count},
               {"entries", info.entry_count},
               {"densified", info.densified_count},
               {"feature_size", index.feature_size()},
               {"dimensions", index.dimensions()},
               {"dimension_bits", info.dimension_bits},
               {"method", info.method},
               {"neighbours", info.neighbour_count},
               {"sex_accuracy", info.sex_accuracy},
               {"tracker_key", fmt::format("{:08x}", info.tracker_key)},
               {"provenance", info.provenance}};
  for (const auto& s : index.sections()) json["sections"].push_back({{"name", s.name}, {"bytes", s.size}});
  for (const auto& g : info.groups)
    json["groups"].push_back(
        {{"name", g.name}, {"values", g.count}, {"weight", g.weight}, {"error_without", g.error_without}});
  for (std::size_t i = 0; i < kMeasurementCount; ++i)
    json["mean_absolute_error"][std::string(kMeasurementTable[i].id)] = {{"answer", info.answer_mae[i]},
                                                                         {"ridge", info.ridge_mae[i]},
                                                                         {"nearest", info.nearest_mae[i]},
                                                                         {"prior", info.prior_mae[i]},
                                                                         {"coverage", info.coverage[i]}};
  return json;
}

void show_refined(const index::Info& info, const char* heading, index::Refinement front, index::Refinement both) {
  const auto& one = info.refined[static_cast<std::size_t>(front)];
  const auto& two = info.refined[static_cast<std::size_t>(both)];
  if (one.sample_count == 0 || two.sample_count == 0) return;
  TextTable table({heading, "front", "in interval %", "front and back", "in interval %"});
  for (std::size_t i = 0; i < kMeasurementCount; ++i)
    table.add({measurement_label(i), number(one.mae[i], 1), number(100 * one.coverage[i], 1), number(two.mae[i], 1),
               number(100 * two.coverage[i], 1)});
  fmt::print("\n{}", table.text());
}

void show_clothing(const index::Info& info) {
  const auto& [front, both] = info.clothing;
  if (front.sample_count == 0 || both.sample_count == 0) return;
  fmt::print("\nbare or dressed: {:.1f} % right from the front, {:.1f} % from both sides (synthetic, cross-fitted)\n",
             100 * front.right_share, 100 * both.right_share);
}

Result<int> inspect(const InspectOptions& options) {
  const auto index = load_index(options.path);
  if (!index) return index.error();
  if (options.json) {
    fmt::print("{}\n", json_text(inspected(*index), 2));
    return kExitOk;
  }
  const index::Info& info = index->info();
  fmt::print(
      "{}\n  people      {} in {} entries{}\n  answer      {}, {} neighbours\n", options.path, info.subject_count,
      info.entry_count,
      info.densified_count > 0 ? fmt::format(", {} of them mixed from pairs of others", info.densified_count) : "",
      info.method, info.neighbour_count);
  fmt::print("  feature     {} values\n  made by     {}\n  sex         {:.1f} % right (synthetic, cross-fitted)\n",
             index->feature_size(), info.provenance, 100 * info.sex_accuracy);
  std::string bits;
  for (const float b : info.dimension_bits) bits += fmt::format(" {:.2f}", b);
  fmt::print("  dimensions  {}; information about the body, bits each:{}\n\n", index->dimensions(), bits);
  TextTable sections({"section", "bytes", "an entry"});
  std::uint64_t total = 0;
  for (const auto& s : index->sections()) {
    sections.add({s.name, std::to_string(s.size), number(static_cast<double>(s.size) / info.entry_count, 2)});
    total += s.size;
  }
  sections.add({"all", std::to_string(total), number(static_cast<double>(total) / info.entry_count, 2)});
  TextTable groups({"group", "values", "weight", "error without"});
  for (const auto& group : info.groups)
    groups.add({group.name, std::to_string(group.count), number(group.weight, 3),
                number(group.error_without / info.error_with_all, 3)});
  TextTable errors({"mean abs. error, synthetic", "answer", "ridge", "nearest", "prior", "in interval %"});
  for (std::size_t i = 0; i < kMeasurementCount; ++i)
    errors.add({measurement_label(i), number(info.answer_mae[i], 1), number(info.ridge_mae[i], 1),
                number(info.nearest_mae[i], 1), number(info.prior_mae[i], 1), number(100 * info.coverage[i], 1)});
  fmt::print("{}\n{}\n{}", sections.text(), groups.text(), errors.text());
  show_refined(info, "on out-of-distribution subjects, with a fitted shape", index::Refinement::fitted,
               index::Refinement::turned);
  show_clothing(info);
  show_refined(info, "the same, in clothes", index::Refinement::clothed, index::Refinement::clothed_turned);
  return kExitOk;
}

Result<int> verify(const InspectOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  const auto index = load_index(options.path);
  if (!index) return index.error();
  if (const auto sound = index->verify(options.trials); !sound) return sound.error();
  fmt::print(
      "{}: sound. {} sections match their checksums, {} entries lie in their leaves, {} searches found what an "
      "exhaustive one finds ({:.1f} s)\n",
      options.path, index->sections().size(), index->size(), options.trials,
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  return kExitOk;
}

Result<std::string> text_of(const std::string& path) {
  if (path == "-") return std::string(std::istreambuf_iterator<char>(std::cin), {});
  const auto bytes = read_file(path);
  if (!bytes) return bytes.error();
  return std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size());
}

// Numbers separated by blanks or commas; "nan" or "-" for a value that was not measured.
Result<std::vector<float>> feature_of(std::string line, const std::string& where) {
  for (char& c : line) c = c == ',' ? ' ' : c;
  std::vector<float> out;
  std::istringstream words(line);
  for (std::string word; words >> word;) {
    char* end = nullptr;
    const float value = word == "-" ? std::numeric_limits<float>::quiet_NaN() : std::strtof(word.c_str(), &end);
    if (word != "-" && *end != 0)
      return Error{ErrorCode::invalid_argument, where + ": '" + word + "' is not a number (value " +
                                                    std::to_string(out.size() + 1) + " of the line)"};
    out.push_back(value);
  }
  return out;
}

Json answered(const index::Answer& a, const index::IndexedPerson& person) {
  Json json;
  for (std::size_t i = 0; i < kMeasurementCount; ++i) {
    const index::IntervalEstimate& e = a.measurements[i];
    json["measurements"][std::string(kMeasurementTable[i].id)] = {
        {"value", e.value}, {"unit", kMeasurementTable[i].unit}, {"interval", {e.low, e.high}}};
  }
  json["female"] = a.female;
  json["entry"] = a.nearest;
  json["distance"] = a.nearest_distance;
  json["person"] = person.number;
  return json;
}

Result<int> query(const InspectOptions& options) {
  const auto index = load_index(options.path);
  if (!index) return index.error();
  const auto text = text_of(options.features);
  if (!text) return text.error();
  const auto scratch = index->make_scratch();
  std::istringstream lines(*text);
  int number_of_line = 0, answers = 0;
  for (std::string line; std::getline(lines, line);) {
    const std::string where =
        fmt::format("{} line {}", options.features == "-" ? "stdin" : options.features, ++number_of_line);
    const auto feature = feature_of(line, where);
    if (!feature) return feature.error();
    if (feature->empty()) continue;
    if (feature->size() != index->feature_size())
      return Error{ErrorCode::invalid_argument,
                   fmt::format("{}: {} values, the index needs {}", where, feature->size(), index->feature_size())};
    const auto answer = index->query(*feature, options.query, *scratch);
    if (!answer) return answer.error();
    const index::Answer& a = *answer;
    const auto person = index->person_of(a.nearest);
    if (!person) return person.error();
    ++answers;
    if (options.json) {
      fmt::print("{}\n", json_text(answered(a, *person)));
      continue;
    }
    TextTable table({where, "value", "from", "to"});
    for (std::size_t i = 0; i < kMeasurementCount; ++i)
      table.add({measurement_label(i), number(a.measurements[i].value, 1), number(a.measurements[i].low, 1),
                 number(a.measurements[i].high, 1)});
    fmt::print("{}woman {:.3f}; nearest entry {} (person {}), {:.2f} away\n", table.text(), a.female, a.nearest,
               person->number, a.nearest_distance);
  }
  if (answers == 0)
    return Error{ErrorCode::invalid_argument,
                 fmt::format("no feature given: expected {} numbers a line", index->feature_size())};
  return kExitOk;
}

cli::App* add_inspection(cli::App& index, Command& chosen, const std::shared_ptr<InspectOptions>& options,
                         const std::string& name, const std::string& about,
                         Result<int> (*run)(const InspectOptions&)) {
  cli::App* sub = add_command<InspectOptions>(index, chosen, name, about, "  im2fit-lab index " + name + " index.i2f",
                                              options, run);
  sub->add_option("FILE", options->path, "Index file")->required();
  return sub;
}

void add_index_inspect(cli::App& index, Command& chosen) {
  const auto options = std::make_shared<InspectOptions>();
  auto* inspects = add_inspection(index, chosen, options, "inspect", "Print the contents of an index", inspect);
  inspects->add_flag("--json", options->json, "As JSON");
  auto* verifies =
      add_inspection(index, chosen, options, "verify", "Check the checksums, tree and search of an index", verify);
  verifies->add_option("--trials", options->trials, "Number of searches to compare with exhaustive searches")
      ->range(1, 1'000'000)
      ->capture_default_str();
  auto* query_command = add_inspection(index, chosen, options, "query", "Query an index with features", query);
  query_command
      ->add_option("FEATURES", options->features,
                   "Text file with one feature per line: numbers, or '-' if not measured; - is stdin")
      ->capture_default_str();
  query_command
      ->add_option("--neighbours", options->query.neighbour_count,
                   "Number of neighbours; 0: the setting of the index")
      ->range(0, 512)
      ->capture_default_str();
  query_command->add_option("--frames", options->query.frame_count, "Number of frames fused for the feature")
      ->range(1, 10000)
      ->capture_default_str();
  query_command->add_option("--distance", options->query.distance_mm, "Distance from camera to person; 0: not known")
      ->range(0, 10000)
      ->type_name("MM")
      ->capture_default_str();
  query_command->add_flag("--exhaustive", options->query.exhaustive, "Scan every entry, with the same result");
  query_command->add_flag("--json", options->json, "One line of JSON per feature");
}

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
                  "Folders with the shards of one run that was made elsewhere; no samples are made")
      ->type_name("DIR")
      ->excludes("--samples");
  sub->add_option("--dimensions", options->dimensions,
                  "Dimensions of the projected space; 0: chosen by held-out error")
      ->range(0, 16)
      ->capture_default_str();
  sub->add_option("--densify", options->densify_to,
                  "Number of entries to reach by mixing pairs of entries, to measure speed and size only")
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
