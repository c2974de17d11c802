// SPDX-License-Identifier: Apache-2.0
#include "train/population/start_body_picker.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <utility>

#include "body/fit/nearest_start.h"
#include "body/measure.h"
#include "train/common/parallel.h"
#include "train/population/drawn_people.h"

namespace im2fit::lab {
namespace {

std::vector<body::StartBody> pick(std::vector<body::StartBody> people, bool woman, std::size_t count) {
  const body::MeasurementDistance distance(woman);
  const std::size_t n = people.size();
  std::vector<double> apart(n * n);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j) apart[i * n + j] = distance.squared(people[i].measured, people[j].measured);
  std::vector<double> nearest(n, std::numeric_limits<double>::max());
  std::vector<body::StartBody> picked;
  while (picked.size() < std::min(count, n)) {
    std::size_t best = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < n; ++i) {
      double sum = 0;
      for (std::size_t j = 0; j < n; ++j) sum += std::min(nearest[j], apart[i * n + j]);
      if (sum < least) {
        least = sum;
        best = i;
      }
    }
    for (std::size_t j = 0; j < n; ++j) nearest[j] = std::min(nearest[j], apart[best * n + j]);
    picked.push_back(people[best]);
  }
  return picked;
}

}  // namespace

PickedStartBodies pick_start_bodies(const body::BodyModel& model, const StartBodyOptions& options) {
  std::vector<body::StartBody> men(static_cast<std::size_t>(options.people) / 2), women(men.size());
  for_each_item(2 * static_cast<int>(men.size()), options.threads, [&](int i) {
    const auto number = static_cast<std::uint64_t>(i);
    body::StartBody person;
    person.params = body::draw_person(model, body::Family::training, options.seed, number).params;
    person.measured = body::measure_person(model, person.params);
    (i % 2 == 1 ? women : men)[static_cast<std::size_t>(i) / 2] = std::move(person);
  });
  const auto of_a_sex = static_cast<std::size_t>(options.starts) / 2;
  return {pick(std::move(men), false, of_a_sex), pick(std::move(women), true, of_a_sex)};
}

}  // namespace im2fit::lab
