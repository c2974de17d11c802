// SPDX-License-Identifier: Apache-2.0
#include "train/population/population.h"

#include <cstddef>

#include "body/measure.h"
#include "core/rng.h"
#include "train/population/shape_variation.h"

namespace im2fit::lab {
namespace {

constexpr std::uint64_t kOffsetStream = 0x9003;
constexpr double kCrownSdMm = 5;  // skulls differ more than MakeHuman's (ANSUR II: tragion to crown 131 +- 6 mm)

void draw_offsets(const body::BodyModel& model, Subject& subject, std::span<const Vec3f> rest) {
  if (subject.family == Family::paper) return;
  Rng rng = Rng::for_item(subject.seed, kOffsetStream, 0);
  subject.rest_offset_mm.resize(static_cast<std::size_t>(model.body_vertex_count()));
  const bool held_out = subject.family == Family::held_out;
  const auto amplitude = static_cast<float>(held_out ? rng.uniform(2, 6) : rng.uniform(0.5, 3));
  add_bumps(model, rest, {.count = held_out ? 10 : 6}, amplitude, rng, subject.rest_offset_mm);
  if (!held_out) raise_crown(model, rest, static_cast<float>(rng.normal(0, kCrownSdMm)), subject.rest_offset_mm);
  if (held_out) add_asymmetry(model, rest, static_cast<float>(rng.uniform(2, 6)), rng, subject.rest_offset_mm);
}

}  // namespace

Subject draw_subject(const body::BodyModel& model, Family family, std::uint64_t seed, std::uint64_t index) {
  std::vector<Vec3f> rest;
  return draw_subject(model, family, seed, index, rest);
}

Subject draw_subject(const body::BodyModel& model, Family family, std::uint64_t seed, std::uint64_t index,
                     std::vector<Vec3f>& rest) {
  Subject subject = draw_unmeasured(model, family, seed, index, rest);
  subject.truth = body::measure_rest_mesh(model, rest, subject.params.gender);
  return subject;
}

Subject draw_unmeasured(const body::BodyModel& model, Family family, std::uint64_t seed, std::uint64_t index,
                        std::vector<Vec3f>& rest) {
  body::Drawn drawn = body::draw_person(model, family, seed, index);
  Subject subject;
  subject.seed = drawn.seed;
  subject.family = family;
  subject.woman = drawn.woman;
  subject.params = std::move(drawn.params);
  rest.resize(static_cast<std::size_t>(model.vertex_count()));
  model.morph(subject.params, rest);
  draw_offsets(model, subject, rest);
  for (std::size_t i = 0; i < subject.rest_offset_mm.size(); ++i) rest[i] = rest[i] + subject.rest_offset_mm[i];
  return subject;
}

void morph_subject(const body::BodyModel& model, const Subject& subject, std::span<Vec3f> out) {
  model.morph(subject.params, out);
  for (std::size_t i = 0; i < subject.rest_offset_mm.size(); ++i) out[i] = out[i] + subject.rest_offset_mm[i];
}

}  // namespace im2fit::lab
