// SPDX-License-Identifier: Apache-2.0
// Restores edges in pictures of sensors whose drivers blend depth across edges or drop the pixels beside them. In
// these a person's outline lies a pixel or two inside the person, and every girth comes out small. Phones do this.
#pragma once

#include <array>
#include <cstdint>

#include "core/camera.h"
#include "core/lazy_zeros.h"

namespace im2fit {

// Statistics of a sensor's edges: the steps in depth of all frames since reset().
struct EdgeCounts {
  std::uint32_t steps = 0;
  std::uint32_t bridged = 0;    // of them: with a value well between the two surfaces
  std::uint32_t bridge_px = 0;  // such values
  // Steps whose pixels between the two surfaces have no data, by the side the nearer surface is on: left, right,
  // above, below of the step.
  struct Side {
    std::uint32_t steps = 0, gaps = 0, gap_px = 0;
  };
  std::array<Side, 4> sides{};
};

// A blend that weighs all directions alike has, at an edge, the mean of the two surfaces, and a driver drops as many
// pixels on either side of an edge. So of the pixels between two surfaces those nearer than the mean get the nearer
// surface's depth, the others the farther's; of pixels without data the half on either side. Where nothing is seen
// behind, an outline grows by half of the usual gap between surfaces.
// Integers only; no allocation after construction; not shareable between threads.
class EdgeRestorer {
 public:
  EdgeRestorer(int width, int height);
  // Judges the frame's edges and restores them in place, where they need it. Sharp sensors' frames stay as they are
  // to the bit. `depth` of the constructor's size; `focal_px` of its camera.
  void run(DepthImage depth, float focal_px);
  void reset();
  // Whether the last run restored edges.
  bool restored() const { return blends_ || drops_; }
  // Whether the gaps between surfaces are so wide that hands and gaps beside arms are lost in them and cannot be
  // restored.
  bool beyond_repair() const { return wide_; }
  const EdgeCounts& counts() const { return counts_; }

 private:
  void judge(DepthView depth, float focal_px);
  void restore(DepthImage depth, float focal_px);
  std::uint32_t gaps() const;
  std::uint32_t gap_px() const;
  EdgeCounts counts_;
  std::uint32_t frames_ = 0;  // since reset()
  bool blends_ = false, drops_ = false, wide_ = false;
  LazyZeros<std::uint16_t> before_;   // the frame as delivered
  LazyZeros<std::uint16_t> step_mm_;  // by how large a step a row decided on a pixel; 0: it did not
};

}  // namespace im2fit
