// SPDX-License-Identifier: Apache-2.0
#include "kernels/unpack11/shift_table.h"

#include "kernels/unpack11/unpack11.h"

namespace im2fit {
namespace {

constexpr std::int64_t kDepthMax_mm = 10'000;
constexpr std::int64_t kNmPerMm = 1'000'000;
constexpr int kBlock = 640;  // pixels unpacked at a time: a multiple of 8, and small enough to stay in the cache

bool within(std::int64_t value, std::int64_t low, std::int64_t high) {
  return value >= low && value <= high;
}

}  // namespace

bool is_plausible(const ZeroPlane& plane) {
  return within(plane.emitter_nm, 10 * kNmPerMm, 200 * kNmPerMm) &&
         within(plane.distance_nm, 100 * kNmPerMm, 5000 * kNmPerMm) &&
         within(plane.pixel_nm, kNmPerMm / 10, 10 * kNmPerMm) && within(plane.constant_shift, 0, 1000);
}

// With k = 2 raw - 8 c - 3, m is k p / 8 and z = 8 e r / (8 e - k p). At the plausible limits the numerator is 8e18
// of the 9.2e18 that 64 bits hold, and k p 1.2e11.
ShiftTable shift_table(const ZeroPlane& plane) {
  ShiftTable table{};
  const std::int64_t numerator = 8 * plane.emitter_nm * plane.distance_nm;
  for (int raw = 0; raw < kShiftCount; ++raw) {
    if (raw == kNoShift) continue;
    const std::int64_t k = 2 * raw - 8 * plane.constant_shift - 3;
    const std::int64_t denominator = 8 * plane.emitter_nm - k * plane.pixel_nm;
    if (denominator <= 0) continue;  // beyond infinity
    // Half millimetres are whole numbers of nanometres: nothing is lost by dividing twice.
    const std::int64_t z_mm = (numerator / denominator + kNmPerMm / 2) / kNmPerMm;
    if (z_mm <= kDepthMax_mm) table[static_cast<std::size_t>(raw)] = static_cast<std::uint16_t>(z_mm);
  }
  return table;
}

float focal_length_px(const ZeroPlane& plane) {
  return static_cast<float>(static_cast<double>(plane.distance_nm) / static_cast<double>(2 * plane.pixel_nm));
}

void shifts_to_mm(const std::uint8_t* packed, int count, const ShiftTable& table, std::uint16_t* out) {
  std::uint16_t raw[kBlock];
  while (count > 0) {
    const int block = count < kBlock ? count : kBlock;
    unpack11(packed, block, raw);
    for (int i = 0; i < block; ++i) out[i] = table[raw[i]];
    packed += kBlock / 8 * 11;
    out += block;
    count -= block;
  }
}

}  // namespace im2fit
