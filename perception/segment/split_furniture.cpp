// SPDX-License-Identifier: Apache-2.0
// A cupboard or a box that a hand touches is one surface with the person, and its corner lies where no person's can.
#include "perception/segment/blobs.h"

// The thresholds of this file: what each bounds and where it comes from. Source:
//   [touch] a person whose hand touches a box is found, arms and legs apart stay whole (tests/perception/
//           segment_furniture_test.cpp); no other measurement on record
namespace im2fit::segment::split_furniture_limits {

constexpr float kBesideMm = 500.0F;   // from the head sideways, least: further than a trunk's sides; [touch]
constexpr float kNearestMm = 300.0F;  // what is upright further out is taken to here, least: legs are; [touch]
constexpr float kLowMm = 450.0F;      // above the floor: what begins lower stands on it, or is a leg; [touch]
constexpr float kUprightMm = 500.0F;  // of a column, least: an arm or a slanting leg has 250 there; [touch]

}  // namespace im2fit::segment::split_furniture_limits

namespace im2fit::segment {

using namespace split_furniture_limits;

namespace {

std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

}  // namespace

// Whether the blob's cells of a column begin near the floor and rise further than a leg's or an arm's can there.
bool BlobFinder::rises_from_floor(const Grid& grid, int b, int c) const {
  const auto label = static_cast<std::uint16_t>(b + 1);
  float tall_mm = 0;
  bool low = false;
  for (int r = blobs_[at(b)].r_min; r <= blobs_[at(b)].r_max; ++r) {
    const auto cell = at(grid.index(c, r));
    if (labels_[cell] != label) continue;
    tall_mm += static_cast<float>(grid.step) * static_cast<float>(grid.depth[cell]) / grid.intrinsics.fy;
    low = low || grid.height_mm[cell] < kLowMm;
  }
  return low && tall_mm > kUprightMm;
}

// Takes columns of cells on one side of a head from its blob: from where they rise from the floor on.
bool BlobFinder::detach_side(const Grid& grid, const Head& head, int side) {
  const Blob& blob = blobs_[at(head.blob)];
  const float cell_mm = static_cast<float>(grid.step) * head.top_mm.z / grid.intrinsics.fx;
  const int last = side < 0 ? blob.c_min : blob.c_max;
  const auto rises = [&](int c) { return rises_from_floor(grid, head.blob, c); };
  int first = head.c + side * static_cast<int>(kBesideMm / cell_mm);
  while ((last - first) * side > 0 && !(rises(first) && rises(first + side))) first += side;
  if ((last - first) * side <= 0) return false;
  const int nearest = head.c + side * static_cast<int>(kNearestMm / cell_mm);
  while ((first - nearest) * side > 0 && rises(first - side)) first -= side;
  const auto own = static_cast<std::uint16_t>(head.blob + 1);
  const auto other = static_cast<std::uint16_t>(++blob_count_);
  for (int r = blob.r_min; r <= blob.r_max; ++r)
    for (int c = first; (last - c) * side >= 0; c += side)
      if (std::uint16_t& cell = labels_[at(grid.index(c, r))]; cell == own) cell = other;
  return true;
}

void BlobFinder::detach_furniture(const Grid& grid, const FloorPlane& floor) {
  if (!floor.known) return;
  bool detached = false;
  for (int h = 0; h < head_count_; ++h)
    for (const int side : {-1, 1})
      if (heads_[at(h)].seen && blob_count_ < kBlobCountMax)
        detached = detach_side(grid, heads_[at(h)], side) || detached;
  if (detached) describe(grid);
}

}  // namespace im2fit::segment
