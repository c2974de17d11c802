// SPDX-License-Identifier: Apache-2.0
// im2fit-lab make error-correlation BODY.i2b TRACKER.i2t INDEX.i2f [PEOPLE] > estimate/error_correlation.inc
// How the errors of an answer go together, in people unlike the index's own (train/population/ood_subjects.h), who
// are neither the held-out family nor another make of the evaluation. From the front and from both sides; bare, in
// clothes and in draped garments. Minutes.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "apps/im2fit-lab/make/make.h"
#include "estimate/known_facts.h"
#include "evaluation/measurements/conditions.h"
#include "evaluation/measurements/evaluation.h"
#include "person/data_files.h"

namespace {

using namespace im2fit;
using namespace im2fit::lab;

constexpr std::uint64_t kSeed = 0xE2207;  // no other use
constexpr int kPeople = 400;              // of each condition
constexpr const char* kConditions[] = {"noise", "both", "clothed", "both+clothed", "garments", "both+garments"};
constexpr double kSdsMax = 6;    // errors beyond so many count as that: one wild answer must not carry a slope
constexpr double kSdMin = 0.05;  // of errors that hardly vary, as of sex where all are right: they go with nothing

using Errors = std::array<double, kErrorCount>;

Errors errors_of(const Outcome& o) {
  const auto sds = error_sds(o.answer, o.age);
  Errors errors{};
  for (std::size_t m = 0; m < kMeasurementCount; ++m)
    errors[m] = (static_cast<double>(o.truth[m]) - static_cast<double>(o.answer.measurements[m].value)) / sds[m];
  errors[kSexError] = ((o.woman ? 1.0 : 0.0) - static_cast<double>(o.answer.female)) / sds[kSexError];
  errors[kAgeError] =
      (static_cast<double>(o.true_age_years) - static_cast<double>(o.age.years.value)) / sds[kAgeError];
  for (double& e : errors) e = std::clamp(e, -kSdsMax, kSdsMax);
  return errors;
}

void print(const std::vector<Errors>& rows) {
  const auto count = static_cast<double>(rows.size());
  Errors mean{}, sd{};
  for (const Errors& e : rows)
    for (std::size_t i = 0; i < kErrorCount; ++i) mean[i] += e[i] / count;
  const auto covariance = [&](std::size_t i, std::size_t j) {
    double sum = 0;
    for (const Errors& e : rows) sum += (e[i] - mean[i]) * (e[j] - mean[j]);
    return sum / count;
  };
  for (std::size_t i = 0; i < kErrorCount; ++i) sd[i] = std::sqrt(covariance(i, i));
  std::printf("// %zu people\n{{", rows.size());
  for (std::size_t i = 0; i < kErrorCount; ++i) {
    std::printf("%s{", i > 0 ? "},\n " : "");
    for (std::size_t j = 0; j < kErrorCount; ++j) {
      const bool varies = sd[i] > kSdMin && sd[j] > kSdMin;
      const double correlation = i == j ? 1 : varies ? covariance(i, j) / (sd[i] * sd[j]) : 0;
      std::printf("%s%.2fF", j > 0 ? ", " : "", correlation);
    }
  }
  std::printf("}}},\n");
}

int failed(const Error& error) {
  std::fprintf(stderr, "im2fit-lab make error-correlation: %s\n", error.message.c_str());
  return 1;
}

int print_tables(const char* body_path, const char* tracker_path, const char* index_path, int people) {
  const auto model = load_body(body_path);
  if (!model) return failed(model.error());
  const auto tracker = Tracker::load(tracker_path);
  if (!tracker) return failed(tracker.error());
  const auto index = load_index(index_path);
  if (!index) return failed(index.error());
  std::array<std::vector<Errors>, kErrorTableCount> rows;
  for (const char* name : kConditions) {
    EvaluationOptions options;
    options.subjects = people;
    options.seed = kSeed;
    options.family = PeopleFamily::unlike;
    options.threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
    const auto condition = condition_of(name, options);
    if (!condition) return failed(condition.error());
    std::fprintf(stderr, "%s: %d people\n", name, people);
    const auto outcomes = evaluate(*model, tracker->model(), *index, nullptr, condition->options);
    if (!outcomes) return failed(outcomes.error());
    for (const Outcome& o : *outcomes)
      if (o.measured) rows[error_table_of(o.answer)].push_back(errors_of(o));
  }
  std::printf(
      "// Made by im2fit-lab make error-correlation of %d people a condition, index of %zu people; see\n"
      "// estimate/known_facts.h.\n// clang-format off\n",
      people, index->size());
  for (const auto& table : rows) {
    if (table.size() < 2 * kErrorCount)
      return failed({ErrorCode::invalid_argument, "too few people were measured: give more PEOPLE"});
    print(table);
  }
  return 0;
}

}  // namespace

namespace im2fit::apps {

int make_error_correlation(int argc, char** argv) {
  int people = kPeople;
  bool right = argc == 4 || argc == 5;
  if (argc == 5) {
    const std::string_view word = argv[4];
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), people);
    right = error == std::errc{} && end == word.data() + word.size() && people > 0;
  }
  if (!right) {
    std::fprintf(stderr,
                 "im2fit-lab make error-correlation BODY.i2b TRACKER.i2t INDEX.i2f [PEOPLE] > "
                 "estimate/error_correlation.inc\n");
    return 2;
  }
  return print_tables(argv[1], argv[2], argv[3], people);
}

}  // namespace im2fit::apps
