// SPDX-License-Identifier: Apache-2.0
// The shape space inside a body file: sections shape_* (docs/formats-body.md). Points are stored in 16 bits with a
// scale a component, so a space that was read differs from the one written by half a step (0.02 mm of a mean point,
// thousandths of a component) and is the same on every machine.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "body/shape_space.h"
#include "core/container.h"
#include "core/status.h"

namespace im2fit::body {

// The space of a parsed body file, checked; one of no points when the file has no section shape_about.
Result<ShapeSpace> read_shape_space(const ContainerReader& reader, const std::string& what);

// The body file `pack` with its shape sections replaced by those of `space`. Errors: as read_shape_space.
Result<std::vector<std::byte>> with_shape_space(std::span<const std::byte> pack, const ShapeSpace& space);

}  // namespace im2fit::body
