// SPDX-License-Identifier: Apache-2.0
// Whose result the page has, and for how long: seen over HTTP by as many clients as it takes.
#include "apps/kiosk/live_page.h"

#include <gmock/gmock.h>

#include <thread>

#include "apps/kiosk/small_picture.h"
#include "shown_page.h"

namespace im2fit::apps {
namespace {

using std::chrono::milliseconds;
constexpr int kClients = 9;
const std::string kFirst = "911.25", kSecond = "1022.75";  // chest girths that stand nowhere else

// A client that follows the stream until the test lets it go.
class Follower {
 public:
  explicit Follower(const test::ShownPage& page)
      : thread_([this, client = std::make_shared<httplib::Client>(page.client())] {
          const auto answer = client->Get("/events", [&](const char* data, std::size_t size) {
            const std::lock_guard lock(mutex_);
            text_.append(data, size);
            return !leaving_;
          });
          const std::lock_guard lock(mutex_);
          if (answer) status_ = answer->status;
        }) {}
  ~Follower() {
    leave();
    thread_.join();
  }
  void leave() {  // with the next beat
    const std::lock_guard lock(mutex_);
    leaving_ = true;
  }
  bool hears(const std::string& what) {
    for (int i = 0; i < 400; ++i) {
      {
        const std::lock_guard lock(mutex_);
        if (text_.find(what) != std::string::npos) return true;
        if (status_ == 503) return false;
      }
      std::this_thread::sleep_for(milliseconds(10));
    }
    return false;
  }
  std::string text() {
    const std::lock_guard lock(mutex_);
    return text_;
  }
  int status() {
    const std::lock_guard lock(mutex_);
    return status_;
  }

 private:
  std::mutex mutex_;
  std::string text_;
  int status_ = 0;
  bool leaving_ = false;
  std::thread thread_;
};

int with_files(const test::ShownPage& page) {
  int found = 0;
  for (int i = 0; i < kClients; ++i)
    for (const char* path : {"/result.json", "/avatar.glb", "/picture.png"}) found += page.status_of(path) != 404;
  return found;
}

// A stream that its client left is noticed a little later.
bool unwatched(test::ShownPage& page) {
  for (int i = 0; i < 400 && page.page().watchers() > 0; ++i) std::this_thread::sleep_for(milliseconds(10));
  return page.page().watchers() == 0;
}

TEST(LivePage, TakesNothingFromTheCameraBeforeConsent) {
  test::ShownPage shown;
  EXPECT_EQ(shown.page().permit(), 0U);
  shown.state("TRACKING", {});
  shown.measured(911.25);
  EXPECT_EQ(shown.status_of("/result.json"), 404);
  for (const auto& event : shown.events("beat"))
    EXPECT_THAT(event["event"], testing::AnyOf("hello", "visit", "beat"));
  const std::string visit = shown.visit();
  EXPECT_EQ(shown.post("/consent", visit, "en-1"), 200);
  EXPECT_EQ(shown.page().permit(), 1U);
  shown.measured(911.25);
  EXPECT_EQ(shown.status_of("/result.json"), 200);
}

TEST(LivePage, ConsentSaysToWhichText) {
  LivePageSettings settings;
  std::string told;
  settings.consented = [&](std::uint64_t visit, const std::string& text) {
    told = std::to_string(visit) + " " + text;
  };
  test::ShownPage shown(settings);
  EXPECT_EQ(shown.post("/consent", shown.visit(), "fr-1"), 200);
  EXPECT_EQ(told, "1 fr-1");
}

// Nine clients: eight streams and one that there is no room for. None has anything of the first person after
// "Delete", none gets the second person's from a page that shows the first.
TEST(LivePage, ADeletedResultIsGoneForNineClients) {
  test::ShownPage shown;
  ASSERT_EQ(shown.post("/consent", shown.visit()), 200);
  shown.measured(std::stod(kFirst));
  const std::string first = shown.visit();
  ASSERT_TRUE(unwatched(shown));
  std::vector<std::unique_ptr<Follower>> followers;
  for (int i = 0; i < kClients; ++i) followers.push_back(std::make_unique<Follower>(shown));
  int refused = 0;
  for (auto& follower : followers) {
    const bool heard = follower->hears(kFirst);
    refused += follower->status() == 503;
    EXPECT_TRUE(heard || follower->status() == 503);
  }
  EXPECT_EQ(refused, kClients - PageServer::kWatchersMax);
  EXPECT_EQ(with_files(shown), kClients) << "the result; there is no avatar and no picture";

  EXPECT_EQ(shown.post("/delete", first), 200);
  EXPECT_EQ(with_files(shown), 0);
  for (auto& follower : followers) EXPECT_TRUE(follower->status() == 503 || follower->hears(R"("state":"ASKING")"));
  for (auto& follower : followers) follower->leave();
  followers.clear();
  ASSERT_TRUE(unwatched(shown));
  const auto late = shown.events("beat");
  for (const auto& event : late) EXPECT_EQ(event.dump().find(kFirst), std::string::npos) << event;

  // The visit that is over cannot be consented to, touched or deleted again; the next one is not its.
  for (const char* path : {"/consent", "/touch", "/delete"}) EXPECT_EQ(shown.post(path, first), 409) << path;
  EXPECT_EQ(shown.page().permit(), 0U);
  ASSERT_EQ(shown.post("/consent", shown.visit()), 200);
  shown.measured(std::stod(kSecond));
  EXPECT_EQ(shown.post("/delete", first), 409);
  const std::string result = shown.client().Get("/result.json")->body;
  EXPECT_NE(result.find(kSecond), std::string::npos);
  EXPECT_EQ(result.find(kFirst), std::string::npos);
}

TEST(LivePage, AResultGoesByItselfAndATouchPutsItOff) {
  LivePageSettings settings;
  settings.visit.result_max = milliseconds(800);
  test::ShownPage shown(settings);
  const auto start = std::chrono::steady_clock::now();
  ASSERT_EQ(shown.post("/consent", shown.visit()), 200);
  shown.measured(911.25);
  const std::string visit = shown.visit();
  for (int i = 0; i < 8; ++i) {
    std::this_thread::sleep_for(milliseconds(150));
    EXPECT_EQ(shown.post("/touch", visit), 200);
  }
  EXPECT_EQ(shown.status_of("/result.json"), 200);
  for (int i = 0; i < 300 && shown.status_of("/result.json") == 200; ++i)
    std::this_thread::sleep_for(milliseconds(20));
  const auto took = std::chrono::steady_clock::now() - start;
  EXPECT_EQ(with_files(shown), 0);
  EXPECT_GE(took, milliseconds(2000));
  EXPECT_EQ(shown.post("/touch", visit), 409);
}

TEST(LivePage, AnotherRunHasAnotherBootAndNothingOfTheOneBefore) {
  test::ShownPage shown;
  ASSERT_EQ(shown.post("/consent", shown.visit()), 200);
  shown.measured(911.25);
  const std::string boot = shown.events("hello").front()["boot"];
  const int port = shown.port();
  shown.end();
  const test::ShownPage again({}, port);
  EXPECT_EQ(with_files(again), 0);
  EXPECT_NE(again.events("hello").front()["boot"], boot);
}

// Computing a body takes seconds: a result deleted meanwhile must not come back.
TEST(LivePage, AResultThatComesAfterItsVisitIsNotShown) {
  LivePageSettings settings;
  std::string erased;
  settings.erase_folder = [&](const std::string& folder) { erased = folder; };
  test::ShownPage shown(settings);
  ASSERT_EQ(shown.post("/consent", shown.visit()), 200);
  shown.begin_person();
  ASSERT_EQ(shown.post("/delete", shown.visit()), 200);
  ASSERT_EQ(shown.post("/consent", shown.visit()), 200);
  shown.page().publish(
      {{"event", "measured"}, {"person", 1}, {"out", "folder"}, {"result", {{"of", "the one before"}}}});
  EXPECT_EQ(erased, "folder");
  EXPECT_EQ(with_files(shown), 0);
  EXPECT_EQ(shown.page().permit(), 2U);
}

TEST(LivePage, WithoutConsentTheNextPersonEndsTheVisitBefore) {
  LivePageSettings settings;
  settings.visit.ask = false;
  test::ShownPage shown(settings);
  shown.measured(std::stod(kFirst));
  shown.page().publish({{"event", "left"}, {"frame", 2}, {"person", 1}});
  shown.state("SEARCHING", {"NO_PERSON"});
  EXPECT_EQ(shown.status_of("/result.json"), 200) << "it stays for who walks up to the screen";
  shown.state("TRACKING", {});
  EXPECT_EQ(with_files(shown), 0) << "while the next is measured";
  shown.measured(std::stod(kSecond));
  EXPECT_NE(shown.client().Get("/result.json")->body.find(kSecond), std::string::npos);
}

TEST(LivePage, DeleteTakesTheFolderAlongAndTimeDoesNot) {
  LivePageSettings settings;
  settings.visit.result_max = milliseconds(300);
  std::vector<std::string> erased;
  settings.erase_folder = [&](const std::string& folder) { erased.push_back(folder); };
  test::ShownPage shown(settings);
  shown.post("/consent", shown.visit());
  shown.measured(900, "out/person-001");
  EXPECT_EQ(shown.post("/delete", shown.visit()), 200);
  shown.post("/consent", shown.visit());
  shown.measured(900, "out/person-002");
  for (int i = 0; i < 300 && shown.status_of("/result.json") == 200; ++i)
    std::this_thread::sleep_for(milliseconds(20));
  EXPECT_EQ(shown.status_of("/result.json"), 404);
  EXPECT_THAT(erased, testing::ElementsAre("out/person-001"));
}

// What a page of another site, or a form, could send.
TEST(LivePage, OnlyThePageItselfCanAct) {
  test::ShownPage shown;
  const std::string visit = shown.visit(), own = shown.url();
  const auto post = [&](const httplib::Headers& headers, const std::string& body = "") {
    const auto answer = shown.client().Post("/consent", headers, body, "text/plain");
    return answer ? answer->status : 0;
  };
  EXPECT_EQ(post({{"X-Im2fit-Visit", visit}}), 403) << "no Origin";
  EXPECT_EQ(post({{"Origin", "http://evil.example"}, {"X-Im2fit-Visit", visit}}), 403);
  EXPECT_EQ(post({{"Origin", "null"}, {"X-Im2fit-Visit", visit}}), 403);
  EXPECT_EQ(post({{"Origin", own}, {"Origin", own}, {"X-Im2fit-Visit", visit}}), 403);
  EXPECT_EQ(post({{"Origin", own}}), 403) << "no visit: a form cannot send one";
  EXPECT_EQ(post({{"Origin", own}, {"X-Im2fit-Visit", visit}, {"Sec-Fetch-Site", "cross-site"}}), 403);
  EXPECT_EQ(post({{"Origin", own}, {"X-Im2fit-Visit", std::string(65, 'a')}}), 400);
  EXPECT_EQ(post({{"Origin", own}, {"X-Im2fit-Visit", "0"}}), 409);
  EXPECT_NE(post({{"Origin", own}, {"X-Im2fit-Visit", visit}}, "a body"), 200);
  EXPECT_EQ(shown.status_of("/consent"), 405);
  EXPECT_EQ(shown.client().Post("/result.json", "", "text/plain")->status, 405);
  EXPECT_EQ(shown.page().permit(), 0U) << "nothing of that was consent";
}

// By construction: as many bytes as pixels, whatever the camera sees.
TEST(SmallPicture, IsSmallForNoiseToo) {
  std::vector<std::uint16_t> noise(640UL * 480UL);
  std::uint32_t state = 7;
  for (auto& pixel : noise) {
    state = state * 1664525U + 1013904223U;  // Numerical Recipes' generator
    pixel = static_cast<std::uint16_t>(state >> 20U);
  }
  for (const auto& [width, height] : {std::pair{480, 640}, std::pair{640, 480}}) {
    const auto png = small_picture({noise.data(), width, height}, {});
    ASSERT_TRUE(png) << png.error().message;
    EXPECT_EQ(png->substr(1, 3), "PNG");
    EXPECT_LE(png->size(), 20'000U);
  }
  EXPECT_FALSE(small_picture({}, {}));
}

}  // namespace
}  // namespace im2fit::apps
