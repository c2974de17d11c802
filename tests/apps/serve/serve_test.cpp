// SPDX-License-Identifier: Apache-2.0
// `im2fit serve` over a recording of two people, queried as a browser does, and by a browser.
#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>

#include <csignal>
#include <memory>
#include <optional>
#include <regex>
#include <sstream>

#include "background_run.h"
#include "browser.h"
#include "private_files.h"
#include "two_people.h"

namespace im2fit {
namespace {

using testing::HasSubstr;

// Each stands there for long enough (at 30 Hz) that a slow start misses no person.
constexpr int kFramesOfEach = 75;

class Serve : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (!test::have_data()) return;
    folder_ = new test::TestFolder;
    test::write_two_people(folder_->path("two"), kFramesOfEach);
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }
  void SetUp() override {
    if (folder_ == nullptr) GTEST_SKIP() << "no body, tracker or index file";
  }
  void serve() {
    const test::UsualUmask umask;
    run_ = std::make_unique<test::BackgroundRun>(
        std::vector<std::string>{IM2FIT_PROGRAM, "serve", folder_->path("two"), "--port", "0", "--frames", "5",
                                 "--body", test::body_path(), "--tracker", test::tracker_path(), "--index",
                                 test::index_path(), "--out", folder_->path("out")},
        std::vector<std::pair<std::string, std::string>>{}, folder_->path("stderr"));
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
  // Every event until the recording is over.
  std::vector<nlohmann::json> events() const {
    std::string text;
    client().Get("/events", [&](const char* data, std::size_t size) {
      text.append(data, size);
      return text.find("\"event\":\"end\"") == std::string::npos;
    });
    std::vector<nlohmann::json> all;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
      if (line.rfind("data: ", 0) != 0) continue;
      EXPECT_TRUE(nlohmann::json::accept(line.substr(6))) << line;
      all.push_back(nlohmann::json::parse(line.substr(6), nullptr, false));
    }
    return all;
  }
  static inline test::TestFolder* folder_ = nullptr;
  std::unique_ptr<test::BackgroundRun> run_;
  std::string url_;
};

TEST_F(Serve, ShowsOnePersonAfterTheOtherAndTheirBodies) {
  ASSERT_NO_FATAL_FAILURE(serve());
  std::vector<std::string> story;
  std::optional<nlohmann::json> hello, last_result;
  int frames = 0, followed = 0;
  for (const auto& event : events()) {
    const std::string kind = event["event"];
    if (kind == "hello") hello = event;
    if (kind == "frame") {
      ++frames;
      if (!event.contains("rotations")) continue;
      ++followed;
      EXPECT_EQ(event["rotations"].size(), hello->at("segments").size());
      EXPECT_EQ(event["joints"].size(), 15U);
    }
    if (kind == "measured") last_result = event["result"];
    if (kind == "measured" || kind == "left" || kind == "end") story.push_back(kind);
  }
  EXPECT_EQ(story, (std::vector<std::string>{"measured", "left", "measured", "end"}));
  EXPECT_GT(frames, 20);
  EXPECT_GT(followed, 2);
  // What is served is what was written.
  const std::string second = folder_->path("out") + "/person-002";
  EXPECT_EQ(client().Get("/avatar.glb")->body, test::read_text(second + "/avatar.glb"));
  EXPECT_EQ(nlohmann::json::parse(client().Get("/result.json")->body),
            nlohmann::json::parse(test::read_text(second + "/result.json")));
  EXPECT_EQ(*last_result, nlohmann::json::parse(test::read_text(second + "/result.json")));
  const auto picture = client().Get("/picture.png");
  ASSERT_EQ(picture->status, 200);
  test::write_text(folder_->path("picture.png"), picture->body);
  EXPECT_TRUE(test::is_whole_png(folder_->path("picture.png")));
  EXPECT_THAT(test::all_files_in(folder_->path("out")),
              testing::IsSupersetOf({"person-001/result.json", "person-002/result.json", "person-002/avatar.glb"}));
  EXPECT_THAT(test::readable_by_others(folder_->path("out")), testing::IsEmpty());

  run_->signal(SIGTERM);
  EXPECT_EQ(run_->wait(), 0) << run_->messages();
}

// Words, the table, and the body on the stage, in Chromium.
TEST_F(Serve, ABrowserShowsIt) {
  if (!test::Browser::installed()) GTEST_SKIP() << "no chromium: scripts/deps browser";
  test::Browser browser(folder_->path(""));
  ASSERT_TRUE(browser.ready()) << browser.messages();
  ASSERT_NO_FATAL_FAILURE(serve());
  browser.go(url_ + "/");
  ASSERT_TRUE(browser.wait_for("return document.body.dataset.avatar === '2'")) << browser.run(
      "return [failures, {...document.body.dataset}, document.getElementById('stage-caption').textContent]");
  ASSERT_TRUE(browser.wait_for("return document.getElementById('wish').textContent === 'The recording is over'"));
  EXPECT_EQ(browser.run("return document.getElementById('who').textContent"), "Person 2");
  EXPECT_TRUE(browser.wait_for("return document.getElementById('picture').naturalHeight === 480"))
      << browser.run("return document.getElementById('picture').src");

  const auto result = nlohmann::json::parse(client().Get("/result.json")->body);
  const auto& measurements = result["measurements"];
  EXPECT_EQ(browser.run("return document.querySelectorAll('tbody tr').length"), measurements.size());
  const double chest_mm = measurements["chest_girth"]["value"];
  const std::string chest_shown =
      "return [...document.querySelectorAll('tbody tr')].find(r => r.cells[0].textContent === 'chest')"
      ".cells[1].textContent";
  EXPECT_EQ(browser.run(chest_shown), fmt::format("{:.1f}", chest_mm / 10));
  browser.run("document.getElementById('unit').click()");
  EXPECT_EQ(browser.run(chest_shown), fmt::format("{:.1f}", chest_mm / 25.4));
  EXPECT_EQ(browser.run("return document.getElementById('size').firstChild.textContent"), result["size"]["best"]);

  // The body is drawn: in what the stage shows there are many pixels of cloth and of skin, and none without it.
  const std::string drawn =
      "stage.draw();"
      "const gl = stage.renderer.getContext(), w = gl.drawingBufferWidth, h = gl.drawingBufferHeight;"
      "const p = new Uint8Array(4 * w * h); gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, p);"
      "let skin = 0, cloth = 0;"
      "for (let i = 0; i < p.length; i += 4) if (p[i + 3] === 255) {"
      "  if (p[i] > p[i + 2] + 20) ++skin; else if (p[i + 2] > p[i] + 20) ++cloth; }"
      "return [skin / (w * h), cloth / (w * h)];";
  const auto with = browser.run(drawn);
  EXPECT_GT(with[0], 0.005);
  EXPECT_GT(with[1], 0.03);
  browser.run("stage.removeAvatar(); stage.setJoints(null)");
  const auto without = browser.run(drawn);
  EXPECT_LT(without[0], 0.001);
  EXPECT_LT(without[1], 0.001);
  // Nothing went wrong that only a console hears of.
  EXPECT_EQ(browser.run("return failures"), nlohmann::json::array());

  // The program ends, and the page says so.
  run_->signal(SIGINT);
  EXPECT_EQ(run_->wait(), 0) << run_->messages();
  EXPECT_TRUE(browser.wait_for("return document.getElementById('wish').textContent.startsWith('The program has')"));
}

TEST(ServeWords, AnAddressThatIsNotOursIsOneLine) {
  const test::Run run = test::run_program({IM2FIT_PROGRAM, "serve", "synthetic:1", "--host", "192.0.2.1"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_TRUE(test::is_one_line_of(run.err, "im2fit")) << run.err;
  EXPECT_THAT(run.err, HasSubstr("--host"));
}

}  // namespace
}  // namespace im2fit
