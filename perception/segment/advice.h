// SPDX-License-Identifier: Apache-2.0
// What is wrong with the view of the person, as guidance codes.
#pragma once

#include <cstdint>
#include <span>

#include "perception/segment/blobs.h"
#include "perception/segment/grid.h"
#include "perception/segment/segment.h"

namespace im2fit::segment {

// Where the sensor leaves border columns or rows empty, the picture ends at the first with data: sets `cut_*`.
void mark_dead_borders(const Grid& grid, int image_width, int image_height, Person& person);
// Guidance for a person found, with mask `mask` and cells `chosen`; `disturbed`: by another person.
GuidanceSet advise(const Grid& grid, const Person& person, DepthView depth, MaskView mask,
                   std::span<const std::uint8_t> chosen, bool disturbed);
// Guidance for a frame without a person: no_person, or only why a person who is there is not found: too_near,
// step_to_the_middle, depth_missing. The heads of those whom `people` leaves out ask for nothing.
GuidanceSet advise_none_found(const Grid& grid, const FloorPlane& floor, const Blobs& found,
                              const PersonTracker& people);

}  // namespace im2fit::segment
