// SPDX-License-Identifier: Apache-2.0
#include "apps/common/known_options.h"

#include <charconv>
#include <string_view>
#include <system_error>

namespace im2fit::apps {
namespace {

constexpr float kMmPerInch = 25.4F;
constexpr float kKgPerPound = 0.45359237F;  // the international pound
constexpr int kInchesPerFoot = 12;

// All of the text as a number; below 0: it is none.
float number_of(std::string_view text) {
  float value = -1;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size() ? value : -1;
}

}  // namespace

float millimetres_of_feet(const std::string& text) {
  std::string plain;
  for (const char c : text)
    if (c != ' ' && c != '"') plain += c;
  for (const std::string_view mark : {"'", "ft"}) {
    const std::size_t at = plain.find(mark);
    if (at == std::string::npos) continue;
    const std::string_view all = plain;
    std::string_view after = all.substr(at + mark.size());
    if (after.ends_with("in")) after.remove_suffix(2);
    const float feet = number_of(all.substr(0, at)), inches = after.empty() ? 0 : number_of(after);
    if (feet < 0 || inches < 0 || inches >= kInchesPerFoot) return -1;
    return (feet * kInchesPerFoot + inches) * kMmPerInch;
  }
  return -1;
}

void add_known_options(cli::App& sub, KnownOptions& options) {
  auto* height = sub.add_option("--height-mm", options.height_mm, "Height of the person, barefoot")
                     ->type_name("MM")
                     ->range(double{kKnownStatureMm.least}, double{kKnownStatureMm.most});
  sub.add_option("--height-ft", options.height_ft, "Height in feet and inches: 5'11")
      ->type_name("FT")
      ->check([](const std::string& text) {
        const float mm = millimetres_of_feet(text);
        return mm >= static_cast<float>(kKnownStatureMm.least) && mm <= static_cast<float>(kKnownStatureMm.most)
                   ? std::string()
                   : "'" + text + "' is not a height: expected 1'8 to 8'2, as 5'11";
      })
      ->excludes(height);
  auto* weight =
      sub.add_option("--weight-kg", options.weight_kg, "Weight of the person. It makes girths more accurate")
          ->type_name("KG")
          ->range(double{kKnownWeightKg.least}, double{kKnownWeightKg.most});
  sub.add_option("--weight-lb", options.weight_lb, "Weight in pounds")
      ->type_name("LB")
      ->range(33.1, 881.0)
      ->excludes(weight);
  sub.add_option("--weight-from", options.weight_from,
                 "Origin of the weight. scale: weighed today, accurate to 0.7 kg. stated: reported, accurate to 3 kg")
      ->one_of({"stated", "scale"})
      ->capture_default_str();
  sub.add_option("--sex", options.sex, "Sex of the person")->one_of({"woman", "man"});
  sub.add_option("--age", options.age_years, "Age of the person, completed years")
      ->type_name("YEARS")
      ->range(double{kCompletedYears.least}, double{kCompletedYears.most});
}

KnownFacts known_facts(const KnownOptions& options) {
  KnownFacts facts;
  const float height_mm = options.height_ft.empty() ? options.height_mm : millimetres_of_feet(options.height_ft);
  if (height_mm > 0) facts.stature_mm = {height_mm, kStatedStatureSdMm};
  const float weight_kg = options.weight_lb > 0 ? options.weight_lb * kKgPerPound : options.weight_kg;
  if (weight_kg > 0) facts.weight_kg = {weight_kg, options.weight_from == "scale" ? kScaleSdKg : kStatedWeightSdKg};
  if (options.age_years > 0) facts.age_years = {age_of_completed_years(options.age_years), kStatedAgeSdYears};
  if (!options.sex.empty()) facts.sex = options.sex == "woman" ? KnownSex::woman : KnownSex::man;
  return facts;
}

}  // namespace im2fit::apps
