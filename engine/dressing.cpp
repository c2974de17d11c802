// SPDX-License-Identifier: Apache-2.0
#include "engine/dressing.h"

#include <cmath>
#include <utility>

#include "body/measure.h"
#include "engine/builtin_tape.h"

namespace im2fit {

Result<std::vector<BodyGirth>> girths_for(const body::GarmentPattern& pattern, const body::Tape& tape,
                                          std::span<const float> values, std::span<const TapeInterval> intervals) {
  constexpr float kSdsInInterval = 2 * 1.96F;  // 95 % of a normal distribution
  std::vector<BodyGirth> girths;
  for (const body::FitRegion& region : pattern.regions) {
    const int index = definition_index(tape, region.measure);
    if (index < 0)
      return Error{ErrorCode::invalid_argument, pattern.id + ": regions." + region.id + " names " + region.measure +
                                                    ", which is no measurement of the tape"};
    const auto i = static_cast<std::size_t>(index);
    if (!(values[i] > 0)) return Error{ErrorCode::unsupported, region.measure + " is not measured on this body"};
    BodyGirth girth{values[i], 0};
    if (i < intervals.size() && intervals[i].known)
      girth.sd_mm = (intervals[i].high - intervals[i].low) / kSdsInInterval;
    girths.push_back(girth);
  }
  return girths;
}

std::vector<GarmentFit> fits_of(const Wardrobe& wardrobe, const SizeSystem& charts, float female,
                                const body::Tape& tape, std::span<const float> values,
                                std::span<const TapeInterval> intervals) {
  const bool woman = female > 0.5F;
  std::vector<GarmentFit> fits;
  for (const body::GarmentPattern& pattern : wardrobe.garments) {
    const auto girths = girths_for(pattern, tape, values, intervals);
    if (!girths) continue;
    fits.push_back(fit_garment(pattern, wardrobe.law, woman ? charts.women : charts.men, woman, *girths));
  }
  return fits;
}

std::vector<Worn> everyday_clothes(const Wardrobe& wardrobe, std::span<const GarmentFit> fits) {
  std::vector<Worn> worn;
  for (const char* id : {"trousers", "t_shirt"})
    for (const GarmentFit& fit : fits)
      if (fit.garment == id && !fit.sizes.empty())
        worn.push_back({wardrobe.garment(id), fit.sizes[fit.best].chest_mm});
  return worn;
}

Result<std::unique_ptr<body::Outfit>> dress(const Wardrobe& wardrobe, const body::BodyModel& model,
                                            const body::Params& params, const body::Pose& pose, bool woman,
                                            std::span<const Worn> worn, bool moves) {
  std::vector<Vec3f> rest(static_cast<std::size_t>(model.vertex_count()));
  model.morph(params, rest);
  const float inside_leg_mm = body::inside_leg_mm(model, rest);
  std::vector<body::Outfit::Piece> pieces;
  for (const Worn& one : worn) {
    const body::Fabric* fabric = wardrobe.fabric(one.pattern->fabric);
    if (fabric == nullptr)
      return Error{ErrorCode::not_found, one.pattern->id + ": no fabric is called " + one.pattern->fabric};
    const body::CutBody cut = body::turned_up(body::cut_body(wardrobe.law, woman, one.chest_mm), inside_leg_mm);
    pieces.push_back(body::Outfit::piece(*one.pattern, cut, *fabric, moves));
  }
  auto outfit = std::make_unique<body::Outfit>(model, std::move(pieces));
  outfit->dress(rest, body::rest_skeleton(model, rest), pose);
  return outfit;
}

Result<std::unique_ptr<body::Outfit>> dress_everyday(const Wardrobe& wardrobe, const SizeSystem& charts,
                                                     const body::BodyModel& model, const body::Params& params,
                                                     const body::Pose& pose, float female) {
  const body::Tape& tape = builtin_tape();
  std::vector<float> values(tape.definitions.size());
  body::TapeMeasurer(model).measure(tape, params, values);
  const auto fits = fits_of(wardrobe, charts, female, tape, values, {});
  return dress(wardrobe, model, params, pose, female > 0.5F, everyday_clothes(wardrobe, fits));
}

}  // namespace im2fit
