// SPDX-License-Identifier: Apache-2.0
// session.json, schema im2fit.session/1: the recorded person, the tape readings and the consent.
// docs/sessions.md describes each field, docs/session.schema.json is the schema.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "core/status.h"

namespace im2fit::sessions {

inline constexpr char kSchema[] = "im2fit.session/1";

// What is taken for a slip of the pen beyond. Wider than adults are: a wrong unit is found, a rare person is not
// turned away.
struct Range {
  double least, most;
};
inline constexpr Range kHeightMm{500, 2500};
inline constexpr Range kWeightKg{10, 400};
inline constexpr Range kAgeYears{0, 120};
inline constexpr Range kTapeMm{10, 3000};
// Bytes of text in a field.
inline constexpr std::size_t kPersonBytesMax = 64;
inline constexpr std::size_t kWordBytesMax = 64;   // a size, a version, a name of a site
inline constexpr std::size_t kLineBytesMax = 640;  // what a shop says: 160 characters
inline constexpr std::size_t kNotesBytesMax = 4096;
inline constexpr std::size_t kTapeValuesMax = 200;

struct Consent {
  std::string version;      // of the text: "operator-de-1"
  std::string language;     // of the text: "de"
  std::string text_sha256;  // of the text in UTF-8, 64 hexadecimal digits
  std::string given_utc;    // "2026-05-04T12:30:00Z"
  // What the shop added to the text, in that language (--shop); "": nothing.
  std::string operator_name{}, purpose{}, contact{};
};

// One tape measurement, in mm, or a weight in kg: taken once, or twice for the tape's own error.
struct TapeReading {
  double first = 0;
  std::optional<double> second;
  double mean() const { return second ? (first + *second) / 2 : first; }
};

// What is known of the person without a camera. What is not known is absent, never 0 or "".
struct PersonTruth {
  std::optional<double> height_mm, weight_kg, age_years;
  std::string gender;                       // "male", "female" or ""
  std::string worn_size;                    // as the label says: "M"
  std::string clothing;                     // "bare", "close", "loose" or ""
  std::map<std::string, TapeReading> tape;  // by id of the tape's measurements (docs/tape.md)
};

// The reading of a measurement of result.json: the tape's, else the height for the stature and the weight (kg) for
// the weight. nullopt: it was not taken.
std::optional<TapeReading> reading_of(const PersonTruth& truth, const std::string& id);

struct Camera {
  std::string kind;  // how it senses depth (core/sensor_kind.h): "structured-light"; "" when it is not known
  std::string name;
  int width = 0, height = 0;  // pixels, upright
  double fx = 0, fy = 0, cx = 0, cy = 0;
};

// Of what measured.
struct Versions {
  std::string im2fit;
  std::string body, tracker, index;  // CRC-32C of the files, 8 hexadecimal digits
};

// How it was measured, as `im2fit measure` takes it: so that the recording can be measured the same way again.
struct Settings {
  int frames = 0;                             // good ones behind the answer, of each side; 0: not known
  std::string turn = "none";                  // or another of kTurnNames
  std::string calibration, clothing, sensor;  // "": not known
  std::string region{};  // "x0,z0,x1,z1" in metres, within which people were measured; "": everywhere
};

struct Record {
  std::string id;
  std::string started_utc;  // "2026-05-04T12:30:00Z"
  std::string person;       // a pseudonym, typed by the operator
  Consent consent;
  PersonTruth truth;
  std::string notes;
  Camera camera;
  std::string site;  // "": unknown
  Versions versions;
  Settings settings;
  // The text it was read from: record_json() keeps the keys of it that are not known here.
  std::string document;
};

// The text of session.json.
std::string record_json(const Record& record);
// `what` names the file in errors. Errors: unsupported for another schema; corrupt, naming the field, for a field
// that is missing, of another type or out of range.
Result<Record> parse_record(std::string_view text, const std::string& what);
// What is wrong with a record to be written, "" when nothing is; names the field: "truth.height_mm is 17.3, expected
// 500 to 2500".
std::string fault_of(const Record& record);

}  // namespace im2fit::sessions
