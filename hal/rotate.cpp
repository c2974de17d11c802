// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cassert>
#include <cstring>

#include "hal/source.h"

namespace im2fit::hal {
namespace {

// Pixels: a tile of rows and one of columns stay in the first-level cache, so a quarter turn costs about a copy.
constexpr int kTile = 32;
constexpr int kLanes = 8;
using Lanes = std::uint16_t __attribute__((vector_size(kLanes * sizeof(std::uint16_t))));

// Columns of eight rows of pixels, `step` apart, become rows.
void transpose(const std::uint16_t* rows, std::ptrdiff_t step, Lanes columns[kLanes]) {
  Lanes r[kLanes], pairs[kLanes], fours[kLanes];
  for (int i = 0; i < kLanes; ++i) std::memcpy(&r[i], rows + i * step, sizeof r[i]);
  for (int i = 0; i < kLanes; i += 2) {
    pairs[i] = __builtin_shufflevector(r[i], r[i + 1], 0, 8, 1, 9, 2, 10, 3, 11);
    pairs[i + 1] = __builtin_shufflevector(r[i], r[i + 1], 4, 12, 5, 13, 6, 14, 7, 15);
  }
  for (int i = 0; i < kLanes; i += 4)
    for (int half = 0; half < 2; ++half) {
      const Lanes a = pairs[i + half], b = pairs[i + half + 2];
      fours[i + 2 * half] = __builtin_shufflevector(a, b, 0, 1, 8, 9, 2, 3, 10, 11);
      fours[i + 2 * half + 1] = __builtin_shufflevector(a, b, 4, 5, 12, 13, 6, 7, 14, 15);
    }
  for (int i = 0; i < kLanes / 2; ++i) {
    columns[2 * i] = __builtin_shufflevector(fours[i], fours[i + 4], 0, 1, 2, 3, 8, 9, 10, 11);
    columns[2 * i + 1] = __builtin_shufflevector(fours[i], fours[i + 4], 4, 5, 6, 7, 12, 13, 14, 15);
  }
}

// By a quarter turn; 90 degrees: out(u, v) = in(v, in.height - 1 - u), 270: in(in.width - 1 - v, u).
void turn(DepthView in, bool by_90, DepthImage out) {
  const auto pick = [&](int u, int v) { return by_90 ? in.at(v, in.height - 1 - u) : in.at(in.width - 1 - v, u); };
  // Eight rows from below up, or eight columns' places from below up: the lanes stay in registers either way.
  const std::ptrdiff_t step = by_90 ? -std::ptrdiff_t{in.stride} : std::ptrdiff_t{in.stride};
  const std::ptrdiff_t out_step = by_90 ? std::ptrdiff_t{out.stride} : -std::ptrdiff_t{out.stride};
  const auto eight = [&](int u, int v) {
    Lanes rows[kLanes];
    transpose(by_90 ? in.row(in.height - 1 - u) + v : in.row(u) + in.width - v - kLanes, step, rows);
    std::uint16_t* to = out.row(by_90 ? v : v + kLanes - 1) + u;
    for (int i = 0; i < kLanes; ++i, to += out_step) std::memcpy(to, &rows[i], sizeof rows[i]);
  };
  const int whole_width = out.width - out.width % kLanes, whole_height = out.height - out.height % kLanes;
  for (int v0 = 0; v0 < whole_height; v0 += kTile)
    for (int u0 = 0; u0 < whole_width; u0 += kTile)
      for (int v = v0; v < std::min(v0 + kTile, whole_height); v += kLanes)
        for (int u = u0; u < std::min(u0 + kTile, whole_width); u += kLanes) eight(u, v);
  for (int v = 0; v < out.height; ++v)
    for (int u = v < whole_height ? whole_width : 0; u < out.width; ++u) out.at(u, v) = pick(u, v);
}

}  // namespace

bool is_rotation(int rotate_deg) {
  return rotate_deg == 0 || rotate_deg == 90 || rotate_deg == 180 || rotate_deg == 270;
}

void rotate_upright(DepthView in, int rotate_deg, DepthImage out) {
  [[maybe_unused]] const bool quarter = rotate_deg == 90 || rotate_deg == 270;
  assert(is_rotation(rotate_deg));
  assert(out.width == (quarter ? in.height : in.width) && out.height == (quarter ? in.width : in.height));
  switch (rotate_deg) {
    case 90:
    case 270:
      turn(in, rotate_deg == 90, out);
      break;
    case 180:
      for (int v = 0; v < in.height; ++v) {
        const std::uint16_t* row = in.row(in.height - 1 - v);
        std::reverse_copy(row, row + in.width, out.row(v));
      }
      break;
    default:
      for (int v = 0; v < in.height; ++v)
        std::memcpy(out.row(v), in.row(v), static_cast<std::size_t>(in.width) * sizeof(std::uint16_t));
  }
}

Intrinsics rotate_upright(const Intrinsics& in, int rotate_deg) {
  const float right = static_cast<float>(in.width - 1);
  const float bottom = static_cast<float>(in.height - 1);
  switch (rotate_deg) {
    case 90:
      return {in.height, in.width, in.fy, in.fx, bottom - in.cy, in.cx};
    case 180:
      return {in.width, in.height, in.fx, in.fy, right - in.cx, bottom - in.cy};
    case 270:
      return {in.height, in.width, in.fy, in.fx, in.cy, right - in.cx};
    default:
      return in;
  }
}

Vec3f rotate_upright(Vec3f in, int rotate_deg) {
  switch (rotate_deg) {
    case 90:
      return {-in.y, in.x, in.z};
    case 180:
      return {-in.x, -in.y, in.z};
    case 270:
      return {in.y, -in.x, in.z};
    default:
      return in;
  }
}

CameraPose rotate_upright(const CameraPose& delivered, int rotate_deg) {
  const Vec3f axis = rotate_upright(Vec3f{delivered.x, delivered.y, delivered.z}, rotate_deg);
  return {axis.x, axis.y, axis.z, delivered.w, rotate_upright(delivered.position_mm, rotate_deg)};
}

}  // namespace im2fit::hal
