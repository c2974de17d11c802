// SPDX-License-Identifier: Apache-2.0
#include "kernels/components/components.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <utility>

#include "kernels/components/links.h"

namespace im2fit {
namespace {

std::size_t at(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

// Eight link bytes that all have `bits`.
constexpr std::int32_t kTogether = 8;
constexpr std::uint64_t kEach = 0x0101010101010101U;
bool all(const std::uint8_t* links, std::uint8_t bits) {
  std::uint64_t word = 0;
  std::memcpy(&word, links, sizeof word);
  return (~word & kEach * bits) == 0;
}

}  // namespace

Components::Components(int width, int height)
    : width_(width),
      height_(height),
      surface_(at(width) * at(height)),
      limit_(surface_.size()),
      links_(surface_.size()),
      start_(surface_.size()),
      parent_(surface_.size()),
      size_(surface_.size()),
      label_(surface_.size()),
      runs_(surface_.size()) {}

std::int32_t Components::root(std::int32_t start) {
  while (parent_[at(start)] != start) {
    parent_[at(start)] = parent_[at(parent_[at(start)])];
    start = parent_[at(start)];
  }
  return start;
}

void Components::unite(std::int32_t a, std::int32_t b) {
  a = root(start_[at(a)]);
  b = root(start_[at(b)]);
  if (a == b) return;
  if (a > b) std::swap(a, b);  // the earliest cell is the root: labels come in reading order
  parent_[at(b)] = a;
}

// Cells of a row that are joined, from left to right. Closed cells are in none.
void Components::list_runs() {
  run_count_ = 0;
  for (std::int32_t r = 0; r < height_; ++r) {
    const std::int32_t end = (r + 1) * width_;
    for (std::int32_t i = r * width_; i < end; ++i) {
      if (surface_[at(i)] == 0) continue;
      const std::int32_t first = i;
      while (i + kTogether < end && all(&links_[at(i)], kLinkRight)) i += kTogether;
      while ((links_[at(i)] & kLinkRight) != 0) ++i;
      parent_[at(first)] = first;
      size_[at(first)] = 0;
      std::fill(start_.begin() + first, start_.begin() + i + 1, first);
      runs_[at(run_count_++)] = {first, i + 1 - first};
    }
  }
}

// Rosenfeld and Pfaltz 1966 with union-find over runs. Links that others imply (down beside a down link, across a
// square's diagonal) are skipped, so that a solid surface costs one union a run and row.
void Components::join() {
  const auto has = [&](std::int32_t cell, std::uint8_t bit) { return (links_[at(cell)] & bit) != 0; };
  for (std::int32_t k = 0; k < run_count_; ++k) {
    const std::int32_t begin = runs_[at(k)].first, end = begin + runs_[at(k)].count;
    for (std::int32_t here = begin; here < end; ++here) {
      const std::int32_t down = here + width_;
      // Within a square whose upper cell to the left is this run's: down there and one run below is down here.
      while (here > begin && here + kTogether < end && has(here - 1, kLinkDown) && has(down - 1, kLinkRight) &&
             all(&links_[at(here)], kLinkRight | kLinkDown) && all(&links_[at(here + width_)], kLinkRight))
        here += kTogether;
      join_down(here, here > begin);
    }
  }
}

void Components::join_down(std::int32_t here, bool in_run) {
  const std::uint8_t bits = links_[at(here)];
  if ((bits & ~kLinkRight) == 0) return;
  const std::int32_t down = here + width_;
  const auto has = [&](std::int32_t cell, std::uint8_t bit) { return (links_[at(cell)] & bit) != 0; };
  const bool is_down = (bits & kLinkDown) != 0;
  const bool beside = in_run && has(here - 1, kLinkDown) && has(down - 1, kLinkRight);
  if (is_down && !beside) unite(here, down);
  if ((bits & kLinkDownLeft) != 0 && !(is_down && has(down - 1, kLinkRight))) unite(here, down - 1);
  if ((bits & kLinkDownRight) != 0 && !(is_down && has(down, kLinkRight))) unite(here, down + 1);
  if ((bits & kLinkRightOverHole) != 0) unite(here, here + 2);
  if ((bits & kLinkDownOverHole) != 0) unite(here, down + width_);
}

void Components::find_surfaces(std::span<const std::uint16_t> depth, std::span<const std::uint8_t> open) {
  const std::uint16_t* z_of = depth.data();
  const std::uint8_t* is_open = open.data();
  std::uint16_t* __restrict surface = surface_.data(), * __restrict limits = limit_.data();
  for (std::size_t i = 0, count = surface_.size(); i < count; ++i) {
    const std::int32_t z = is_open[i] != 0 ? z_of[i] : 0;
    const float mm = static_cast<float>(z);
    // No depth has a whole number for its limit: less than it is at most its whole part.
    const float limit = 40.0F + 1.5F * (2.85e-6F * mm * mm);
    surface[i] = static_cast<std::uint16_t>(z);
    limits[i] = static_cast<std::uint16_t>(z != 0 ? static_cast<std::int32_t>(limit) : 0);
  }
}

int Components::run(std::span<const std::uint16_t> depth, std::span<const std::uint8_t> open, int cells_min,
                    int count_max, std::span<std::uint16_t> labels) {
  find_surfaces(depth, open);
  links({depth.data(), surface_.data(), limit_.data(), width_, height_}, links_.data());
  list_runs();
  join();
  const std::span<const Run> all_runs = std::span(runs_).first(at(run_count_));
  for (const Run& run : all_runs) size_[at(root(run.first))] += run.count;
  std::fill(labels.begin(), labels.end(), std::uint16_t{0});
  int count = 0;
  for (const Run& run : all_runs) {
    const std::int32_t top = root(run.first);
    if (top == run.first)
      label_[at(top)] =
          size_[at(top)] >= cells_min && count < count_max ? static_cast<std::uint16_t>(++count) : std::uint16_t{0};
    if (const std::uint16_t label = label_[at(top)]; label != 0)
      std::fill_n(labels.begin() + run.first, run.count, label);
  }
  return count;
}

}  // namespace im2fit
