// SPDX-License-Identifier: Apache-2.0
// Chromium, driven over HTTP by ChromeDriver (W3C WebDriver). Every wait is bounded.
#pragma once

#include <gtest/gtest.h>
#include <httplib.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>
#include <string_view>
#include <vector>

#include "background_run.h"

namespace im2fit::test {

class Browser {
 public:
  static constexpr const char* kBrowser = "/usr/bin/chromium";
  static constexpr const char* kDriver = "/usr/bin/chromedriver";
  static bool installed() { return std::filesystem::exists(kBrowser) && std::filesystem::exists(kDriver); }

  // `folder` holds its profile and the driver's output; `more` goes on its command line.
  explicit Browser(const std::string& folder, const std::vector<std::string>& more = {})
      : driver_({kDriver, "--port=0"}, {}, folder + "/chromedriver.log"), profile_(folder + "/profile") {
    const std::regex started("started successfully on port ([0-9]+)");
    std::smatch found;
    for (const auto end = Clock::now() + kPatience; Clock::now() < end && client_ == nullptr;) {
      const std::string printed = driver_.messages();
      if (std::regex_search(printed, found, started))
        client_ = std::make_unique<httplib::Client>("127.0.0.1", std::stoi(found[1]));
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    if (client_ == nullptr) return;
    client_->set_read_timeout(60);
    nlohmann::json words = {"--headless=new",
                            "--no-sandbox",
                            "--disable-gpu",
                            "--use-gl=angle",
                            "--use-angle=swiftshader",
                            "--enable-unsafe-swiftshader",
                            "--disable-quic",
                            "--no-first-run",
                            "--disable-background-networking",
                            "--disable-component-update",
                            "--disable-sync",
                            "--window-size=1280,900",
                            "--user-data-dir=" + profile_};
    for (const std::string& word : more) words.push_back(word);
    const auto session =
        ask("/session",
            {{"capabilities",
              {{"alwaysMatch",
                {{"browserName", "chrome"}, {"goog:chromeOptions", {{"binary", kBrowser}, {"args", words}}}}}}}});
    if (session.is_object()) session_ = "/session/" + session["sessionId"].get<std::string>();
  }
  ~Browser() {
    if (!session_.empty()) client_->Delete(session_);
  }
  Browser(const Browser&) = delete;
  Browser& operator=(const Browser&) = delete;
  bool ready() const { return !session_.empty(); }
  std::string messages() const { return driver_.messages(); }

  void go(const std::string& url) { ask(session_ + "/url", {{"url", url}}); }
  // What `return ...;` gives.
  nlohmann::json run(const std::string& script) {
    return ask(session_ + "/execute/sync", {{"script", script}, {"args", nlohmann::json::array()}});
  }
  // What its last argument, a function, is called with.
  nlohmann::json run_until_called(const std::string& script) {
    return ask(session_ + "/execute/async", {{"script", script}, {"args", nlohmann::json::array()}});
  }
  // A command of the Chrome DevTools Protocol.
  void devtools(const std::string& command, const nlohmann::json& parameters) {
    ask(session_ + "/goog/cdp/execute", {{"cmd", command}, {"params", parameters}});
  }
  void resize(int width, int height) {
    devtools("Emulation.setDeviceMetricsOverride",
             {{"width", width}, {"height", height}, {"deviceScaleFactor", 1}, {"mobile", false}});
  }
  // A PNG of the window's contents.
  std::string screenshot() { return from_base64(get(session_ + "/screenshot")); }
  // Tabs are identified by the return values of these functions.
  std::string tab() { return get(session_ + "/window"); }
  std::string open_tab() { return ask(session_ + "/window/new", {{"type", "tab"}})["handle"]; }
  void show_tab(const std::string& tab) { ask(session_ + "/window", {{"handle", tab}}); }
  // Until the script says true.
  bool wait_for(const std::string& script) {
    for (const auto end = Clock::now() + kPatience; Clock::now() < end && !lost_;) {
      if (run(script) == true) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return false;
  }

 private:
  static std::string from_base64(const std::string& text) {  // RFC 4648
    constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    std::uint32_t bits = 0;
    int count = 0;
    for (const char c : text) {
      const std::size_t digit = kDigits.find(c);
      if (digit == std::string_view::npos) break;
      bits = bits << 6U | static_cast<std::uint32_t>(digit);
      count += 6;
      if (count < 8) continue;
      count -= 8;
      out += static_cast<char>(bits >> static_cast<unsigned>(count) & 255U);
    }
    return out;
  }
  nlohmann::json get(const std::string& path) {
    if (lost_) return nullptr;
    const auto answer = client_->Get(path);
    lost_ = !answer;
    EXPECT_TRUE(answer && answer->status == 200) << path;
    return answer ? nlohmann::json::parse(answer->body, nullptr, false).value("value", nlohmann::json()) : nullptr;
  }
  // Of the answer its value; null for none.
  nlohmann::json ask(const std::string& path, const nlohmann::json& body) {
    if (lost_) return nullptr;
    const auto answer = client_->Post(path, body.dump(), "application/json");
    lost_ = !answer;
    EXPECT_TRUE(answer) << path;
    if (!answer) return nullptr;
    EXPECT_EQ(answer->status, 200) << path << " " << answer->body.substr(0, 500);
    return nlohmann::json::parse(answer->body, nullptr, false).value("value", nlohmann::json());
  }

  BackgroundRun driver_;
  std::string profile_;
  std::unique_ptr<httplib::Client> client_;
  std::string session_;
  // It did not answer for a minute. Nothing more is asked: tests that wait for it would take that minute each time.
  bool lost_ = false;
};

// axe-core's rules for WCAG 2.1 A and AA and its best practices, on a page in a browser. scripts/page-check fetches
// it.

// axe-core's source; "" where there is none.
inline std::string axe_script() {
  const char* path = std::getenv("IM2FIT_AXE");
  std::ifstream file(path != nullptr ? path : "");
  std::string source{std::istreambuf_iterator<char>(file), {}};
  return source.size() < 100'000 ? "" : source;
}

// What it says against the page as it stands: pairs of a rule and the elements that break it.
inline nlohmann::json axe_violations(Browser& browser, const std::string& axe) {
  if (browser.run("return typeof axe") == "undefined") browser.run(axe + ";window.axe = axe;");
  return browser.run_until_called(R"js(
    const done = arguments[arguments.length - 1];
    axe.run(document, {resultTypes: ['violations']}).then(
      (r) => done(r.violations.map((v) => [v.id, v.nodes.map((n) => n.html.slice(0, 200))])), (e) => done(String(e)));
  )js");
}

// Light and dark.
inline void prefer_colours(Browser& browser, const char* scheme) {
  browser.devtools("Emulation.setEmulatedMedia", {{"features",
                                                   {{{"name", "prefers-color-scheme"}, {"value", scheme}},
                                                    {{"name", "prefers-reduced-motion"}, {"value", "reduce"}}}}});
}
inline constexpr const char* kColourSchemes[] = {"light", "dark"};

}  // namespace im2fit::test
