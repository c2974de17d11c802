// SPDX-License-Identifier: Apache-2.0
#include "evaluation/measurements/conditions.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <string_view>

namespace im2fit::lab {
namespace {

struct Word {
  std::string_view name;
  std::string_view what;
  bool in_all;
  void (*change)(EvaluationOptions&);
};

// Near is where Kinect's field just holds a tall person in portrait mount, far close to where TOO_FAR begins.
constexpr float kNearMm = 1900, kFarMm = 3600;

constexpr float kHeavyMin = 38;  // kg/m^2: arms that hang rest on the body

void phone(EvaluationOptions& o) {
  o.tof = true;
  o.width = 256;
  o.height = 192;
}

constexpr std::array<Word, 42> kWords = {{
    {"noise", "a Kinect in a furnished room, 2.0 to 2.6 m away", true, [](EvaluationOptions& o) { o.noise = true; }},
    {"bare", "a perfect sensor in an empty room", true, [](EvaluationOptions& o) { o.noise = false; }},
    {"tof", "a time-of-flight sensor in place of the Kinect", true, [](EvaluationOptions& o) { o.tof = true; }},
    {"smoothed", "a driver that smooths the depth over time", false, [](EvaluationOptions& o) { o.smoothed = true; }},
    {"blend3", "a driver that blends 3x3 pixels across edges", false,
     [](EvaluationOptions& o) { o.edges.blend = EdgeBlend::mean3; }},
    {"blend5", "a driver that blends 5x5 pixels", false,
     [](EvaluationOptions& o) { o.edges.blend = EdgeBlend::mean5; }},
    {"gauss5", "a driver that blends 5x5 pixels by a normal", false,
     [](EvaluationOptions& o) { o.edges.blend = EdgeBlend::gauss5; }},
    {"bilinear2", "a sensor of half the resolution, interpolated", false,
     [](EvaluationOptions& o) { o.edges.blend = EdgeBlend::bilinear2; }},
    {"bilateral5", "a driver with a bilateral filter of 5x5 pixels", false,
     [](EvaluationOptions& o) { o.edges.blend = EdgeBlend::bilateral5; }},
    {"dropped", "a driver that drops the low confidence of edges", false,
     [](EvaluationOptions& o) { o.edges.drop = true; }},
    {"phone-smooth", "a phone: time of flight, 256x192 pixels, blended 3x3", false,
     [](EvaluationOptions& o) {
       phone(o);
       o.edges.blend = EdgeBlend::mean3;
     }},
    {"phone-tof", "a phone: time of flight, 256x192 pixels, low confidence dropped", false,
     [](EvaluationOptions& o) {
       phone(o);
       o.edges.drop = true;
     }},
    {"tremor1", "a camera held in the hand, turning by up to 1 degree", false,
     [](EvaluationOptions& o) { o.tremor_deg = 1; }},
    {"tremor3", "a camera held in the hand, turning by up to 3 degrees", false,
     [](EvaluationOptions& o) { o.tremor_deg = 3; }},
    {"posed", "the device reports the pose of a camera held in the hand", false,
     [](EvaluationOptions& o) { o.poses_told = true; }},
    {"reported", "the driver reports the kind of its sensor", false,
     [](EvaluationOptions& o) { o.sensor_reported = true; }},
    {"clothed", "in clothes, shoes and hair", true, [](EvaluationOptions& o) { o.clothed = true; }},
    {"garments", "in draped garments, shoes and hair", false,
     [](EvaluationOptions& o) { o.clothed = o.garments = true; }},
    {"untold", "the clothing is not reported to the device", false,
     [](EvaluationOptions& o) { o.clothing_reported = false; }},
    {"frames1", "one frame", true, [](EvaluationOptions& o) { o.frames = 1; }},
    {"frames5", "5 frames", true, [](EvaluationOptions& o) { o.frames = 5; }},
    {"frames10", "10 frames", true, [](EvaluationOptions& o) { o.frames = 10; }},
    {"frames30", "30 frames", false, [](EvaluationOptions& o) { o.frames = 30; }},
    {"320", "320x240 pixels", true, [](EvaluationOptions& o) { o.width = 320, o.height = 240; }},
    {"256", "256x192 pixels", false, [](EvaluationOptions& o) { o.width = 256, o.height = 192; }},
    {"640", "640x480 pixels", false, [](EvaluationOptions& o) { o.width = 640, o.height = 480; }},
    {"near", "as near as the whole person fits, 1.9 m or more", true,
     [](EvaluationOptions& o) { o.distance_mm = kNearMm; }},
    {"far", "3.6 m away", true, [](EvaluationOptions& o) { o.distance_mm = kFarMm; }},
    {"yaw0", "facing the camera", true, [](EvaluationOptions& o) { o.yaw_deg = 0; }},
    {"yaw10", "turned 10 degrees to a side", true, [](EvaluationOptions& o) { o.yaw_deg = 10; }},
    {"arms_out", "arms held 30 to 40 degrees off the body", false,
     [](EvaluationOptions& o) { o.pose = StandingPose::arms_out; }},
    {"heavy", "people of a body mass index of 38 and more", false,
     [](EvaluationOptions& o) { o.body_mass_index_min = kHeavyMin; }},
    {"back", "seen from behind", false, [](EvaluationOptions& o) { o.views = Views::back; }},
    {"known-scale", "the weight is known from a scale", false,
     [](EvaluationOptions& o) { o.known = KnownOf::weight_on_scale; }},
    {"known-weight", "the weight is known as people report it", false,
     [](EvaluationOptions& o) { o.known = KnownOf::weight_stated; }},
    {"known-all", "stature, weight, sex and age are known as people report them", false,
     [](EvaluationOptions& o) { o.known = KnownOf::all; }},
    {"20kg-off", "the weight reported is wrong by 20 kg", false,
     [](EvaluationOptions& o) { o.known_weight_off_kg = 20; }},
    {"around", "the front, then one turn on the spot, arms held off the body", true,
     [](EvaluationOptions& o) {
       o.views = Views::around;
       o.pose = StandingPose::arms_out;
     }},
    {"half-turn", "the front, then half a turn on the spot, arms held off the body", false,
     [](EvaluationOptions& o) {
       o.views = Views::half;
       o.pose = StandingPose::arms_out;
     }},
    {"walk-around", "the front, then a camera carried round the person, its pose told, arms held off the body", false,
     [](EvaluationOptions& o) {
       o.views = Views::walk;
       o.pose = StandingPose::arms_out;
       o.tremor_deg = 1;
       o.poses_told = true;
     }},
    {"both", "front, then back", true, [](EvaluationOptions& o) { o.views = Views::both; }},
    {"features", "features alone, no shape is fitted", true, [](EvaluationOptions& o) { o.fit = false; }},
}};

}  // namespace

Result<Condition> condition_of(const std::string& name, const EvaluationOptions& base) {
  Condition condition{name, "", base};
  std::string_view rest = name;
  while (true) {
    const std::string_view part = rest.substr(0, rest.find('+'));
    const auto* word = std::find_if(kWords.begin(), kWords.end(), [&](const Word& w) { return w.name == part; });
    if (word == kWords.end())
      return Error{ErrorCode::invalid_argument,
                   fmt::format("no condition '{}'; there are {}", part, condition_help())};
    word->change(condition.options);
    condition.what += (condition.what.empty() ? "" : "; ") + std::string(word->what);
    if (part.size() == rest.size()) return condition;
    rest.remove_prefix(part.size() + 1);
  }
}

Status shown_by_family(const Condition& condition) {
  if (condition.options.family != PeopleFamily::other) return Ok{};
  if (condition.options.clothed)
    return Error{
        ErrorCode::invalid_argument,
        fmt::format("condition '{}': people of the family other are shown bare, because clothes and garments "
                    "are cut for the body model's mesh; leave out clothed and garments",
                    condition.name)};
  if (condition.options.body_mass_index_min > 0)
    return Error{
        ErrorCode::invalid_argument,
        fmt::format("condition '{}': people of the family other have a body mass index of 18 to 38; leave out "
                    "heavy",
                    condition.name)};
  return Ok{};
}

std::string condition_help() {
  std::string text;
  for (const Word& word : kWords) text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", word.name, word.what);
  return text;
}

std::vector<std::string> all_conditions() {
  std::vector<std::string> names;
  for (const Word& word : kWords)
    if (word.in_all) names.emplace_back(word.name);
  return names;
}

}  // namespace im2fit::lab
