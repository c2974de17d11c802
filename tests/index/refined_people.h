// SPDX-License-Identifier: Apache-2.0
// Synthetic people with a known fit and a known view from behind as well.
#pragma once

#include <limits>

#include "tests/index/synthetic_people.h"

namespace im2fit::index::testing {

inline constexpr std::size_t kWaist = measurement_index(Measurement::waist_girth);
inline constexpr double kBendMm = 25;  // of the waist, by a product of two shapes

// The fit shows the shape with an error of 0.12 standard deviations, the fit of both views with one of 0.04.
inline Sample turned(const World& world, std::uint64_t subject) {
  Sample s = world.sample(subject, 0, 3);
  const Eigen::VectorXd shape = world.shape_of(subject);
  s.truth[kWaist] += static_cast<float>(kBendMm * shape(1) * shape(2));
  s.back = world.sample(subject, 1, 3).feature;
  Rng rng = Rng::for_item(99, 5, subject);
  s.fit_layout.shapes = static_cast<std::uint32_t>(world.shapes);
  for (const auto& [fit, sd] : {std::pair(&s.fit, 0.12), std::pair(&s.fit_both, 0.04)}) {
    for (int i = 0; i < world.shapes; ++i) fit->push_back(static_cast<float>(shape(i) + rng.normal(0, sd)));
  }
  return s;
}

// A person whose waist is by a normal of 20 mm wider than shape and features show, which value `shown_at` of what
// fits tell of views shows to 1 mm: 0 is the front's first patch, 2 * patches its first value of limbs. Those of the
// back are not seen from the front.
inline Sample turned_with_views(const World& world, std::uint64_t subject, std::uint32_t patches, std::uint32_t limbs,
                                std::size_t shown_at) {
  Sample s = turned(world, subject);
  Rng rng = Rng::for_item(99, 6, subject);
  const double wider_mm = rng.normal(0, 20);
  s.truth[kWaist] += static_cast<float>(wider_mm);
  s.fit_layout.patches = patches;
  s.fit_layout.limbs = limbs;
  for (auto* fit : {&s.fit, &s.fit_both}) {
    for (const std::uint32_t count : {patches, limbs})
      for (std::uint32_t i = 0; i < 2 * count; ++i)
        fit->push_back(i < count || fit == &s.fit_both ? static_cast<float>(rng.normal())
                                                       : std::numeric_limits<float>::quiet_NaN());
    (*fit)[s.fit_layout.shapes + shown_at] = static_cast<float>(wider_mm + rng.normal());
  }
  return s;
}

}  // namespace im2fit::index::testing
