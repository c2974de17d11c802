// SPDX-License-Identifier: Apache-2.0
// Connected surfaces of the coarse picture: metric size (blobs.cpp), heads (heads.cpp), and which of them are people
// (people.cpp).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/components/components.h"
#include "perception/segment/floor.h"
#include "perception/segment/grid.h"
#include "perception/segment/wall.h"

namespace im2fit::segment {

inline constexpr int kBlobCountMax = 400;
inline constexpr int kHeadCountMax = 8;
inline constexpr float kShapeUnknown = -100.0F;
inline constexpr float kPersonAreaMaxM2 = 2.2F;     // with all that hangs together with a head
inline constexpr float kHeadHeightMaxMm = 2400.0F;  // above the floor
inline constexpr float kFloatingMm = 450.0F;        // above the floor: what ends there ends in the air

struct Blob {
  int cell_count = 0;
  int c_min = 0, c_max = 0, r_min = 0, r_max = 0;  // cells, inclusive
  float area_m2 = 0;                               // as seen from the camera
  float height_min_mm = 0;
  float height_max_mm = 0;
  Vec3f centroid_mm;
  float relief_mm = 0;               // rms distance in depth from the best plane: furniture fronts and walls are flat
  float shape_odds = kShapeUnknown;  // log-odds of a person's shape against furniture's
  bool person = false;
  bool candidate = false;     // no person, but not shaped like furniture either
  bool person_sized = false;  // without a head: might be one
  bool has_head = false;
  Vec3f head_mm;  // cell at the crown, when has_head
};

struct Head {
  int blob = -1;
  int c = 0, r = 0;  // cell of its top
  Vec3f top_mm;
  float width_mm = 0;
  bool seen = true;    // false: where a tracked person's head is expected
  bool vague = false;  // rather flat, or too far to judge: counts only where there is no better one
};

class BlobFinder {
 public:
  explicit BlobFinder(const Grid& grid);
  void reset() { wall_.reset(); }  // forgets the room
  // Labels every cell: blob index + 1, or 0 for floor, no data, specks and where `background` is 1. `expected`:
  // crowns of people known, who are kept apart also where their heads are not seen.
  void run(const Grid& grid, const FloorPlane& floor, std::span<const std::uint8_t> background,
           std::span<const Vec3f> expected);
  std::span<const std::uint16_t> labels() const { return labels_; }
  std::span<const Blob> blobs() const { return {blobs_.data(), static_cast<std::size_t>(blob_count_)}; }
  std::span<const Head> heads() const { return {heads_.data(), static_cast<std::size_t>(head_count_)}; }

 private:
  struct TrunkShape {
    float bulge_mm = 0;  // of the middle before the edges
    float edge_mm = 0;   // of that, beyond half way
    int row_count = 0;
  };

  struct Roundness {
    float score = 0;     // mm: 12 to 45 for people, below 9 for furniture
    float sides_mm = 0;  // of the rounder quarter, about the upright axis
    float share = 0;     // of the cells with blob on either side
  };
  // Below a top, where a head may be. Columns of cells.
  struct HeadShape {
    int centre = 0;
    int lo = 0, hi = 0;                        // of its last row
    float width_mm = 0;                        // mean, 55..165 mm below the top
    float narrowest_mm = 1e9F, widest_mm = 0;  // there
    float neck_mm = 1e9F;                      // narrowest, 165..280 mm below
    float shoulders_mm = 0;                    // widest, 270..430 mm below
    float left_mm = 0, right_mm = 0;           // what they reach beyond the head
    float relief_mm = 0;                       // of the head's middle before its edges
    float bulge_mm = 0;                        // of the trunk, rms
    bool cut = false;                          // by the picture's left or right border
  };
  class HeadProbe;

  void open_cells(const Grid& grid, const FloorPlane& floor, std::span<const std::uint8_t> background);
  void label(const Grid& grid);
  bool close_further_walls(const Grid& grid, const FloorPlane& floor);
  void describe(const Grid& grid);
  void expect_heads(const Grid& grid, const FloorPlane& floor, std::span<const Vec3f> expected);
  int blob_under(const Grid& grid, Vec3f crown, Vec3f up) const;
  void split_between_heads(const Grid& grid);
  void find_heads(const Grid& grid, int blob, const FloorPlane& floor);
  bool head_at(const Grid& grid, int blob, int c, int r, Head& out) const;
  void join_trunks(const Grid& grid, const FloorPlane& floor);
  int blob_over(const Grid& grid, int blob) const;
  void join_split_bodies(const Grid& grid, const FloorPlane& floor);
  void detach_furniture(const Grid& grid, const FloorPlane& floor);
  bool detach_side(const Grid& grid, const Head& head, int side);
  bool rises_from_floor(const Grid& grid, int blob, int c) const;
  bool on_pole(const Grid& grid, int blob, const FloorPlane& floor) const;
  bool floats(const Grid& grid, int blob, const FloorPlane& floor) const;
  void judge(const Grid& grid, const FloorPlane& floor);
  TrunkShape trunk_shape(const Grid& grid, int blob, int c, int r_first, int r_last, float z_mm) const;
  bool person_shaped(const Grid& grid, int blob) const;
  bool has_legs(const Grid& grid, int blob) const;
  Roundness roundness(const Grid& grid, int blob, int row_last) const;
  bool round_body(const Grid& grid, int blob, const FloorPlane& floor) const;
  float shape_odds(const Grid& grid, int blob, const FloorPlane& floor) const;
  TrunkShape trunk_of(const Grid& grid, int blob) const;
  static float trunk_misfit(const TrunkShape& shape);
  static bool person_sized(const Grid& grid, const Blob& blob, const FloorPlane& floor);

  std::vector<std::uint8_t> open_;  // cells that may belong to a thing
  std::vector<std::uint8_t> part_;  // of them, those of one blob
  WallRemover wall_;
  Components components_;
  std::vector<std::uint16_t> labels_;
  std::vector<std::int16_t> top_;  // per column, for the blob in hand
  std::vector<FloorEquations> planes_;
  std::array<Blob, kBlobCountMax> blobs_;
  int blob_count_ = 0;
  std::array<Head, kHeadCountMax> heads_;
  int head_count_ = 0;
};

}  // namespace im2fit::segment
