// SPDX-License-Identifier: Apache-2.0
// A structured-light camera sends a shift, not a distance: how far the pattern lies from its place on the plane of
// the calibration. By similar triangles, with e the distance from emitter to camera, r that of the
// plane, p the size of a pixel on it (of the sensor's 1280 columns) and c the constant shift,
//     m = ((raw - 4 c) / 4 - 3/8) p,   z = m r / (e - m) + r = e r / (e - m)
// (libfreenect and OpenNI compute the left form in floating point).
#pragma once

#include <array>
#include <cstdint>

namespace im2fit {

// The camera's zero plane, in nanometres: whole numbers, so that the table is the same on every machine.
struct ZeroPlane {
  std::int64_t emitter_nm = 75'000'000;      // 7.5 cm
  std::int64_t distance_nm = 1'200'000'000;  // 120 cm
  std::int64_t pixel_nm = 1'042'000;         // 0.1042 cm, which makes fx 575.8 pixels at 640 columns
  std::int32_t constant_shift = 200;
};

inline constexpr int kShiftCount = 2048;
inline constexpr std::uint16_t kNoShift = 2047;  // "no data"

// Within what any such camera can have: emitter 10 to 200 mm, plane 0.1 to 5 m, pixel 0.1 to 10 mm, shift 0 to 1000.
// Outside of it shift_table()'s products could overflow.
bool is_plausible(const ZeroPlane& plane);

// Millimetres for each raw value, rounded half up; 0 for kNoShift and for depths above 10,000 mm. `plane` must be
// plausible.
using ShiftTable = std::array<std::uint16_t, kShiftCount>;
ShiftTable shift_table(const ZeroPlane& plane);

// The focal length in pixels of a picture of 640 columns: two sensor pixels to each. From integers, in one division.
float focal_length_px(const ZeroPlane& plane);

// `count` packed values (kernels/unpack11) to millimetres. No allocation, thread-safe.
void shifts_to_mm(const std::uint8_t* packed, int count, const ShiftTable& table, std::uint16_t* out);

}  // namespace im2fit
