// SPDX-License-Identifier: Apache-2.0
// Random pictures and tables for kernels that read coordinates along axes, between guard pages.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "core/camera.h"
#include "tests/kernels/checkasm.h"

namespace im2fit::test {

struct RayPicture {
  static constexpr int kAxes = 3;
  int width, height;
  checkasm::Buffer<std::uint16_t> depth;
  checkasm::Buffer<std::uint8_t> mask;
  checkasm::Buffer<std::int32_t> columns0, columns1, columns2, rows0, rows1, rows2;

  // Column and row slopes within +-slope_max each, depths within low .. high; both full of holes.
  RayPicture(int w, int h, std::int32_t slope_max, int low, int high, checkasm::Trial& trial)
      : width(w),
        height(h),
        depth(size(w) * size(h), trial.next_end()),
        mask(depth.size(), trial.next_end()),
        columns0(size(w), trial.next_end()),
        columns1(size(w), trial.next_end()),
        columns2(size(w), trial.next_end()),
        rows0(size(h), trial.next_end()),
        rows1(size(h), trial.next_end()),
        rows2(size(h), trial.next_end()) {
    for (auto* table : {&columns0, &columns1, &columns2, &rows0, &rows1, &rows2})
      trial.fill(table->span(), -slope_max, slope_max);
    int left = 0;
    bool inside = false;
    for (std::size_t i = 0; i < depth.size(); ++i) {
      if (left-- <= 0) {
        left = static_cast<int>(trial.rng().index(60));
        inside = !inside;
      }
      const bool hole = trial.rng().index(12) == 0;
      depth[i] = hole ? std::uint16_t{0} : static_cast<std::uint16_t>(trial.biased(low, high));
      mask[i] = inside && trial.rng().index(20) != 0 ? std::uint8_t{255} : std::uint8_t{0};
    }
  }
  ImageView<const std::uint16_t> depths() const { return {depth.data(), width, height}; }
  MaskView masks() const { return {mask.data(), width, height}; }

 private:
  static std::size_t size(int n) { return static_cast<std::size_t>(n); }
};

}  // namespace im2fit::test
