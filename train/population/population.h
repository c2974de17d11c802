// SPDX-License-Identifier: Apache-2.0
// The person before the virtual camera: a person of train/population/drawn_people.h, with the parts the body model
// cannot express, and the truth about it. Index and evaluation families differ in shape, not only in seed.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "body/model.h"
#include "core/measurement.h"
#include "train/population/drawn_people.h"

namespace im2fit::lab {

using body::Family;

struct Actor;  // train/population/actor.h

struct Subject {
  std::uint64_t seed = 0;  // of this person alone: differs between families also for the same seed and index
  Family family = Family::training;
  bool woman = false;
  body::Params params;
  MeasurementValues truth{};           // measured on the mesh, offsets included
  std::vector<Vec3f> rest_offset_mm;   // per body vertex additions the model cannot express (held_out: asymmetry,
                                       // bumps; training: smaller bumps); empty for none
  std::shared_ptr<const Actor> actor;  // shown in place of the body model; null: the model. An actor stands and
                                       // walks bare. It has no clothes and does not sit
};

// Deterministic: depends on the model, family, seed and index only. Even indices are men, odd ones women.
Subject draw_subject(const body::BodyModel& model, Family family, std::uint64_t seed, std::uint64_t index);
// The same; `rest` becomes what morph_subject() would make of it, which is at hand here.
Subject draw_subject(const body::BodyModel& model, Family family, std::uint64_t seed, std::uint64_t index,
                     std::vector<Vec3f>& rest);

// The same, not measured yet: `truth` is zero.
Subject draw_unmeasured(const body::BodyModel& model, Family family, std::uint64_t seed, std::uint64_t index,
                        std::vector<Vec3f>& rest);

// The subject a camera shows when only a seed is given: a woman for odd seeds, a man for even ones.
constexpr std::uint64_t subject_of_seed(std::uint64_t seed) {
  return seed % 2;
}

// The rest mesh of a subject, offsets applied; out has model.vertex_count() places.
void morph_subject(const body::BodyModel& model, const Subject& subject, std::span<Vec3f> out);

}  // namespace im2fit::lab
