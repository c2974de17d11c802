// SPDX-License-Identifier: Apache-2.0
// `im2fit serve --ask-facts` over a recording of two people: facts before the pose, corrected while the person is in
// view and after they have left it, and gone with the visit.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>

#include <csignal>
#include <filesystem>
#include <functional>
#include <memory>
#include <regex>
#include <thread>

#include "background_run.h"
#include "two_people.h"

namespace im2fit {
namespace {

using Json = nlohmann::json;
using testing::HasSubstr;

class KnownPerson : public testing::Test {
 protected:
  void SetUp() override {
    if (!test::have_data()) GTEST_SKIP() << "no body, tracker or index file";
    test::write_two_people(folder_.path("two"), 75);
    const std::vector<std::string> command = {IM2FIT_PROGRAM,
                                              "serve",
                                              folder_.path("two"),
                                              "--frames",
                                              "5",
                                              "--body",
                                              test::body_path(),
                                              "--tracker",
                                              test::tracker_path(),
                                              "--index",
                                              test::index_path(),
                                              "--out",
                                              folder_.path("out"),
                                              "--ask-facts",
                                              "--port",
                                              "0"};
    run_ = std::make_unique<test::BackgroundRun>(command, std::vector<std::pair<std::string, std::string>>{},
                                                 folder_.path("stderr"));
    const std::regex address("open (http://[^/]+)/");
    std::smatch found;
    for (const auto end = test::Clock::now() + test::kPatience; test::Clock::now() < end && url_.empty();) {
      const std::string printed = run_->messages();
      if (std::regex_search(printed, found, address)) url_ = found[1];
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    ASSERT_FALSE(url_.empty()) << run_->messages();
  }
  httplib::Client client() const {
    httplib::Client c(url_);
    c.set_read_timeout(40);
    return c;
  }
  // The first event that this holds of.
  Json event_with(const std::function<bool(const Json&)>& holds) const {
    std::string text;
    Json found;
    const auto end = test::Clock::now() + test::kPatience;
    client().Get("/events", [&](const char* data, std::size_t size) {
      text.append(data, size);
      for (std::size_t at = text.find("data: "); at != std::string::npos && found.is_null();) {
        const std::size_t line_end = text.find('\n', at);
        if (line_end == std::string::npos) break;
        const Json event = Json::parse(text.substr(at + 6, line_end - at - 6), nullptr, false);
        if (holds(event)) found = event;
        text.erase(0, line_end);
        at = text.find("data: ");
      }
      return found.is_null() && test::Clock::now() < end;
    });
    return found;
  }
  std::string visit(const std::string& state) const {
    return event_with([&](const Json& e) { return e["event"] == "visit" && e["state"] == state; })["id"];
  }
  // A result whose known weight is this.
  Json measured_with(double weight_kg) const {
    const Json event = event_with([&](const Json& e) {
      return e["event"] == "measured" && e["result"].contains("known") &&
             std::abs(e["result"]["known"]["given"]["weight"]["value"].get<double>() - weight_kg) < 0.01;
    });
    EXPECT_FALSE(event.is_null()) << weight_kg << " kg: " << run_->messages();
    return event;
  }
  int post(const std::string& path, const std::string& visit, const std::string& body = "") const {
    return client()
        .Post(path, httplib::Headers{{"Origin", url_}, {"X-Im2fit-Visit", visit}}, body,
              body.empty() ? "" : "application/json")
        ->status;
  }
  static double width_of(const Json& measurement) {
    return measurement["interval"][1].get<double>() - measurement["interval"][0].get<double>();
  }

  const test::TestFolder folder_;
  std::unique_ptr<test::BackgroundRun> run_;
  std::string url_;
};

TEST_F(KnownPerson, IsMeasuredWithThemCorrectedAndForgotten) {
  const std::string first = visit("ASKING");
  ASSERT_EQ(post("/consent", first), 200);
  ASSERT_EQ(visit("FACTS"), first);
  ASSERT_EQ(post("/facts", first, R"({"weight_kg": 211.5, "weight_from": "scale"})"), 202);
  const Json doubted = measured_with(211.5);
  ASSERT_FALSE(doubted.is_null());
  EXPECT_FALSE(doubted.contains("corrected"));
  const Json& before = doubted["result"]["known"];
  EXPECT_EQ(before["doubted"], Json::parse(R"(["weight"])"));
  EXPECT_EQ(before["used"], Json::array());
  const double weight_kg = std::round(before["without"]["weight"]["value"].get<double>()) + 1;

  // Without a new frame of them.
  ASSERT_EQ(post("/facts", first, Json{{"weight_kg", weight_kg}, {"weight_from", "scale"}}.dump()), 202);
  const Json corrected = measured_with(weight_kg);
  ASSERT_FALSE(corrected.is_null());
  EXPECT_EQ(corrected["corrected"], true);
  EXPECT_EQ(corrected["person"], doubted["person"]);
  const Json& after = corrected["result"]["known"];
  EXPECT_EQ(after["used"], Json::parse(R"(["weight"])"));
  EXPECT_EQ(after["doubted"], Json::array());
  EXPECT_EQ(after["without"], before["without"]) << "from the same frames";
  EXPECT_EQ(corrected["result"]["frames"], doubted["result"]["frames"]);
  EXPECT_EQ(corrected["result"]["joints"], doubted["result"]["joints"]);
  const Json& weight = corrected["result"]["measurements"]["weight"];
  EXPECT_LT(width_of(weight), width_of(after["without"]["weight"]));
  EXPECT_LT(std::abs(weight["value"].get<double>() - weight_kg),
            std::abs(after["without"]["weight"]["value"].get<double>() - weight_kg));
  // The page, the files and the event are one.
  const std::string out = corrected["out"];
  EXPECT_EQ(Json::parse(client().Get("/result.json")->body), corrected["result"]);
  EXPECT_EQ(Json::parse(test::read_text(out + "/result.json")), corrected["result"]);
  EXPECT_EQ(client().Get("/avatar.glb")->body, test::read_text(out + "/avatar.glb"));
  EXPECT_FALSE(std::filesystem::exists(out + "/overlay.png")) << "it shows the values of before";

  // At the screen, out of the picture.
  ASSERT_FALSE(event_with([](const Json& e) { return e["event"] == "left"; }).is_null());
  ASSERT_EQ(post("/facts", first, Json{{"weight_kg", weight_kg + 1}}.dump()), 202);
  const Json again = measured_with(weight_kg + 1);
  ASSERT_FALSE(again.is_null());
  EXPECT_EQ(again["result"]["known"]["without"], before["without"]);
  EXPECT_EQ(again["result"]["known"]["given"]["weight"]["sd"], 3);

  ASSERT_EQ(post("/delete", first), 200);
  EXPECT_EQ(client().Get("/result.json")->status, 404);
  EXPECT_FALSE(std::filesystem::exists(out));
  EXPECT_EQ(post("/facts", first, "{}"), 409);
  // The next person has reported nothing.
  const std::string second = visit("ASKING");
  ASSERT_EQ(post("/consent", second), 200);
  ASSERT_EQ(post("/facts", second, "{}"), 202);
  const Json next = event_with([](const Json& e) { return e["event"] == "measured"; });
  EXPECT_EQ(next["person"], 2);
  EXPECT_FALSE(next["result"].contains("known"));
  for (const char* word : {"211.5", "weight", " kg"})
    EXPECT_EQ(run_->messages().find(word), std::string::npos) << run_->messages();
  run_->signal(SIGINT);
  EXPECT_EQ(run_->wait(), 0) << run_->messages();
}

TEST(KnownPersonWords, TheFormNeedsConsentAndConsentTheForm) {
  for (const auto& [words, named] :
       {std::pair<std::vector<std::string>, const char*>{{"--ask-facts", "--no-consent"}, "--no-consent"},
        {{"--weight-kg", "70"}, "--ask-facts"}}) {
    std::vector<std::string> command = {IM2FIT_PROGRAM, "serve", "synthetic:1"};
    command.insert(command.end(), words.begin(), words.end());
    const test::Run run = test::run_program(command);
    EXPECT_NE(run.exit_code, 0);
    EXPECT_TRUE(test::is_one_line_of(run.err, "im2fit")) << run.err;
    EXPECT_THAT(run.err, HasSubstr(named));
  }
}

}  // namespace
}  // namespace im2fit
