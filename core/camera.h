// SPDX-License-Identifier: Apache-2.0
// The pinhole camera, depth images and masks. Camera axes: x right, y down, z forward; lengths in mm.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/vec3.h"

namespace im2fit {

inline constexpr int kImageSideMax = 2048;  // px; larger frames are refused at the edge

// An integer pixel coordinate is the pixel's centre: x = (u - cx) z / fx.
struct Intrinsics {
  int width = 0;   // px
  int height = 0;  // px
  float fx = 0;    // px
  float fy = 0;    // px
  float cx = 0;    // px
  float cy = 0;    // px
};

// Row-major pixels, `stride` values from row to row. A view: owns nothing.
template <class T>
struct ImageView {
  T* pixels = nullptr;
  int width = 0;
  int height = 0;
  int stride = 0;

  ImageView() = default;
  ImageView(T* p, int w, int h) : pixels(p), width(w), height(h), stride(w) {}
  ImageView(T* p, int w, int h, int s) : pixels(p), width(w), height(h), stride(s) {}
  T* row(int v) const { return pixels + static_cast<std::ptrdiff_t>(v) * stride; }
  T& at(int u, int v) const { return row(v)[u]; }
  operator ImageView<const T>() const { return {pixels, width, height, stride}; }
};

using DepthView = ImageView<const std::uint16_t>;  // mm, 0 = no data
using DepthImage = ImageView<std::uint16_t>;
using MaskView = ImageView<const std::uint8_t>;  // 0 or 255
using MaskImage = ImageView<std::uint8_t>;

inline Vec3f unproject(const Intrinsics& k, float u, float v, float z_mm) {
  return {(u - k.cx) * z_mm / k.fx, (v - k.cy) * z_mm / k.fy, z_mm};
}

}  // namespace im2fit
