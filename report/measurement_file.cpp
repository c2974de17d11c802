// SPDX-License-Identifier: Apache-2.0
#include "report/measurement_file.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <string_view>

namespace im2fit {
namespace {

constexpr double kMmPerCm = 10, kMmPerInch = 25.4;

// A name of theirs: `plus` of the tape less `minus`; "" for none.
struct TheirName {
  std::string_view name, plus, minus;
};

// SeamlyMe's names.
constexpr TheirName kSeamly[] = {{"height", "stature", ""},
                                 {"height_neck_back", "cervical_height", ""},
                                 {"height_armpit", "armpit_height", ""},
                                 {"height_waist_side", "waist_height", ""},
                                 {"height_hip", "hip_height", ""},
                                 {"height_knee", "knee_height", ""},
                                 {"height_ankle", "ankle_height", ""},
                                 {"height_highhip", "high_hip_height", ""},
                                 {"height_bustpoint", "bust_height", ""},
                                 {"height_shoulder_tip", "shoulder_height", ""},
                                 {"height_waist_side_to_knee", "waist_to_knee", ""},
                                 {"height_waist_side_to_hip", "waist_to_hip", ""},
                                 {"width_bust", "chest_breadth", ""},
                                 {"width_waist", "waist_breadth", ""},
                                 {"width_hip", "hip_breadth", ""},
                                 {"neck_mid_circ", "neck_girth", ""},
                                 {"neck_circ", "neck_base_girth", ""},
                                 {"bust_circ", "chest_girth", ""},
                                 {"lowbust_circ", "under_bust_girth", ""},
                                 {"waist_circ", "waist_girth", ""},
                                 {"waist_natural_circ", "natural_waist_girth", ""},
                                 {"highhip_circ", "high_hip_girth", ""},
                                 {"hip_circ", "hip_girth", ""},
                                 {"body_torso_circ", "torso_girth", ""},
                                 {"neck_front_to_waist_f", "front_neck_to_waist", ""},
                                 {"neck_back_to_waist_b", "back_neck_to_waist", ""},
                                 {"neck_side_to_waist_bustpoint_f", "front_waist_length", ""},
                                 {"neck_side_to_waist_scapula_b", "back_waist_length", ""},
                                 {"shoulder_length", "shoulder_length", ""},
                                 {"shoulder_tip_to_shoulder_tip_b", "across_back_shoulder", ""},
                                 {"across_back_b", "across_back", ""},
                                 {"across_chest_f", "across_front", ""},
                                 {"bustpoint_to_bustpoint", "bust_point_to_bust_point", ""},
                                 {"bustpoint_to_neck_side", "neck_to_bust_point", ""},
                                 {"arm_shoulder_tip_to_wrist", "arm_length", ""},
                                 {"arm_shoulder_tip_to_elbow", "upper_arm_length", ""},
                                 {"arm_elbow_to_wrist", "lower_arm_length", ""},
                                 {"arm_upper_circ", "upper_arm_girth", ""},
                                 {"arm_elbow_circ", "elbow_girth", ""},
                                 {"arm_lower_circ", "forearm_girth", ""},
                                 {"arm_wrist_circ", "wrist_girth", ""},
                                 {"armscye_circ", "armscye_girth", ""},
                                 {"leg_crotch_to_floor", "inside_leg", ""},
                                 {"leg_waist_side_to_floor", "outside_leg", ""},
                                 {"leg_waist_side_to_ankle", "waist_to_ankle_side", ""},
                                 {"leg_thigh_upper_circ", "thigh_girth", ""},
                                 {"leg_thigh_mid_circ", "mid_thigh_girth", ""},
                                 {"leg_knee_circ", "knee_girth", ""},
                                 {"leg_calf_circ", "calf_girth", ""},
                                 {"leg_ankle_circ", "ankle_girth", ""},
                                 {"crotch_length", "total_crotch_length", ""},
                                 {"crotch_length_b", "back_crotch_length", ""},
                                 {"crotch_length_f", "front_crotch_length", ""}};

// FreeSewing's hips are where trousers sit, its seat is the widest girth.
constexpr TheirName kFreeSewing[] = {{"ankle", "ankle_girth", ""},
                                     {"biceps", "upper_arm_girth", ""},
                                     {"bustSpan", "bust_point_to_bust_point", ""},
                                     {"chest", "chest_girth", ""},
                                     {"crossSeam", "total_crotch_length", ""},
                                     {"crossSeamFront", "front_crotch_length", ""},
                                     {"crotchDepth", "body_rise", ""},
                                     {"hips", "high_hip_girth", ""},
                                     {"hpsToBust", "neck_to_bust_point", ""},
                                     {"hpsToWaistBack", "back_waist_length", ""},
                                     {"hpsToWaistFront", "front_waist_length", ""},
                                     {"inseam", "inside_leg", ""},
                                     {"knee", "knee_girth", ""},
                                     {"neck", "neck_girth", ""},
                                     {"seat", "hip_girth", ""},
                                     {"shoulderToElbow", "upper_arm_length", ""},
                                     {"shoulderToShoulder", "across_back_shoulder", ""},
                                     {"shoulderToWrist", "arm_length", ""},
                                     {"underbust", "under_bust_girth", ""},
                                     {"upperLeg", "thigh_girth", ""},
                                     {"waist", "waist_girth", ""},
                                     {"waistToArmpit", "armpit_height", "waist_height"},
                                     {"waistToFloor", "outside_leg", ""},
                                     {"waistToHips", "waist_height", "high_hip_height"},
                                     {"waistToKnee", "waist_to_knee", ""},
                                     {"waistToSeat", "waist_to_hip", ""},
                                     {"wrist", "wrist_girth", ""}};

constexpr TheirName kGarmentCode[] = {{"height", "stature", ""},
                                      {"head_l", "stature", "cervical_height"},
                                      {"arm_length", "arm_length", ""},
                                      {"armscye_depth", "shoulder_height", "armpit_height"},
                                      {"shoulder_w", "across_back_shoulder", ""},
                                      {"bust", "chest_girth", ""},
                                      {"bust_line", "neck_to_bust_point", ""},
                                      {"vert_bust_line", "cervical_height", "bust_height"},
                                      {"bust_points", "bust_point_to_bust_point", ""},
                                      {"underbust", "under_bust_girth", ""},
                                      {"waist", "waist_girth", ""},
                                      {"waist_line", "back_neck_to_waist", ""},
                                      {"waist_over_bust_line", "front_waist_length", ""},
                                      {"hips", "hip_girth", ""},
                                      {"hips_line", "waist_to_hip", ""},
                                      {"crotch_hip_diff", "hip_height", "inside_leg"},
                                      {"leg_circ", "thigh_girth", ""},
                                      {"wrist", "wrist_girth", ""}};

// Of GarmentCode's mean body (assets/bodies/mean_all.yaml): a share of a measured girth or length, or degrees.
struct MeanBody {
  std::string_view name, of;
  double share;
};
constexpr MeanBody kGarmentCodeMean[] = {{"back_width", "chest_girth", 47.6761 / 99.8407},
                                         {"waist_back_width", "waist_girth", 39.1358 / 84.3338},
                                         {"hip_back_width", "hip_girth", 54.8237 / 103.478},
                                         {"bum_points", "hip_girth", 18.2342 / 103.478},
                                         {"neck_w", "across_back_shoulder", 18.9328 / 36.4568},
                                         {"shoulder_incl", "", 21.6777},
                                         {"hip_inclination", "", 4.93},
                                         {"arm_pose_angle", "", 45.483}};

// None: this body does not have it.
std::optional<double> tape_mm(const PersonMeasurement& person, std::string_view id) {
  const int place = person.tape == nullptr ? -1 : definition_index(*person.tape, id);
  const auto i = static_cast<std::size_t>(place);
  if (place < 0 || i >= person.tape_values.size() || !std::isfinite(person.tape_values[i])) return std::nullopt;
  return static_cast<double>(person.tape_values[i]);
}

std::optional<double> their_mm(const PersonMeasurement& person, const TheirName& name) {
  const auto plus = tape_mm(person, name.plus);
  if (!plus || name.minus.empty()) return plus;
  const auto minus = tape_mm(person, name.minus);
  return minus && *plus > *minus ? std::optional(*plus - *minus) : std::nullopt;
}

// Tenths of a millimetre, as in result.json: digits that are no measurement are not written.
std::string length(double mm, LengthUnit unit) {
  if (unit == LengthUnit::in) return fmt::format("{:.3f}", mm / kMmPerInch);
  return unit == LengthUnit::cm ? fmt::format("{:.2f}", mm / kMmPerCm) : fmt::format("{:.1f}", mm);
}

std::string seamly(const PersonMeasurement& person, LengthUnit wanted) {
  const LengthUnit unit = wanted == LengthUnit::in ? LengthUnit::in : LengthUnit::cm;
  std::string text = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<smis>\n    <!--Measured by im2fit-->\n"
      "    <version>0.3.4</version>\n    <read-only>false</read-only>\n    <notes/>\n    <unit>{}</unit>\n"
      "    <pm_system>998</pm_system>\n    <personal>\n        <family-name/>\n        <given-name/>\n"
      "        <birth-date>1800-01-01</birth-date>\n        <gender>unknown</gender>\n        <email/>\n"
      "    </personal>\n    <body-measurements>\n",
      unit == LengthUnit::in ? "inch" : "cm");
  for (const TheirName& name : kSeamly)
    if (const auto mm = their_mm(person, name))
      text += fmt::format("        <m name=\"{}\" value=\"{}\"/>\n", name.name, length(*mm, unit));
  return text + "    </body-measurements>\n</smis>\n";
}

std::string free_sewing(const PersonMeasurement& person) {
  std::string text;
  for (const TheirName& name : kFreeSewing)
    if (const auto mm = their_mm(person, name))
      text += fmt::format("{}  \"{}\": {:.1f}", text.empty() ? "" : ",\n", name.name, *mm);
  return "{\n" + text + "\n}\n";
}

std::string garment_code(const PersonMeasurement& person) {
  std::string text = "# Measured by im2fit; cm and degrees\nbody:\n";
  for (const TheirName& name : kGarmentCode)
    if (const auto mm = their_mm(person, name))
      text += fmt::format("  {}: {}\n", name.name, length(*mm, LengthUnit::cm));
  text += "  # not measured: of GarmentCode's mean body, scaled by this body's girths\n";
  for (const MeanBody& mean : kGarmentCodeMean) {
    if (mean.of.empty())
      text += fmt::format("  {}: {:.2f}\n", mean.name, mean.share);
    else if (const auto mm = tape_mm(person, mean.of))
      text += fmt::format("  {}: {}\n", mean.name, length(*mm * mean.share, LengthUnit::cm));
  }
  return text;
}

// A name of one's own tape may hold a comma or a quote.
std::string cell(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c == '\n' ? ' ' : c);
  return out + "\"";
}

std::string table(const PersonMeasurement& person, LengthUnit unit) {
  constexpr std::string_view kUnits[] = {"mm", "cm", "in"};
  std::string text = "id,value,low,high,unit,iso_8559_1,name\n";
  for (std::size_t i = 0; i < person.tape_values.size(); ++i) {
    const body::TapeDefinition& d = person.tape->definitions[i];
    if (d.kind == body::TapeKind::refused || !std::isfinite(person.tape_values[i])) continue;
    const bool is_length = unit_of(d) == "mm";
    const auto number = [&](float value) {
      return is_length ? length(static_cast<double>(value), unit) : fmt::format("{:.2f}", value);
    };
    const bool known = i < person.tape_intervals.size() && person.tape_intervals[i].known;
    text += fmt::format(
        "{},{},{},{},{},{},{}\n", d.id, number(person.tape_values[i]),
        known ? number(person.tape_intervals[i].low) : "", known ? number(person.tape_intervals[i].high) : "",
        is_length ? kUnits[static_cast<std::size_t>(unit)] : std::string_view("kg"), d.iso_8559, cell(d.names[0]));
  }
  return text;
}

}  // namespace

std::string measurement_file_fault(const std::string& path) {
  for (const char* ending : {".smis", ".json", ".yaml", ".csv"})
    if (path.size() > std::string_view(ending).size() && path.ends_with(ending)) return "";
  return path + ": expected .smis (Seamly2D), .json (FreeSewing), .yaml (GarmentCode) or .csv (all of the tape)";
}

Result<std::string> measurement_file(const PersonMeasurement& person, const std::string& path, LengthUnit unit) {
  if (const std::string fault = measurement_file_fault(path); !fault.empty())
    return Error{ErrorCode::invalid_argument, fault};
  if (person.tape == nullptr || person.tape_values.empty())
    return Error{ErrorCode::unsupported, path + ": nothing was measured, so there is nothing to write"};
  if (path.ends_with(".smis")) return seamly(person, unit);
  if (path.ends_with(".json")) return free_sewing(person);
  if (path.ends_with(".yaml")) return garment_code(person);
  return table(person, unit);
}

}  // namespace im2fit
