// SPDX-License-Identifier: Apache-2.0
// Connected surfaces of the coarse picture: metric size (blobs.cpp), heads (heads.cpp), which of them are one or
// several things (split.cpp), their shape (body.cpp), and which are people (people.cpp).
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
  bool vague = false;  // rather flat, or too far to judge: counts only without a better one
};

// The surfaces of one frame, and the memory in which they are found: made once, for frames of one size.
struct Blobs {
  explicit Blobs(const Grid& grid);
  void reset() { wall.reset(); }  // forgets the room
  std::span<const Blob> list() const { return {blobs.data(), at(blob_count)}; }

  std::vector<std::uint16_t> labels;  // per cell: blob index + 1, or 0 for floor, no data, specks and background
  std::array<Blob, kBlobCountMax> blobs;
  int blob_count = 0;
  std::array<Head, kHeadCountMax> heads;
  int head_count = 0;

  // Used by the steps alone.
  std::vector<std::uint8_t> open;  // cells that may belong to a thing
  std::vector<std::uint8_t> part;  // of them, those of one blob
  // Of the frame as it was before its smaller walls were removed.
  std::vector<std::uint16_t> labels_before;
  std::vector<Blob> blobs_before;
  std::vector<Head> heads_before;
  WallRemover wall;
  Components components;
  std::vector<std::int16_t> top;  // per column, for the blob in hand
  std::vector<FloorEquations> planes;
};

// Labels every cell and decides which blobs are people. Cells where `background` is 1 stay out. `expected`: crowns of
// known people, who are kept apart even where their heads are not seen.
void find_blobs(const Grid& grid, const FloorPlane& floor, std::span<const std::uint8_t> background,
                std::span<const Vec3f> expected, Blobs& found);

// The steps of find_blobs(), in their order. Steps that change labels compute the descriptions of the blobs again.
void describe_blobs(const Grid& grid, Blobs& found);                                 // blobs.cpp
void find_heads(const Grid& grid, const FloorPlane& floor, int blob, Blobs& found);  // heads.cpp
void join_trunks(const Grid& grid, const FloorPlane& floor, Blobs& found);           // split.cpp
void expect_heads(const Grid& grid, const FloorPlane& floor, std::span<const Vec3f> expected, Blobs& found);
void split_between_heads(const Grid& grid, Blobs& found);
void detach_furniture(const Grid& grid, const FloorPlane& floor, Blobs& found);
void join_split_bodies(const Grid& grid, const FloorPlane& floor, Blobs& found);
void judge_blobs(const Grid& grid, const FloorPlane& floor, Blobs& found);  // people.cpp

// The shape of one blob (body.cpp).
struct TrunkShape {
  float bulge_mm = 0;  // of the middle before the edges
  float edge_mm = 0;   // of that, beyond half way
  int row_count = 0;
};
TrunkShape trunk_shape(const Grid& grid, std::span<const std::uint16_t> labels, int blob, int c, int r_first,
                       int r_last, float z_mm);
float trunk_misfit(const TrunkShape& shape);
bool has_legs(const Grid& grid, const Blobs& found, int blob, float scale = 1);  // scale: of an adult's legs

struct Roundness {
  float score = 0;     // mm: 12 to 45 for people, below 9 for furniture
  float sides_mm = 0;  // of the rounder quarter, about the upright axis
  float share = 0;     // of the cells with blob on either side
};
Roundness roundness(const Grid& grid, const Blobs& found, int blob, int row_last);
bool floats(const Grid& grid, const FloorPlane& floor, const Blobs& found, int blob);
bool on_pole(const Grid& grid, const FloorPlane& floor, const Blobs& found, int blob);
bool round_body(const Grid& grid, const FloorPlane& floor, const Blobs& found, int blob);
float shape_odds(const Grid& grid, const FloorPlane& floor, const Blobs& found, int blob);

}  // namespace im2fit::segment
