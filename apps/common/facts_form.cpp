// SPDX-License-Identifier: Apache-2.0
#include "apps/common/facts_form.h"

#include <fmt/format.h>

#include <string>

#include "apps/common/events.h"
#include "formats/json_file.h"

namespace im2fit::apps {
namespace {

Error bad_form(std::string why) {
  return Error{ErrorCode::invalid_argument, std::move(why)};
}

// Of a field that must be a number in this range.
Result<float> number_field(const std::string& name, const Json& field, const KnownRange& range) {
  const auto& [least, most] = range;
  const auto expected = [&, least = least, most = most] {
    return bad_form(fmt::format("{}: expected a number, {} to {}", name, least, most));
  };
  if (!field.is_number()) return expected();
  const double value = field.get<double>();
  if (!(value >= static_cast<double>(least) && value <= static_cast<double>(most))) return expected();
  return static_cast<float>(value);
}

// Of a field that must be one of two words: whether it is the first.
Result<bool> word_field(const std::string& name, const Json& field, const char* first, const char* second) {
  if (field == first) return true;
  if (field == second) return false;
  return bad_form(fmt::format("{}: expected \"{}\" or \"{}\"", name, first, second));
}

}  // namespace

Result<KnownFacts> facts_of_form(std::string_view body) {
  const auto read = parse_json<Json>(body, "the form");
  if (!read || !read->is_object()) return bad_form("expected a JSON object");
  const Json& form = *read;
  KnownFacts facts;
  bool of_scale = false, has_origin = false;
  for (const auto& [name, field] : form.items()) {
    if (name == "height_mm" || name == "weight_kg" || name == "age") {
      const bool height = name == "height_mm", weight = name == "weight_kg";
      const auto value = height   ? number_field(name, field, kKnownStatureMm)
                         : weight ? number_field(name, field, kKnownWeightKg)
                                  : number_field(name, field, kCompletedYears);
      if (!value) return value.error();
      if (height) facts.stature_mm = {*value, kStatedStatureSdMm};
      if (weight) facts.weight_kg = {*value, kStatedWeightSdKg};
      if (name == "age") facts.age_years = {age_of_completed_years(*value), kStatedAgeSdYears};
    } else if (name == "sex") {
      const auto woman = word_field(name, field, "woman", "man");
      if (!woman) return woman.error();
      facts.sex = *woman ? KnownSex::woman : KnownSex::man;
    } else if (name == "weight_from") {
      const auto scale = word_field(name, field, "scale", "stated");
      if (!scale) return scale.error();
      of_scale = *scale;
      has_origin = true;
    } else {
      return bad_form("unknown field; known are height_mm, weight_kg, weight_from, sex and age");
    }
  }
  if (has_origin && facts.weight_kg.sd == 0) return bad_form("weight_from: expected with weight_kg");
  if (of_scale) facts.weight_kg.sd = kScaleSdKg;
  return facts;
}

}  // namespace im2fit::apps
