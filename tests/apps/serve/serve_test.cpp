// SPDX-License-Identifier: Apache-2.0
// `im2fit serve` over a recording of two people, queried as a browser does, and by a browser.
#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <filesystem>
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
  void serve(const std::vector<std::string>& more = {"--no-consent"}) {
    const test::UsualUmask umask;
    url_.clear();
    std::vector<std::string> command = {
        IM2FIT_PROGRAM,     "serve",           folder_->path("two"), "--frames",           "5",
        "--body",           test::body_path(), "--tracker",          test::tracker_path(), "--index",
        test::index_path(), "--out",           folder_->path("out")};
    if (std::find(more.begin(), more.end(), "--port") == more.end()) command.insert(command.end(), {"--port", "0"});
    command.insert(command.end(), more.begin(), more.end());
    run_ = std::make_unique<test::BackgroundRun>(command, std::vector<std::pair<std::string, std::string>>{},
                                                 folder_->path("stderr"));
    find_address();
  }
  void find_address() {
    url_.clear();
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
  // Every event until the recording is over. `bytes`: of the page's traffic meanwhile, pictures and headers included.
  std::vector<nlohmann::json> events(std::size_t* bytes = nullptr) const {
    std::string text;
    httplib::Client pictures = client();
    pictures.set_keep_alive(true);
    const auto count_picture = [&] {
      const auto answer = pictures.Get("/picture.png");
      *bytes += answer->body.size();
      for (const auto& [name, value] : answer->headers) *bytes += name.size() + value.size() + 4;
    };
    client().Get("/events", [&](const char* data, std::size_t size) {
      text.append(data, size);
      if (bytes != nullptr && std::string(data, size).find("\"event\":\"picture\"") != std::string::npos)
        count_picture();
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
  // The page's trouble code once it is `wanted`; at the end of patience, the last one sent.
  std::string trouble_until(const std::string& wanted) const {
    std::string text, last = "nothing said";
    const auto end = test::Clock::now() + test::kPatience;
    client().Get("/events", [&](const char* data, std::size_t size) {
      text.append(data, size);
      const std::string before = "{\"event\":\"trouble\",\"code\":\"";
      const std::size_t at = text.rfind(before);
      if (at != std::string::npos && text.find('\n', at) != std::string::npos)
        last = text.substr(at + before.size(), text.find('"', at + before.size()) - at - before.size());
      return last != wanted && test::Clock::now() < end;
    });
    return last;
  }
  static inline test::TestFolder* folder_ = nullptr;
  std::unique_ptr<test::BackgroundRun> run_;
  std::string url_;
};

TEST_F(Serve, ShowsOnePersonAfterTheOtherAndTheirBodies) {
  ASSERT_NO_FATAL_FAILURE(serve());
  std::vector<std::string> story;
  std::optional<nlohmann::json> hello, last_result;
  int frames = 0, followed = 0, pictures = 0;
  double frame_bytes = 0;
  std::size_t picture_bytes = 0;
  for (const auto& event : events(&picture_bytes)) {
    const std::string kind = event["event"];
    if (kind == "hello") hello = event;
    pictures += kind == "picture";
    if (kind == "frame") {
      ++frames;
      frame_bytes += static_cast<double>(event.dump().size()) + 8;  // "data: ", two line ends
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
  // At full speed, however slow this machine is: ten pictures and thirty frames a second.
  const double rate = 10.0 * static_cast<double>(picture_bytes) / pictures + 30.0 * frame_bytes / frames;
  std::printf("a client: %.0f kB/s (a picture %.0f bytes, a frame %.0f)\n", rate / 1e3,
              static_cast<double>(picture_bytes) / pictures, frame_bytes / frames);
  EXPECT_GT(pictures, 2);
  EXPECT_LT(rate, 300e3);
  // The served files equal the written ones.
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

// From consent to delete, over HTTP: the recording stands still until someone agrees.
TEST_F(Serve, MeasuresAfterConsentAndForgetsOnDelete) {
  ASSERT_NO_FATAL_FAILURE(serve({}));
  const auto event_of = [&](const std::string& kind, const std::string& holding = "") {
    std::string text, found;
    client().Get("/events", [&](const char* data, std::size_t size) {
      text.append(data, size);
      for (std::size_t at = text.find("data: "); at != std::string::npos; at = text.find("data: ", at + 1)) {
        const std::size_t end = text.find('\n', at);
        if (end == std::string::npos) break;
        const std::string line = text.substr(at + 6, end - at - 6);
        if (line.find("\"event\":\"" + kind + "\"") != std::string::npos && line.find(holding) != std::string::npos)
          found = line;
      }
      return found.empty();
    });
    return nlohmann::json::parse(found, nullptr, false);
  };
  const auto post = [&](const std::string& path, const std::string& visit) {
    return client().Post(path, httplib::Headers{{"Origin", url_}, {"X-Im2fit-Visit", visit}}, "", "")->status;
  };
  const std::string visit = event_of("visit")["id"];
  std::this_thread::sleep_for(std::chrono::seconds(1));
  for (const char* path : {"/result.json", "/avatar.glb", "/picture.png"})
    EXPECT_EQ(client().Get(path)->status, 404) << path;
  EXPECT_EQ(run_->messages().find("TRACKING"), std::string::npos);
  ASSERT_EQ(post("/consent", visit), 200);
  const auto measured = event_of("measured");
  EXPECT_EQ(measured["person"], 1);
  EXPECT_EQ(client().Get("/result.json")->status, 200);
  EXPECT_EQ(client().Get("/avatar.glb")->status, 200);
  const std::string folder = measured["out"];
  EXPECT_TRUE(std::filesystem::exists(folder + "/result.json"));
  EXPECT_EQ(run_->messages().find("stature"), std::string::npos) << "a journal would keep it";
  ASSERT_EQ(post("/delete", visit), 200);
  for (const char* path : {"/result.json", "/avatar.glb", "/picture.png"})
    EXPECT_EQ(client().Get(path)->status, 404) << path;
  EXPECT_FALSE(std::filesystem::exists(folder)) << "what was written goes too";
  // The recording goes on with the next consent only.
  const std::string next = event_of("visit", "ASKING")["id"];
  EXPECT_NE(next, visit);
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  EXPECT_EQ(event_of("beat").is_object(), true);
  ASSERT_EQ(post("/consent", next), 200);
  EXPECT_EQ(event_of("measured")["person"], 2);
  // Ctrl-C while a page is connected and frames come.
  std::thread follower([c = std::make_shared<httplib::Client>(client())] {
    c->Get("/events", [](const char*, std::size_t) { return true; });
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  const auto pressed = test::Clock::now();
  run_->signal(SIGINT);
  EXPECT_EQ(run_->wait(), 0) << run_->messages();
  const double took_ms = std::chrono::duration<double, std::milli>(test::Clock::now() - pressed).count();
  std::printf("ended %.0f ms after Ctrl-C\n", took_ms);
  EXPECT_LT(took_ms, 300);
  follower.join();
}

// Without a camera, then without models: the page reports it, and the trouble is over within three seconds.
TEST_F(Serve, WaitsForWhatIsMissing) {
  const std::string folder = folder_->path("late");
  const auto serve_late = [&] {
    run_ = std::make_unique<test::BackgroundRun>(
        std::vector<std::string>{IM2FIT_PROGRAM, "serve", folder, "--wait", "--port", "0", "--body",
                                 test::body_path(), "--tracker", test::tracker_path(), "--index",
                                 folder_->path("late.i2f")},
        std::vector<std::pair<std::string, std::string>>{}, folder_->path("stderr"));
  };
  serve_late();
  ASSERT_NO_FATAL_FAILURE(find_address());
  EXPECT_EQ(trouble_until("MODELS_MISSING"), "MODELS_MISSING");
  std::filesystem::copy_file(test::index_path(), folder_->path("late.i2f"));
  EXPECT_EQ(trouble_until("NO_CAMERA"), "NO_CAMERA");
  const auto plugged = test::Clock::now();
  std::filesystem::create_directory_symlink(folder_->path("two"), folder);
  EXPECT_EQ(trouble_until(""), "");
  EXPECT_LT(test::Clock::now() - plugged, std::chrono::seconds(3));
  run_->signal(SIGINT);
  EXPECT_EQ(run_->wait(), 0) << "a page that has measured no one has not failed: " << run_->messages();
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
  ASSERT_TRUE(browser.wait_for("return over"));
  EXPECT_EQ(browser.run("return document.body.dataset.stage"), "result");

  const auto result = nlohmann::json::parse(client().Get("/result.json")->body);
  const auto& measurements = result["measurements"];
  EXPECT_EQ(browser.run("return document.querySelectorAll('tbody tr').length"), measurements.size());
  const double chest_mm = measurements["chest_girth"]["value"];
  const std::string chest_shown = "return document.querySelector('tr[data-id=chest_girth]').cells[1].textContent";
  browser.run("words.inches = false; showResult()");  // whatever this machine's region says
  EXPECT_EQ(browser.run(chest_shown), fmt::format("{:.1f}", chest_mm / 10));
  browser.run("document.getElementById('unit').click()");
  EXPECT_EQ(browser.run(chest_shown), fmt::format("{:.1f}", chest_mm / 25.4));
  EXPECT_EQ(browser.run("return document.getElementById('size').firstChild.textContent"), result["size"]["best"]);

  // The body is drawn: the stage shows many pixels of cloth and of skin with it, and none without it.
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
  browser.run("stage.removeAvatar()");
  const auto without = browser.run(drawn);
  EXPECT_LT(without[0], 0.001);
  EXPECT_LT(without[1], 0.001);
  // Nothing went wrong that only a console hears of.
  EXPECT_EQ(browser.run("return failures"), nlohmann::json::array());

  // The program ends, and the page reports it.
  run_->signal(SIGINT);
  EXPECT_EQ(run_->wait(), 0) << run_->messages();
  EXPECT_TRUE(browser.wait_for("return document.body.dataset.code === 'SERVER_GONE'"));
  EXPECT_EQ(browser.run("return document.querySelectorAll('tbody tr').length"), 0) << "a result without its program";
}

TEST(ServeWords, AnAddressThatIsNotOursIsOneLine) {
  const test::Run run = test::run_program({IM2FIT_PROGRAM, "serve", "synthetic:1", "--host", "192.0.2.1"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_TRUE(test::is_one_line_of(run.err, "im2fit")) << run.err;
  EXPECT_THAT(run.err, HasSubstr("--host"));
}

}  // namespace
}  // namespace im2fit
