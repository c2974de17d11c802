// SPDX-License-Identifier: Apache-2.0
#include "evaluation/measurements/limits_study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <mutex>
#include <optional>

#include "core/rng.h"
#include "evaluation/measurements/limits_people.h"

namespace im2fit::lab {
namespace {

constexpr std::uint64_t kExtentStream = 0x11317;

constexpr GuidanceSet bit_of(Guidance code) {
  return static_cast<GuidanceSet>(code);
}

// What an ordinary person must never see (estimate/plausibility.h, perception/observe).
constexpr GuidanceSet kNewCodes = bit_of(Guidance::out_of_population) | bit_of(Guidance::floor_bent) |
                                  bit_of(Guidance::feet_raised) | bit_of(Guidance::head_unseen) |
                                  bit_of(Guidance::step_to_the_middle) | bit_of(Guidance::depth_missing);

constexpr std::array<SituationRule, kSituationCount> kRules = {{
    {"ordinary", "as they are", 0, true, false},
    {"dressed", "as they are, in clothes, shoes and hair", 0, true, true},
    {"child", "1.00 to 1.37 m tall, with a child's head", bit_of(Guidance::out_of_population), false, false},
    {"tall", "2.15 to 2.35 m tall", bit_of(Guidance::out_of_population), false, false},
    {"squat", "knees bent by 30 to 100 degrees", bit_of(Guidance::not_upright), false, false},
    {"bent-knees", "knees bent by 12 to 45 degrees", bit_of(Guidance::not_upright), true, false},
    {"heels", "heels raised by 50 to 95 mm", 0, true, true},
    {"crown", "50 to 130 mm of the crown without depth", 0, true, false},
    {"scale", "on a scale of 25 to 60 mm", 0, true, false},
    {"platform", "on a platform of 60 to 180 mm", 0, true, false},
    {"range", "distances in place of depths", bit_of(Guidance::floor_bent), false, false},
    {"lens", "a lens with k1 of 0.08 to 0.2 not undone", bit_of(Guidance::floor_bent), true, false},
    {"hem", "a skirt to the floor, over shoes", bit_of(Guidance::feet_cut), true, true},
    {"arm", "one arm in the air", bit_of(Guidance::arms_close) | bit_of(Guidance::not_upright), true, false},
}};

// Of those that frames carried, the one most of them did.
GuidanceSet most_frequent(const EngineResult& result) {
  const auto most = std::max_element(result.guidance_frames.begin(), result.guidance_frames.end());
  if (most == result.guidance_frames.end() || *most == 0) return 0;
  return GuidanceSet{1} << static_cast<std::size_t>(most - result.guidance_frames.begin());
}

bool holds(const index::IntervalEstimate& e, float truth) {
  return e.low <= truth && truth <= e.high;
}

std::string words_of(GuidanceSet codes) {
  std::string out;
  for (std::size_t i = 0; i < kGuidanceCount; ++i)
    if ((codes >> i & 1U) != 0) out += (out.empty() ? "" : "+") + std::string(kGuidanceNames[i]);
  return out;
}

std::string fate_of(const LimitsOutcome& o) {
  if (o.measured) return o.codes != 0 ? "measured, " + words_of(o.codes) : "measured";
  return o.codes != 0 ? words_of(o.codes) : "no person";
}

}  // namespace

const SituationRule& rule_of(Situation situation) {
  return kRules[static_cast<std::size_t>(situation)];
}

Result<Situation> situation_of(std::string_view id) {
  std::string known;
  for (std::size_t i = 0; i < kRules.size(); ++i) {
    if (kRules[i].id == id) return static_cast<Situation>(i);
    known += (known.empty() ? "" : ", ") + std::string(kRules[i].id);
  }
  return Error{ErrorCode::invalid_argument, fmt::format("no situation '{}'; there are {}", id, known)};
}

HeldOutPerson person_in(const body::BodyModel& model, const EvaluationOptions& options, Situation situation,
                        std::uint64_t index, float* extent) {
  HeldOutPerson person = draw_person(model, options, index);
  SceneOptions& scene = person.capture.scene;
  Rng rng = Rng::for_item(options.seed, kExtentStream + static_cast<std::uint64_t>(situation), index);
  const auto draw = [&](double least, double most) { return static_cast<float>(rng.uniform(least, most)); };
  const float stature_mm = person.subject.truth[measurement_index(Measurement::stature)];
  float drawn = 0;
  switch (situation) {
    case Situation::child:
    case Situation::tall:
      drawn = situation == Situation::child ? draw(1000, 1370) : draw(2150, 2350);
      resize(model, drawn, situation == Situation::child, person);
      break;
    case Situation::squat:
      scene.pose = StandingPose::squat;
      break;
    case Situation::bent_knees:
      scene.pose = StandingPose::bent_knees;
      break;
    case Situation::arm:
      scene.pose = StandingPose::arm_raised;
      break;
    case Situation::heels:
      drawn = draw(50, 95);
      person.rest.resize(static_cast<std::size_t>(model.vertex_count()));
      morph_subject(model, person.subject, person.rest);
      raise_heels(model, drawn, person.rest);
      break;
    case Situation::crown:
      drawn = draw(50, 130);
      person.change = lose_crown(stature_mm, drawn);
      break;
    case Situation::scale:
      drawn = draw(25, 60);
      scene.plate = {drawn, draw(300, 360)};
      break;
    case Situation::platform:
      drawn = draw(60, 180);
      scene.plate = {drawn, draw(600, 1000)};
      break;
    case Situation::range:
      person.change = give_range();
      break;
    case Situation::lens:
      drawn = draw(0.08, 0.2);
      person.change = distort(drawn);
      break;
    case Situation::hem:
      drawn = draw(0, 6);
      scene.clothing = Clothing::garments;
      scene.dresser = long_skirt(model, drawn, draw(60, 200), person.capture.seed);
      break;
    case Situation::dressed: {
      constexpr Clothing kWorn[] = {Clothing::tight, Clothing::normal, Clothing::loose};
      scene.clothing = kWorn[rng.index(3)];
      scene.hair = true;
      break;
    }
    case Situation::ordinary:
      break;
  }
  if (extent != nullptr) *extent = drawn;
  return person;
}

ShownPicture first_picture(const body::BodyModel& model, const HeldOutPerson& person) {
  const CaptureOptions& capture = person.capture;
  const Intrinsics upright = hal::rotate_upright(capture.intrinsics, capture.scene.rotate_deg);
  VirtualScene scene(model, person.subject, capture.scene, capture.sensor, capture.intrinsics, capture.seed);
  if (!person.rest.empty()) scene.restage(person.subject, capture.scene, capture.sensor, capture.seed, person.rest);
  std::vector<std::uint16_t> delivered(static_cast<std::size_t>(upright.width) *
                                       static_cast<std::size_t>(upright.height));
  const DepthImage sensor(delivered.data(), capture.intrinsics.width, capture.intrinsics.height);
  scene.render(0, sensor);
  ShownPicture out{upright.width, upright.height, std::vector<std::uint16_t>(delivered.size())};
  const DepthImage image(out.depth_mm.data(), out.width, out.height);
  hal::rotate_upright(sensor, capture.scene.rotate_deg, image);
  if (person.change) person.change(upright, scene, image);
  return out;
}

void judge(const EngineResult& result, LimitsOutcome& outcome) {
  const SituationRule& rule = rule_of(outcome.situation);
  outcome.measured = result.measured;
  outcome.plausibility = result.plausibility;
  outcome.unexpected = (result.guidance_seen & kNewCodes) | result.plausibility.refused;
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  outcome.stature = {kNaN, kNaN, kNaN};
  if (!result.measured) {
    outcome.codes = result.plausibility.refused != 0 ? result.plausibility.refused : most_frequent(result);
    outcome.right = (outcome.codes & rule.codes) != 0;
    return;
  }
  outcome.codes = result.guidance;
  outcome.stature = result.answer.measurements[measurement_index(Measurement::stature)];
  if (is_ordinary(outcome.situation))
    outcome.right = outcome.unexpected == 0;
  else
    outcome.right = rule.may_answer && holds(outcome.stature, outcome.true_stature_mm);
}

Result<std::vector<LimitsOutcome>> study_limits(const SessionModels& models, const EvaluationOptions& options,
                                                const std::vector<Situation>& situations) {
  struct Item {
    Situation situation;
    std::uint64_t index;
  };
  std::vector<Item> items;
  for (const Situation situation : situations) {
    if (options.family == PeopleFamily::other && rule_of(situation).of_model_mesh) continue;
    for (int i = 0; i < options.subjects; ++i) items.push_back({situation, static_cast<std::uint64_t>(i)});
  }
  std::vector<LimitsOutcome> outcomes(items.size());
  std::mutex mutex;
  std::optional<Error> failure;
  for_each_item(
      items.size(), options.threads,
      [&](std::uint64_t i) {
        LimitsOutcome& outcome = outcomes[i];
        outcome.situation = items[i].situation;
        const HeldOutPerson person =
            person_in(models.body, options, outcome.situation, items[i].index, &outcome.extent);
        outcome.true_stature_mm = person.subject.truth[measurement_index(Measurement::stature)];
        const auto engine = run_session(models, person, Views::front, {});
        if (!engine) {
          const std::lock_guard lock(mutex);
          failure = engine.error();
          return;
        }
        const EngineResult result = (*engine)->result();
        judge(result, outcome);
        for (const Measurement girth : {Measurement::chest_girth, Measurement::waist_girth, Measurement::hip_girth}) {
          const std::size_t m = measurement_index(girth);
          outcome.girths_held +=
              result.measured && holds(result.answer.measurements[m], person.subject.truth[m]) ? 1 : 0;
        }
      },
      begin_progress(options.progress, "people in situations", items.size()));
  if (failure) return *failure;
  return outcomes;
}

std::string text_of(const std::vector<LimitsOutcome>& outcomes) {
  std::string text =
      "| situation | right | measured, intervals of the stature that hold | became of them |\n|---|---|---|---|\n";
  int all_right = 0, all = 0;
  for (std::size_t s = 0; s < kSituationCount; ++s) {
    int right = 0, count = 0, measured = 0, held = 0;
    std::map<std::string, std::pair<int, int>> fates;  // all, wrong
    for (const LimitsOutcome& o : outcomes) {
      if (static_cast<std::size_t>(o.situation) != s) continue;
      ++count;
      right += o.right ? 1 : 0;
      measured += o.measured ? 1 : 0;
      held += o.measured && holds(o.stature, o.true_stature_mm) ? 1 : 0;
      auto& fate = fates[fate_of(o)];
      ++fate.first;
      fate.second += o.right ? 0 : 1;
    }
    if (count == 0) continue;
    std::string became;
    for (const auto& [word, n] : fates) {
      became += fmt::format("{}{} {}", became.empty() ? "" : ", ", n.first, word);
      if (n.second > 0 && n.second < n.first) became += fmt::format(" ({} wrong)", n.second);
      if (n.second == n.first) became += " (wrong)";
    }
    text += fmt::format("| {}: {} | {} of {} | {}, {} | {} |\n", kRules[s].id, kRules[s].what, right, count, measured,
                        held, became);
    if (is_ordinary(static_cast<Situation>(s))) continue;
    all_right += right;
    all += count;
  }
  if (all > 0)
    text +=
        fmt::format("| all but the ordinary | {} of {} ({:.1f} %) | | |\n", all_right, all, 100.0 * all_right / all);
  return text;
}

std::string csv_of(const std::vector<LimitsOutcome>& outcomes) {
  std::string text =
      "situation,extent,true_stature_mm,right,measured,codes,unexpected,stature,low,high,girths_held,seen_stature_mm,"
      "knees_deg,floor_bend,ground_mm,heels_mm,crown_missing_mm\n";
  for (const LimitsOutcome& o : outcomes) {
    const Plausibility& p = o.plausibility;
    text += fmt::format(
        "{},{:.3f},{:.1f},{},{},{},{},{:.1f},{:.1f},{:.1f},{},{:.1f},{:.1f},{:.4f},{:.1f},{:.1f},{:.1f}\n",
        rule_of(o.situation).id, o.extent, o.true_stature_mm, o.right ? 1 : 0, o.measured ? 1 : 0, words_of(o.codes),
        words_of(o.unexpected), o.stature.value, o.stature.low, o.stature.high, o.girths_held, p.seen_stature_mm,
        p.knees_deg, p.floor_bend, p.ground_mm, p.heels_mm, p.crown_missing_mm);
  }
  return text;
}

}  // namespace im2fit::lab
