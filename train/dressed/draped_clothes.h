// SPDX-License-Identifier: Apache-2.0
// Evaluation people in garments of garment/drape: clothes that no index was taught. The tailor's (clothing.h), which
// teach, are moulded on the skin; these are cut flat in the sizes of a chart and hang on the posed body.
#pragma once

#include <string>
#include <vector>

#include "body/model.h"
#include "core/rng.h"
#include "train/population/scene_person.h"

namespace im2fit::lab {

struct GarmentChoice {
  std::vector<std::string> garments;  // ids, in this order from the skin
  int sizes_larger = 0;               // than what fits best: 0 or 1
};
// A shirt, short- or long-sleeved, over trousers; half of all people wear one size larger.
GarmentChoice draw_garments(Rng& rng);

// Hangs them on a person in the sizes for that person's girths (bought_chest_mm). About half a second a call. The
// model must outlive it.
Dresser dresser_of(const body::BodyModel& model, bool woman, const GarmentChoice& choice);

}  // namespace im2fit::lab
