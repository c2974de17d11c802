// SPDX-License-Identifier: Apache-2.0
// Eight cells at a time; the structure loads (vld2, vld3, vld4) part the pixels of steps 2, 3 and 4 as they come.
#include <arm_neon.h>

#include "kernels/sample/sample.h"

namespace im2fit {
namespace {

constexpr int kLanes = 8;

uint16x8_t sort_key(uint16x8_t z) {
  const uint16x8_t less = vsubq_u16(z, vdupq_n_u16(1));
  return vorrq_u16(less, vcgeq_u16(less, vdupq_n_u16(kSampleDepthMaxMm)));
}

void order(uint16x8_t& a, uint16x8_t& b) {
  const uint16x8_t low = vminq_u16(a, b);
  b = vmaxq_u16(a, b);
  a = low;
}

void median(uint16x8_t a, uint16x8_t b, uint16x8_t c, uint16x8_t d, uint16x8_t e, std::uint16_t* out) {
  a = sort_key(a);
  b = sort_key(b);
  c = sort_key(c);
  d = sort_key(d);
  e = sort_key(e);
  order(a, b);
  order(d, e);
  order(c, e);
  order(c, d);
  order(a, d);
  order(a, c);
  order(b, e);
  order(b, d);
  order(b, c);
  const uint16x8_t none = vdupq_n_u16(65535);
  const uint16x8_t fewer = vbslq_u16(vceqq_u16(c, none), a, b);
  vst1q_u16(out, vaddq_u16(vbslq_u16(vceqq_u16(e, none), fewer, c), vdupq_n_u16(1)));
}

struct Rows {
  const std::uint16_t *top, *middle, *bottom;  // of a row of cells
};

void cells_of_4(const Rows& p, std::uint16_t* out) {
  const uint16x8x4_t t = vld4q_u16(p.top), b = vld4q_u16(p.bottom);
  median(t.val[0], t.val[3], vld4q_u16(p.middle).val[2], b.val[0], b.val[3], out);
}
void cells_of_3(const Rows& p, std::uint16_t* out) {
  const uint16x8x3_t t = vld3q_u16(p.top), b = vld3q_u16(p.bottom);
  median(t.val[0], t.val[2], vld3q_u16(p.middle).val[1], b.val[0], b.val[2], out);
}
void cells_of_2(const Rows& p, std::uint16_t* out) {
  const uint16x8x2_t t = vld2q_u16(p.top), b = vld2q_u16(p.bottom);
  median(t.val[0], t.val[1], b.val[1], b.val[0], b.val[1], out);
}

// Any step, and the remainder of a row: `count` cells from 1 to 8.
void cells_one_by_one(const Rows& p, int step, int count, std::uint16_t* out) {
  std::uint16_t samples[5][kLanes] = {};
  for (int c = 0; c < count; ++c) {
    const int u = c * step;
    samples[0][c] = p.top[u];
    samples[1][c] = p.top[u + step - 1];
    samples[2][c] = p.middle[u + step / 2];
    samples[3][c] = p.bottom[u];
    samples[4][c] = p.bottom[u + step - 1];
  }
  std::uint16_t medians[kLanes];
  median(vld1q_u16(samples[0]), vld1q_u16(samples[1]), vld1q_u16(samples[2]), vld1q_u16(samples[3]),
         vld1q_u16(samples[4]), medians);
  for (int c = 0; c < count; ++c) out[c] = medians[c];
}

}  // namespace

void sample_neon(DepthView depth, int step, std::uint16_t* out) {
  const int width = depth.width / step;
  const std::ptrdiff_t stride = depth.stride;
  for (int r = 0; r < depth.height / step; ++r) {
    const std::uint16_t* top = depth.pixels + r * step * stride;
    const Rows row = {top, top + (step / 2) * stride, top + (step - 1) * stride};
    for (int c = 0; c < width; c += kLanes) {
      const Rows here = {row.top + c * step, row.middle + c * step, row.bottom + c * step};
      const int left = width - c;
      if (left < kLanes || step < 2 || step > 4)
        cells_one_by_one(here, step, left < kLanes ? left : kLanes, out + c);
      else if (step == 4)
        cells_of_4(here, out + c);
      else if (step == 3)
        cells_of_3(here, out + c);
      else
        cells_of_2(here, out + c);
    }
    out += width;
  }
}

}  // namespace im2fit
