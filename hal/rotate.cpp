// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cassert>
#include <cstring>

#include "hal/source.h"

namespace im2fit::hal {
namespace {

// Pixels: a tile of rows and one of columns stay in the first-level cache, so a quarter turn costs about a copy.
constexpr int kTile = 32;

template <class Pick>
void copy_tiled(DepthImage out, Pick pick) {
  for (int v0 = 0; v0 < out.height; v0 += kTile) {
    for (int u0 = 0; u0 < out.width; u0 += kTile) {
      const int v1 = std::min(v0 + kTile, out.height);
      const int u1 = std::min(u0 + kTile, out.width);
      for (int v = v0; v < v1; ++v)
        for (int u = u0; u < u1; ++u) out.at(u, v) = pick(u, v);
    }
  }
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
      copy_tiled(out, [&](int u, int v) { return in.at(v, in.height - 1 - u); });
      break;
    case 180:
      copy_tiled(out, [&](int u, int v) { return in.at(in.width - 1 - u, in.height - 1 - v); });
      break;
    case 270:
      copy_tiled(out, [&](int u, int v) { return in.at(in.width - 1 - v, u); });
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

}  // namespace im2fit::hal
