// SPDX-License-Identifier: Apache-2.0
// What the page says, in every language: all of it, and short enough to be read from where one stands.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "core/guidance.h"
#include "core/measurement.h"
#include "hal/depth_diagnosis.h"

namespace im2fit {
namespace {

using Json = nlohmann::ordered_json;
const std::vector<std::string> kLanguages = {"en", "de", "es", "fr", "zh"};

std::string text_of(const std::string& name) {
  std::ifstream file(std::string(IM2FIT_WEB_DIR) + "/" + name);
  EXPECT_TRUE(file) << name;
  return {std::istreambuf_iterator<char>(file), {}};
}
Json table_of(const std::string& language) {
  const Json table = Json::parse(text_of("lang/" + language + ".json"), nullptr, false);
  EXPECT_TRUE(table.is_object()) << language;
  return table;
}
std::size_t words_in(const std::string& text) {
  std::istringstream words(text);
  std::size_t count = 0;
  // French sets its colon apart: no word.
  for (std::string word; words >> word;) count += word != ":" && word != ";" && word != "!" && word != "?";
  return count;
}
std::size_t characters_in(const std::string& text) {
  std::size_t count = 0;
  for (const char c : text) count += (static_cast<unsigned char>(c) & 0xC0U) != 0x80U;  // UTF-8
  return count;
}
// Every code of the engine, the arms it names, and the page's own.
std::set<std::string> codes() {
  std::set<std::string> all(kGuidanceNames.begin(), kGuidanceNames.end());
  all.erase("");  // bits without a code
  for (const char* code : {"WELCOME", "FACTS", "ARMS_CLOSE_LEFT", "ARMS_CLOSE_RIGHT", "HOLD", "WORKING", "DONE",
                           "OVER", "CAMERA_LOST", "NO_CAMERA", "MODELS_MISSING", "SERVER_GONE", "TOO_MANY_SCREENS"})
    all.insert(code);
  return all;
}
// Of every text at any depth, "list.title"; how many there are of a list belongs to its name.
void add_names(const Json& json, const std::string& name, std::set<std::string>& names) {
  if (json.is_object())
    for (const auto& [key, value] : json.items()) add_names(value, name + "." + key, names);
  else if (json.is_array())
    for (std::size_t i = 0; i < json.size(); ++i) add_names(json[i], name + "." + std::to_string(i), names);
  else
    names.insert(name);
}
std::set<std::string> all_names(const Json& json) {
  std::set<std::string> names;
  add_names(json, "", names);
  return names;
}
std::set<std::string> keys_of(const Json& object) {
  std::set<std::string> keys;
  for (const auto& [key, value] : object.items()) {
    keys.insert(key);
    EXPECT_FALSE(value.empty() || value == "") << key;
  }
  return keys;
}

TEST(Texts, EveryLanguageSaysEverythingAndNothingElse) {
  const Json english = table_of("en");
  std::set<std::string> measurements;
  for (const auto& info : kMeasurementTable) measurements.insert(std::string(info.id));
  for (const std::string& language : kLanguages) {
    SCOPED_TRACE(language);
    const Json table = table_of(language);
    EXPECT_EQ(table["language"], language);
    EXPECT_EQ(keys_of(table["say"]), codes());
    EXPECT_EQ(keys_of(table["measurements"]), measurements);
    EXPECT_EQ(keys_of(table["page"]), keys_of(english["page"]));
    EXPECT_EQ(keys_of(table["consent"]), keys_of(english["consent"]));
    EXPECT_EQ(keys_of(table["handed"]), keys_of(english["handed"]));
    EXPECT_EQ(keys_of(table["facts"]), keys_of(english["facts"]));
    EXPECT_EQ(keys_of(table["doubts"]), (std::set<std::string>{"FEET_RAISED", "HEELS_RAISED", "HEAD_UNSEEN"}));
    EXPECT_EQ(keys_of(table["shop"]), (std::set<std::string>{"operator", "purpose", "contact"}));
    for (const auto& [key, text] : table["shop"].items())
      EXPECT_NE(text.get<std::string>().find("{" + key + "}"), std::string::npos) << key;
    for (const char* key : {"FEET_RAISED", "HEELS_RAISED"})
      EXPECT_NE(table["doubts"][key].get<std::string>().find("{h}"), std::string::npos) << key;
    EXPECT_EQ(keys_of(table["tryon"]), keys_of(english["tryon"]));
    for (const char* group : {"garments", "regions", "verdicts"})
      EXPECT_EQ(keys_of(table["tryon"][group]), keys_of(english["tryon"][group])) << group;
    EXPECT_EQ(table["tryon"]["legend"].size(), english["tryon"]["legend"].size());
    EXPECT_EQ(table["consent"]["points"].size(), english["consent"]["points"].size());
    EXPECT_EQ(table["consent"]["version"], english["consent"]["version"]) << "one text, in five languages";
    EXPECT_EQ(keys_of(table["units"]), (std::set<std::string>{"cm", "in", "kg", "lb"}));
    for (const char* key : {"verdict", "best_of"})
      EXPECT_NE(table["tryon"][key].get<std::string>().find("{size}"), std::string::npos) << key;
    for (const char* key : {"tight", "snug", "loose"})
      EXPECT_NE(table["tryon"]["verdicts"][key].get<std::string>().find("{where}"), std::string::npos) << key;
    for (const char* key : {"left", "left_recorded", "scan"})
      EXPECT_NE(table["page"][key].get<std::string>().find("{s}"), std::string::npos) << key;
  }
}

TEST(Texts, TheOperatorsAreTheSameInEveryLanguageAndAllThatTheirPageAsksFor) {
  const Json english = table_of("en")["operator"];
  const std::set<std::string> names = all_names(english);
  EXPECT_GT(names.size(), 40U);
  for (const std::string& language : kLanguages) {
    SCOPED_TRACE(language);
    const Json texts = table_of(language)["operator"];
    EXPECT_EQ(all_names(texts), names);
    EXPECT_EQ(texts["consent"]["version"], english["consent"]["version"]);
    for (const auto& [key, word] : {std::pair{"/phases/RECORDING", "{n}"},
                                    {"/phases/RECORDING", "{max}"},
                                    {"/misc/saved", "{id}"},
                                    {"/misc/dropped", "{n}"},
                                    {"/list/values", "{n}"},
                                    {"/region/not_number", "{field}"},
                                    {"/region/not_number", "{text}"},
                                    {"/region/too_far", "{field}"},
                                    {"/diagnosis/UNIT", "{unit}"},
                                    {"/diagnosis/ROTATED", "{deg}"}})
      EXPECT_NE(texts.at(Json::json_pointer(key)).get<std::string>().find(word), std::string::npos) << key;
  }
  for (const std::string_view code : hal::kDiagnosisNames) {
    EXPECT_TRUE(code.empty() || english["diagnosis"].contains(code)) << code;
  }
  const std::string asking = text_of("operator.html") + text_of("operator.js");
  for (const std::string& before : {std::string("data-text=\""), std::string(" of('"), std::string("(of('")})
    for (std::size_t at = asking.find(before); at != std::string::npos; at = asking.find(before, at + 1)) {
      const std::size_t from = at + before.size();
      std::string pointer = "/" + asking.substr(from, asking.find_first_of("\"'", from) - from);
      std::replace(pointer.begin(), pointer.end(), '.', '/');
      EXPECT_TRUE(english.contains(Json::json_pointer(pointer))) << pointer;
    }
}

TEST(Texts, TheFormIsTheSameInEveryLanguage) {
  const Json english = table_of("en")["facts"];
  const std::set<std::string> names = all_names(english);
  EXPECT_GT(names.size(), 25U);
  const std::string script = text_of("facts.js");
  for (const std::string& language : kLanguages) {
    SCOPED_TRACE(language);
    const Json texts = table_of(language)["facts"];
    EXPECT_EQ(all_names(texts), names);
    EXPECT_NE(texts["used"].get<std::string>().find("{facts}"), std::string::npos);
    EXPECT_NE(texts["years"].get<std::string>().find("{n}"), std::string::npos);
    for (const char* group : {"names", "yours", "doubted"})
      EXPECT_EQ(keys_of(texts[group]), (std::set<std::string>{"stature", "weight", "sex", "age"})) << group;
    std::set<std::string> doubts;
    for (const auto& [fact, text] : texts["doubted"].items()) doubts.insert(text);
    EXPECT_EQ(doubts.size(), 4U) << "each names its fact";
  }
  const std::string before = "this.texts.";
  for (std::size_t at = script.find(before); at != std::string::npos; at = script.find(before, at + 1)) {
    const std::size_t from = at + before.size();
    const std::string key = script.substr(from, script.find_first_not_of("abcdefghijklmnopqrstuvwxyz_", from) - from);
    EXPECT_TRUE(english.contains(key)) << key;
  }
}

TEST(Texts, AMessageIsSixWordsAtMost) {
  for (const std::string& language : kLanguages) {
    const Json say = table_of(language)["say"];
    for (const auto& [code, text] : say.items()) {
      EXPECT_LE(language == "zh" ? (characters_in(text) + 1) / 2 : words_in(text), 6U) << code << ": " << text;
    }
  }
}

// Words that a native ear took offence at; one language has one word for a camera.
TEST(Texts, WordsThatWereMendedStayMended) {
  const std::pair<const char*, std::vector<const char*>> kWrong[] = {
      {"en", {"as designed", "less certain"}},
      {"de", {"Schirme sind", "Kamera weg", "wie gedacht"}},
      {"es", {"Bienvenido", "Póngase derecho", "sí mismo", "menos seguro", "como debe ser"}},
      {"fr", {"moins sûr", "Tenez-vous droit", "comme prévu"}},
      {"zh", {"摄像头"}}};
  for (const auto& [language, wrong] : kWrong)
    for (const char* words : wrong)
      EXPECT_EQ(text_of("lang/" + std::string(language) + ".json").find(words), std::string::npos) << words;
}

TEST(Texts, TwoCodesNeverSayTheSame) {
  for (const std::string& language : kLanguages) {
    std::set<std::string> said;
    const Json say = table_of(language)["say"];
    for (const auto& [code, text] : say.items()) EXPECT_TRUE(said.insert(text).second) << language << " " << code;
  }
}

// The page's script asks for nothing that the languages lack.
TEST(Texts, WhatTheScriptAsksForIsThere) {
  const Json page = table_of("en")["page"];
  const std::string script = text_of("page.js") + text_of("handed.js");
  for (const std::string& before : {std::string("words.of('"), std::string("page.")}) {
    for (std::size_t at = script.find(before); at != std::string::npos; at = script.find(before, at + 1)) {
      const std::size_t from = at + before.size();
      const std::size_t to = script.find_first_not_of("abcdefghijklmnopqrstuvwxyz_", from);
      const std::string key = script.substr(from, to - from);
      EXPECT_TRUE(key == "js" || key == "md" || key.empty() || page.contains(key)) << key;
    }
  }
}

TEST(Texts, EveryCodeHasAPictureAndATone) {
  const std::string icons = text_of("icons.js"), sounds = text_of("sounds.js");
  for (const std::string& code : codes()) {
    EXPECT_NE(icons.find("\n  " + code + ": "), std::string::npos) << code;
    // Nothing to be heard from afar.
    if (code == "WELCOME" || code == "FACTS" || code == "OVER" || code == "TOO_MANY_SCREENS") continue;
    EXPECT_NE(sounds.find("\n  " + code + ": [["), std::string::npos) << code;
  }
  std::set<std::string> tones;
  std::istringstream lines(sounds.substr(sounds.find("kTones = {")));
  for (std::string line; std::getline(lines, line) && line != "};";) {
    const std::size_t at = line.find(": [[");
    EXPECT_TRUE(at == std::string::npos || tones.insert(line.substr(at)).second) << "the same tones: " << line;
  }
  EXPECT_GE(tones.size(), std::set(kGuidanceNames.begin(), kGuidanceNames.end()).size());
}

}  // namespace
}  // namespace im2fit
