// SPDX-License-Identifier: Apache-2.0
#include "train/population/ood_subjects.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <vector>

#include "body/measure.h"
#include "core/rng.h"
#include "train/population/drawn_people.h"
#include "train/population/shape_spread.h"
#include "train/population/shape_variation.h"
#include "train/population/surface_smoother.h"

namespace im2fit::lab {
namespace {

constexpr std::uint64_t kOodStream = 0x57A6, kMakeStream = 0x57A7;

// Spread of a modifier in either family; "l-" and "r-" variants belong to the pair's row.
bool used(std::string_view name) {
  const auto plain = [](std::string_view n) {
    std::string out(n);
    const std::size_t slash = out.find('/') + 1;
    if (out.compare(slash, 2, "l-") == 0 || out.compare(slash, 2, "r-") == 0) out.erase(slash, 2);
    return out;
  };
  return std::any_of(body::modifier_spreads().begin(), body::modifier_spreads().end(),
                     [&](const body::ModifierSpread& row) { return plain(row.name) == plain(name); });
}

// Lengths of bones vary freely in training already; hands, feet and parts moved sideways have nothing to do with
// measurements. What is left changes shapes.
bool is_shape(std::string_view name) {
  for (const std::string_view word : {"hand", "foot", "trans-horiz", "vert", "height", "arm-scale"})
    if (name.find(word) != name.npos) return false;
  return true;
}

// Another surface under other dimensions, of the same stature, weight and age.
void make_anew(const body::BodyModel& model, const Subject& subject, const OodVariation& variation, Rng& rng,
               const SurfaceSmoother* smoother, std::vector<Vec3f>& rest) {
  const double share = rng.uniform();  // most are smoothed little: passes are drawn by their logarithm
  const double passes =
      variation.passes_least * std::pow(static_cast<double>(variation.passes_most) / variation.passes_least, share);
  if (smoother != nullptr)
    smoother->run(rest, static_cast<int>(passes));
  else
    SurfaceSmoother(model).run(rest, static_cast<int>(passes));
  const body::Warp warp =
      body::draw_warp(model, subject.woman, body::draw_build(Family::training, subject.woman, subject.seed), rng,
                      rest, rng.uniform(variation.tape_share_least, 1), variation.girth_sd);
  body::apply_warp(model, warp, rest);
}

}  // namespace

Subject draw_ood_subject(const body::BodyModel& model, std::uint64_t seed, std::uint64_t index,
                         const OodVariation& variation) {
  std::vector<Vec3f> rest;
  return draw_ood_subject(model, seed, index, variation, rest);
}

Subject draw_ood_subject(const body::BodyModel& model, std::uint64_t seed, std::uint64_t index,
                         const OodVariation& variation, std::vector<Vec3f>& rest, const SurfaceSmoother* smoother) {
  Subject subject = draw_unmeasured(model, Family::training, seed ^ kOodStream, index, rest);
  Rng rng = Rng::for_item(subject.seed, kOodStream, index);
  const auto names = model.modifier_names();
  subject.params.modifiers.resize(names.size(), 0.0F);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const double sd = variation.modifier_sd;
    const double value = std::clamp(rng.normal(0, sd), -2.2 * sd, 2.2 * sd);
    if (!used(names[i]) && is_shape(names[i])) subject.params.modifiers[i] += static_cast<float>(value);
  }
  model.morph(subject.params, rest);
  subject.rest_offset_mm.resize(static_cast<std::size_t>(model.body_vertex_count()));
  const double amplitude_mm =
      rng.uniform(static_cast<double>(variation.bump_least_mm), static_cast<double>(variation.bump_most_mm));
  add_bumps(model, rest, variation.bumps, static_cast<float>(amplitude_mm), rng, subject.rest_offset_mm);
  for (const Mirrored* part : {&variation.trunk, &variation.neck})
    add_mirrored(model, rest, *part, rng, subject.rest_offset_mm);
  if (variation.crown_sd_mm > 0)
    raise_crown(model, rest, static_cast<float>(rng.normal()) * variation.crown_sd_mm, subject.rest_offset_mm);
  for (std::size_t i = 0; i < subject.rest_offset_mm.size(); ++i) rest[i] = rest[i] + subject.rest_offset_mm[i];
  Rng make = Rng::for_item(subject.seed, kMakeStream, index);
  if (make.uniform() < variation.smoothed_share) {
    std::vector<Vec3f> plain(rest.size());
    model.morph(subject.params, plain);
    make_anew(model, subject, variation, make, smoother, rest);
    // Of all vertices: joints move with the surface.
    subject.rest_offset_mm.resize(rest.size());
    for (std::size_t i = 0; i < rest.size(); ++i) subject.rest_offset_mm[i] = rest[i] - plain[i];
    for (std::size_t i = 0; i < rest.size(); ++i)
      rest[i] = plain[i] + subject.rest_offset_mm[i];  // as morph_subject()
  }
  subject.truth = body::measure_rest_mesh(model, rest, subject.params.gender);
  return subject;
}

}  // namespace im2fit::lab
