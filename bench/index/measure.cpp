// SPDX-License-Identifier: Apache-2.0
#include "bench/index/measure.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>

namespace im2fit::bench {
namespace {

constexpr std::size_t kAskedMin = 100;  // for a 99th percentile that is not the maximum of a handful

// Of the thread: the machine may be busy with others' work.
double cpu_us() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

class Budget {
 public:
  explicit Budget(double seconds) : seconds_(seconds) {}
  bool left() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count() < seconds_;
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  double seconds_;
};

double percentile(std::vector<double> values, double share) {
  const auto at = std::min(values.size() - 1, static_cast<std::size_t>(share * static_cast<double>(values.size())));
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(at), values.end());
  return values[at];
}

void add_errors(Errors& errors, const MeasurementValues& found, const MeasurementValues& truth) {
  for (std::size_t k = 0; k < kJudged.size(); ++k) {
    const std::size_t m = measurement_index(kJudged[k]);
    errors[k] += std::abs(static_cast<double>(found[m]) - static_cast<double>(truth[m]));
  }
}

Errors mean(Errors errors, std::size_t count) {
  for (double& e : errors) e /= static_cast<double>(std::max<std::size_t>(count, 1));
  return errors;
}

// Share of the first replies that looking at every model agrees with, bit for bit where values are answered.
std::optional<double> own_recall(Reference& reference, const Exam& exam, const std::vector<Reply>& replies) {
  const Budget budget(exam.seconds / 2);
  std::size_t checked = 0, same = 0;
  for (; checked < replies.size() && (checked < kAskedMin || budget.left()); ++checked) {
    const auto truth = reference.ask_exhaustively({exam.queries[checked].feature, exam.raw[checked]});
    if (!truth) return std::nullopt;
    same += truth->model == replies[checked].model && truth->values == replies[checked].values ? 1 : 0;
  }
  return static_cast<double>(same) / static_cast<double>(checked);
}

}  // namespace

Exam make_exam(const Models& models, const std::vector<index::Sample>& queries, double seconds) {
  Exam exam{models, {}, {}, queries, seconds};
  for (const index::Sample& q : queries) exam.raw.push_back(models.query(q.feature));
  const ExactNearest exact(models);
  const Budget budget(2 * seconds);
  for (const auto& raw : exam.raw) {
    if (exam.raw_nearest.size() >= kAskedMin && !budget.left()) break;
    exam.raw_nearest.push_back(exact.nearest(raw, kAveraged));
  }
  return exam;
}

Times timed(std::size_t count, double seconds, const std::function<void(std::size_t)>& ask,
            const std::function<bool(std::size_t)>& judge) {
  std::vector<double> us;
  us.reserve(count);
  const Budget budget(seconds);
  for (std::size_t q = 0; q < count && (q < kAskedMin || budget.left()); ++q) {
    const double start = cpu_us();
    ask(q);
    us.push_back(cpu_us() - start);
    if (!judge(q)) break;
  }
  return {percentile(us, 0.5), percentile(us, 0.99)};
}

Row measure(Reference& reference, const Exam& exam) {
  Row row;
  row.reference = reference.name();
  row.note = reference.note();
  row.models = exam.models.size();
  row.densified = exam.models.densified_count();
  row.bytes_a_model = reference.bytes() / static_cast<double>(row.models);
  std::vector<Reply> replies;
  replies.reserve(exam.queries.size());
  Reply reply;
  const Times times = timed(
      exam.queries.size(), exam.seconds,
      [&](std::size_t q) {
        reply = reference.ask({exam.queries[q].feature, exam.raw[q]});
      },
      [&](std::size_t) {
        replies.push_back(reply);
        return true;
      });
  row.queries = replies.size();
  row.p50_us = times.p50_us;
  row.p99_us = times.p99_us;

  Errors error{}, error_of_nearest{};
  std::size_t right = 0;
  const std::size_t judged = std::min(replies.size(), exam.raw_nearest.size());
  for (std::size_t q = 0; q < replies.size(); ++q) {
    const Reply& r = replies[q];
    const MeasurementValues& truth = exam.queries[q].truth;
    add_errors(error, r.values ? *r.values : exam.models.truth(r.model), truth);
    if (r.nearest_values) add_errors(error_of_nearest, *r.nearest_values, truth);
    if (q < judged && r.model == exam.raw_nearest[q].front()) ++right;
  }
  row.error = mean(error, replies.size());
  if (!replies.empty() && replies.front().nearest_values) {
    row.error_of_nearest = mean(error_of_nearest, replies.size());
  } else {
    row.recall_raw = static_cast<double>(right) / static_cast<double>(judged);
  }
  row.recall_own = own_recall(reference, exam, replies);
  if (!row.recall_own) row.recall_own = row.recall_raw;
  return row;
}

Row untimed_row(const Exam& exam, std::size_t averaged) {
  Row row;
  row.reference = "brute force, " + std::to_string(exam.models.width()) + " float";
  if (averaged > 1) row.reference += ", mean of " + std::to_string(averaged);
  row.kind = "untimed";
  row.note = "error only";
  row.models = exam.models.size();
  row.densified = exam.models.densified_count();
  row.queries = exam.raw_nearest.size();
  for (std::size_t q = 0; q < exam.raw_nearest.size(); ++q) {
    const std::size_t count = std::min(averaged, exam.raw_nearest[q].size());
    MeasurementValues sum{};
    for (std::size_t k = 0; k < count; ++k) {
      const MeasurementValues values = exam.models.truth(exam.raw_nearest[q][k]);
      for (std::size_t m = 0; m < kMeasurementCount; ++m) sum[m] += values[m] / static_cast<float>(count);
    }
    add_errors(row.error, sum, exam.queries[q].truth);
  }
  row.error = mean(row.error, row.queries);
  return row;
}

}  // namespace im2fit::bench
