// SPDX-License-Identifier: Apache-2.0
// Nearest-neighbour search among places of a pattern: rims, seams and the edges a garment hangs from.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "garment/pattern.h"

namespace im2fit::body {

// Consecutive places lie near each other, as along an outline, and so do consecutive queries: bounding boxes of a few
// places each exclude most places. Not shareable between threads.
class FlatPlaces {
 public:
  struct Nearest {
    float squared_mm = 1e30F;
    std::int32_t vertex = -1;  // -1: no places
  };

  void add(Flat place, std::size_t vertex);
  // Of places equally near the one added first.
  Nearest nearest(Flat to);

 private:
  struct Box {
    Flat low, high;
  };
  static constexpr std::size_t kBlock = 8;
  std::vector<Flat> places_;
  std::vector<std::int32_t> vertices_;
  std::vector<Box> boxes_;  // about each kBlock places
  std::size_t last_ = 0;    // found by the question before
};

}  // namespace im2fit::body
