// SPDX-License-Identifier: Apache-2.0
// Hair as a cap over the scalp, drawn for this project: a man's, cropped, and a woman's, to the jaw. Hand-made for
// MakeHuman's base mesh, whose places (mm) it names.
#pragma once

#include <span>
#include <vector>

#include "body/look.h"
#include "core/vec3.h"

namespace im2fit::body::makehuman {

// About how far above the hairline a point of the head lies, mm; negative below it. `p`: on the base mesh, head and
// neck.
float above_hairline_mm(Vec3f p, LookOf whose);

// `body`: the base mesh's body, mm; `on_head`: 1 where a vertex belongs to head or neck.
std::vector<HairRecord> hair_cap(std::span<const Vec3f> body, std::span<const std::uint8_t> on_head);

}  // namespace im2fit::body::makehuman
