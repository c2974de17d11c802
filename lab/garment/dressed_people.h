// SPDX-License-Identifier: Apache-2.0
// People to dress, and poses to see them in.
#pragma once

#include <string>
#include <vector>

#include "body/garment/outfit.h"
#include "body/garment/pattern.h"
#include "body/model.h"
#include "body/skeleton.h"
#include "engine/report/garment_file.h"

namespace im2fit::lab {

struct DressedPerson {
  std::string name;
  bool woman = false;
  body::Params params;
  std::vector<Vec3f> rest;
  body::Skeleton skeleton;
  float chest_mm = 0, hip_mm = 0;
};
// "thin", "median", "heavy" of each sex: body mass indices 17.5, 24, 35.
std::vector<DressedPerson> example_people(const body::BodyModel& model);
// Of the held-out family, by number.
DressedPerson drawn_person(const body::BodyModel& model, std::uint64_t number);

// The mean of the size's chest girths, by EN 13402-3: the size a chest would buy, and `steps` sizes larger.
float bought_chest_mm(bool woman, float chest_mm, int steps = 0);
// Trousers are bought by the hips: the chest of the size whose body has them.
float bought_chest_for_hip_mm(const body::CutLaw& law, bool woman, float hip_mm);

struct NamedPose {
  std::string name;
  body::Pose pose;
};
// relaxed, arms level, arms up, elbows bent, psi, twist, stride, bow, knee bent, sitting.
std::vector<NamedPose> dressed_poses(const body::BodyModel& model, const DressedPerson& person);

// Garments by id or file (.yaml), in this order from the skin; each in the size the person would buy.
std::vector<body::Outfit::Piece> pieces_for(const DressedPerson& person, const std::vector<std::string>& garments,
                                            int steps = 0);

}  // namespace im2fit::lab
