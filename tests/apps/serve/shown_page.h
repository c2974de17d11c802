// SPDX-License-Identifier: Apache-2.0
// A LivePage that gets its events from a test, in place of a camera and an engine.
#pragma once

#include <gtest/gtest.h>
#include <httplib.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "apps/kiosk/live_page.h"
#include "core/measurement.h"

namespace im2fit::test {

class ShownPage {
 public:
  static constexpr const char* kPassword = "correct horse battery";
  explicit ShownPage(apps::LivePageSettings settings = {}, int port = 0) {
    settings.address.port = port;
    if (settings.desk) settings.operator_password = kPassword;
    auto page = apps::LivePage::open(settings);
    EXPECT_TRUE(page) << page.error().message;
    if (page) page_ = std::move(*page);
    page_->begin(Intrinsics{}, 30);
  }
  apps::LivePage& page() { return *page_; }
  std::string url() const { return page_->url().substr(0, page_->url().size() - 1); }
  int port() const { return std::stoi(url().substr(url().rfind(':') + 1)); }
  void end() { page_.reset(); }

  httplib::Client client() const {
    httplib::Client c(url());
    c.set_read_timeout(20);
    return c;
  }
  // Signs in once; later calls are of that session.
  httplib::Client operator_client() {
    httplib::Client c = client();
    if (cookie_.empty()) {
      const apps::Json password = {{"password", kPassword}};
      const auto answer = c.Post("/operator/sign-in", {{"Origin", url()}}, password.dump(), "application/json");
      EXPECT_TRUE(answer && answer->status == 200);
      cookie_ = answer ? answer->get_header_value("Set-Cookie") : "";
      cookie_.resize(std::min(cookie_.size(), cookie_.find(';')));
      token_ = c.Get("/operator/token", {{"Cookie", cookie_}})->body;
    }
    c.set_default_headers({{"Cookie", cookie_}});
    return c;
  }
  // The status and the text of the answer.
  std::pair<int, std::string> post_operator(const std::string& path, const apps::Json& body) {
    httplib::Client c = operator_client();
    const auto answer = c.Post(path, httplib::Headers{{"Origin", url()}, {"X-Im2fit-Token", token_}}, body.dump(),
                               "application/json");
    return answer ? std::pair(answer->status, answer->body) : std::pair(0, std::string());
  }
  int status_of(const std::string& path) const {
    const auto answer = client().Get(path);
    return answer ? answer->status : 0;
  }
  // What a person reports, as the page's own script sends it.
  int post_facts(const std::string& visit, const std::string& json) const {
    const auto answer = client().Post("/facts", httplib::Headers{{"Origin", url()}, {"X-Im2fit-Visit", visit}}, json,
                                      "application/json");
    return answer ? answer->status : 0;
  }
  // As the page's own script asks.
  int post(const std::string& path, const std::string& visit, const std::string& note = "") const {
    const auto answer = client().Post(
        path, httplib::Headers{{"Origin", url()}, {"X-Im2fit-Visit", visit}, {"X-Im2fit-Note", note}}, "", "");
    return answer ? answer->status : 0;
  }
  // The stream's events up to the first of the kind `last`.
  std::vector<apps::Json> events(const std::string& last) const {
    std::string text;
    client().Get("/events", [&](const char* data, std::size_t size) {
      text.append(data, size);
      return text.find("\"event\":\"" + last + "\"") == std::string::npos;
    });
    std::vector<apps::Json> all;
    for (std::size_t at = text.find("data: "); at != std::string::npos; at = text.find("data: ", at + 1))
      all.push_back(apps::Json::parse(text.substr(at + 6, text.find('\n', at) - at - 6), nullptr, false));
    return all;
  }
  std::string visit() const {
    for (const auto& event : events("beat"))
      if (event["event"] == "visit") return event["id"];
    return "";
  }

  // Frames and events from here on are of the person who may be measured now.
  void begin_person() {
    const std::uint64_t permit = page_->permit();
    if (permit != 0 && permit != permit_) page_->begin_person(permit);
    permit_ = permit;
  }
  void state(const std::string& name, const std::vector<std::string>& guidance,
             apps::Json details = apps::Json::object()) {
    begin_person();
    page_->publish({{"event", "state"},
                    {"frame", 1},
                    {"state", name},
                    {"guidance", guidance},
                    {"guidance_details", std::move(details)},
                    {"user", guidance == std::vector<std::string>{"NO_PERSON"} ? 0 : 1},
                    {"view", "front"},
                    {"frames_used", 12}});
  }
  // As in result.json: of every garment M fits, smaller sizes are tight and larger ones loose.
  static apps::Json fits() {
    apps::Json all = apps::Json::array();
    for (const char* garment : {"t_shirt", "long_sleeved_shirt", "dress", "trousers", "shorts", "skirt"}) {
      apps::Json sizes;
      int ease_mm = -40;
      for (const char* size : {"XS", "S", "M", "L", "XL", "XXL", "3XL"}) {
        for (const char* region : {"chest", "waist", "hip"}) {
          const bool waist_of_s = std::string(size) == "S" && std::string(region) == "waist";
          const char* verdict = ease_mm < 0 ? "tight" : waist_of_s ? "snug" : ease_mm < 80 ? "good" : "loose";
          sizes[size][region] = {
              {"ease_mm", ease_mm}, {"interval", {ease_mm - 60, ease_mm + 60}}, {"verdict", verdict}};
        }
        ease_mm += 40;
      }
      all.push_back({{"garment", garment}, {"chart", "EN 13402-3"}, {"best", "M"}, {"fits", true}, {"sizes", sizes}});
    }
    return all;
  }
  apps::Json more_of_result = apps::Json::object();  // of measured()
  // A result of this chest girth. `known`: as in result.json.
  void measured(double chest_mm, const std::string& out = "", const apps::Json& known = nullptr,
                bool corrected = false) {
    apps::Json result = {{"views", "front+back"}, {"sex", {{"female", 0.9}}}};
    result["clothing"] = {{"answered_as", "bare"}};
    result["size"] = {{"chart", "EN 13402-3"}, {"best", "M"}, {"probabilities", {{"M", 0.8}, {"L", 0.2}}}};
    for (const auto& info : kMeasurementTable) {
      const double value = info.unit == "kg" ? 70 : chest_mm;
      result["measurements"][std::string(info.id)] = {
          {"value", value}, {"unit", info.unit}, {"interval", {value - 20, value + 20}}};
    }
    result["fit"] = fits();
    if (!known.is_null()) result["known"] = known;
    result.merge_patch(more_of_result);
    apps::Json event = {{"event", "measured"}, {"frame", 1}, {"person", 1}, {"result", std::move(result)}};
    if (corrected) event["corrected"] = true;
    if (!out.empty()) event["out"] = out;
    begin_person();
    page_->publish(event);
  }

 private:
  std::unique_ptr<apps::LivePage> page_;
  std::string cookie_, token_;  // of the operator
  std::uint64_t permit_ = 0;
};

}  // namespace im2fit::test
