// SPDX-License-Identifier: Apache-2.0
// The loop that unpacks a shape space; see read_points() of shape_space.cpp.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace im2fit::body {

inline constexpr std::size_t kShapeTile = 8;  // values, and planes, that are turned together

// `steps`: of kShapeTile values in the first of `planes` planes, which are `stride` apart. out: a row of `planes` a
// value, each step times the value's scale of that plane; the product of two floats, whatever the machine.
void unpack_tiles(const std::int16_t* steps, std::size_t stride, std::size_t planes,
                  const std::array<const float*, kShapeTile>& scale, float* out);

}  // namespace im2fit::body
