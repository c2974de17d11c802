// SPDX-License-Identifier: Apache-2.0
// Hands, arms and legs that became islands of their own, given back to the person.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "perception/segment/blobs.h"
#include "perception/segment/grid.h"

namespace im2fit::segment {

class SplitLimbJoiner {
 public:
  SplitLimbJoiner();
  // Sets `chosen` to 1 for the cells of blob `person` and of the islands that belong to it, 0 elsewhere.
  void run(const Grid& grid, const Blobs& found, bool floor_known, int person, std::span<std::uint8_t> chosen);

 private:
  enum class Kind : std::uint8_t { no, enclosed, hand, arm, leg };

  void list_candidates(const Grid& grid, std::span<const Blob> list, bool floor_known, int person);
  void scan_along(const Grid& grid, std::span<const std::uint16_t> labels, std::span<const std::uint8_t> chosen,
                  int r_first, int r_last);
  bool belongs(const Blob& blob, std::size_t index, const Blob& body) const;
  void scan_around(const Grid& grid, std::span<const std::uint16_t> labels, std::span<const std::uint8_t> chosen,
                   int c, int r);

  // Per blob.
  std::vector<std::int32_t> touch_, border_;
  std::vector<float> gap_mm_, gap_max_mm_;  // nearest to the person in space
  std::vector<Kind> kind_;
  std::vector<std::int32_t> ends_, held_;  // columns that end, and those that do so on something else
  std::vector<std::int32_t> tops_, hung_;  // columns that begin, and those that do so under the person
};

}  // namespace im2fit::segment
