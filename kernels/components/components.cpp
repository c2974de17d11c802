// SPDX-License-Identifier: Apache-2.0
#include "kernels/components/components.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "kernels/components/links.h"

namespace im2fit {
namespace {

std::size_t at(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

}  // namespace

Components::Components(int width, int height)
    : width_(width),
      height_(height),
      surface_(at(width) * at(height)),
      limit_(surface_.size()),
      links_(surface_.size()),
      parent_(surface_.size()),
      size_(surface_.size()) {}

std::int32_t Components::root(std::int32_t cell) {
  while (parent_[at(cell)] != cell) {
    parent_[at(cell)] = parent_[at(parent_[at(cell)])];
    cell = parent_[at(cell)];
  }
  return cell;
}

void Components::unite(std::int32_t a, std::int32_t b) {
  a = root(a);
  b = root(b);
  if (a == b) return;
  if (a > b) std::swap(a, b);  // the earliest cell is the root: labels come in reading order
  parent_[at(b)] = a;
}

// Rosenfeld and Pfaltz 1966 with union-find. A cell joins the run to its left at once; links that others imply (down
// beside a down link, across a square's diagonal) are skipped, so that a solid surface costs one union a run and row.
void Components::join() {
  for (std::int32_t r = 0; r < height_; ++r) {
    const std::int32_t first = r * width_;
    for (std::int32_t i = first; i < first + width_; ++i)
      parent_[at(i)] = i > first && (links_[at(i - 1)] & kLinkRight) != 0 ? parent_[at(i - 1)] : i;
  }
  const auto has = [&](std::int32_t cell, std::uint8_t bit) { return (links_[at(cell)] & bit) != 0; };
  for (std::int32_t r = 0; r < height_; ++r) {
    for (std::int32_t c = 0; c < width_; ++c) {
      const std::int32_t here = r * width_ + c, down = here + width_;
      const std::uint8_t bits = links_[at(here)];
      if ((bits & ~kLinkRight) == 0) continue;
      const bool is_down = (bits & kLinkDown) != 0;
      const bool beside = c > 0 && has(here - 1, kLinkRight) && has(here - 1, kLinkDown) && has(down - 1, kLinkRight);
      if (is_down && !beside) unite(here, down);
      if ((bits & kLinkDownLeft) != 0 && !(is_down && has(down - 1, kLinkRight))) unite(here, down - 1);
      if ((bits & kLinkDownRight) != 0 && !(is_down && has(down, kLinkRight))) unite(here, down + 1);
      if ((bits & kLinkRightOverHole) != 0) unite(here, here + 2);
      if ((bits & kLinkDownOverHole) != 0) unite(here, down + width_);
    }
  }
}

int Components::run(std::span<const std::uint16_t> depth, std::span<const std::uint8_t> open, int cells_min,
                    int count_max, std::span<std::uint16_t> labels) {
  const auto cells = static_cast<std::int32_t>(surface_.size());
  for (std::size_t i = 0; i < surface_.size(); ++i) {
    const std::int32_t z = open[i] != 0 ? depth[i] : 0;
    const float mm = static_cast<float>(z);
    // No depth has a whole number for its limit: less than it is at most its whole part.
    const float limit = 40.0F + 1.5F * (2.85e-6F * mm * mm);
    surface_[i] = static_cast<std::uint16_t>(z);
    limit_[i] = static_cast<std::uint16_t>(z != 0 ? static_cast<std::int32_t>(limit) : 0);
  }
  links({depth.data(), surface_.data(), limit_.data(), width_, height_}, links_.data());
  join();
  std::fill(size_.begin(), size_.end(), 0);
  for (std::int32_t i = 0; i < cells; ++i) {
    parent_[at(i)] = root(i);
    size_[at(parent_[at(i)])] += surface_[at(i)] != 0 ? 1 : 0;
  }
  int count = 0;
  for (std::int32_t i = 0; i < cells; ++i) {
    const std::int32_t top = parent_[at(i)];
    std::uint16_t label = 0;
    if (top != i)
      label = labels[at(top)];
    else if (surface_[at(i)] != 0 && size_[at(i)] >= cells_min && count < count_max)
      label = static_cast<std::uint16_t>(++count);
    labels[at(i)] = label;
  }
  return count;
}

}  // namespace im2fit
