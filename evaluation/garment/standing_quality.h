// SPDX-License-Identifier: Apache-2.0
// What a viewer may see wrong with one garment on a standing person, counted in pictures from eight sides and along
// its rims. All of cloth as pictures and avatars show it (Outfit::shown, skin that Outfit::hidden_skin names left
// out).
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "body/model.h"
#include "garment/drape/outfit.h"
#include "report/dressed_picture.h"

namespace im2fit::lab {

inline constexpr std::size_t kStandingViews = 8;  // about the person, every 45 degrees, from the front on
inline constexpr float kStandingPixelMm = 3;      // of those pictures
inline constexpr float kHemOffMm = 5;             // a hem's point nearer to its plane than this is level
PictureView standing_view(std::size_t view);

// A fault that is a pixel: where it is, in the body's axes.
struct SeenFault {
  std::size_t view = 0;
  Vec3f place;
  bool skin = false;  // else cloth's inside
};

// A vertex of a hem: where it is in the pattern's left half, and how far it lies above its hem's plane.
struct HemPoint {
  body::Flat place;
  std::uint8_t layer = body::kFrontLayer;
  float above_mm = 0;
};

struct StandingQuality {
  int cloth_px = 0;    // of all views
  int skin_px = 0;     // of skin that the garment should cover: its nearest cloth that faces as it does is no rim's
  int crossed_px = 0;  // of cloth's inside, seen otherwise than through an opening: there cloth has crossed cloth
  float rim_mm = 0;    // rim_roughness_mm
  // Hems lie level in the pattern, so round the body in a plane: the share of their points within kHemOffMm of their
  // hem's plane, and the largest distance.
  float hem_share = 1, hem_off_mm = 0;
  std::vector<HemPoint> hem_points;
  std::vector<SeenFault> faults;
};
StandingQuality judge_standing(const body::BodyModel& model, const body::Outfit& outfit, std::size_t cloth);

// How far a hem's points lie above the plane that is nearest to them in height; no hem may stand upright.
std::vector<float> above_plane_mm(const std::vector<Vec3f>& points);

}  // namespace im2fit::lab
