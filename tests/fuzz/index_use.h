// SPDX-License-Identifier: Apache-2.0
// Every query an index has, made of a file that may be damaged.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "core/rng.h"
#include "index/index.h"
#include "train/index/builder.h"

namespace im2fit::fuzz {

// A small sound index: 60 people of 12 features, and mixes of them.
inline std::vector<std::byte> small_index() {
  std::vector<index::Sample> samples(60);
  Rng rng(3);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    index::Sample& s = samples[i];
    s.subject = i;
    s.woman = i % 2 == 1;
    for (int f = 0; f < 12; ++f) s.feature.push_back(static_cast<float>(rng.normal(5, 2)));
    for (std::size_t m = 0; m < kMeasurementCount; ++m)
      s.truth[m] = static_cast<float>(1000 + 20 * static_cast<double>(s.feature[m]) + rng.normal(0, 10));
  }
  index::BuildOptions options;
  options.provenance = "small";
  options.densify_to = 1500;  // several leaves
  auto bytes = index::build_index(options, index::source_of(samples));
  return bytes ? std::move(*bytes) : std::vector<std::byte>{};
}

// The answers to a few features; nothing when the file is refused, or was found damaged where it was read. `sane`:
// every number is finite and every interval ordered, which a file that was accepted must keep to.
// `verified`: what looking at all of it says.
struct Answers {
  std::vector<index::Answer> answers;
  bool sane = true;
  bool verified = false;
};
inline std::optional<Answers> use_index(std::vector<std::byte> bytes) {
  const auto index = index::Index::parse(std::move(bytes), "fuzzed.i2f");
  if (!index) return std::nullopt;
  Answers out;
  const auto scratch = index->make_scratch();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::vector<std::vector<float>> features = {std::vector<float>(index->feature_size(), 5.0F),
                                              std::vector<float>(index->feature_size(), nan),
                                              std::vector<float>(index->feature_size(), -3e38F),
                                              {}};
  for (std::size_t i = 0; i < features[0].size(); ++i) features[0][i] += static_cast<float>(i % 5) - 2;
  for (const auto& feature : features) {
    for (const bool exhaustive : {false, true}) {
      const auto answer =
          index->query(feature, {.neighbour_count = 0, .frame_count = 3, .exhaustive = exhaustive}, *scratch);
      if (!answer) return std::nullopt;
      const index::Answer& a = *answer;
      for (const index::IntervalEstimate& e : a.measurements)
        out.sane &= std::isfinite(e.value) && std::isfinite(e.low) && std::isfinite(e.high) && e.low <= e.high;
      out.sane &= a.female >= 0 && a.female <= 1 && a.nearest < index->size();
      const auto values = index->measurements_of(a.nearest);
      if (!values) return std::nullopt;
      for (const float v : *values) out.sane &= std::isfinite(v);
      (void)index->person_of(a.nearest);
      (void)index->age_of(a.nearest);
      out.answers.push_back(a);
    }
  }
  (void)index->sections();
  out.verified = static_cast<bool>(index->verify(2));
  return out;
}

}  // namespace im2fit::fuzz
