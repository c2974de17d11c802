// SPDX-License-Identifier: Apache-2.0
// What people wear: a garment layer over the rest mesh, hair with volume, shoes.
//
// Cloth lies along the body's normals at an ease that differs by region and person, spans small hollows and carries
// low-frequency folds; hems are steps. It uses the body's own vertices (and MakeHuman's skirt), so that it is posed
// by the body's skinning. Head, neck above the collar and hands stay bare.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "body/model.h"
#include "body/skeleton.h"
#include "core/rng.h"
#include "train/population/hanging_clothes.h"
#include "train/render/raster.h"

namespace im2fit::lab {

// hanging: a wide shirt that falls from chest, belly and shoulder blades as a tube, off the waist by as much as it
// takes, wide legs and short sleeves (hanging_clothes.h). garments: shoes and hair are the tailor's, what covers the
// skin is draped (scene_person.h).
enum class Clothing : std::uint8_t { none, tight, normal, loose, hanging, garments };

// Distance from skin to the cloth's outside wherever there is cloth, mm: tight 3..8, normal 4..20, loose 6..28 on the
// trunk and 6..20 on the limbs, hanging 4..120 of a shirt on the trunk, 4..28 elsewhere. Skirts and what hangs as a
// tube are free of the body and not held to it. Where posed skin meets skin (armpits, groin, bent knees)
// layers run into each other, unseen.
struct EaseRange {
  float least_mm = 0;
  float most_mm = 0;
};
// `shirt`: on the trunk.
EaseRange ease_range(Clothing clothing, bool shirt);
inline constexpr float kHairMostMm = 40;
inline constexpr float kSoleLeastMm = 10;
inline constexpr float kSoleMostMm = 30;

enum class Cover : std::uint8_t { bare, upper, lower, hair };

// One person's things on the rest mesh.
struct Outfit {
  std::vector<Vec3f> rest;            // model.vertex_count(): the body's vertices moved to the cloth's outside
  std::vector<Cover> cover;           // body_vertex_count
  std::vector<std::uint8_t> hair;     // of the body's triangles: 1 hair
  std::vector<Triangle> skirt;        // open, into `rest`; empty for trousers
  std::vector<Vec3f> shoe;            // rest axes; first half left, second half right; feet are inside
  std::vector<Triangle> shoe_body;    // closed, into `shoe`
  std::optional<HangingCut> hanging;  // over all this, for a posed person
  float sole_mm = 0;                  // under the foot; 0: barefoot
};

// Crown, sides and back of the head: per body vertex, from the rest mesh and the head bone.
bool in_hair_region(const body::Skeleton& skeleton, float crown_y_mm, Vec3f rest_vertex);

// Dresses people of one model. Keeps scratch: not shareable between threads.
class Tailor {
 public:
  explicit Tailor(const body::BodyModel& model);
  // `rest`: model.vertex_count() vertices of the naked rest mesh. Depends on the arguments and rng only.
  void dress(std::span<const Vec3f> rest, const body::Skeleton& skeleton, bool woman, Clothing clothing, bool hair,
             Rng& rng, Outfit& out);

 private:
  // Where a vertex is on the body: its part and how far along it (limbs: 0 at the root, 1 at the middle joint, 2 at
  // wrist or ankle; neck: 0..1; trunk: 0 at the hips' height, 1 at the shoulders').
  enum class Part : std::uint8_t { trunk, neck, head, arm, hand, leg, foot };
  struct Place {
    Part part = Part::trunk;
    float along = 0;
    float radius_mm = 0;  // from the bone
    // About the trunk's axis: height (0 hips, 1 shoulders), distance and direction (0 front, left positive, radians).
    float up = 0;
    float out_mm = 0;
    float angle = 0;
  };
  struct Cut;
  static Cut draw_cut(Clothing clothing, bool woman, Rng& rng);
  EaseRange range_of(std::size_t vertex, const Cut& cut) const;
  void find_normals(std::span<const Vec3f> rest);
  void locate(std::span<const Vec3f> rest, const body::Skeleton& skeleton);
  Cover cover_of(const Place& place, const Cut& cut) const;
  float ease_of(std::size_t vertex, const Cut& cut, Cover cover) const;
  void hang(const Cut& cut, const Outfit& out);
  void clothe(std::span<const Vec3f> rest, const Cut& cut, Rng& rng, Outfit& out);
  void grow_hair(std::span<const Vec3f> rest, const body::Skeleton& skeleton, bool woman, Rng& rng, Outfit& out);
  void hang_skirt(std::span<const Vec3f> rest, const Cut& cut, Rng& rng, Outfit& out) const;

  const body::BodyModel& model_;
  std::vector<std::int32_t> neighbour_first_, neighbour_;  // by body vertex, along quad edges
  std::vector<Vec3f> normal_, spare_;
  std::vector<Place> place_;
  std::vector<float> ease_, base_, next_;
  float hips_y_ = 0, shoulders_y_ = 0;
  Vec3f axis_;  // the trunk's
};

}  // namespace im2fit::lab
