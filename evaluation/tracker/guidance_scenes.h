// SPDX-License-Identifier: Apache-2.0
// One scene maker per guidance code: person, place and camera for which the engine should raise this code, and no
// other but its companions.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/guidance.h"
#include "evaluation/tracker/scene_props.h"
#include "evaluation/tracker/upright_scene.h"

namespace im2fit::lab {

// "OK" first, then the codes a scene can name, in their order (CALIBRATION_POSE is the session's wish, not a
// scene's), then scenes that people reported: PET, PET_ALONE, WALL, MIRROR, LEGS_ALONE.
std::vector<std::string> guidance_kinds();

// The code that a scene of this kind must raise (0 for OK), and the codes allowed beside it.
struct GuidanceRule {
  GuidanceSet named = 0;
  GuidanceSet companions = 0;
};
GuidanceRule guidance_rule(const std::string& kind);

struct GuidanceScene {
  Subject subject;
  Shot shot;
  double lost_share = 0;  // of the pixels, in blobs: sunlight
  Props props;
};
// Depends on the arguments only.
GuidanceScene draw_guidance_scene(const body::BodyModel& model, const std::string& kind, std::uint64_t seed,
                                  std::uint64_t number);

// What sunlight does: pixels lost in square blobs of 1 to 4 px (at 320x240) until `lost_share` of them are gone.
void spoil(DepthImage depth, double lost_share, std::uint64_t seed, std::uint64_t frame);

}  // namespace im2fit::lab
