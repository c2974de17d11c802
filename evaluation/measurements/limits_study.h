// SPDX-License-Identifier: Apache-2.0
// Held-out people in situations in which a measurement may be wrong: are they refused by name, told, or right?
// `ordinary` and `dressed`: the same people as they are and in clothes, shoes and hair, who must get none of the
// codes of estimate/plausibility.h.
//
// A person of a situation is right if the answer is refused, or no frame is accepted, with one of the situation's
// codes; or, where the situation allows an answer, if the interval of the stature holds the stature of the bare
// person who stands straight on the ground.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/guidance.h"
#include "evaluation/measurements/evaluation.h"
#include "evaluation/measurements/session.h"

namespace im2fit::lab {

enum class Situation : std::uint8_t {
  ordinary,
  dressed,
  child,
  tall,
  squat,
  bent_knees,
  heels,
  crown,
  scale,
  platform,
  range,
  lens,
  hem,
  arm,
};
inline constexpr std::size_t kSituationCount = 14;

struct SituationRule {
  std::string_view id;
  std::string_view what;  // for people
  GuidanceSet codes;      // that may refuse or block
  bool may_answer;        // with an interval that holds the stature
  bool of_model_mesh;     // not to be had of people of another mesh
};
constexpr bool is_ordinary(Situation situation) {
  return situation == Situation::ordinary || situation == Situation::dressed;
}
const SituationRule& rule_of(Situation situation);
Result<Situation> situation_of(std::string_view id);

struct LimitsOutcome {
  Situation situation{};
  bool measured = false, right = false;
  GuidanceSet codes = 0;       // beside the answer; or what refused it; or of most frames that were not accepted
  GuidanceSet unexpected = 0;  // of the ordinary: codes of estimate/plausibility.h among those seen
  float true_stature_mm = 0;
  float extent = 0;                 // of what is wrong: mm, degrees or k1, by situation; 0: not drawn here
  index::IntervalEstimate stature;  // not numbers unless measured
  int girths_held = 0;              // of chest, waist and hip, whose interval holds the bare person's
  Plausibility plausibility;
};

// The same person for the same options, situation and index.
HeldOutPerson person_in(const body::BodyModel& model, const EvaluationOptions& options, Situation situation,
                        std::uint64_t index, float* extent = nullptr);

// What the engine is shown of the person first: depth in mm, upright, row by row.
struct ShownPicture {
  int width = 0, height = 0;
  std::vector<std::uint16_t> depth_mm;
};
ShownPicture first_picture(const body::BodyModel& model, const HeldOutPerson& person);

// Judges what came of the session.
void judge(const EngineResult& result, LimitsOutcome& outcome);

Result<std::vector<LimitsOutcome>> study_limits(const SessionModels& models, const EvaluationOptions& options,
                                                const std::vector<Situation>& situations);

// A line for each situation: N of M right, how, and what the wrong ones were.
std::string text_of(const std::vector<LimitsOutcome>& outcomes);
std::string csv_of(const std::vector<LimitsOutcome>& outcomes);

}  // namespace im2fit::lab
