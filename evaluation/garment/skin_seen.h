// SPDX-License-Identifier: Apache-2.0
// Skin that shows where cloth should cover it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "body/model.h"
#include "garment/drape/outfit.h"

namespace im2fit::lab {

// The body's vertices that cloth covers now, some centimetres from any hem: 1 each.
std::vector<std::uint8_t> covered_skin(const body::BodyModel& model, const body::Outfit& outfit);

struct SkinSeen {
  int cloth_px = 0;    // of all views
  int through_px = 0;  // of covered skin with the cloth that covers it right behind
  int bare_px = 0;     // of covered skin from which a hem has moved away: a shirt's as arms rise, a leg's in a lap
  int drawn_px = 0;    // through_px where skin that cloth hides as it lies is left out, as pictures leave it out
};
// Of four views (front, left, back, slant), 3 mm a pixel; but for drawn_px no skin is left out: cloth itself has to
// cover it. `covered`: of a pose in which it did.
SkinSeen look_for_skin(const body::BodyModel& model, const body::Outfit& outfit,
                       std::span<const std::uint8_t> covered);

}  // namespace im2fit::lab
