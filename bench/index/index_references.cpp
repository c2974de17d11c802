// SPDX-License-Identifier: Apache-2.0
// Our index against alternatives a user could pick, over the same models and queried by the same people.
//   index_references --samples DIR --out bench/results
//   index_references --self-check
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <exception>
#include <fstream>
#include <stdexcept>

#include "bench/index/report.h"
#include "bench/index/search_alone.h"
#include "core/file.h"
#include "train/index/builder.h"

namespace im2fit::bench {
namespace {

struct Options {
  std::string samples, out;
  std::vector<std::size_t> sizes = {1'000, 10'000, 50'000, 500'000, 5'000'000};
  std::vector<std::string> references;
  std::size_t queries = 1000;
  double seconds = 5;
  bool full = false, self_check = false;
};

constexpr std::size_t kGraphMax = 500'000;  // above it even a graph over a dozen values is minutes in the making

const auto kStart = std::chrono::steady_clock::now();

double elapsed_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - kStart).count();
}

void log_line(const std::string& words) {
  std::fprintf(stderr, "[%4.0f s] %s\n", elapsed_s(), words.c_str());
}

double memory_peak_gb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1e6;
}

std::string processor() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  return "unknown processor";
}

void log_row(const Row& row) {
  char text[160];
  std::snprintf(text, sizeof text, "  %-52s %9.1f us p50 %9.1f us p99", row.reference.c_str(), row.p50_us.value_or(0),
                row.p99_us.value_or(0));
  log_line(text);
}

void measure_reference(const Options& options, const ReferenceKind& kind, const People& people, const Exam& exam,
                       Measured& all) {
  const auto reference = kind.make(people);
  log_line("  " + reference->name() + ": building");
  const double build_s = reference->build(exam.models);
  for (std::size_t method = 0; method < reference->method_count(); ++method) {
    reference->use_method(method);
    Row row = measure(*reference, exam);
    row.kind = kind.id;
    row.build_s = build_s;
    // The same answers as the exact search's, which may have had more queries.
    if (row.kind == "brute" && row.recall_raw == 1.0) row.error = untimed_row(exam, 1).error;
    log_row(row);
    all.rows.push_back(row);
  }
  if (kind.id != "ours") return;
  for (const Row& row :
       search_alone(reference->file(), exam, exam.models.size() <= (options.full ? kind.to_full : kGraphMax))) {
    log_row(row);
    all.searches.push_back(row);
  }
}

bool wanted(const Options& options, const ReferenceKind& kind, std::size_t size) {
  const auto& chosen = options.references;
  if (!chosen.empty() && std::find(chosen.begin(), chosen.end(), kind.id) == chosen.end()) return false;
  return size >= kind.from && size <= (options.full ? kind.to_full : kind.to);
}

void measure_size(const Options& options, const People& people, std::size_t size, Measured& all) {
  const std::uint64_t seed = index::BuildOptions{}.seed;
  const std::size_t width = people.models.front().feature.size();
  const Models models(people.models, size, seed);
  log_line(std::to_string(models.size()) + " models, " + std::to_string(models.densified_count()) +
           " of them densified: exact answers");
  const Exam exam = make_exam(models, people.queries, options.seconds);
  bool brute_force_timed = false;
  for (const ReferenceKind& kind : all_references()) {
    if (!wanted(options, kind, size)) continue;
    measure_reference(options, kind, people, exam, all);
    brute_force_timed = brute_force_timed || kind.id == "brute";
  }
  if (!brute_force_timed) all.rows.push_back(untimed_row(exam, 1));
  all.rows.push_back(untimed_row(exam, kAveraged));
  if (width == kRawSize) return;
  const Models whole(people.models, size, seed, width);
  const Exam with_all = make_exam(whole, people.queries, options.seconds / 2);
  all.rows.push_back(untimed_row(with_all, 1));
  all.rows.push_back(untimed_row(with_all, kAveraged));
}

Status write(const Options& options, const Measured& all) {
  if (auto made = make_directory(options.out); !made) return made;
  const std::string base = options.out + "/index-references";
  if (auto s = write_file_atomically(base + ".json", json_of(all)); !s) return s;
  if (auto s = write_file_atomically(base + ".svg", plot_of(all)); !s) return s;
  return write_file_atomically(base + ".md", markdown_of(all, "index-references.svg"));
}

// What holds at any size and speed.
int judge(const Measured& all) {
  int failed = 0;
  const auto expect = [&](bool holds, const std::string& what) {
    if (holds) return;
    std::fprintf(stderr, "index_references: %s\n", what.c_str());
    failed = 1;
  };
  std::size_t ours_seen = 0;
  for (const Row& ours : all.rows) {
    if (ours.kind != "ours" && ours.kind != "ours501") continue;
    ++ours_seen;
    const std::string at = ours.reference + " at " + std::to_string(ours.models);
    expect(ours.recall_own == 1.0, at + " answers otherwise than its exhaustive search");
    for (const Row& raw : all.rows) {
      if (raw.kind != "brute" || raw.models != ours.models) continue;
      expect(raw.recall_raw == 1.0, "brute force and the exact search it is judged by disagree");
      for (std::size_t k = 0; k < kJudged.size(); ++k)
        expect(ours.error[k] < raw.error[k], at + " is no nearer the truth than the nearest raw feature");
    }
  }
  expect(ours_seen > 0, "nothing of ours was measured");
  return failed;
}

int run(Options options) {
  if (options.self_check) {
    if (options.sizes == Options().sizes) options.sizes = {1'000, 4'000};
    options.seconds = 0.5;
    options.queries = 100;
  }
  std::size_t most = 1;
  for (const std::size_t size : options.sizes) most = std::max(most, size);
  constexpr std::size_t kSelfCheckPeople = 3000;
  auto people = Result<People>(People{});
  if (options.samples.empty()) {
    if (!options.self_check) throw std::runtime_error("--samples is missing: a folder of im2fit-lab dataset");
    people = invent_people(kSelfCheckPeople, 1);
  } else {
    people = read_people(options.samples, options.self_check ? kSelfCheckPeople : 2 * most + 1000);
  }
  if (!people) throw std::runtime_error(people.error().message);
  if (people->queries.size() > options.queries) people->queries.resize(options.queries);
  if (people->models.size() < 100 || people->queries.empty())
    throw std::runtime_error("only " + std::to_string(people->models.size()) +
                             " models; at least 100 are needed, thousands for figures that mean something");
  Measured all;
  all.origin = people->origin;
  all.processor = processor();
  all.models_real = people->models.size();
  all.queries = people->queries.size();
  all.feature_size = people->models.front().feature.size();
  for (const std::size_t size : options.sizes) measure_size(options, *people, size, all);
  all.seconds = elapsed_s();
  all.memory_peak_gb = memory_peak_gb();
  if (!options.out.empty())
    if (const auto written = write(options, all); !written) throw std::runtime_error(written.error().message);
  for (const Target& target : targets_of(all))
    std::printf("%-80s %14s  %s%s\n", target.what.c_str(), target.target.c_str(), target.measured.c_str(),
                target.met == false ? "  MISSED" : "");
  return options.self_check ? judge(all) : 0;
}

constexpr std::size_t kAll = 16'000'000;
constexpr std::size_t kMinutes = 60'000;    // above it a graph over 501 values is minutes in the making
constexpr std::size_t kMemory = 1'000'000;  // above it raw features and their graph are many GB

}  // namespace

std::vector<ReferenceKind> all_references() {
  return {
      {"ours", 0, kAll, kAll, [](const People& p) { return make_ours(p, false); }},
      {"ours501", 0, kMinutes, kAll, [](const People& p) { return make_ours(p, true); }},
      {"brute", 0, kMemory, kMemory, [](const People&) { return make_brute_force(); }},
      {"nanoflann", 0, kMinutes, kMemory, [](const People&) { return make_nanoflann_raw(); }},
      {"pca", 0, kAll, kAll, [](const People&) { return make_nanoflann_pca(); }},
#ifdef IM2FIT_REFERENCES_FAISS
      {"ivfpq", 4'000, kAll, kAll, [](const People&) { return make_faiss_ivf_pq(); }},
      {"hnsw", 0, kMinutes, kMemory, [](const People&) { return make_faiss_hnsw(); }},
#endif
#ifdef IM2FIT_REFERENCES_HNSWLIB
      {"hnswlib", 0, kMinutes, kMemory, [](const People&) { return make_hnswlib(); }},
#endif
  };
}

}  // namespace im2fit::bench

int main(int argc, char** argv) {
  im2fit::bench::Options options;
  CLI::App app{"The index and its references: time, size and measurement error over the same models"};
  app.add_option("--samples", options.samples, "Shards of one run of im2fit-lab dataset")->type_name("DIR");
  app.add_option("--out", options.out, "Writes index-references.json, .md and .svg there")->type_name("DIR");
  app.add_option("--sizes", options.sizes, "Models")->delimiter(',')->check(CLI::Range(100, 16'000'000));
  app.add_option("--references", options.references,
                 "Of ours ours501 brute nanoflann pca ivfpq hnsw hnswlib; default all")
      ->delimiter(',');
  app.add_option("--queries", options.queries, "Held-out people to query, at most")->capture_default_str();
  app.add_option("--seconds", options.seconds, "To spend on queries, for each row")->capture_default_str();
  app.add_flag("--full", options.full, "Graphs and trees over raw features also at 500,000 (about an hour)");
  app.add_flag("--self-check", options.self_check,
               "A few seconds; fails unless ours is exact and better than the nearest raw feature");
  CLI11_PARSE(app, argc, argv);
  try {
    return im2fit::bench::run(options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "index_references: %s\n", error.what());
    return 1;
  }
}
