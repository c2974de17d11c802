// SPDX-License-Identifier: Apache-2.0
// What a person reports of themselves: the form's JSON, and whose visit it belongs to, seen over HTTP.
#include <gmock/gmock.h>

#include "apps/common/facts_form.h"
#include "depth_folder.h"
#include "shown_page.h"

namespace im2fit::apps {
namespace {

using testing::HasSubstr;

TEST(FactsForm, ReadsEveryFieldAndNeedsNone) {
  const auto none = facts_of_form("{}");
  ASSERT_TRUE(none) << none.error().message;
  EXPECT_EQ(none->given(), 0U);
  const auto all =
      facts_of_form(R"({"height_mm": 1701.8, "weight_kg": 72.5, "weight_from": "scale", "sex": "man", "age": 35})");
  ASSERT_TRUE(all) << all.error().message;
  EXPECT_FLOAT_EQ(all->stature_mm.value, 1701.8F);
  EXPECT_FLOAT_EQ(all->stature_mm.sd, kStatedStatureSdMm);
  EXPECT_FLOAT_EQ(all->weight_kg.value, 72.5F);
  EXPECT_FLOAT_EQ(all->weight_kg.sd, kScaleSdKg);
  EXPECT_FLOAT_EQ(all->age_years.value, 35.5F) << "completed years: half a year more on average";
  EXPECT_EQ(all->sex, KnownSex::man);
  EXPECT_TRUE(check_known(*all));
  const auto stated = facts_of_form(R"({"sex": "woman", "weight_from": "stated", "weight_kg": 60})");
  ASSERT_TRUE(stated) << stated.error().message;
  EXPECT_FLOAT_EQ(stated->weight_kg.sd, kStatedWeightSdKg);
  EXPECT_EQ(stated->sex, KnownSex::woman);
  EXPECT_FLOAT_EQ(facts_of_form(R"({"weight_kg": 60})")->weight_kg.sd, kStatedWeightSdKg);
}

// What is accepted is what the engine accepts; an error names the field and repeats no value.
TEST(FactsForm, RefusesWhatIsNoFact) {
  const std::pair<const char*, const char*> wrong[] = {
      {"", "object"},
      {"{", "object"},
      {"[]", "object"},
      {"null", "object"},
      {"{} {}", "object"},
      {R"({"height_mm": 499})", "height_mm"},
      {R"({"height_mm": 2501})", "height_mm"},
      {R"({"height_mm": 1e400})", "object"},
      {R"({"height_mm": "1700"})", "height_mm"},
      {R"({"height_mm": null})", "height_mm"},
      {R"({"weight_kg": 14.9})", "weight_kg"},
      {R"({"weight_kg": 401})", "weight_kg"},
      {R"({"weight_kg": -70})", "weight_kg"},
      {R"({"weight_kg": true})", "weight_kg"},
      {R"({"age": 0})", "age"},
      {R"({"age": 120})", "age"},
      {R"({"age": [35]})", "age"},
      {R"({"sex": "female"})", "sex"},
      {R"({"sex": 1})", "sex"},
      {R"({"weight_kg": 70, "weight_from": "guess"})", "weight_from"},
      {R"({"weight_from": "scale"})", "weight_from"},
      {R"({"name": "Ada"})", "unknown field"}};
  for (const auto& [body, named] : wrong) {
    const auto facts = facts_of_form(body);
    ASSERT_FALSE(facts) << body;
    EXPECT_EQ(facts.error().code, ErrorCode::invalid_argument) << body;
    EXPECT_THAT(facts.error().message, HasSubstr(named)) << body;
    for (const char* value : {"14.9", "2501", "-70", "Ada", "guess", "female"})
      EXPECT_EQ(facts.error().message.find(value), std::string::npos) << facts.error().message;
  }
  for (const char* edge : {R"({"height_mm": 500})", R"({"height_mm": 2500})", R"({"weight_kg": 15})",
                           R"({"weight_kg": 400})", R"({"age": 1})", R"({"age": 119})"}) {
    const auto facts = facts_of_form(edge);
    ASSERT_TRUE(facts) << edge;
    EXPECT_TRUE(check_known(*facts)) << edge;
  }
}

class FactsOfVisit : public testing::Test {
 protected:
  FactsOfVisit() : shown_(settings()) {}
  static LivePageSettings settings() {
    LivePageSettings all;
    all.visit.ask_facts = true;
    all.hand_over = {"127.0.0.1", 0};
    return all;
  }
  int send(const std::string& body, const std::string& visit) const { return shown_.post_facts(visit, body); }
  std::string state() const {
    std::string state;
    for (const auto& event : shown_.events("beat"))
      if (event["event"] == "visit") state = event["state"];
    return state;
  }
  // A result, or the one with corrected facts.
  void measure(bool corrected) {
    Json event = {{"event", "measured"}, {"person", 1}, {"result", {{"of", corrected ? "corrected" : "first"}}}};
    if (corrected) event["corrected"] = true;
    shown_.begin_person();
    shown_.page().publish(event);
  }
  bool serves(const std::string& text) const {
    const auto answer = shown_.client().Get("/result.json");
    return answer->status == 200 && answer->body.find(text) != std::string::npos;
  }
  test::ShownPage shown_;
};

TEST_F(FactsOfVisit, ComeAfterConsentAndBeforeAnyFrame) {
  const std::string visit = shown_.visit();
  bool asks = false;
  for (const auto& event : shown_.events("beat")) asks = asks || event.value("asks_facts", false);
  EXPECT_TRUE(asks) << "the page is told";
  EXPECT_EQ(send("{}", visit), 409) << "no consent yet";
  ASSERT_EQ(shown_.post("/consent", visit), 200);
  EXPECT_EQ(state(), "FACTS");
  EXPECT_EQ(shown_.page().permit(), 0U) << "no frame is taken while a person fills in the form";
  EXPECT_EQ(send(R"({"weight_kg": 7})", visit), 400);
  EXPECT_EQ(send("{}", "another"), 409);
  EXPECT_EQ(state(), "FACTS") << "nothing of that was an answer";
  EXPECT_EQ(shown_.page().reported(1).count, 0U);
  EXPECT_EQ(send(R"({"weight_kg": 72})", visit), 202);
  EXPECT_EQ(state(), "MEASURING");
  EXPECT_EQ(shown_.page().permit(), 1U);
  const ReportedFacts reported = shown_.page().reported(1);
  EXPECT_GT(reported.count, 0U);
  EXPECT_FLOAT_EQ(reported.facts.weight_kg.value, 72);
  EXPECT_EQ(shown_.page().reported(2).count, 0U) << "of this visit alone";
}

TEST_F(FactsOfVisit, SkippingIsAnAnswerToo) {
  const std::string visit = shown_.visit();
  ASSERT_EQ(shown_.post("/consent", visit), 200);
  EXPECT_EQ(send("{}", visit), 202);
  EXPECT_EQ(state(), "MEASURING");
  EXPECT_EQ(shown_.page().reported(1).facts.given(), 0U);
}

TEST_F(FactsOfVisit, AreCorrectedAfterTheResult) {
  const std::string visit = shown_.visit();
  ASSERT_EQ(shown_.post("/consent", visit), 200);
  ASSERT_EQ(send(R"({"weight_kg": 30})", visit), 202);
  const std::uint32_t count = shown_.page().reported(1).count;
  measure(false);
  ASSERT_TRUE(serves("first"));
  const auto offered = shown_.client().Post(
      "/hand-over", httplib::Headers{{"Origin", shown_.url()}, {"X-Im2fit-Visit", visit}}, "", "");
  const std::string address = Json::parse(offered->body)["address"];
  shown_.page().publish({{"event", "left"}, {"frame", 2}, {"person", 1}});
  EXPECT_EQ(shown_.page().permit(), 0U) << "the person stands at the screen, and no frame is taken";
  EXPECT_EQ(send(R"({"weight_kg": 72})", visit), 202);
  EXPECT_NE(shown_.page().reported(1).count, count);
  EXPECT_FLOAT_EQ(shown_.page().reported(1).facts.weight_kg.value, 72);
  measure(true);
  EXPECT_TRUE(serves("corrected"));
  EXPECT_EQ(shown_.page().permit(), 0U) << "who has left is still gone";
  const std::size_t hash = address.find('#');
  httplib::Client phone(address.substr(0, hash - 1));
  const std::string origin = address.substr(0, hash - 1);
  EXPECT_EQ(
      phone.Post("/take", httplib::Headers{{"Origin", origin}, {"X-Im2fit-Token", address.substr(hash + 1)}}, "", "")
          ->status,
      404)
      << "its code was of the result before";
}

TEST_F(FactsOfVisit, GoWithTheVisit) {
  const std::string first = shown_.visit();
  ASSERT_EQ(shown_.post("/consent", first), 200);
  ASSERT_EQ(send(R"({"weight_kg": 72})", first), 202);
  measure(false);
  ASSERT_EQ(shown_.post("/delete", first), 200);
  EXPECT_EQ(shown_.page().reported(1).count, 0U);
  EXPECT_EQ(shown_.page().reported(2).count, 0U);
  EXPECT_EQ(send("{}", first), 409);
  // A correction that was being worked out when the person pressed "Delete".
  measure(true);
  EXPECT_EQ(shown_.status_of("/result.json"), 404);
  ASSERT_EQ(shown_.post("/consent", shown_.visit()), 200);
  EXPECT_EQ(state(), "FACTS");
  measure(true);
  EXPECT_EQ(shown_.status_of("/result.json"), 404);
}

// A tape is compared with what the camera measured alone.
TEST(FactsOfARecordedVisit, AreNotTaken) {
  const test::TestFolder folder;
  LivePageSettings settings;
  settings.visit.ask_facts = true;
  settings.desk.emplace();
  settings.desk->root = folder.path("sessions");
  test::ShownPage shown(settings);
  shown.page().use_source({}, {});
  const auto begun = shown.post_operator("/operator/begin", {{"language", "en"}, {"version", "1"}});
  ASSERT_EQ(begun.first, 200) << begun.second;
  std::string visit;
  for (const auto& event : shown.events("beat")) {
    if (event["event"] != "visit") continue;
    visit = event["id"];
    EXPECT_EQ(event["state"], "MEASURING") << "the form is left out";
    EXPECT_EQ(event["recorded"], true);
  }
  EXPECT_EQ(shown.post_facts(visit, R"({"weight_kg": 72})"), 409);
  EXPECT_EQ(shown.page().reported(1).count, 0U);
}

// Without the run that measured the person there is no one to correct the answer.
TEST_F(FactsOfVisit, CannotBeCorrectedAfterTheRun) {
  const std::string visit = shown_.visit();
  ASSERT_EQ(shown_.post("/consent", visit), 200);
  ASSERT_EQ(send("{}", visit), 202);
  measure(false);
  EXPECT_EQ(send(R"({"age": 35})", visit), 202);
  shown_.page().publish({{"event", "end"}});
  EXPECT_EQ(send(R"({"age": 36})", visit), 409);
  EXPECT_FLOAT_EQ(shown_.page().reported(1).facts.age_years.value, 35.5F);
}

}  // namespace
}  // namespace im2fit::apps
