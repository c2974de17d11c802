// SPDX-License-Identifier: Apache-2.0
#include "kernels/observe/somebody.h"

#include <array>
#include <cmath>

#include "kernels/core/skeleton.h"

namespace im2fit {
namespace {

// A logistic regression on means over six frames of 1,240 people (600 of them turned by 40 to 80 degrees or bent by
// 28 to 50, the rest in full conditions) and 498 things taken for such in 3,000 rooms without people; cross-fitted it
// loses 0.7 % of the people where it lets one of the things pass, and 1.4 % without the skeleton's part.
constexpr float kConstant = 6.57F;
constexpr float kOfShape = 1.38F;
constexpr float kOfLikeness = 9.79F;      // above kLikenessEven
constexpr float kOfMoreLikeness = 40.0F;  // above kLikenessMore: of those things one in fifty has 0.72
constexpr float kLikenessMore = 0.68F;
constexpr float kOfUnevenness = -2.63F;
constexpr float kOfLegs = -0.0227F;  // a millimetre off the mean adult's
constexpr float kThighMm = 390.0F;
constexpr float kShankMm = 415.0F;

// Of what is cut off or beyond 4 m, whose shape and legs tell nothing: set on people and things of that kind.
constexpr float kOfLikenessAlone = 22.0F;
constexpr float kLikenessEven = 0.65F;
constexpr float kLikenessRare = 0.73F;  // what is above counts more: nothing of furniture
constexpr float kOfRareLikeness = 30.0F;

float above(float value, float limit) {
  return value > limit ? value - limit : 0.0F;
}

float bone_mm(const JointSet& joints, Joint j) {
  return norm(joints[j] - joints[parent_of(j)]);
}

// Differences between left and right upper arms, forearms, thighs and shanks, summed. The runs of the joint model
// disagree on furniture, each side in its own way.
float unevenness_mm(const JointSet& joints) {
  float sum = 0;
  for (const Joint j : {Joint::LE, Joint::LA, Joint::LK, Joint::LF})
    sum += std::fabs(bone_mm(joints, j) - bone_mm(joints, mirror_of(j)));
  return sum;
}

float legs_off_mm(const JointSet& joints) {
  const float thigh = 0.5F * (bone_mm(joints, Joint::LK) + bone_mm(joints, Joint::RK));
  const float shank = 0.5F * (bone_mm(joints, Joint::LF) + bone_mm(joints, Joint::RF));
  return std::fabs(thigh - kThighMm) + std::fabs(shank - kShankMm);
}

}  // namespace

float somebody_odds(float shape_odds, float likeness, const JointSet& joints) {
  if (shape_odds == 0)
    return kOfLikenessAlone * (likeness - kLikenessEven) + kOfRareLikeness * above(likeness, kLikenessRare);
  return kConstant + kOfShape * shape_odds + kOfLikeness * (likeness - kLikenessEven) +
         kOfMoreLikeness * above(likeness, kLikenessMore) + kOfUnevenness * std::sqrt(0.01F * unevenness_mm(joints)) +
         kOfLegs * legs_off_mm(joints);
}

}  // namespace im2fit
