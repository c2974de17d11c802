// SPDX-License-Identifier: Apache-2.0
// Small sound recordings for fuzzers to start from.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <string>

#include "hal/intrinsics.h"

namespace im2fit::fuzz {

// An element of EBML, whose size takes four bytes.
inline std::string ebml(std::uint32_t id, const std::string& payload) {
  std::string out;
  for (int shift = 24; shift >= 0; shift -= 8)
    if (id >> shift != 0) out += static_cast<char>(id >> shift & 0xFFU);
  const auto size = static_cast<std::uint32_t>(payload.size()) | 0x10000000U;
  for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>(size >> shift & 0xFFU);
  return out + payload;
}
inline std::string ebml(std::uint32_t id, std::initializer_list<std::string> children) {
  std::string payload;
  for (const std::string& child : children) payload += child;
  return ebml(id, payload);
}

// Two frames of 8 x 6 pixels.
inline std::string matroska_recording() {
  hal::Calibration calibration;
  calibration.intrinsics = {8, 6, 7.5F, 7.5F, 3.5F, 2.5F};
  calibration.distortion.coefficients = {0.1, -0.05, 0.001, 0.002, 0.01};
  const std::string head = ebml(0x1A45DFA3, {ebml(0x4282, "matroska")});
  const std::string track =
      ebml(0x1654AE6B, {ebml(0xAE, {ebml(0xD7, "\x01"), ebml(0x73C5, "\x05"), ebml(0x83, "\x01"),
                                    ebml(0x536E, "DEPTH"), ebml(0x86, "V_UNCOMPRESSED"),
                                    ebml(0xE0, {ebml(0xB0, "\x08"), ebml(0xBA, "\x06"), ebml(0x2EB524, "b16g")})})});
  const std::string attached =
      ebml(0x1941A469, {ebml(0x61A7, {ebml(0x466E, "calibration.json"), ebml(0x46AE, "\x07"),
                                      ebml(0x465C, hal::camera_yaml_text(calibration, "x"))})});
  const std::string tags =
      ebml(0x1254C367, {ebml(0x7373, {ebml(0x63C0, {ebml(0x63C5, "\x05")}),
                                      ebml(0x67C8, {ebml(0x45A3, "K4A_DEPTH_TRACK"), ebml(0x4487, "5")})}),
                        ebml(0x7373, {ebml(0x67C8, {ebml(0x45A3, "K4A_START_OFFSET_NS"), ebml(0x4487, "500")})})});
  const std::string pixels(std::size_t{8} * 6 * 2, '\x0B');
  const std::string clusters =
      ebml(0x1F43B675, {ebml(0xE7, std::string(1, '\0')), ebml(0xA3, std::string("\x81\0\0\x80", 4) + pixels)}) +
      ebml(0x1F43B675, {ebml(0xE7, "\x21"), ebml(0xA0, {ebml(0xA1, std::string("\x81\0\x01\0", 4) + pixels)})});
  return head +
         ebml(0x18538067, {ebml(0x1549A966, {ebml(0x2AD7B1, "\x0F\x42\x40")}), track, attached, tags, clusters});
}

}  // namespace im2fit::fuzz
