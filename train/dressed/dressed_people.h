// SPDX-License-Identifier: Apache-2.0
// People to dress, and poses to see them in.
#pragma once

#include <string>
#include <vector>

#include "body/model.h"
#include "body/skeleton.h"
#include "garment/drape/outfit.h"
#include "garment/pattern.h"
#include "person/garment_file.h"

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

}  // namespace im2fit::lab
