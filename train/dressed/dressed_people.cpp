// SPDX-License-Identifier: Apache-2.0
#include "train/dressed/dressed_people.h"

#include <algorithm>
#include <cstddef>
#include <span>

#include "body/measure.h"
#include "body/tape.h"
#include "garment/drape/outfit.h"
#include "person/builtin_tape.h"
#include "person/dressing.h"
#include "person/garment_fit.h"
#include "person/size_chart.h"
#include "train/population/drawn_people.h"
#include "train/population/solve.h"

namespace im2fit::lab {
namespace {

using body::Mat3f;
using body::Segment;

std::size_t at(Segment s) {
  return static_cast<std::size_t>(s);
}

// Turns parts of a relaxed body, each relative to its parent.
class Posing {
 public:
  explicit Posing(const body::Pose& relaxed) {
    for (std::size_t s = 0; s < local_.size(); ++s) {
      const int parent = body::kSegmentParent[s];
      local_[s] = parent < 0
                      ? relaxed.rotation[s]
                      : body::transpose(relaxed.rotation[static_cast<std::size_t>(parent)]) * relaxed.rotation[s];
    }
  }
  // Follows the rotations so far.
  Posing& turn(Segment s, Vec3f axis, float degrees) {
    local_[at(s)] = body::rotation_about(axis, degrees) * local_[at(s)];
    return *this;
  }
  // Both sides, mirrored: axes of the left one.
  Posing& both(Segment left, Segment right, Vec3f axis, float degrees) {
    turn(left, axis, degrees);
    return turn(right, {axis.x, -axis.y, -axis.z}, degrees);
  }
  body::Pose pose() const { return body::pose_from_local(local_); }

 private:
  std::array<Mat3f, body::kSegmentCount> local_;
};

void add(const body::Outfit& outfit, std::size_t index, Vec3f by, DrapedCloth& out) {
  const body::GarmentMesh& mesh = outfit.cloth(index).mesh();
  std::vector<Vec3f> places(mesh.vertex_count());
  outfit.shown(index, places);
  const auto first = static_cast<std::int32_t>(out.vertices.size());
  for (const Vec3f& p : places) out.vertices.push_back(p + by);
  for (const Triangle& t : mesh.triangles) out.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
}

}  // namespace

DressedPerson dressed_person(const body::BodyModel& model, std::string name, bool woman, const body::Params& params) {
  DressedPerson p;
  p.name = std::move(name);
  p.woman = woman;
  p.params = params;
  p.rest.resize(static_cast<std::size_t>(model.vertex_count()));
  model.morph(params, p.rest);
  p.skeleton = body::rest_skeleton(model, p.rest);
  p.tape.resize(builtin_tape().definitions.size());
  body::TapeMeasurer(model).measure(builtin_tape(), params, p.tape);
  return p;
}

std::vector<DressedPerson> example_people(const body::BodyModel& model) {
  std::vector<DressedPerson> people;
  struct Build {
    const char* name;
    double body_mass_index;
    float muscle;
  };
  for (const bool woman : {false, true})
    for (const Build& build : {Build{"thin", 17.5, 0.4F}, Build{"median", 24, 0.5F}, Build{"heavy", 35, 0.35F}}) {
      body::Params params;
      params.gender = woman ? 0 : 1;
      params.age_years = 35;
      params.muscle = build.muscle;
      const double stature_mm = woman ? 1640 : 1770;
      body::solve_stature_and_weight(model, params, stature_mm,
                                     build.body_mass_index * stature_mm * stature_mm * 1e-6);
      people.push_back(dressed_person(model, std::string(build.name) + (woman ? "-woman" : "-man"), woman, params));
    }
  return people;
}

DressedPerson drawn_person(const body::BodyModel& model, std::uint64_t number) {
  constexpr std::uint64_t kSeed = 0x6472;
  const body::Drawn drawn = body::draw_person(model, body::Family::held_out, kSeed, number);
  return dressed_person(model, "person-" + std::to_string(number), drawn.woman, drawn.params);
}

float bought_chest_mm(const DressedPerson& person, const body::GarmentPattern& pattern, int steps) {
  const SizeChart& chart = person.woman ? builtin_size_system().women : builtin_size_system().men;
  const auto girths = girths_for(pattern, builtin_tape(), person.tape, {});
  int row = 0;
  if (girths)
    row = static_cast<int>(fit_garment(pattern, builtin_wardrobe().regression, chart, person.woman, *girths).best);
  row = std::clamp(row + steps, 0, static_cast<int>(chart.rows.size()) - 1);
  return im2fit::size_chest_mm(chart.rows[static_cast<std::size_t>(row)]);
}

std::vector<NamedPose> dressed_poses(const body::BodyModel& model, const DressedPerson& person) {
  const body::Pose relaxed = body::relaxed_pose(person.skeleton, body::relaxed_spread_deg(model, person.rest));
  using S = Segment;
  std::vector<NamedPose> poses;
  poses.push_back({"relaxed", relaxed});
  poses.push_back({"arms-level", body::arms_out_pose(person.skeleton)});
  poses.push_back({"psi", body::psi_pose(person.skeleton)});
  poses.push_back({"arms-up", Posing(body::arms_out_pose(person.skeleton))
                                  .both(S::left_shoulder, S::right_shoulder, {0, 0, 1}, 12)
                                  .both(S::left_upper_arm, S::right_upper_arm, {0, 0, 1}, 60)
                                  .pose()});
  poses.push_back({"elbows", Posing(relaxed)
                                 .both(S::left_upper_arm, S::right_upper_arm, {0, 0, 1}, 20)
                                 .both(S::left_lower_arm, S::right_lower_arm, {1, 0, 0}, -100)
                                 .pose()});
  poses.push_back({"twist", Posing(relaxed).turn(S::abdomen, {0, 1, 0}, 20).turn(S::chest, {0, 1, 0}, 20).pose()});
  poses.push_back({"bow", Posing(relaxed).turn(S::abdomen, {1, 0, 0}, 20).turn(S::chest, {1, 0, 0}, 20).pose()});
  poses.push_back({"stride", Posing(relaxed)
                                 .turn(S::left_upper_leg, {1, 0, 0}, -28)
                                 .turn(S::left_lower_leg, {1, 0, 0}, 10)
                                 .turn(S::right_upper_leg, {1, 0, 0}, 22)
                                 .turn(S::right_lower_leg, {1, 0, 0}, 12)
                                 .pose()});
  poses.push_back(
      {"knee",
       Posing(relaxed).turn(S::left_upper_leg, {1, 0, 0}, -75).turn(S::left_lower_leg, {1, 0, 0}, 90).pose()});
  poses.push_back({"sitting", Posing(relaxed)
                                  .both(S::left_upper_arm, S::right_upper_arm, {0, 0, 1}, 15)
                                  .both(S::left_upper_leg, S::right_upper_leg, {1, 0, 0}, -80)
                                  .both(S::left_lower_leg, S::right_lower_leg, {1, 0, 0}, 85)
                                  .pose()});
  return poses;
}

std::vector<body::Outfit::Piece> pieces_for(const DressedPerson& person, const std::vector<std::string>& garments,
                                            int steps, bool moves) {
  const Wardrobe& wardrobe = builtin_wardrobe();
  const float leg = person.tape[static_cast<std::size_t>(definition_index(builtin_tape(), "inside_leg"))];
  std::vector<body::Outfit::Piece> pieces;
  for (const std::string& id : garments) {
    const body::GarmentPattern* pattern = wardrobe.garment(id);
    const auto own = id.ends_with(".yaml") ? load_garment(id) : Result<body::GarmentPattern>(Error{});
    if (own) pattern = &*own;
    if (pattern == nullptr) continue;
    const float chest = bought_chest_mm(person, *pattern, steps);
    const body::CutBody cut = body::turned_up(body::cut_body(wardrobe.regression, person.woman, chest), leg);
    pieces.push_back(body::Outfit::piece(*pattern, cut, *wardrobe.fabric(pattern->fabric), moves));
  }
  return pieces;
}

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
