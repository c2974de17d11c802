// SPDX-License-Identifier: Apache-2.0
#include "kernels/rayform/rayform_neon.h"
#include "kernels/section/section.h"

namespace im2fit {
namespace {

// Row `bits`: the bytes of the four-byte lanes whose bits are set, in order, then zeros.
struct Compaction {
  std::uint8_t bytes[16][16];
  std::uint8_t counts[16];
};
constexpr Compaction compaction() {
  Compaction c{};
  for (int bits = 0; bits < 16; ++bits) {
    int count = 0;
    for (int lane = 0; lane < 4; ++lane) {
      if ((bits >> lane & 1) == 0) continue;
      for (int byte = 0; byte < 4; ++byte)
        c.bytes[bits][4 * count + byte] = static_cast<std::uint8_t>(4 * lane + byte);
      ++count;
    }
    c.counts[bits] = static_cast<std::uint8_t>(count);
  }
  return c;
}
constexpr Compaction kCompaction = compaction();

struct Columns {
  const std::int32_t *along, *x, *y;
};
struct RowValues {
  int32x4_t along, x, y;
};

struct Lists {
  SectionPoint* points;
  int capacity;
  int* counts;
};

inline uint32x4_t within(int32x4_t a, std::int32_t limit) {
  return vcleq_s32(vabsq_s32(a), vdupq_n_s32(limit));
}

inline int32x4_t plane_coordinate(int32x4_t product, std::int32_t centre) {
  return vrshrq_n_s32(vsubq_s32(product, vdupq_n_s32(centre)), 7);
}

inline unsigned lane_bits4(uint32x4_t a) {
  const uint32x4_t place = {1, 2, 4, 8};
#ifdef __aarch64__
  return vaddvq_u32(vandq_u32(a, place));
#else
  const uint32x4_t bits = vandq_u32(a, place);
  const uint32x2_t pair = vadd_u32(vget_low_u32(bits), vget_high_u32(bits));
  return vget_lane_u32(vpadd_u32(pair, pair), 0);
#endif
}

inline uint8x16_t compacted(uint8x16_t values, unsigned bits) {
  const uint8x16_t lanes = vld1q_u8(kCompaction.bytes[bits]);
#ifdef __aarch64__
  return vqtbl1q_u8(values, lanes);
#else
  const uint8x8x2_t table = {{vget_low_u8(values), vget_high_u8(values)}};
  return vcombine_u8(vtbl2_u8(table, vget_low_u8(lanes)), vtbl2_u8(table, vget_high_u8(lanes)));
#endif
}

inline void append(int32x4_t x, int32x4_t y, unsigned bits, int cut, const Lists& lists) {
  const int32x4_t pairs = vsliq_n_s32(x, y, 16);
  const int count = lists.counts[cut];
  SectionPoint* to = lists.points + static_cast<std::ptrdiff_t>(cut) * (lists.capacity + kSectionSlack) + count;
  vst1q_u8(reinterpret_cast<std::uint8_t*>(to), compacted(vreinterpretq_u8_s32(pairs), bits));
  const int grown = count + kCompaction.counts[bits];
  lists.counts[cut] = grown < lists.capacity ? grown : lists.capacity;
}

// Whether four points at these products lie in the cut; appends those that do.
inline void take4(int32x4_t off_plane, uint32x4_t near, int32x4_t x_product, int32x4_t y_product, int cut,
                  const SectionCut& c, const Lists& lists) {
  const int32x4_t x = plane_coordinate(x_product, c.x), y = plane_coordinate(y_product, c.y);
  const uint32x4_t inside = vandq_u32(within(x, kSectionCoordinateMax), within(y, kSectionCoordinateMax));
  const int32x4_t off = vrshrq_n_s32(off_plane, 5);
  const int32x4_t distance = vshlq_n_s32(vmlaq_s32(vmulq_s32(x, x), y, y), 4);
  const int32x4_t off_99 = vmulq_n_s32(vmulq_s32(off, off), 99);
  const uint32x4_t taken = vandq_u32(vandq_u32(near, inside), vcgtq_s32(distance, off_99));
  const unsigned bits = lane_bits4(taken);
  if (bits != 0) append(x, y, bits, cut, lists);
}

inline void scan8(const SectionScan& s, const int32x4_t* centres, const std::uint16_t* depth,
                  const std::uint8_t* mask, const Columns& columns, const RowValues& row, const Lists& lists) {
  const uint16x8_t d = seen_depth8(depth, mask);
  const int32x4_t z[2] = {form_depth4(vget_low_u16(d)), form_depth4(vget_high_u16(d))};
  const uint32x4_t seen[2] = {vcgtq_s32(z[0], vdupq_n_s32(0)), vcgtq_s32(z[1], vdupq_n_s32(0))};
  const int32x4_t along[2] = {form_product4(columns.along, row.along, z[0]),
                              form_product4(columns.along + 4, row.along, z[1])};
  int32x4_t x[2] = {along[0], along[1]}, y[2] = {along[0], along[1]};
  bool have_products = false;
  for (int cut = 0; cut < s.cut_count; ++cut) {
    const int32x4_t off[2] = {vsubq_s32(along[0], centres[cut]), vsubq_s32(along[1], centres[cut])};
    const uint32x4_t near[2] = {vandq_u32(seen[0], within(off[0], kSectionOffMax)),
                                vandq_u32(seen[1], within(off[1], kSectionOffMax))};
    if (!any4(vorrq_u32(near[0], near[1]))) continue;
    if (!have_products) {
      for (int half = 0; half < 2; ++half) {
        x[half] = form_product4(columns.x + 4 * half, row.x, z[half]);
        y[half] = form_product4(columns.y + 4 * half, row.y, z[half]);
      }
      have_products = true;
    }
    take4(off[0], near[0], x[0], y[0], cut, s.cuts[cut], lists);
    take4(off[1], near[1], x[1], y[1], cut, s.cuts[cut], lists);
  }
}

// A row's last pixels, fewer than eight, copied into room for eight.
void scan_tail(const SectionScan& s, const int32x4_t* centres, const std::uint16_t* depth, const std::uint8_t* mask,
               int begin, int count, const RowValues& row, const Lists& lists) {
  std::uint16_t depth_tail[8] = {};
  std::uint8_t mask_tail[8] = {};
  std::int32_t along_tail[8] = {}, x_tail[8] = {}, y_tail[8] = {};
  for (int i = 0; i < count; ++i) {
    depth_tail[i] = depth[begin + i];
    mask_tail[i] = mask[begin + i];
    along_tail[i] = s.along_columns[begin + i];
    x_tail[i] = s.x_columns[begin + i];
    y_tail[i] = s.y_columns[begin + i];
  }
  if (masked8(mask_tail)) scan8(s, centres, depth_tail, mask_tail, {along_tail, x_tail, y_tail}, row, lists);
}

}  // namespace

void section_neon(const SectionScan& s, SectionPoint* points, int capacity, int* counts) {
  for (int cut = 0; cut < s.cut_count; ++cut) counts[cut] = 0;
  const Lists lists = {points, capacity, counts};
  int32x4_t centres[kSectionCountMax];
  for (int cut = 0; cut < s.cut_count; ++cut) centres[cut] = vdupq_n_s32(s.cuts[cut].along);
  const int width = s.depth_q4.width, whole = width & ~7;
  for (std::ptrdiff_t v = 0; v < s.depth_q4.height; ++v) {
    const std::uint16_t* depth = s.depth_q4.pixels + v * s.depth_q4.stride;
    const std::uint8_t* mask = s.mask.pixels + v * s.mask.stride;
    const RowValues row = {vdupq_n_s32(s.along_rows[v]), vdupq_n_s32(s.x_rows[v]), vdupq_n_s32(s.y_rows[v])};
    for (int u = 0; u < whole; u += 8) {
      if (masked8(mask + u))
        scan8(s, centres, depth + u, mask + u, {s.along_columns + u, s.x_columns + u, s.y_columns + u}, row, lists);
    }
    if (whole < width) scan_tail(s, centres, depth, mask, whole, width - whole, row, lists);
  }
}

}  // namespace im2fit
