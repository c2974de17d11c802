// SPDX-License-Identifier: Apache-2.0
// Out-of-distribution subjects: people unlike the index' population, to train and to calibrate on. A training subject
// changed by modifiers and smooth changes of shape that neither the training nor the held-out family uses. Not the
// held-out family, which is for the evaluation alone.
#pragma once

#include <cstdint>

#include "body/model.h"
#include "train/population/population.h"
#include "train/population/shape_variation.h"

namespace im2fit::lab {

class SurfaceSmoother;

// How they differ: modifiers that no family uses, bumps, and changes that are alike on both sides.
struct OodVariation {
  double modifier_sd;
  Bumps bumps;
  float bump_least_mm, bump_most_mm;  // of a person's bumps, drawn evenly
  Mirrored trunk;                     // alike on both sides
  Mirrored neck;                      // with the head
  // Of people whose surface is smoothed, and then given dimensions of their own again: another make of body, of which
  // no detail of MakeHuman's meshes is left, so that none can be learned.
  double smoothed_share = 0;
  int passes_least = 10, passes_most = 120;
  double tape_share_least = 1;  // of those: body::draw_warp's share is drawn from here to 1
  double girth_sd = 0;
  float crown_sd_mm = 0;  // how far crowns are higher or flatter than the mesh's
};
// Refined answers learn from these and intervals are fitted on them: trunks differ where a camera in front does not
// see it, limbs hardly. Left and right differ alike, mostly, and whole parts are wider, deeper or farther forward, as
// people are: bumps alone, each on one side, teach less (docs/dataset.md). People measured by tape differ from any
// model by a girth error of 13..17 mm even when breadths and depths are known (ANSUR II,
// docs/notebook/evaluation.md).
inline constexpr OodVariation kOodTrunk = {
    .modifier_sd = 0.15,
    .bumps = {.count = 3, .reach_least_mm = 200, .reach_most_mm = 400, .low = 0.45F, .high = 0.8F, .aside_mm = 170},
    .bump_least_mm = 3,
    .bump_most_mm = 10,
    .trunk = {.bumps = 12,
              .bump_least_mm = 6,
              .bump_most_mm = 24,
              .slides = 4,
              .slide_sd_mm = 12,
              .warps = 5,
              .warp_sd_mm = 11,
              .warp_stretch_sd = 0.05,
              .shifts = 4,
              .shift_sd_mm = 5},
    .neck = {.low = 0.79F,
             .high = 0.96F,
             .bumps = 4,
             .bump_least_mm = 2,
             .bump_most_mm = 8,
             .bump_reach_least_mm = 60,
             .bump_reach_most_mm = 160,
             .warps = 2,
             .warp_sd_mm = 6,
             .warp_stretch_sd = 0.05,
             .warp_reach_least_mm = 90,
             .warp_reach_most_mm = 220},
    .smoothed_share = 0.5,
    .tape_share_least = 0,
    .girth_sd = 0.02,
    .crown_sd_mm = 8};
// The shape space knows these as well: different all over.
inline constexpr OodVariation kOodAllOver = {
    .modifier_sd = 0.3, .bumps = {.count = 14}, .bump_least_mm = 5, .bump_most_mm = 17, .trunk = {}, .neck = {}};

// Deterministic: depends on the model, seed and index only. `family` is training; truth is measured on the mesh.
Subject draw_ood_subject(const body::BodyModel& model, std::uint64_t seed, std::uint64_t index,
                         const OodVariation& variation = kOodTrunk);
// The same; `rest` becomes what morph_subject() would make of it. `smoother`: of the model, for those who make many.
Subject draw_ood_subject(const body::BodyModel& model, std::uint64_t seed, std::uint64_t index,
                         const OodVariation& variation, std::vector<Vec3f>& rest,
                         const SurfaceSmoother* smoother = nullptr);

}  // namespace im2fit::lab
