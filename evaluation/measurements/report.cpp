// SPDX-License-Identifier: Apache-2.0
#include "evaluation/measurements/report.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "person/size_chart.h"

namespace im2fit::lab {
namespace {

// Kilograms over square metres, of the truth; 0 without a stature.
double mass_index_of(const Outcome& outcome) {
  const double metres = static_cast<double>(outcome.truth[measurement_index(Measurement::stature)]) / 1000;
  return metres > 0 ? static_cast<double>(outcome.truth[measurement_index(Measurement::weight)]) / (metres * metres)
                    : 0;
}

double error_of(const Outcome& o, std::size_t m) {
  return static_cast<double>(o.answer.measurements[m].value) - static_cast<double>(o.truth[m]);
}

std::vector<const Outcome*> of_known_truth(std::span<const Outcome* const> people, std::size_t m) {
  std::vector<const Outcome*> known;
  std::copy_if(people.begin(), people.end(), std::back_inserter(known),
               [m](const Outcome* o) { return std::isfinite(o->truth[m]); });
  return known;
}

GroupReport group_of(std::string name, std::span<const Outcome* const> people) {
  GroupReport group;
  group.name = std::move(name);
  group.people = static_cast<int>(people.size());
  group.mass_index_low = 1e9;
  for (const Outcome* o : people) {
    group.mass_index_low = std::min(group.mass_index_low, mass_index_of(*o));
    group.mass_index_high = std::max(group.mass_index_high, mass_index_of(*o));
  }
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    GroupReport::Row& row = group.rows[m];
    const std::vector<const Outcome*> known = of_known_truth(people, m);
    row.people = static_cast<int>(known.size());
    const auto n = static_cast<double>(known.size());
    for (const Outcome* o : known) {
      const index::IntervalEstimate& e = o->answer.measurements[m];
      row.bias += error_of(*o, m) / n;
      row.mae += std::fabs(error_of(*o, m)) / n;
      if (o->truth[m] >= e.low && o->truth[m] <= e.high) row.coverage += 1 / n;
    }
  }
  return group;
}

// Men then women, each in thirds of their number by body mass index, the lightest first; then each family where there
// are several. Empty groups are left out.
std::vector<GroupReport> groups_of(const std::vector<const Outcome*>& measured) {
  std::vector<GroupReport> groups;
  for (const bool woman : {false, true}) {
    std::vector<const Outcome*> people;
    std::copy_if(measured.begin(), measured.end(), std::back_inserter(people),
                 [&](const Outcome* o) { return o->woman == woman; });
    std::stable_sort(people.begin(), people.end(),
                     [](const Outcome* a, const Outcome* b) { return mass_index_of(*a) < mass_index_of(*b); });
    for (std::size_t third = 0; third < 3; ++third) {
      const std::size_t first = third * people.size() / 3, last = (third + 1) * people.size() / 3;
      if (first == last) continue;
      groups.push_back(group_of("", std::span(people).subspan(first, last - first)));
      groups.back().name = fmt::format("{}, BMI {:.1f} to {:.1f}", woman ? "women" : "men",
                                       groups.back().mass_index_low, groups.back().mass_index_high);
    }
  }
  const auto of_family = [&](PeopleFamily family) {
    std::vector<const Outcome*> people;
    std::copy_if(measured.begin(), measured.end(), std::back_inserter(people),
                 [&](const Outcome* o) { return o->family == family; });
    return people;
  };
  for (const PeopleFamily family : {PeopleFamily::ansur, PeopleFamily::modifiers})
    if (const auto people = of_family(family); !people.empty() && people.size() < measured.size())
      groups.push_back(group_of(fmt::format("all of {}", name_of(family)), people));
  return groups;
}

// Least squares of the error on body mass index over all people; zeros for fewer than three or where none differ.
IndexSlope index_slope(const std::vector<const Outcome*>& people, std::size_t measurement) {
  const std::vector<const Outcome*> measured = of_known_truth(people, measurement);
  const auto n = static_cast<double>(measured.size());
  if (measured.size() < 3) return {};
  double index_mean = 0, error_mean = 0;
  for (const Outcome* o : measured) {
    index_mean += mass_index_of(*o) / n;
    error_mean += error_of(*o, measurement) / n;
  }
  double xx = 0, xy = 0, yy = 0;
  for (const Outcome* o : measured) {
    const double x = mass_index_of(*o) - index_mean, y = error_of(*o, measurement) - error_mean;
    xx += x * x, xy += x * y, yy += y * y;
  }
  if (!(xx > 0)) return {};
  const double slope = xy / xx;
  return {slope, std::sqrt(std::max(0.0, yy - slope * xy) / (n - 2) / xx)};
}

// `sds`: how far the interval of 95 % reaches when it is read as a normal's of that many standard deviations.
bool covers(const index::IntervalEstimate& estimate, double truth, double sds) {
  const double scale = sds / kLevels[kStatedLevel].sds;
  return truth >= estimate.value - scale * (estimate.value - estimate.low) &&
         truth <= estimate.value + scale * (estimate.high - estimate.value);
}

MeasurementReport measurement_report(const std::vector<const Outcome*>& measured, std::size_t m) {
  MeasurementReport report;
  std::array<std::vector<double>, kEstimatorCount> errors;
  std::vector<std::array<double, 2>> with_truth, with_itself;
  std::vector<double> widths;
  for (const Outcome* o : measured)
    if (o->measured_again) with_itself.push_back({o->answer.measurements[m].value, o->again[m]});
  const std::vector<const Outcome*> known = of_known_truth(measured, m);
  const auto n = static_cast<double>(known.size());
  for (const Outcome* o : known) {
    const double truth = o->truth[m];
    const index::IntervalEstimate& estimate = o->answer.measurements[m];
    for (std::size_t estimator = 0; estimator < kEstimatorCount; ++estimator)
      errors[estimator].push_back(value_of(*o, static_cast<Estimator>(estimator), m) - truth);
    with_truth.push_back({estimate.value, truth});
    for (std::size_t level = 0; level < kLevels.size(); ++level) {
      // The stated interval to the bit, not recomputed from its scale.
      const bool inside = level == kStatedLevel ? truth >= estimate.low && truth <= estimate.high
                                                : covers(estimate, truth, kLevels[level].sds);
      if (inside) report.covered[level] += 1 / n;
    }
    report.interval_width += (estimate.high - estimate.low) / n;
    widths.push_back(static_cast<double>(estimate.high) - static_cast<double>(estimate.low));
  }
  report.interval_width_median = box_statistics(widths).median;
  for (std::size_t estimator = 0; estimator < kEstimatorCount; ++estimator)
    report.errors[estimator] = error_statistics(errors[estimator]);
  report.agreement = agreement(with_truth);
  report.repeatability = repeatability(with_itself);
  return report;
}

template <class Predicate>
double share_of(const std::vector<const Outcome*>& outcomes, const Predicate& holds) {
  if (outcomes.empty()) return 0;
  return static_cast<double>(std::count_if(outcomes.begin(), outcomes.end(), holds)) /
         static_cast<double>(outcomes.size());
}

void add_joints(const std::vector<Outcome>& outcomes, Report& report) {
  double sum_mm = 0;
  double count = 0, within = 0;
  for (const Outcome& o : outcomes) {
    sum_mm += o.joint_error_sum_mm;
    count += o.joint_count;
    within += o.joints_within_100mm;
  }
  report.joint_error_mm = count > 0 ? sum_mm / count : 0;
  report.joints_within_100mm = count > 0 ? within / count : 0;
}

// The label of a chest girth in the chart of the person's own sex, counted from the smallest (0: below the chart).
int size_number(double chest_mm, const SizeChart& chart) {
  int number = 0;
  for (const SizeRow& row : chart.rows)
    if (chest_mm >= row.low_mm) ++number;
  return chest_mm < chart.rows.back().high_mm ? number : number + 1;
}

const SizeChart& chart_of(bool woman) {
  return woman ? builtin_size_system().women : builtin_size_system().men;
}

// As the answer names it.
std::string label_of(int number, const SizeChart& chart) {
  if (number == 0) return "<" + chart.rows.front().size;
  const auto row = static_cast<std::size_t>(number - 1);
  return row < chart.rows.size() ? chart.rows[row].size : ">" + chart.rows.back().size;
}

constexpr std::size_t kChest = measurement_index(Measurement::chest_girth);

// 0: the true size is the most probable, 1: the next, and so on.
std::size_t size_rank(const Outcome& o) {
  auto answer = size_probabilities(builtin_size_system(), o.answer.measurements[kChest], o.answer.female);
  std::stable_sort(answer.entries.begin(), answer.entries.end(),
                   [](const auto& a, const auto& b) { return a.probability > b.probability; });
  const SizeChart& chart = chart_of(o.woman);
  const std::string truth = label_of(size_number(o.truth[kChest], chart), chart);
  std::size_t rank = 0;
  while (rank < answer.entries.size() && answer.entries[rank].size != truth) ++rank;
  return rank;
}

// By the chest alone, in the person's own chart.
int size_steps_off(const Outcome& o) {
  const SizeChart& chart = chart_of(o.woman);
  const int off = size_number(o.answer.measurements[kChest].value, chart) - size_number(o.truth[kChest], chart);
  return std::clamp(off, -kSizeStepMost, kSizeStepMost);
}

void add_ages(const std::vector<const Outcome*>& measured, Report& report) {
  if (measured.empty()) return;
  for (const Outcome* o : measured) {
    const double error = std::fabs(static_cast<double>(o->age.years.value) - static_cast<double>(o->true_age_years));
    report.age_error_years += error / static_cast<double>(measured.size());
    const auto likeliest = std::max_element(o->age.bands.begin(), o->age.bands.end());
    report.age_band_expected += static_cast<double>(*likeliest) / static_cast<double>(measured.size());
  }
  report.age_coverage = share_of(measured, [](const Outcome* o) {
    return o->age.years.low <= o->true_age_years && o->true_age_years <= o->age.years.high;
  });
  report.age_band_accuracy = share_of(measured, [](const Outcome* o) {
    const auto likeliest = std::max_element(o->age.bands.begin(), o->age.bands.end()) - o->age.bands.begin();
    return static_cast<std::size_t>(likeliest) == age_band_of(o->true_age_years);
  });
}

}  // namespace

double value_of(const Outcome& outcome, Estimator estimator, std::size_t measurement) {
  switch (estimator) {
    case Estimator::ours:
      return outcome.answer.measurements[measurement].value;
    case Estimator::nearest:
      return outcome.answer.nearest_values[measurement];
    case Estimator::raw:
      if (outcome.has_raw) return outcome.raw.values[measurement];
      break;
    case Estimator::paper:
      return outcome.paper[measurement];
  }
  return std::numeric_limits<double>::quiet_NaN();
}

double mean_coverage(const Report& report) {
  double sum = 0;
  int judged = 0;
  for (const MeasurementReport& m : report.measurements) {
    if (!m.judged()) continue;
    sum += m.coverage();
    ++judged;
  }
  return judged > 0 ? sum / judged : 0;
}

double girth_error_mm(const Report& report) {
  double sum = 0;
  for (const Measurement m :
       {Measurement::chest_girth, Measurement::waist_girth, Measurement::hip_girth, Measurement::neck_girth})
    sum += report.measurements[measurement_index(m)].of(Estimator::ours).mae / 4;
  return sum;
}

std::string title_of(const Report& report) {
  return report.family.empty() ? report.condition : report.condition + " of " + report.family;
}

Report report_of(const std::vector<Outcome>& outcomes, const std::string& condition, const std::string& what,
                 const std::string& family) {
  Report report;
  report.condition = condition;
  report.family = family;
  report.what = what;
  report.subjects = static_cast<int>(outcomes.size());
  std::vector<const Outcome*> measured;
  std::vector<const Outcome*> with_raw;
  for (const Outcome& o : outcomes) {
    if (o.measured) measured.push_back(&o);
    if (o.measured && o.lifted_arms) ++report.lifted_arms;
    for (std::size_t fact = 0; fact < kKnownFactCount; ++fact) {
      if (o.measured && (o.known.used >> fact & 1U) != 0) ++report.facts_used[fact];
      if (o.measured && (o.known.doubted >> fact & 1U) != 0) ++report.facts_doubted[fact];
    }
    if (o.measured && o.has_raw) with_raw.push_back(&o);
    for (std::size_t g = 0; g < kGuidanceCount; ++g)
      if (!o.measured && (o.guidance_seen >> g & 1U) != 0) ++report.not_measured_because[g];
  }
  report.measured = static_cast<int>(measured.size());
  for (std::size_t m = 0; m < kMeasurementCount; ++m) report.measurements[m] = measurement_report(measured, m);
  report.sex_accuracy = share_of(measured, [](const Outcome* o) { return (o->answer.female > 0.5F) == o->woman; });
  std::vector<const Outcome*> estimated;
  for (const Outcome* o : measured)
    if (std::isfinite(o->answer.clothing.probability)) estimated.push_back(o);
  report.clothing_estimated = static_cast<int>(estimated.size());
  report.clothing_right =
      share_of(estimated, [](const Outcome* o) { return (o->answer.clothing.probability > 0.5F) == o->dressed; });
  for (const Outcome* o : estimated)
    report.clothing_ease_mm +=
        static_cast<double>(o->answer.clothing.ease_mm) / static_cast<double>(estimated.size());
  report.raw_sex_accuracy = share_of(with_raw, [](const Outcome* o) { return o->raw.woman == o->woman; });
  add_ages(measured, report);
  const std::vector<const Outcome*> sized = of_known_truth(measured, kChest);
  report.size_accuracy = share_of(sized, [](const Outcome* o) { return size_rank(*o) == 0; });
  report.size_top_two = share_of(sized, [](const Outcome* o) { return size_rank(*o) <= 1; });
  for (const Outcome* o : sized) ++report.size_steps[static_cast<std::size_t>(size_steps_off(*o) + kSizeStepMost)];
  report.groups = groups_of(measured);
  for (std::size_t m = 0; m < kMeasurementCount; ++m) report.slopes[m] = index_slope(measured, m);
  add_joints(outcomes, report);
  return report;
}

}  // namespace im2fit::lab
