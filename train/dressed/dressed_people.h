// SPDX-License-Identifier: Apache-2.0
// People to dress, and poses to see them in.
#pragma once

#include <string>
#include <vector>

#include "body/model.h"
#include "body/skeleton.h"
#include "core/rng.h"
#include "garment/drape/outfit.h"
#include "garment/pattern.h"
#include "person/garment_file.h"
#include "train/population/scene_person.h"

namespace im2fit::lab {

struct DressedPerson {
  std::string name;
  bool woman = false;
  body::Params params;
  std::vector<Vec3f> rest;
  body::Skeleton skeleton;
  std::vector<float> tape;  // values of builtin_tape()
};
DressedPerson dressed_person(const body::BodyModel& model, std::string name, bool woman, const body::Params& params);
// "thin", "median", "heavy" of each sex: body mass indices 17.5, 24, 35.
std::vector<DressedPerson> example_people(const body::BodyModel& model);
// Of the held-out family, by number.
DressedPerson drawn_person(const body::BodyModel& model, std::uint64_t number);

// The size that fits best (fit_garment), and `steps` sizes larger, by the chest girth it is cut for.
float bought_chest_mm(const DressedPerson& person, const body::GarmentPattern& pattern, int steps = 0);

struct NamedPose {
  std::string name;
  body::Pose pose;
};
// relaxed, arms level, arms up, elbows bent, psi, twist, stride, bow, knee bent, sitting.
std::vector<NamedPose> dressed_poses(const body::BodyModel& model, const DressedPerson& person);

// Garments by id or file (.yaml), in this order from the skin; each in the size the person would buy.
std::vector<body::Outfit::Piece> pieces_for(const DressedPerson& person, const std::vector<std::string>& garments,
                                            int steps = 0, bool moves = false);

// Evaluation people in garments of garment/drape: clothes that no index was taught. The tailor's (clothing.h), which
// teach, are moulded on the skin; these are cut flat in the sizes of a chart and hang on the posed body.
struct GarmentChoice {
  std::vector<std::string> garments;  // ids, in this order from the skin
  int sizes_larger = 0;               // than the best fit: 0 or 1
};
// A shirt, short- or long-sleeved, over trousers; half of all people wear one size larger.
GarmentChoice draw_garments(Rng& rng);

// Hangs them on a person in the sizes for that person's girths (bought_chest_mm). About half a second a call. The
// model must outlive it.
Dresser dresser_of(const body::BodyModel& model, bool woman, const GarmentChoice& choice);

}  // namespace im2fit::lab
