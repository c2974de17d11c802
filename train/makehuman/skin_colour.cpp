// SPDX-License-Identifier: Apache-2.0
// Complexion, lips, brows, lashes, scalp, linen, eyes. One complexion for everybody: a depth camera sees no colour,
// and the avatar claims none.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "train/makehuman/hair_cap.h"
#include "train/makehuman/skin_texture.h"
#include "train/makehuman/smooth.h"

namespace im2fit::body::makehuman {
namespace {

constexpr Colour kManSkin = {211, 167, 142}, kWomanSkin = {219, 177, 153}, kFlushed = {198, 104, 92},
                 kShadow = {140, 92, 76}, kLash = {48, 34, 30}, kManHair = {62, 46, 36}, kWomanHair = {84, 56, 38},
                 kManLips = {181, 113, 103}, kWomanLips = {192, 104, 100}, kMouthLine = {122, 66, 60},
                 kInside = {74, 34, 32}, kBeard = {124, 112, 106}, kLinen = {70, 77, 92}, kBand = {46, 51, 62};

// Places of the face, mm; x outwards from its middle.
constexpr float kEyeX = 31.5F, kEyeY = 729, kLidHalfWidth = 12.8F, kLidHalfHeight = 5.4F;
constexpr float kMouthY = 660, kMouthHalfWidth = 24.5F;
constexpr float kNippleY = 382, kCrotchY = -42;  // of the landmarks

void mix(Colour& colour, const Colour& other, float share) {
  for (std::size_t i = 0; i < 3; ++i) colour[i] += (other[i] - colour[i]) * std::clamp(share, 0.0F, 1.0F);
}

float bump(Vec3f p, Vec3f middle, float radius) {
  const Vec3f d = Vec3f{std::fabs(p.x), p.y, p.z} - middle;
  return std::exp(-dot(d, d) / (radius * radius));
}

// -1..1 at the corners of a lattice, smooth between them (value noise).
float lattice(int x, int y, int z) {
  auto h = static_cast<std::uint32_t>(x) * 0x8DA6B343U ^ static_cast<std::uint32_t>(y) * 0xD8163841U ^
           static_cast<std::uint32_t>(z) * 0xCB1AB31FU;
  h = (h ^ h >> 15U) * 0x2C1B3C6DU;
  h = (h ^ h >> 12U) * 0x297A2D39U;
  return static_cast<float>((h ^ h >> 15U) & 0xFFFFU) / 32767.5F - 1;
}
float noise(Vec3f p) {
  const float fx = std::floor(p.x), fy = std::floor(p.y), fz = std::floor(p.z);
  const int x = static_cast<int>(fx), y = static_cast<int>(fy), z = static_cast<int>(fz);
  const float u = smooth(p.x - fx, 0, 1), v = smooth(p.y - fy, 0, 1), w = smooth(p.z - fz, 0, 1);
  float sum = 0;
  for (int k = 0; k < 8; ++k)
    sum += ((k & 1) != 0 ? u : 1 - u) * ((k & 2) != 0 ? v : 1 - v) * ((k & 4) != 0 ? w : 1 - w) *
           lattice(x + (k & 1), y + (k >> 1 & 1), z + (k >> 2));
  return sum;
}

void paint_face(Colour& colour, Vec3f p, LookOf whose) {
  const bool man = whose == LookOf::man;
  const float x = std::fabs(p.x);
  mix(colour, kFlushed,
      0.20F * bump(p, {42, 692, 128}, 22) + 0.16F * bump(p, {0, 692, 168}, 13) + 0.06F * bump(p, {0, 622, 148}, 14));
  mix(colour, kFlushed, 0.18F * smooth(x, 77, 86) * smooth(p.y, 665, 680));  // ears
  const float across = (x - kEyeX) / 24, over = (p.y - kEyeY) / 15;
  if (p.z > 110) mix(colour, kShadow, (man ? 0.20F : 0.14F) * std::exp(-(across * across + over * over)));
  if (man) {
    const float cheeks = smooth(p.y, 694, 676) * smooth(p.y, 598, 624) * smooth(p.z, 40, 85);
    mix(colour, kBeard, 0.24F * cheeks * (0.85F + 0.15F * noise(p * 0.9F)));
  }
  if (p.z > 120) {  // brows
    const float at = (x - 34) / 22;
    const float middle = 745.5F + 5.5F * (1 - at * at), thick = (man ? 3.5F : 2.5F) * (1 - 0.55F * smooth(x, 28, 52));
    const float share =
        smooth(x, 9, 15) * smooth(x, 54, 48) * smooth(std::fabs(p.y - middle), thick + 1.1F, thick - 1.1F);
    mix(colour, man ? kManHair : kWomanHair, share * (0.78F + 0.18F * noise({x * 0.9F, p.y * 0.3F, 3})));
  }
  if (p.z > 126) {  // the lids' edges
    const float a = (x - kEyeX) / kLidHalfWidth, b = (p.y - kEyeY) / kLidHalfHeight;
    const float edge = std::sqrt(a * a + b * b);
    const float dark = p.y > kEyeY ? (man ? 0.75F : 0.92F) : (man ? 0.3F : 0.45F);
    mix(colour, kLash, dark * smooth(edge, 1.42F, 1.12F));
  }
  // The mouth's inside: behind the lips and the skin about them, which recede to its corners.
  const float front = p.y > 671.5F ? 152.5F : (p.y < 648.5F ? 145.5F : 150.6F);
  if (x < 26 && p.y > 638 && p.y < 684 && p.z > 10 && p.z < front - 0.0185F * x * x) {
    mix(colour, kInside, 1);
  } else if (p.z > 128) {  // lips
    const float t = std::min(x / kMouthHalfWidth, 1.0F);
    const float bow = 1.3F * std::exp(-x * x / 7);
    const float top = kMouthY + 1 + 11.5F * (1 - std::pow(t, 1.8F)) - bow;
    const float low = kMouthY - 13.0F * std::pow(1 - t * t, 0.8F);
    const float share = smooth(p.y, top + 0.9F, top - 1.2F) * smooth(p.y, low - 1.2F, low + 1.2F) *
                        smooth(x, kMouthHalfWidth + 1, kMouthHalfWidth - 2);
    mix(colour, man ? kManLips : kWomanLips, (man ? 0.6F : 0.72F) * share);
    mix(colour, kMouthLine,
        0.7F * smooth(std::fabs(p.y - kMouthY), 1.7F, 0.5F) * smooth(x, kMouthHalfWidth + 1, kMouthHalfWidth - 3));
  }
}

// The skin under the hair, which is also the hair's own colour: its cap shows the same places.
void paint_hair(Colour& colour, Vec3f p, LookOf whose) {
  const float above = above_hairline_mm(p, whose);
  // Long hair ends in the air: its rim, which goes back to the skin below, is hair as well.
  const float rim = whose == LookOf::woman ? 13 * smooth(p.y, 735, 705) : 0;
  const float share = smooth(above + rim + 1.5F * noise(p * 0.35F), -3, whose == LookOf::man ? 7.0F : 3.0F);
  if (share <= 0) return;
  // Strands run from the crown downwards.
  const float turn = std::atan2(p.x, p.z - 30) * 34 / std::numbers::pi_v<float>;
  const float strand = 0.6F * noise({turn, p.y * 0.012F, 1}) + 0.4F * noise({2.7F * turn, p.y * 0.02F, 9});
  Colour hair = whose == LookOf::man ? kManHair : kWomanHair;
  const float combed = 1 - 0.8F * smooth(std::fabs(p.x), 74, 79);  // nothing of the folds of ears shows in it
  for (float& c : hair) c *= 1 + 0.34F * strand * combed;
  mix(colour, hair, share);
}

// Trunks and a top: an avatar without garments is still dressed.
void paint_linen(Colour& colour, const SkinPlace& place, LookOf whose) {
  const Vec3f p = place.at;
  const float x = std::fabs(p.x);
  const bool man = whose == LookOf::man;
  const float body = smooth(place.arm, 0.6F, 0.4F);
  Colour linen = kLinen;
  for (float& c : linen) c *= 1 + 0.05F * noise(p * 0.4F);
  constexpr float kTopY = 92, kBandY = 74;
  const float leg = man ? kCrotchY - 62 : kCrotchY - 18 + 0.55F * std::max(0.0F, x - 30);
  const float trunks = smooth(p.y, leg - 1.2F, leg + 1.2F) * smooth(p.y, kTopY + 1.2F, kTopY - 1.2F) * body;
  mix(colour, linen, trunks);
  mix(colour, kBand, trunks * smooth(p.y, kBandY - 1, kBandY + 1));
  mix(colour, kBand, man ? trunks * smooth(p.y, leg + 9, leg + 7) : 0);
  if (man) return;
  const float hem = kNippleY - 84, edge = kNippleY + 52 - 14 * smooth(p.z, 70, 20) + 18 * smooth(x, 30, 110);
  const float top =
      smooth(p.y, hem - 1.2F, hem + 1.2F) * smooth(p.y, edge + 1.2F, edge - 1.2F) * smooth(place.arm, 0.42F, 0.30F);
  mix(colour, linen, top);
  mix(colour, kBand, top * (smooth(p.y, hem + 13, hem + 11) + smooth(p.y, edge - 9, edge - 7)));
}

}  // namespace

Colour skin_colour(const SkinPlace& place, LookOf whose) {
  const Vec3f p = place.at;
  Colour colour = whose == LookOf::man ? kManSkin : kWomanSkin;
  const float tone = 0.55F * noise(p * (1 / 70.0F)) + 0.30F * noise(p * (1 / 22.0F)) + 0.15F * noise(p * (1 / 7.0F));
  for (float& c : colour) c += 7 * tone;
  const float red = noise(p * (1 / 40.0F) + Vec3f{7, 3, 5});
  colour[1] -= 2.5F * red;
  colour[2] -= 2.5F * red;
  if (p.y > 590 && p.y < 900 && place.arm < 0.1F) {
    paint_face(colour, p, whose);
    paint_hair(colour, p, whose);
  }
  paint_linen(colour, place, whose);
  return colour;
}

Colour eye_colour(float right, float above) {
  constexpr float kPupil = 0.125F, kIris = 0.365F;  // of 75 degrees: 9 and 27 (an iris is 11.7 mm of a ball of 24)
  const float r = std::sqrt(right * right + above * above);
  const float turn = std::atan2(above, right);
  Colour white = {232, 228, 222};
  mix(white, {206, 160, 148}, 0.6F * smooth(r, 0.5F, 1));
  Colour iris = {104, 74, 48};
  for (float& c : iris) c *= 1 + 0.3F * noise({9 * turn, 6 * r, 2});
  mix(iris, {40, 28, 22}, smooth(r, kIris - 0.09F, kIris));
  mix(iris, {14, 11, 10}, smooth(r, kPupil + 0.02F, kPupil - 0.02F));
  Colour colour = white;
  mix(colour, iris, smooth(r, kIris + 0.02F, kIris - 0.02F));
  mix(colour, {60, 44, 40}, 0.45F * smooth(above, 0.05F, 0.5F));  // the upper lid's shadow
  const float glint_x = right + 0.12F, glint_y = above - 0.13F;
  mix(colour, {255, 255, 255}, smooth(glint_x * glint_x + glint_y * glint_y, 0.0045F, 0.0015F));
  return colour;
}

}  // namespace im2fit::body::makehuman
