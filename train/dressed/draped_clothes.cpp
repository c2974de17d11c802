// SPDX-License-Identifier: Apache-2.0
#include "train/dressed/draped_clothes.h"

#include <cstddef>
#include <span>

#include "body/tape.h"
#include "garment/drape/outfit.h"
#include "person/builtin_tape.h"
#include "train/dressed/dressed_people.h"

namespace im2fit::lab {
namespace {

void add(const body::Outfit& outfit, std::size_t index, Vec3f by, DrapedCloth& out) {
  const body::GarmentMesh& mesh = outfit.cloth(index).mesh();
  std::vector<Vec3f> places(mesh.vertex_count());
  outfit.shown(index, places);
  const auto first = static_cast<std::int32_t>(out.vertices.size());
  for (const Vec3f& p : places) out.vertices.push_back(p + by);
  for (const Triangle& t : mesh.triangles) out.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
}

}  // namespace

GarmentChoice draw_garments(Rng& rng) {
  GarmentChoice choice;
  choice.garments = {"trousers", rng.index(2) == 0 ? "t_shirt" : "long_sleeved_shirt"};
  choice.sizes_larger = rng.index(2);
  return choice;
}

Dresser dresser_of(const body::BodyModel& model, bool woman, const GarmentChoice& choice) {
  return
      [&model, woman, choice](std::span<const Vec3f> rest, const body::Skeleton& skeleton, const body::Pose& pose) {
        DressedPerson person;
        person.woman = woman;
        person.rest.assign(rest.begin(), rest.end());
        person.skeleton = skeleton;
        person.tape.resize(builtin_tape().definitions.size());
        body::TapeMeasurer(model).measure_rest_mesh(builtin_tape(), person.rest, woman ? 0.0F : 1.0F, person.tape);
        body::Outfit outfit(model, pieces_for(person, choice.garments, choice.sizes_larger));
        outfit.dress(person.rest, person.skeleton, pose);
        DrapedCloth cloth;
        for (std::size_t i = 0; i < outfit.size(); ++i) add(outfit, i, pose.translation_mm, cloth);
        return cloth;
      };
}

}  // namespace im2fit::lab
