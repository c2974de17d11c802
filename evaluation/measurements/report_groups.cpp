// SPDX-License-Identifier: Apache-2.0
#include "evaluation/measurements/report_groups.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <span>

namespace im2fit::lab {
namespace {

double error_of(const Outcome& o, std::size_t m) {
  return static_cast<double>(o.answer.measurements[m].value) - static_cast<double>(o.truth[m]);
}

GroupReport group_of(std::string name, std::span<const Outcome* const> people) {
  GroupReport group;
  group.name = std::move(name);
  group.people = static_cast<int>(people.size());
  const auto n = static_cast<double>(people.size());
  group.mass_index_low = 1e9;
  for (const Outcome* o : people) {
    group.mass_index_low = std::min(group.mass_index_low, mass_index_of(*o));
    group.mass_index_high = std::max(group.mass_index_high, mass_index_of(*o));
    for (std::size_t m = 0; m < kMeasurementCount; ++m) {
      const index::IntervalEstimate& e = o->answer.measurements[m];
      group.rows[m].bias += error_of(*o, m) / n;
      group.rows[m].mae += std::fabs(error_of(*o, m)) / n;
      if (o->truth[m] >= e.low && o->truth[m] <= e.high) group.rows[m].coverage += 1 / n;
    }
  }
  return group;
}

}  // namespace

double mass_index_of(const Outcome& outcome) {
  const double metres = static_cast<double>(outcome.truth[measurement_index(Measurement::stature)]) / 1000;
  return metres > 0 ? static_cast<double>(outcome.truth[measurement_index(Measurement::weight)]) / (metres * metres)
                    : 0;
}

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

IndexSlope index_slope(const std::vector<const Outcome*>& measured, std::size_t measurement) {
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

}  // namespace im2fit::lab
