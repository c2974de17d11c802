// SPDX-License-Identifier: Apache-2.0
#include "report/result_json.h"

#include <bit>
#include <cmath>
#include <nlohmann/json.hpp>

#include "formats/json_file.h"

namespace im2fit {
namespace {

using Json = nlohmann::ordered_json;

// JSON has no NaN: null. Rounding in decimal steps gives the shortest text for what the value means.
Json rounded(double value, double steps_per_unit) {
  if (!std::isfinite(value)) return nullptr;
  const double steps = std::floor(value * steps_per_unit + 0.5);
  return steps == 0 ? 0.0 : steps / steps_per_unit;  // no minus zero
}
Json rounded(float value, double steps_per_unit) {
  return rounded(static_cast<double>(value), steps_per_unit);
}

constexpr double kTenths = 10;
constexpr double kThousandths = 1000;
constexpr double kHundredths = 100;
constexpr double kTenThousandths = 10000;
constexpr double kMillionths = 1e6;
double steps_of(const MeasurementInfo& info) {
  return info.unit == "kg" ? 100 : kTenths;
}

Json source_json(const hal::SourceInfo& source) {
  const Intrinsics& k = source.intrinsics;
  return {{"uri", source.uri},
          {"name", source.name},
          {"serial", source.serial},
          {"rotate_deg", source.rotate_deg},
          {"intrinsics",
           {{"width", k.width},
            {"height", k.height},
            {"fx", rounded(k.fx, kTenThousandths)},
            {"fy", rounded(k.fy, kTenThousandths)},
            {"cx", rounded(k.cx, kTenThousandths)},
            {"cy", rounded(k.cy, kTenThousandths)},
            {"origin", std::string(name_of(source.intrinsics_origin))}}}};
}

Json measurements_json(const EngineResult& result) {
  Json all = Json::object();
  if (!result.measured) return all;
  for (std::size_t i = 0; i < kMeasurementCount; ++i) {
    const MeasurementInfo& info = kMeasurementTable[i];
    const index::IntervalEstimate& e = result.answer.measurements[i];
    const double steps = steps_of(info);
    all[std::string(info.id)] = {
        {"value", rounded(e.value, steps)},
        {"unit", std::string(info.unit)},
        {"interval", Json::array({rounded(e.low, steps), rounded(e.high, steps)})},
        {"iso", info.iso.empty() ? Json(nullptr) : Json("ISO 8559-1:2017 " + std::string(info.iso))}};
  }
  return all;
}

// The site that corrected the answer, and the uncorrected values.
Json site_json(const PersonMeasurement& person) {
  const SiteCalibration& site = *person.site;
  constexpr char kHex[] = "0123456789abcdef";
  std::string crc;
  for (int shift = 28; shift >= 0; shift -= 4) crc += kHex[site.crc32c >> shift & 15U];
  Json uncorrected = Json::object();
  for (std::size_t i = 0; i < kMeasurementCount; ++i) {
    const MeasurementInfo& info = kMeasurementTable[i];
    const index::IntervalEstimate& e = person.result.uncorrected[i];
    const double steps = steps_of(info);
    uncorrected[std::string(info.id)] = {{"value", rounded(e.value, steps)},
                                         {"interval", Json::array({rounded(e.low, steps), rounded(e.high, steps)})}};
  }
  return {{"name", site.name},
          {"people", site.people},
          {"crc32c", crc},
          {"camera_known", site.knows_camera(person.source.name)},
          {"index_known", site.of_this_index ? Json(*site.of_this_index) : Json(nullptr)},
          {"uncorrected", uncorrected}};
}

// What was known, what became of it, and what the answer was without.
Json known_json(const EngineResult& result) {
  const KnownFacts& known = result.known;
  Json given = Json::object(), without = Json::object();
  const auto add = [&](const char* name, const KnownValue& v, const char* unit, double steps) {
    if (v.sd > 0) given[name] = {{"value", rounded(v.value, steps)}, {"sd", rounded(v.sd, steps)}, {"unit", unit}};
  };
  add("stature", known.stature_mm, "mm", kTenths);
  add("weight", known.weight_kg, "kg", kHundredths);
  add("age", known.age_years, "years", kTenths);
  if (known.sex != KnownSex::unknown) given["sex"] = known.sex == KnownSex::woman ? "woman" : "man";
  for (std::size_t i = 0; i < kMeasurementCount; ++i) {
    const index::IntervalEstimate& e = result.unconditioned[i];
    const double steps = steps_of(kMeasurementTable[i]);
    without[std::string(kMeasurementTable[i].id)] = {
        {"value", rounded(e.value, steps)},
        {"interval", Json::array({rounded(e.low, steps), rounded(e.high, steps)})}};
  }
  return {{"given", given},
          {"used", names_of_facts(result.known_outcome.used)},
          {"doubted", names_of_facts(result.known_outcome.doubted)},
          {"without", without}};
}

Json clothing_json(const index::Answer& answer) {
  return {{"probability", rounded(answer.clothing.probability, kTenThousandths)},
          {"ease_mm", rounded(answer.clothing.ease_mm, kTenths)},
          {"answered_as", answer.clothed ? "dressed" : "bare"}};
}

Json age_json(const AgeAnswer& age) {
  Json bands = Json::object();
  for (std::size_t i = 0; i < kAgeBandCount; ++i)
    bands[std::string(kAgeBandNames[i])] = rounded(age.bands[i], kTenThousandths);
  return {{"value", rounded(age.years.value, kTenths)},
          {"unit", "years"},
          {"interval", Json::array({rounded(age.years.low, kTenths), rounded(age.years.high, kTenths)})},
          {"bands", bands}};
}

// Every size's ease at every region, and which to buy.
Json garment_json(const GarmentFit& fit) {
  Json sizes = Json::object();
  for (const SizeFit& size : fit.sizes) {
    Json regions = Json::object();
    for (std::size_t i = 0; i < size.regions.size(); ++i) {
      const RegionFit& region = size.regions[i];
      regions[fit.region_ids[i]] = {
          {"ease_mm", rounded(region.ease_mm, kTenths)},
          {"interval", Json::array({rounded(region.low_mm, kTenths), rounded(region.high_mm, kTenths)})},
          {"verdict", std::string(name_of(region.verdict))}};
    }
    sizes[size.size] = regions;
  }
  Json json = {{"garment", fit.garment}, {"chart", fit.chart}, {"sizes", sizes}};
  if (fit.sizes.empty()) return json;
  json["best"] = fit.sizes[fit.best].size;
  json["fits"] = !fit.none_fits;
  if (fit.other == fit.best) return json;
  json["other"] = {{"size", fit.sizes[fit.other].size},
                   {"region", fit.region_ids[fit.other_region]},
                   {"verdict", std::string(name_of(fit.sizes[fit.other].regions[fit.other_region].verdict))}};
  return json;
}

// Of a chart by several measures: how far each size is from the body, and why the best is best.
Json reason_json(const GarmentFit& fit) {
  Json json = garment_json(fit);
  json.erase("garment");
  json.erase("chart");
  json.erase("best");
  return json;
}

Json size_json(const SizeAnswer& size) {
  Json probabilities = Json::object();
  for (const SizeAnswer::Entry& entry : size.entries)
    probabilities[entry.size] = rounded(entry.probability, kTenThousandths);
  Json json = {{"chart", size.chart}, {"best", size.best}, {"probabilities", probabilities}};
  if (size.reason) json["reason"] = reason_json(*size.reason);
  if (!size.left_out.empty()) json["left_out"] = size.left_out;
  return json;
}

Json joints_json(const EngineResult& result) {
  Json all = Json::object();
  if (!result.measured && !result.has_joints) return all;
  const JointSet& joints = result.measured ? result.measured_joints : result.joints;
  for (std::size_t i = 0; i < kJointCount; ++i) {
    const Vec3f& p = joints.position_mm[i];
    all[std::string(kJointNames[i])] = {
        {"position_mm", Json::array({rounded(p.x, kTenths), rounded(p.y, kTenths), rounded(p.z, kTenths)})},
        {"confidence", rounded(joints.confidence[i], kThousandths)}};
    if (!result.measured && (result.joints_inferred & joint_bit(i)) != 0)
      all[std::string(kJointNames[i])]["inferred"] = true;
  }
  return all;
}

Json parameters_json(const body::Params& p, std::span<const std::string> modifier_names) {
  Json modifiers = Json::object();
  for (std::size_t i = 0; i < modifier_names.size() && i < p.modifiers.size(); ++i)
    if (p.modifiers[i] != 0) modifiers[modifier_names[i]] = rounded(p.modifiers[i], kTenThousandths);
  Json warp = Json::object();
  for (std::size_t i = 0; i < body::kWarpCount; ++i)
    if (p.warp.values[i] != 0) warp[std::string(body::kWarpNames[i])] = rounded(p.warp.values[i], kMillionths);
  return {{"gender", rounded(p.gender, kTenThousandths)},
          {"age_years", rounded(p.age_years, kTenths)},
          {"muscle", rounded(p.muscle, kTenThousandths)},
          {"weight", rounded(p.weight, kTenThousandths)},
          {"height", rounded(p.height, kTenThousandths)},
          {"proportions", rounded(p.proportions, kTenThousandths)},
          {"cup", rounded(p.cup, kTenThousandths)},
          {"firmness", rounded(p.firmness, kTenThousandths)},
          {"race",
           {{"african", rounded(p.race[0], kTenThousandths)},
            {"asian", rounded(p.race[1], kTenThousandths)},
            {"caucasian", rounded(p.race[2], kTenThousandths)}}},
          {"modifiers", modifiers},
          {"warp", warp}};
}

// Of lengths and girths; of weight apart, whose unit is another.
Json residual_json(const body::MeasurementFit& fit) {
  Json all = Json::object();
  for (std::size_t i = 0; i < kMeasurementCount; ++i)
    if (kMeasurementTable[i].unit == "mm")
      all[std::string(kMeasurementTable[i].id)] = rounded(fit.residual[i], kHundredths);
  return all;
}

Json body_json(const PersonMeasurement& person) {
  Json body = {{"entry", person.result.answer.nearest},
               {"distance", rounded(person.result.answer.nearest_distance, kTenThousandths)}};
  if (!person.body) return body;
  const body::MeasurementFit& fit = person.body->fit;
  body["parameters"] = parameters_json(person.body->params, person.modifier_names);
  body["residual_mm"] = residual_json(fit);
  body["residual_kg"] = rounded(fit.residual[measurement_index(Measurement::weight)], kThousandths);
  body["meets_measurements"] = body::girth_residual_mm(fit.residual) <= body::kResidualToldMm;
  return body;
}

// Of the answered body's mesh, by each definition that is measured.
Json tape_json(const PersonMeasurement& person) {
  Json all = Json::object();
  for (std::size_t i = 0; i < person.tape_values.size(); ++i) {
    const body::TapeDefinition& d = person.tape->definitions[i];
    if (d.kind == body::TapeKind::refused) continue;
    const std::string unit(unit_of(d));
    const double steps = unit == "kg" ? kHundredths : kTenths;
    Json entry = {{"value", rounded(person.tape_values[i], steps)}, {"unit", unit}};
    if (i < person.tape_intervals.size() && person.tape_intervals[i].known)
      entry["interval"] =
          Json::array({rounded(person.tape_intervals[i].low, steps), rounded(person.tape_intervals[i].high, steps)});
    entry["iso"] = d.iso_8559.empty() ? Json(nullptr) : Json("ISO 8559-1:2017 " + d.iso_8559);
    all[d.id] = entry;
  }
  return all;
}

Json paper_json(const EngineResult& result) {
  Json all = Json::object();
  if (!result.measured) return all;
  for (std::size_t i = 0; i < kMeasurementCount; ++i)
    if (std::isfinite(result.paper[i]))
      all[std::string(kMeasurementTable[i].id)] = rounded(result.paper[i], steps_of(kMeasurementTable[i]));
  return all;
}

}  // namespace

std::string_view name_of(SessionState state) {
  switch (state) {
    case SessionState::searching:
      return "SEARCHING";
    case SessionState::user_found:
      return "USER_FOUND";
    case SessionState::calibrating:
      return "CALIBRATING";
    case SessionState::tracking:
      return "TRACKING";
    case SessionState::measured:
      return "MEASURED";
    case SessionState::turning:
      return "TURNING";
    case SessionState::lost:
      break;
  }
  return "LOST";
}

std::string_view name_of(ViewSide view) {
  switch (view) {
    case ViewSide::front:
      return "front";
    case ViewSide::back:
      return "back";
    case ViewSide::side:
      return "side";
    case ViewSide::unknown:
      break;
  }
  return "unknown";
}

std::string_view name_of(AnswerViews views) {
  switch (views) {
    case AnswerViews::front:
      return "front";
    case AnswerViews::front_and_back:
      return "front+back";
    case AnswerViews::around:
      return "around";
    case AnswerViews::none:
      break;
  }
  return "none";
}

std::string_view name_of(index::AnsweredFrom from) {
  switch (from) {
    case index::AnsweredFrom::fitted_front:
      return "front fit";
    case index::AnsweredFrom::front_and_back:
      return "front+back fit";
    case index::AnsweredFrom::around:
      return "around fit";
    case index::AnsweredFrom::front:
      break;
  }
  return "features";
}

std::string_view name_of(hal::IntrinsicsOrigin origin) {
  switch (origin) {
    case hal::IntrinsicsOrigin::device:
      return "device";
    case hal::IntrinsicsOrigin::calibration_file:
      return "calibration_file";
    case hal::IntrinsicsOrigin::recording:
      return "recording";
    case hal::IntrinsicsOrigin::field_of_view:
      return "field_of_view";
    case hal::IntrinsicsOrigin::caller:
      return "caller";
    case hal::IntrinsicsOrigin::synthetic:
      break;
  }
  return "synthetic";
}

GuidanceSet reported_guidance(const EngineResult& result) {
  if (result.measured)
    return result.guidance &
           (Guidance::clothed | Guidance::feet_raised | static_cast<GuidanceSet>(Guidance::head_unseen));
  GuidanceSet set = result.guidance | result.plausibility.refused;
  for (std::size_t i = 0; i < kGuidanceCount; ++i)
    if (result.guidance_frames[i] > 0 && 2 * std::uint64_t{result.guidance_frames[i]} >= result.frames_seen)
      set |= 1U << i;
  return set;
}

GuidanceSet reported_guidance(const PersonMeasurement& person) {
  GuidanceSet set = reported_guidance(person.result);
  const EngineResult& result = person.result;
  if (!result.measured || result.views != AnswerViews::front) return set;
  if (result.turn == Turn::back) set |= static_cast<GuidanceSet>(Guidance::turn_round);
  // front_measured: a turn was asked for.
  if (is_all_round(result.turn) && result.front_measured && std::fabs(result.turned_deg) < kTurnEnoughDeg)
    set |= static_cast<GuidanceSet>(turn_guidance(result.turn));
  return set;
}

ArmSet reported_arms(const EngineResult& result) {
  if (!has(reported_guidance(result), Guidance::arms_close)) return 0;
  if (result.arms_close != 0) return result.arms_close;
  ArmSet set = 0;
  constexpr auto kBit = static_cast<std::size_t>(std::countr_zero(static_cast<GuidanceSet>(Guidance::arms_close)));
  const std::uint64_t said = result.guidance_frames[kBit];
  for (std::size_t arm = 0; arm < kArmCount; ++arm)
    if (2 * std::uint64_t{result.arms_close_frames[arm]} >= said) set |= 1U << arm;
  return set;
}

namespace {

// What was found for each code reported, and confirmed people in view who are not measured.
Json details_json(const EngineResult& r, GuidanceSet codes, ArmSet arms) {
  Json details = Json::object();
  if (arms != 0) details["arms_close"] = names_of_arms(arms);
  const Plausibility& p = r.plausibility;
  const GuidanceSet judged = (p.refused | p.beside) & codes;
  if (has(judged, Guidance::not_upright)) details["not_upright"] = {{"knees_deg", rounded(p.knees_deg, kTenths)}};
  if (has(codes, Guidance::out_of_population) && std::isfinite(p.seen_stature_mm))
    details["out_of_population"] = {
        {"stature_mm", rounded(p.seen_stature_mm, 1)}, {"from_mm", kSeenStatureMinMm}, {"to_mm", kSeenStatureMaxMm}};
  if (has(judged, Guidance::floor_bent)) details["floor_bent"] = {{"bend", rounded(p.floor_bend, kThousandths)}};
  const bool heels = p.heels_mm > 0;
  if (has(judged, Guidance::feet_raised))
    details["feet_raised"] = {{heels ? "heels_mm" : "ground_mm", rounded(heels ? p.heels_mm : p.ground_mm, 1)}};
  if (has(judged, Guidance::head_unseen)) details["head_unseen"] = {{"added_mm", rounded(p.crown_missing_mm, 1)}};
  for (const LeftOutUser& one : left_out_of(r))
    details["left_out"].push_back({{"user", one.user}, {"reason", std::string(one.reason)}});
  return details;
}

}  // namespace

std::string guidance_details_json(const EngineResult& result, GuidanceSet codes, ArmSet arms) {
  return details_json(result, codes, arms).dump();
}

std::string fit_json(const GarmentFit& fit) {
  return garment_json(fit).dump(2) + "\n";
}

std::string result_json(const PersonMeasurement& person, const std::optional<ResultTiming>& timing) {
  const EngineResult& r = person.result;
  Json json;
  json["schema"] = std::string(kResultSchema);
  json["state"] = std::string(name_of(r.state));
  json["guidance"] = names_of(reported_guidance(person));
  json["guidance_details"] = details_json(r, reported_guidance(person), reported_arms(r));
  if (person.diagnosis.code != hal::DiagnosisCode::none)
    json["diagnosis"] = {{"code", std::string(hal::name_of(person.diagnosis.code))}, {"text", person.diagnosis.text}};
  json["frames"] = {{"seen", r.frames_seen},
                    {"used", r.frames_used},
                    {"dropped", r.frames_dropped},
                    {"damaged", person.frames_damaged}};
  json["source"] = source_json(person.source);
  if (r.measured) json["views"] = std::string(name_of(r.views));
  if (r.measured && r.turned_deg != 0) json["turned_deg"] = rounded(r.turned_deg, 1);
  if (r.measured) json["estimator"] = std::string(name_of(r.answer.from));
  if (r.measured) json["clothing"] = clothing_json(r.answer);
  json["measurements"] = measurements_json(r);
  if (r.measured && person.site != nullptr && r.views != AnswerViews::around)
    json["calibration_site"] = site_json(person);
  if (r.measured && r.known.given() != 0) json["known"] = known_json(r);
  if (r.measured) json["sex"] = {{"female", rounded(r.answer.female, kTenThousandths)}};
  if (r.measured) json["age"] = age_json(r.age);
  if (r.measured && person.size) json["size"] = size_json(*person.size);
  if (r.measured && !person.fits.empty()) {
    json["fit"] = Json::array();
    for (const GarmentFit& fit : person.fits) json["fit"].push_back(garment_json(fit));
  }
  json["joints"] = joints_json(r);
  if (r.measured) json["body"] = body_json(person);
  if (r.measured && person.body && person.tape != nullptr) json["tape"] = tape_json(person);
  json["paper"] = paper_json(r);
  if (timing)
    json["timing"] = {{"total_ms", rounded(timing->total_ms, kTenths)},
                      {"first_answer_ms", rounded(timing->first_answer_ms, kTenths)},
                      {"sequence_gaps", r.sequence_gaps},
                      {"sequence_repeats", r.sequence_repeats},
                      {"time_reversals", r.time_reversals}};
  return json_text(json, 2) + "\n";
}

}  // namespace im2fit
