// SPDX-License-Identifier: Apache-2.0
// What falls free of the body: a shirt's tail, the seat and legs of trousers, short sleeves. Tubes about the posed
// trunk and limbs, drawn over clothes that lie on the skin (clothing.h): where those stand out farther they are seen.
#pragma once

#include <optional>
#include <span>

#include "body/model.h"
#include "body/skeleton.h"
#include "core/rng.h"
#include "train/population/drape.h"

namespace im2fit::lab {

// How one outfit is cut. Ends of limbs: 1 at knee or elbow, 2 at the ankle.
struct HangingCut {
  // Where cloth rests within the room it has about a limb, -1..1: outwards, forwards.
  struct Rest {
    float outwards = 0, forwards = 0;
  };
  struct Shirt {
    float end = 0;       // height of the hem over the hips, in shares of hips to shoulders
    float flare_mm = 0;  // farther out at the hem than the surface above
    float slack_mm = 0;  // TrunkHang
    float fold_mm = 0;
    int folds = 0;  // round the hem
    float phase = 0;
  } shirt;
  struct Trousers {
    float drop_mm = 0;  // of their crotch below the body's
    float end = 0;
    float thigh_mm = 0;   // off the thigh
    float hem = 0;        // radius at the end, in radii of the calf; of shorts, of the thigh
    float narrowing = 1;  // 1: evenly from thigh to hem; more: above the knee
    Rest rest;
  };
  std::optional<Trousers> trousers;
  struct Sleeve {
    float end = 0;
    bool is_short = false;
    float room_mm = 0;  // off the arm: a short one's at the end, a long one's halfway to the elbow
    Rest rest;
  };
  std::optional<Sleeve> sleeve;
};

// `sleeve_end`, `leg_end`: of the layer on the skin, below it; skirts have no legs.
HangingCut draw_hanging_cut(Rng& rng, float sleeve_end, float leg_end, bool skirt);

// `worn`: body vertices dressed and posed by body::skin(), then whatever stands on the floor. Nothing hangs below
// the lowest of them.
DrapedCloth hang_clothes(const body::BodyModel& model, const HangingCut& cut, std::span<const Vec3f> worn,
                         const body::PosedSkeleton& bones);

}  // namespace im2fit::lab
