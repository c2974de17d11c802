// SPDX-License-Identifier: Apache-2.0
// One reference at one size: how fast it answers people it does not know, and how wrong.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/index/reference.h"

namespace im2fit::bench {

// What the errors are of.
inline constexpr std::array<Measurement, 4> kJudged = {Measurement::stature, Measurement::chest_girth,
                                                       Measurement::waist_girth, Measurement::hip_girth};
using Errors = std::array<double, kJudged.size()>;  // mean absolute, mm

struct Row {
  std::string kind, reference, note;
  std::size_t models = 0, densified = 0;
  std::optional<double> build_s, bytes_a_model;
  std::size_t queries = 0;
  std::optional<double> p50_us, p99_us;  // processor time of one thread
  std::optional<double> recall_own;      // the same nearest as by looking at every model in the reference's own space
  std::optional<double> recall_raw;      // the same nearest as by the raw 501 features
  Errors error{};
  std::optional<Errors> error_of_nearest;  // of ours, before the regression
};

inline constexpr std::size_t kAveraged = 32;  // about as many as our own regression uses

// The queries and their right answers at one size.
struct Exam {
  const Models& models;
  std::vector<std::vector<float>> raw;                  // of every query
  std::vector<std::vector<std::uint32_t>> raw_nearest;  // kAveraged of the first so many, as time allowed
  const std::vector<index::Sample>& queries;
  double seconds;  // to spend on queries, for each row; at least a hundred are made
};
Exam make_exam(const Models& models, const std::vector<index::Sample>& queries, double seconds);

struct Times {
  double p50_us = 0, p99_us = 0;
};
// `ask` is timed for query 0, 1, .. `count`-1 until time is up, at least for a hundred; `judge` is not timed, and
// ends it by saying false.
Times timed(std::size_t count, double seconds, const std::function<void(std::size_t)>& ask,
            const std::function<bool(std::size_t)>& judge);

// Every query once, in turn, until time is up.
Row measure(Reference& reference, const Exam& exam);
// Only the errors of a brute-force answer. `averaged`: the mean of this number of nearest models, up to kAveraged.
Row untimed_row(const Exam& exam, std::size_t averaged);

}  // namespace im2fit::bench
