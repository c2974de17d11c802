// SPDX-License-Identifier: Apache-2.0
// A result handed from the page to a phone: by a code that only the requesting page shows, once, while the visit
// goes on.
#include <gmock/gmock.h>
#include <png.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <thread>

#include "browser.h"
#include "read_qr.h"
#include "run_program.h"
#include "shown_page.h"

namespace im2fit {
namespace {

using Json = nlohmann::json;
using std::chrono::milliseconds;

apps::LivePageSettings handing_over(milliseconds hand_over_max = apps::kHandOverMax) {
  apps::LivePageSettings settings;
  settings.hand_over = {"127.0.0.1", 0};
  settings.hand_over_max = hand_over_max;
  return settings;
}

// The answer to the page.
std::pair<int, Json> offer(const test::ShownPage& page, const std::string& visit) {
  const auto answer =
      page.client().Post("/hand-over", httplib::Headers{{"Origin", page.url()}, {"X-Im2fit-Visit", visit}}, "", "");
  if (!answer) return {0, nullptr};
  return {answer->status, Json::parse(answer->body, nullptr, false)};
}
std::string token_in(const std::string& address) {
  return address.substr(std::min(address.find('#') + 1, address.size()));
}
// Its status and what came, as the phone's page asks.
std::pair<int, std::string> take(const std::string& address, const std::string& token) {
  const std::string at = address.substr(0, address.find("/#"));
  const auto answer =
      httplib::Client(at).Post("/take", httplib::Headers{{"Origin", at}, {"X-Im2fit-Token", token}}, "", "");
  return answer ? std::pair(answer->status, answer->body) : std::pair(0, std::string());
}

bool hands_over(const test::ShownPage& page) {
  for (const auto& event : page.events("hello"))
    if (event["event"] == "hello") return event["hands_over"];
  ADD_FAILURE() << "no hello";
  return false;
}

class Phone : public testing::Test {
 protected:
  void measure(test::ShownPage& page, double chest_mm) {
    ASSERT_EQ(page.post("/consent", page.visit()), 200);
    page.measured(chest_mm);
    ASSERT_EQ(page.status_of("/result.json"), 200);
  }
};

TEST_F(Phone, TakesTheResultOnce) {
  test::ShownPage page(handing_over());
  EXPECT_TRUE(hands_over(page));
  EXPECT_EQ(offer(page, page.visit()).first, 409) << "there is no result yet";
  ASSERT_NO_FATAL_FAILURE(measure(page, 911.25));
  const auto [status, code] = offer(page, page.visit());
  ASSERT_EQ(status, 200);
  const std::string address = code["address"];
  EXPECT_EQ(address.substr(0, address.find('#')), page.page().phone_url());
  EXPECT_EQ(code["left_s"], 120) << "as long as the visit does without a touch";
  if (test::kReadsQr) {
    EXPECT_EQ(test::read_qr_path(code["path"], code["side"]), address);
  }
  for (const auto& event : page.events("beat"))
    EXPECT_EQ(event.dump().find(token_in(address)), std::string::npos) << "told to whoever asked alone";

  EXPECT_EQ(take(address, std::string(32, '0')).first, 404) << "forged";
  EXPECT_EQ(take(address, page.visit()).first, 404) << "the visit's id is no token";
  const auto [taken, result] = take(address, token_in(address));
  EXPECT_EQ(taken, 200);
  EXPECT_EQ(result, page.client().Get("/result.json")->body);
  EXPECT_EQ(take(address, token_in(address)).first, 404) << "once";
}

TEST_F(Phone, FindsNothingAfterTimeDeleteOrTheNextCode) {
  test::ShownPage page(handing_over(milliseconds(300)));
  ASSERT_NO_FATAL_FAILURE(measure(page, 911.25));
  const std::string first = page.visit();
  std::string address = offer(page, first).second["address"];
  std::this_thread::sleep_for(milliseconds(350));
  EXPECT_EQ(take(address, token_in(address)).first, 404) << "too late";
  address = offer(page, first).second["address"];
  const std::string next = offer(page, first).second["address"];
  EXPECT_EQ(take(address, token_in(address)).first, 404) << "another code was asked for";
  EXPECT_EQ(take(next, token_in(next)).first, 200);

  address = offer(page, first).second["address"];
  ASSERT_EQ(page.post("/delete", first), 200);
  EXPECT_EQ(take(address, token_in(address)).first, 404) << "deleted";
  EXPECT_EQ(offer(page, first).first, 409);
  ASSERT_NO_FATAL_FAILURE(measure(page, 987.5));
  EXPECT_EQ(offer(page, first).first, 409) << "a page that still shows the one before gets nothing of the next";
  EXPECT_EQ(take(address, token_in(address)).first, 404);
}

TEST_F(Phone, FindsNothingAfterTheVisitEndedByItself) {
  apps::LivePageSettings settings = handing_over();
  settings.visit.result_max = milliseconds(400);
  test::ShownPage page(settings);
  ASSERT_NO_FATAL_FAILURE(measure(page, 911.25));
  const std::string address = offer(page, page.visit()).second["address"];
  for (int i = 0; i < 300 && page.status_of("/result.json") == 200; ++i)
    std::this_thread::sleep_for(milliseconds(20));
  EXPECT_EQ(take(address, token_in(address)).first, 404);
}

TEST_F(Phone, IsHandedNothingUnlessAskedFor) {
  test::ShownPage page;
  EXPECT_FALSE(hands_over(page));
  ASSERT_NO_FATAL_FAILURE(measure(page, 911.25));
  EXPECT_EQ(offer(page, page.visit()).first, 405);
  EXPECT_EQ(page.page().phone_url(), "");
  const test::Run run = test::run_program({IM2FIT_PROGRAM, "serve", "synthetic:1", "--hand-over", "0.0.0.0"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_TRUE(test::is_one_line_of(run.err, "im2fit")) << run.err;
}

// In grey.
struct Picture {
  std::vector<std::uint8_t> grey;
  int width = 0, height = 0;
};
Picture picture_of(const std::string& png) {
  Picture picture;
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_memory(&image, png.data(), png.size()) == 0) return picture;
  image.format = PNG_FORMAT_GRAY;
  picture.width = static_cast<int>(image.width);
  picture.height = static_cast<int>(image.height);
  picture.grey.resize(PNG_IMAGE_SIZE(image));
  if (png_image_finish_read(&image, nullptr, picture.grey.data(), 0, nullptr) == 0) picture.grey.clear();
  return picture;
}

// From the screen to the phone's own page, both in Chromium; the code is read from a screenshot.
TEST_F(Phone, ReadsTheCodeFromTheScreenAndShowsTheResult) {
  if (!test::Browser::installed()) GTEST_SKIP() << "no chromium: scripts/deps browser";
  if (!test::kReadsQr) GTEST_SKIP() << "no ZXing here: scripts/deps test";
  const test::TestFolder folder;
  apps::LivePageSettings settings = handing_over();
  settings.shop.emplace();
  settings.shop->name = "Müller & Söhne";
  settings.shop->accent = {"#7a1f3d", "#f2a7bd"};
  settings.shop->consent = {"7", "Müller GmbH", {{"en", "to find your size"}}, "privacy@mueller.example"};
  test::ShownPage page(settings);
  test::Browser browser(folder.path(""), {"--lang=de-DE"});
  ASSERT_TRUE(browser.ready()) << browser.messages();
  browser.go(page.url());
  ASSERT_TRUE(browser.wait_for("return typeof words !== 'undefined' && !!words.table && visit !== null"));
  page.more_of_result = {{"guidance", {"FEET_RAISED"}},
                         {"guidance_details", {{"feet_raised", {{"ground_mm", 38.7}}}}}};
  ASSERT_NO_FATAL_FAILURE(measure(page, 911));
  ASSERT_TRUE(browser.wait_for("return document.body.dataset.code === 'DONE'"));
  browser.run("at('to-phone').click()");
  ASSERT_TRUE(browser.wait_for("return !at('phone').hidden"));
  std::string address;
  for (const auto& [width, height] : {std::pair{390, 844}, {800, 1280}, {1280, 800}}) {
    browser.resize(width, height);
    browser.run("at('phone').scrollIntoView({block: 'nearest'})");
    const Picture screen = picture_of(browser.screenshot());
    ASSERT_EQ(screen.width, width);
    address = test::read_qr(screen.grey, screen.width, screen.height);
    EXPECT_EQ(address, browser.run("return offer.address")) << width << "x" << height;
    if (const char* kept = std::getenv("IM2FIT_SCREENSHOTS"))
      test::write_text(std::string(kept) + "/code-" + std::to_string(width) + ".png", browser.screenshot());
  }
  browser.resize(390, 844);
  browser.devtools("Browser.setDownloadBehavior",
                   {{"behavior", "allow"}, {"downloadPath", folder.path("downloads")}});
  // A phone on which the address was typed may have made its letters large.
  std::string typed = address.substr(address.find('#'));
  std::transform(typed.begin(), typed.end(), typed.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  browser.go(address.substr(0, address.find('#')) + "?lang=de-DE" + typed);
  ASSERT_TRUE(browser.wait_for("return document.body && document.body.dataset.state === 'once'"));
  EXPECT_EQ(browser.run("return location.hash"), "") << "the token is of no use any more";
  EXPECT_EQ(browser.run("return document.querySelector('tr[data-id=chest_girth]').cells[1].textContent"), "91,1");
  EXPECT_EQ(browser.run("return at('size').textContent"), "Ihre Größe: M");
  EXPECT_EQ(browser.run("return [document.title, at('shop').textContent, at('brand').hidden, at('logo').hidden]"),
            (Json{"Müller & Söhne", "Müller & Söhne", false, true}));
  EXPECT_EQ(browser.run("return at('brand').getClientRects().length > 0"), true) << "on a narrow screen, too";
  EXPECT_EQ(browser.run("return getComputedStyle(document.documentElement).getPropertyValue('--accent').trim()"),
            "#7a1f3d");
  const std::string beside = "Sie standen 3,9 cm über dem Boden; Ihre Körpergröße zählt ab dort.";
  EXPECT_EQ(browser.run("return at('doubts').textContent"), beside);
  EXPECT_EQ(browser.run("return words.doubts({guidance: ['FEET_RAISED'], guidance_details: "
                        "{feet_raised: {heels_mm: 48}}})[0]"),
            "Für Absätze wurden etwa 4,8 cm von Ihrer Körpergröße abgezogen; ohne Schuhe wird sie genauer.")
      << "who stands on the floor is not told that they do not";
  EXPECT_EQ(browser.run("return document.documentElement.scrollWidth <= innerWidth"), true);
  EXPECT_EQ(browser.run("return document.body.innerText.includes('undefined')"), false);
  browser.run("at('text').click()");
  std::string text;
  for (int i = 0; i < 400 && text.empty(); ++i) {
    std::this_thread::sleep_for(milliseconds(10));
    text = test::read_text(folder.path("downloads/measurements.txt"));
  }
  EXPECT_THAT(text, testing::AllOf(testing::StartsWith("Müller & Söhne\n"), testing::HasSubstr("91,1 ("),
                                   testing::HasSubstr(beside)));
  if (const char* kept = std::getenv("IM2FIT_SCREENSHOTS"))
    test::write_text(std::string(kept) + "/phone.png", browser.screenshot());
  browser.go("about:blank");
  browser.go(address);
  ASSERT_TRUE(browser.wait_for("return document.body && document.body.dataset.state === 'gone'"));
  EXPECT_EQ(browser.run("return at('taken').hidden"), true);
}

// Of a shop a phone gets the name, the colours and the logo, nothing else; without a shop, nobody's.
TEST_F(Phone, GetsTheShopsNameAndNothingElseOfIt) {
  for (const bool named : {false, true}) {
    apps::LivePageSettings settings = handing_over();
    if (named) {
      settings.shop.emplace();
      settings.shop->name = "Müller & Söhne";
      settings.shop->logo = "a picture";
      settings.shop->consent = {"7", "Müller GmbH", {{"en", "to find your size"}}, "privacy@mueller.example"};
    }
    test::ShownPage page(settings);
    ASSERT_NO_FATAL_FAILURE(measure(page, 911.25));
    const std::string url = page.page().phone_url();
    httplib::Client phone(url.substr(0, url.size() - 1));  // without its '/'
    const auto shop = phone.Get("/shop.json");
    ASSERT_TRUE(shop && shop->status == 200);
    EXPECT_EQ(Json::parse(shop->body), named ? Json({{"name", "Müller & Söhne"}, {"logo", true}}) : Json());
    EXPECT_EQ(phone.Get("/shop.css")->status, 200);
    EXPECT_EQ(phone.Get("/shop.png")->status, named ? 200 : 404);
    for (const char* path : {"/result.json", "/avatar.glb", "/events", "/picture.png", "/index.html", "/operator"})
      EXPECT_EQ(phone.Get(path)->status, 404) << path;
  }
}

class AxePhone : public Phone {};

TEST_F(AxePhone, FindsNothingInAResultTakenNorInOneThatIsGone) {
  const std::string axe = test::axe_script();
  if (axe.empty()) GTEST_SKIP() << "no axe-core: scripts/page-check";
  if (!test::Browser::installed()) GTEST_SKIP() << "no chromium: scripts/deps browser";
  const test::TestFolder folder;
  test::ShownPage page(handing_over());
  ASSERT_NO_FATAL_FAILURE(measure(page, 911));
  const std::string address = offer(page, page.visit()).second["address"];
  test::Browser browser(folder.path(""), {"--lang=en-GB"});
  ASSERT_TRUE(browser.ready()) << browser.messages();
  browser.resize(390, 844);
  for (const char* state : {"once", "gone"}) {
    browser.go("about:blank");
    browser.go(address);
    ASSERT_TRUE(
        browser.wait_for("return document.body && document.body.dataset.state === '" + std::string(state) + "'"));
    for (const char* scheme : test::kColourSchemes) {
      test::prefer_colours(browser, scheme);
      EXPECT_EQ(test::axe_violations(browser, axe), Json::array()) << state << ", " << scheme;
    }
  }
}

}  // namespace
}  // namespace im2fit
