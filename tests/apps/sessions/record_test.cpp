// SPDX-License-Identifier: Apache-2.0
#include "apps/sessions/record.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "a_record.h"
#include "engine/schema.h"

namespace im2fit::sessions {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using Json = nlohmann::json;

std::vector<std::string> schema_faults(const std::string& text) {
  std::ifstream file(IM2FIT_SESSION_SCHEMA);
  return test::SchemaCheck(Json::parse(file)).run(Json::parse(text));
}

// `change` made to the JSON of a good record.
template <class Change>
std::string changed(const Change& change) {
  Json json = Json::parse(record_json(test::a_record()));
  change(json);
  return json.dump();
}

TEST(SessionRecord, EveryFieldComesBack) {
  const Record written = test::a_record();
  const std::string text = record_json(written);
  EXPECT_THAT(schema_faults(text), IsEmpty());
  const auto read = parse_record(text, "session.json");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->id, written.id);
  EXPECT_EQ(read->started_utc, written.started_utc);
  EXPECT_EQ(read->person, "P017");
  EXPECT_EQ(read->consent.version, "operator-de-1");
  EXPECT_EQ(read->consent.text_sha256, written.consent.text_sha256);
  EXPECT_EQ(read->truth.height_mm, 1743);
  EXPECT_EQ(read->truth.weight_kg, 72.5);
  EXPECT_EQ(read->truth.age_years, 41);
  EXPECT_EQ(read->truth.gender, "female");
  EXPECT_EQ(read->truth.clothing, "close");
  EXPECT_EQ(read->truth.tape.at("waist_girth").second, 809.5);
  EXPECT_EQ(read->truth.tape.at("waist_girth").mean(), 810.75);
  EXPECT_EQ(read->truth.tape.at("thigh_girth").second, std::nullopt);
  EXPECT_EQ(read->truth.tape.at("thigh_girth").mean(), 566);
  EXPECT_EQ(read->notes, written.notes);
  EXPECT_EQ(read->camera.height, 640);
  EXPECT_EQ(read->camera.cy, 319.5);
  EXPECT_EQ(read->versions.index, "89ab0123");
  EXPECT_EQ(read->settings.frames, 20);
  EXPECT_EQ(read->settings.turn, "back");
  EXPECT_EQ(read->settings.clothing, "bare");
  EXPECT_EQ(record_json(*read), text);
}

TEST(SessionRecord, WhatIsNotKnownIsAbsent) {
  Record record = test::a_record();
  record.truth = {};
  const std::string text = record_json(record);
  EXPECT_EQ(Json::parse(text)["truth"], Json::object());
  EXPECT_THAT(schema_faults(text), IsEmpty());
  const auto read = parse_record(text, "session.json");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_FALSE(read->truth.height_mm || read->truth.weight_kg || read->truth.age_years);
  EXPECT_TRUE(read->truth.tape.empty());
}

TEST(SessionRecord, UnknownKeysAreKept) {
  const std::string text = changed([](Json& json) {
    json["mood"] = "good";
    json["truth"]["shoe_size"] = 42;
    json["truth"]["tape"] = {{"neck_girth", {370}}};
  });
  auto read = parse_record(text, "session.json");
  ASSERT_TRUE(read) << read.error().message;
  read->truth.height_mm.reset();
  const Json again = Json::parse(record_json(*read));
  EXPECT_EQ(again["mood"], "good");
  EXPECT_EQ(again["truth"]["shoe_size"], 42);
  EXPECT_FALSE(again["truth"].contains("height_mm"));
  EXPECT_EQ(again["truth"]["tape"], Json({{"neck_girth", {370}}}));
}

TEST(SessionRecord, ErrorsNameFileAndField) {
  const std::pair<std::string, std::string> kCases[] = {
      {changed([](Json& j) { j["truth"]["height_mm"] = 17.43; }), "truth.height_mm is 17.43, expected 500 to 2500"},
      {changed([](Json& j) { j["truth"]["height_mm"] = "1743"; }), "truth.height_mm is not a number"},
      {changed([](Json& j) { j["truth"]["gender"] = "x"; }), "truth.gender is \"x\", expected female, male"},
      {changed([](Json& j) { j["truth"]["tape"]["waist_girth"] = Json::array(); }), "truth.tape.waist_girth"},
      {changed([](Json& j) {
         j["truth"]["tape"]["waist_girth"] = {1, 2};
       }),
       "truth.tape.waist_girth is 1"},
      {changed([](Json& j) { j["truth"]["tape"]["../x"] = {800}; }), "expected an id"},
      {changed([](Json& j) { j["truth"] = 3; }), "truth is not an object"},
      {changed([](Json& j) { j.erase("person"); }), "person is missing"},
      {changed([](Json& j) { j["person"] = "a\nb"; }), "person has control characters"},
      {changed([](Json& j) { j["consent"].erase("version"); }), "consent.version is missing"},
      {changed([](Json& j) { j["consent"]["text_sha256"] = "abc"; }), "consent.text_sha256"},
      {changed([](Json& j) { j["camera"]["width"] = 0; }), "camera.width is not a whole number of 1 to 65535"},
      {changed([](Json& j) { j["camera"].erase("fx"); }), "camera.fx is missing"},
      {changed([](Json& j) { j["settings"]["frames"] = 0; }), "settings.frames is not a whole number of 1 to 65535"},
      {changed([](Json& j) { j["settings"]["turn"] = 1; }), "settings.turn is not none, back, around or walk"},
      {changed([](Json& j) { j["settings"]["region"] = "0.6,1.5,-0.6,3"; }), "settings.region is not x0,z0,x1,z1"},
      {changed([](Json& j) { j["started_utc"] = "yesterday"; }), "started_utc"},
      {changed([](Json& j) { j["schema"] = "im2fit.session/2"; }), "expected \"im2fit.session/1\""},
      {changed([](Json& j) { j["notes"] = std::string(5000, 'x'); }), "notes has 5000 bytes"},
      {"[1, 2]", "not a JSON object"},
      {"{\"schema\": \"im2fit.se", "not JSON"}};
  for (const auto& [text, expected] : kCases) {
    const auto read = parse_record(text, "a/session.json");
    ASSERT_FALSE(read) << expected;
    EXPECT_THAT(read.error().message, HasSubstr("a/session.json: ")) << expected;
    EXPECT_THAT(read.error().message, HasSubstr(expected));
  }
}

std::string nested(std::size_t levels) {
  return std::string(levels, '[') + std::string(levels, ']');
}

// 100,000 levels end a program that prints, copies or compares them; 100,000 keys keep it busy for 20 s.
TEST(SessionRecord, DeepWideAndLongTextsAreRefusedInALine) {
  const std::string whole = changed([](Json& j) { j["mood"] = "MOOD"; });
  const auto with_mood = [&](const std::string& value) {
    return std::string(whole).replace(whole.find("\"MOOD\""), 6, value);
  };
  const auto many = [](int count) {
    std::string keys = "{\"0\": 0";
    for (int i = 1; i < count; ++i) keys += ", \"" + std::to_string(i) + "\": 0";
    return keys + "}";
  };
  const std::pair<std::string, std::string> kCases[] = {
      {"{\"schema\": " + nested(100'000) + "}", "nested deeper than 64 levels"},
      {with_mood(nested(100'000)), "nested deeper than 64 levels"},
      {with_mood("{\"a\\\"\": " + nested(63) + "}"), "nested deeper than 64 levels"},
      {with_mood(many(100'000)), "has an object of more than 10000 keys"},
      {with_mood("[" + many(4000) + "," + many(9000) + "," + many(9000) + "]"), "or many of nearly as many"},
      {with_mood("\"caf\xe9\""), "not JSON"},
      {changed([](Json& j) { j["schema"] = std::string(100'000, 'x'); }), "schema is \"xxx"},
      {changed([](Json& j) { j["truth"]["gender"] = std::string(100'000, 'x'); }), "truth.gender is \"xxx"},
      {changed([](Json& j) { j["truth"]["tape"][std::string(100'000, 'x')] = 3; }), "truth.tape.xxx"},
      {changed([](Json& j) { j["truth"]["tape"][std::string(100'000, 'x')] = {800}; }), "expected an id"}};
  for (const auto& [text, expected] : kCases) {
    const auto read = parse_record(text, "session.json");
    ASSERT_FALSE(read) << expected;
    EXPECT_THAT(read.error().message, HasSubstr(expected));
    EXPECT_LT(read.error().message.size(), 200U) << expected;
  }
  for (const std::string& value :
       {nested(63), "\"" + std::string(1000, '[') + "\\\"{\\\\\"", "[0" + std::string(40'000, ' ') + "]"}) {
    const auto read = parse_record(with_mood(value), "session.json");
    EXPECT_TRUE(read) << read.error().message;
  }
}

TEST(SessionRecord, EveryCutOffTextIsAnError) {
  const std::string text = record_json(test::a_record());
  for (std::size_t size = 0; size + 2 < text.size(); ++size)
    EXPECT_FALSE(parse_record(std::string_view(text).substr(0, size), "session.json")) << size;
}

TEST(SessionRecord, NothingThatIsNoNumberIsWritten) {
  Record record = test::a_record();
  record.truth.weight_kg = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(fault_of(record), HasSubstr("truth.weight_kg"));
  record.truth.weight_kg = std::numeric_limits<double>::infinity();
  EXPECT_THAT(fault_of(record), HasSubstr("truth.weight_kg"));
}

}  // namespace
}  // namespace im2fit::sessions
