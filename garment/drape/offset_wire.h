// SPDX-License-Identifier: Apache-2.0
// Offsets of cloth as bytes. A block of sixteen vertices, which lie near each other, has one step: the least power of
// two of 1/8 mm at which all of its numbers fit into a byte. A byte a block and three a vertex: the size is known
// beforehand.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/status.h"
#include "core/vec3.h"

namespace im2fit::body {

inline constexpr std::size_t kOffsetBlock = 16;  // vertices
inline constexpr float kOffsetStepMm = 0.125F;   // the finest
inline constexpr int kOffsetStepsMax = 5;        // doublings: 4 mm, numbers up to 508 mm

// Of `count` vertices.
constexpr std::size_t offset_bytes(std::size_t count) {
  return 3 * count + (count + kOffsetBlock - 1) / kOffsetBlock;
}
// Appends offset_bytes(offsets.size()) bytes: of each block the doublings of its step, then x, y, z of each vertex,
// as two's complement, in steps, rounded. Larger numbers are clamped to the range of a byte.
void append_offsets(std::span<const Vec3f> offsets, std::string& out);
// The step a block of these is sent in.
float offset_step_mm(std::span<const Vec3f> block);

// All garments of a frame: "im2c", uint32 number of the frame, uint32 count of garments; of each uint32 count of its
// vertices, then their offsets. Little-endian.
std::string cloth_message(std::uint32_t number, std::span<const std::span<const Vec3f>> garments);
struct ClothMessage {
  std::uint32_t number = 0;
  std::vector<std::vector<Vec3f>> garments;  // mm
};
// Errors: a wrong beginning, too short, bytes left over, an invalid step.
Result<ClothMessage> read_cloth_message(std::string_view bytes);

}  // namespace im2fit::body
