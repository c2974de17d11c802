// SPDX-License-Identifier: Apache-2.0
// The search alone: who finds the neighbours fastest once our projection has done its part. With the same neighbours
// our regression gives the same answer, so these are the references of equal error.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bench/index/measure.h"

namespace im2fit::bench {

class PlaceSearch {
 public:
  virtual ~PlaceSearch() = default;
  virtual std::string name() const = 0;
  virtual void build(std::vector<float> places, std::size_t dimensions) = 0;
  virtual void find(const float* place, std::span<std::uint32_t> nearest) = 0;
  virtual double bytes() const = 0;
};
std::unique_ptr<PlaceSearch> make_nanoflann_places();
std::unique_ptr<PlaceSearch> make_hnswlib_places();

// `file`: an index over the exam's models. Rows of ours, its exhaustive search, and references over the same places
// as floats; recall_own is the share of the neighbours found, of those exhaustive search finds. `graphs`: hnswlib
// too.
std::vector<Row> search_alone(std::span<const std::byte> file, const Exam& exam, bool graphs);

}  // namespace im2fit::bench
