// SPDX-License-Identifier: Apache-2.0
#include "apps/sessions/record.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/common/measuring.h"
#include "core/text.h"
#include "engine/engine.h"
#include "formats/json_file.h"

namespace im2fit::sessions {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array kGenders = {"female", "male"};
constexpr std::array kClothing = {"bare", "close", "loose"};

// ---- to JSON: each known key is set or, when there is no value, taken away; others stay as they are.

Json& object_in(Json& json, const char* key) {
  Json& found = json[key];
  if (!found.is_object()) found = Json::object();
  return found;
}

void set_text(Json& json, const char* key, const std::string& text) {
  json[key] = text;
}

void set_or_drop(Json& json, const char* key, const std::string& text) {
  if (text.empty())
    json.erase(key);
  else
    json[key] = text;
}

void set_or_drop(Json& json, const char* key, const std::optional<double>& value) {
  if (value)
    json[key] = *value;
  else
    json.erase(key);
}

void set_truth(Json& json, const PersonTruth& truth) {
  set_or_drop(json, "height_mm", truth.height_mm);
  set_or_drop(json, "weight_kg", truth.weight_kg);
  set_or_drop(json, "age_years", truth.age_years);
  set_or_drop(json, "gender", truth.gender);
  set_or_drop(json, "worn_size", truth.worn_size);
  set_or_drop(json, "clothing", truth.clothing);
  json.erase("tape");
  for (const auto& [id, reading] : truth.tape) {
    Json values = Json::array({reading.first});
    if (reading.second) values.push_back(*reading.second);
    json["tape"][id] = values;
  }
}

void set_settings(Json& json, const Settings& settings) {
  if (settings.frames > 0)
    json["frames"] = settings.frames;
  else
    json.erase("frames");
  json["turn"] = settings.turn;
  set_or_drop(json, "calibration", settings.calibration);
  set_or_drop(json, "clothing", settings.clothing);
  set_or_drop(json, "sensor", settings.sensor);
  set_or_drop(json, "region", settings.region);
}

// ---- from JSON: the first field that is wrong ends it.

class Fields {
 public:
  explicit Fields(const std::string& what) : what_(what) {}

  void wrong(const std::string& field, const std::string& problem) {
    if (error_.message.empty()) error_ = {ErrorCode::corrupt, fmt::format("{}: {} {}", what_, field, problem)};
  }
  const Json* find(const Json& json, const std::string& prefix, const char* key, bool needed) {
    const auto found = json.find(key);
    if (found != json.end()) return &*found;
    if (needed) wrong(prefix + key, "is missing");
    return nullptr;
  }
  void text(const Json& json, const std::string& prefix, const char* key, std::string& value, bool needed) {
    const Json* found = find(json, prefix, key, needed);
    if (found == nullptr) return;
    if (!found->is_string()) return wrong(prefix + key, "is not a text");
    value = found->get<std::string>();
  }
  void number(const Json& json, const std::string& prefix, const char* key, std::optional<double>& value) {
    const Json* found = find(json, prefix, key, false);
    if (found == nullptr) return;
    if (!found->is_number()) return wrong(prefix + key, "is not a number");
    value = found->get<double>();
  }
  void needed_number(const Json& json, const std::string& prefix, const char* key, double& value) {
    std::optional<double> read;
    number(json, prefix, key, read);
    if (find(json, prefix, key, true) != nullptr && read) value = *read;
  }
  // 1 to 65535
  void count(const Json& json, const std::string& prefix, const char* key, int& value, bool needed) {
    const Json* found = find(json, prefix, key, needed);
    if (found == nullptr) return;
    if (!found->is_number_integer() || found->get<std::int64_t>() < 1 || found->get<std::int64_t>() > 65535)
      return wrong(prefix + key, "is not a whole number of 1 to 65535");
    value = found->get<int>();
  }
  // Older sessions say true for the back.
  void turn(const Json& json, std::string& value) {
    const Json* found = find(json, "settings.", "turn", false);
    if (found == nullptr) return;
    if (found->is_boolean()) {
      value = kTurnNames[found->get<bool>() ? 1 : 0];
    } else if (found->is_string() &&
               std::find(kTurnNames.begin(), kTurnNames.end(), found->get<std::string>()) != kTurnNames.end()) {
      value = found->get<std::string>();
    } else {
      wrong("settings.turn", "is not none, back, around or walk");
    }
  }
  const Json& object(const Json& json, const char* key, bool needed) {
    static const Json kNone = Json::object();
    const Json* found = find(json, "", key, needed);
    if (found == nullptr) return kNone;
    if (found->is_object()) return *found;
    wrong(key, "is not an object");
    return kNone;
  }
  const Error& error() const { return error_; }

 private:
  const std::string& what_;
  Error error_;
};

void read_tape(Fields& fields, const Json& json, PersonTruth& truth) {
  const Json* tape = fields.find(json, "truth.", "tape", false);
  if (tape == nullptr) return;
  if (!tape->is_object()) return fields.wrong("truth.tape", "is not an object");
  for (const auto& [id, values] : tape->items()) {
    const bool right = values.is_array() && (values.size() == 1 || values.size() == 2) &&
                       std::all_of(values.begin(), values.end(), [](const Json& v) { return v.is_number(); });
    if (!right) return fields.wrong("truth.tape." + excerpt(id), "is not one or two numbers");
    TapeReading& reading = truth.tape[id];
    reading.first = values[0].get<double>();
    if (values.size() == 2) reading.second = values[1].get<double>();
  }
}

void read_truth(Fields& fields, const Json& json, PersonTruth& truth) {
  fields.number(json, "truth.", "height_mm", truth.height_mm);
  fields.number(json, "truth.", "weight_kg", truth.weight_kg);
  fields.number(json, "truth.", "age_years", truth.age_years);
  fields.text(json, "truth.", "gender", truth.gender, false);
  fields.text(json, "truth.", "worn_size", truth.worn_size, false);
  fields.text(json, "truth.", "clothing", truth.clothing, false);
  read_tape(fields, json, truth);
}

void read_camera(Fields& fields, const Json& json, Camera& camera) {
  fields.text(json, "camera.", "kind", camera.kind, false);
  fields.text(json, "camera.", "name", camera.name, false);
  fields.count(json, "camera.", "width", camera.width, true);
  fields.count(json, "camera.", "height", camera.height, true);
  fields.needed_number(json, "camera.", "fx", camera.fx);
  fields.needed_number(json, "camera.", "fy", camera.fy);
  fields.needed_number(json, "camera.", "cx", camera.cx);
  fields.needed_number(json, "camera.", "cy", camera.cy);
}

void read_settings(Fields& fields, const Json& json, Settings& settings) {
  fields.count(json, "settings.", "frames", settings.frames, false);
  fields.turn(json, settings.turn);
  fields.text(json, "settings.", "calibration", settings.calibration, false);
  fields.text(json, "settings.", "clothing", settings.clothing, false);
  fields.text(json, "settings.", "sensor", settings.sensor, false);
  fields.text(json, "settings.", "region", settings.region, false);
  if (!settings.region.empty() && !apps::region_of(settings.region))
    fields.wrong("settings.region", "is not x0,z0,x1,z1 in metres with x0 < x1 and z0 < z1");
}

void read_record(Fields& fields, const Json& json, Record& record) {
  fields.text(json, "", "id", record.id, true);
  fields.text(json, "", "started_utc", record.started_utc, true);
  fields.text(json, "", "person", record.person, true);
  const Json& consent = fields.object(json, "consent", true);
  fields.text(consent, "consent.", "version", record.consent.version, true);
  fields.text(consent, "consent.", "language", record.consent.language, true);
  fields.text(consent, "consent.", "text_sha256", record.consent.text_sha256, true);
  fields.text(consent, "consent.", "given_utc", record.consent.given_utc, true);
  fields.text(consent, "consent.", "operator", record.consent.operator_name, false);
  fields.text(consent, "consent.", "purpose", record.consent.purpose, false);
  fields.text(consent, "consent.", "contact", record.consent.contact, false);
  read_truth(fields, fields.object(json, "truth", true), record.truth);
  fields.text(json, "", "notes", record.notes, false);
  read_camera(fields, fields.object(json, "camera", true), record.camera);
  fields.text(json, "", "site", record.site, false);
  const Json& versions = fields.object(json, "versions", true);
  fields.text(versions, "versions.", "im2fit", record.versions.im2fit, true);
  fields.text(versions, "versions.", "body", record.versions.body, false);
  fields.text(versions, "versions.", "tracker", record.versions.tracker, false);
  fields.text(versions, "versions.", "index", record.versions.index, false);
  read_settings(fields, fields.object(json, "settings", false), record.settings);
}

// ---- limits

std::string fault_of_number(const char* field, const std::optional<double>& value, Range range) {
  if (!value || (*value >= range.least && *value <= range.most)) return "";  // false for NaN
  return fmt::format("{} is {}, expected {} to {}", field, *value, range.least, range.most);
}

std::string fault_of_text(const char* field, const std::string& text, std::size_t bytes_max) {
  if (text.size() > bytes_max)
    return fmt::format("{} has {} bytes, expected at most {}", field, text.size(), bytes_max);
  return "";
}

// One line, for lists.
std::string fault_of_line(const char* field, const std::string& text, std::size_t bytes_max) {
  if (printable(text) != text) return fmt::format("{} has control characters", field);
  return fault_of_text(field, text, bytes_max);
}

template <std::size_t N>
std::string fault_of_word(const char* field, const std::string& word, const std::array<const char*, N>& words) {
  if (word.empty() || std::find(words.begin(), words.end(), word) != words.end()) return "";
  return fmt::format("{} is \"{}\", expected {}", field, excerpt(word), fmt::join(words, ", "));
}

bool is_tape_id(const std::string& id) {
  return !id.empty() && id.size() <= kWordBytesMax &&
         id.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") == std::string::npos;
}

std::string fault_of_tape(const PersonTruth& truth) {
  if (truth.tape.size() > kTapeValuesMax) return fmt::format("truth.tape has more than {} values", kTapeValuesMax);
  for (const auto& [id, reading] : truth.tape) {
    if (!is_tape_id(id))
      return fmt::format("truth.tape has \"{}\", expected an id of small letters, digits and _", excerpt(id));
    const std::string field = "truth.tape." + id;
    for (const std::optional<double>& value : {std::optional(reading.first), reading.second})
      if (std::string fault = fault_of_number(field.c_str(), value, kTapeMm); !fault.empty()) return fault;
  }
  return "";
}

// "2026-05-04T12:30:00Z"
bool is_utc(const std::string& text) {
  constexpr std::string_view kForm = "dddd-dd-ddTdd:dd:ddZ";
  if (text.size() != kForm.size()) return false;
  for (std::size_t i = 0; i < text.size(); ++i)
    if (kForm[i] == 'd' ? text[i] < '0' || text[i] > '9' : text[i] != kForm[i]) return false;
  return true;
}

bool is_sha256(const std::string& text) {
  return text.size() == 64 && text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

std::string fault_of_consent(const Consent& consent) {
  if (consent.version.empty()) return "consent.version is missing";
  if (!is_sha256(consent.text_sha256)) return "consent.text_sha256 is not 64 hexadecimal digits";
  if (!is_utc(consent.given_utc)) return "consent.given_utc is not a time like 2026-05-04T12:30:00Z";
  for (const std::string& fault : {fault_of_line("consent.version", consent.version, kWordBytesMax),
                                   fault_of_line("consent.language", consent.language, kWordBytesMax),
                                   fault_of_line("consent.operator", consent.operator_name, kLineBytesMax),
                                   fault_of_line("consent.purpose", consent.purpose, kLineBytesMax),
                                   fault_of_line("consent.contact", consent.contact, kLineBytesMax)})
    if (!fault.empty()) return fault;
  return "";
}

}  // namespace

std::string record_json(const Record& record) {
  auto document = parse_json<Json>(record.document, "session.json");
  Json json = document && document->is_object() ? std::move(*document) : Json::object();
  json["schema"] = kSchema;
  set_text(json, "id", record.id);
  set_text(json, "started_utc", record.started_utc);
  set_text(json, "person", record.person);
  Json& consent = object_in(json, "consent");
  set_text(consent, "version", record.consent.version);
  set_text(consent, "language", record.consent.language);
  set_text(consent, "text_sha256", record.consent.text_sha256);
  set_text(consent, "given_utc", record.consent.given_utc);
  set_or_drop(consent, "operator", record.consent.operator_name);
  set_or_drop(consent, "purpose", record.consent.purpose);
  set_or_drop(consent, "contact", record.consent.contact);
  set_truth(object_in(json, "truth"), record.truth);
  set_text(json, "notes", record.notes);
  Json& camera = object_in(json, "camera");
  set_text(camera, "kind", record.camera.kind);
  set_text(camera, "name", record.camera.name);
  camera["width"] = record.camera.width;
  camera["height"] = record.camera.height;
  camera["fx"] = record.camera.fx;
  camera["fy"] = record.camera.fy;
  camera["cx"] = record.camera.cx;
  camera["cy"] = record.camera.cy;
  set_text(json, "site", record.site);
  Json& versions = object_in(json, "versions");
  set_text(versions, "im2fit", record.versions.im2fit);
  set_text(versions, "body", record.versions.body);
  set_text(versions, "tracker", record.versions.tracker);
  set_text(versions, "index", record.versions.index);
  set_settings(object_in(json, "settings"), record.settings);
  return json_text(json, 2) + "\n";
}

Result<Record> parse_record(std::string_view text, const std::string& what) {
  const auto read = parse_json<Json>(text, what);
  if (!read) return read.error();
  const Json& json = *read;
  if (!json.is_object()) return Error{ErrorCode::corrupt, what + ": not a JSON object, expected a session.json"};
  const auto schema = json.find("schema");
  if (schema == json.end() || *schema != kSchema)
    return Error{ErrorCode::unsupported,
                 fmt::format("{}: schema {}, expected \"{}\"", what,
                             schema == json.end() ? "is missing" : "is " + excerpt(json_text(*schema)), kSchema)};
  Record record;
  Fields fields(what);
  read_record(fields, json, record);
  if (!fields.error().message.empty()) return fields.error();
  if (const std::string fault = fault_of(record); !fault.empty())
    return Error{ErrorCode::corrupt, fmt::format("{}: {}", what, fault)};
  record.document = text;
  return record;
}

std::string fault_of(const Record& record) {
  if (record.person.empty()) return "person is missing";
  if (!is_utc(record.started_utc)) return "started_utc is not a time like 2026-05-04T12:30:00Z";
  const PersonTruth& truth = record.truth;
  for (const std::string& fault :
       {fault_of_line("person", record.person, kPersonBytesMax), fault_of_consent(record.consent),
        fault_of_number("truth.height_mm", truth.height_mm, kHeightMm),
        fault_of_number("truth.weight_kg", truth.weight_kg, kWeightKg),
        fault_of_number("truth.age_years", truth.age_years, kAgeYears),
        fault_of_word("truth.gender", truth.gender, kGenders),
        fault_of_line("truth.worn_size", truth.worn_size, kWordBytesMax),
        fault_of_word("truth.clothing", truth.clothing, kClothing), fault_of_tape(truth),
        fault_of_text("notes", record.notes, kNotesBytesMax), fault_of_line("site", record.site, kWordBytesMax),
        fault_of_line("camera.name", record.camera.name, 4 * kWordBytesMax)})
    if (!fault.empty()) return fault;
  return "";
}

std::optional<TapeReading> reading_of(const PersonTruth& truth, const std::string& id) {
  if (const auto found = truth.tape.find(id); found != truth.tape.end()) return found->second;
  if (id == "stature" && truth.height_mm) return TapeReading{*truth.height_mm, {}};
  if (id == "weight" && truth.weight_kg) return TapeReading{*truth.weight_kg, {}};
  return std::nullopt;
}

}  // namespace im2fit::sessions
