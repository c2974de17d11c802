// SPDX-License-Identifier: Apache-2.0
#include "person/dressing.h"

#include <memory>
#include <utility>

#include "body/measure.h"
#include "person/builtin_tape.h"

namespace im2fit {

Result<std::unique_ptr<body::Outfit>> dress(const Wardrobe& wardrobe, const body::BodyModel& model,
                                            const body::Params& params, const body::Pose& pose, bool woman,
                                            std::span<const Worn> worn, bool moves) {
  std::vector<Vec3f> rest(static_cast<std::size_t>(model.vertex_count()));
  model.morph(params, rest);
  return dress(wardrobe, model, rest, body::rest_skeleton(model, rest), pose, woman, worn, moves);
}

Result<std::unique_ptr<body::Outfit>> dress(const Wardrobe& wardrobe, const body::BodyModel& model,
                                            std::span<const Vec3f> rest, const body::Skeleton& skeleton,
                                            const body::Pose& pose, bool woman, std::span<const Worn> worn,
                                            bool moves) {
  const float inside_leg_mm = body::inside_leg_mm(model, rest);
  std::vector<body::Outfit::Piece> pieces;
  for (const Worn& one : worn) {
    const body::Fabric* fabric = wardrobe.fabric(one.pattern->fabric);
    if (fabric == nullptr)
      return Error{ErrorCode::not_found, one.pattern->id + ": no fabric is called " + one.pattern->fabric};
    const body::CutBody cut =
        body::turned_up(body::cut_body(wardrobe.regression, woman, one.chest_mm), inside_leg_mm);
    if (const auto checked = body::check_cut(*one.pattern, cut); !checked) return checked.error();
    pieces.push_back(body::Outfit::piece(*one.pattern, cut, *fabric, moves));
  }
  auto outfit = std::make_unique<body::Outfit>(model, std::move(pieces));
  outfit->dress(rest, skeleton, pose);
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
