// SPDX-License-Identifier: Apache-2.0
// The page in Chromium: every state in every language on four screens; two tabs, a restart, a touch; axe-core's
// rules.
#include <fmt/core.h>
#include <gmock/gmock.h>

#include <array>
#include <filesystem>
#include <thread>

#include "browser.h"
#include "core/guidance.h"
#include "depth_folder.h"
#include "shown_page.h"

namespace im2fit {
namespace {

using Json = nlohmann::json;

// What is wrong with the page as it stands: an array of words. `kFaults` in the language it has, `kAllFaults` in
// each.
constexpr const char* kFaults = R"js(
const faults = () => {
  const found = [], say = (what) => found.push(`${words.language} ${document.body.dataset.code}: ${what}`);
  const seen = (e) => e.getClientRects().length > 0;
  const root = document.documentElement, message = at('message'), box = message.getBoundingClientRect();
  if (root.lang !== words.language) say('lang');
  if (root.scrollWidth > innerWidth) say(`${root.scrollWidth} wide`);
  if (document.querySelectorAll('h1').length !== 1 || !seen(message)) say('no h1');
  if (message.textContent !== words.say(document.body.dataset.code) || !message.textContent) say('no text');
  if (/[A-Z]{3,}_[A-Z]/.test(document.body.innerText) || document.body.innerText.includes('undefined')) say('a raw code');
  if (message.scrollWidth > message.clientWidth + 1) say('a word wider than the screen');
  if (box.bottom > innerHeight) say('message below the screen');
  if (!at('icon').childElementCount) say('no icon');
  for (const e of document.querySelectorAll('button, a')) {
    const r = e.getBoundingClientRect();
    if (seen(e) && (r.height < 44 || r.width < 44)) say(`${e.id || e.lang} is ${r.width} x ${r.height}`);
    if (seen(e) && !e.textContent.trim()) say(`${e.id} says nothing`);
  }
  const stage = document.body.dataset.stage, bar = at('accumulated');
  for (const e of document.querySelectorAll('#facts label')) {
    const r = e.getBoundingClientRect();
    if (seen(e) && (r.height < 44 || r.width < 44)) say(`${e.innerText} is ${r.width} x ${r.height}`);
  }
  for (const id of ['facts-skip', 'facts-go']) {
    if (seen(at(id)) && at(id).getBoundingClientRect().bottom > innerHeight) say(`${id} below the screen`);
  }
  if (['red', 'amber'].includes(document.body.dataset.tone) && seen(bar)) say('a bar');
  if (stage === 'result') {
    const inside = (e, what) => {
      const r = e.getBoundingClientRect();
      if (seen(e) && (r.top < 0 || r.left < 0 || r.bottom > innerHeight + .5 || r.right > innerWidth + .5)) say(`${what} outside`);
    };
    const box = at('stage').getBoundingClientRect(), panel = at('panel');
    const share = box.width * (Math.min(box.bottom, innerHeight) - box.top) / (innerWidth * innerHeight);
    if (share < .5) say(`the body has ${share} of the screen`);
    if (panel.scrollWidth > panel.clientWidth) say(`the panel is ${panel.scrollWidth} wide`);
    for (const id of ['size', 'try-on', 'to-phone', 'open-figures', 'left', 'more', 'delete', 'view']) inside(at(id), id);
    // Nothing of it is behind what stands below it.
    const floor = at('actions').getBoundingClientRect().top;
    const told = at('told').childElementCount > 0 || !at('recorded').hidden || !at('doubts').hidden;
    for (const e of document.querySelectorAll('#tryon .row, #tryon .verdict')) {
      if (!told || e.classList.contains('row')) inside(e, e.className);
      if (!told && seen(e) && e.getBoundingClientRect().bottom > floor) say(`${e.className} behind the actions`);
    }
    if (/\u00b1|\bmm\b/.test(at('tryon').innerText)) say('millimetres');
  }
  // 12 mm on a 10-inch tablet of 1280 x 800: 217 mm wide.
  if (Math.max(innerWidth, innerHeight) === 1280 && ['welcome', 'measure', 'trouble', 'result'].includes(stage) &&
      !document.body.dataset.near) {
    const pen = document.createElement('canvas').getContext('2d'), style = getComputedStyle(message);
    pen.font = `${style.fontWeight} ${style.fontSize} ${style.fontFamily}`;
    const mm = pen.measureText('H').actualBoundingBoxAscent * 217 / 1280;
    if (mm < 12) say(`capitals of ${mm} mm`);
  }
  return found;
};
)js";
const std::string kAllFaults = std::string(kFaults) + R"js(
  const all = [], before = words.language;
  for (const language of kLanguages) { words.language = language; showTexts(); all.push(...faults()); }
  words.language = before; showTexts();
  return all;
)js";

// Of a result: a height that was used, a weight that does not fit.
const apps::Json kDoubted = {{"given",
                              {{"stature", {{"value", 1720}, {"sd", 20}, {"unit", "mm"}}},
                               {"weight", {{"value", 130}, {"sd", 3}, {"unit", "kg"}}}}},
                             {"used", {"stature"}},
                             {"doubted", {"weight"}}};
// Of a result: the person stood on something, and their crown has no depth.
const apps::Json kBeside = {
    {"guidance", {"FEET_RAISED", "HEAD_UNSEEN"}},
    {"guidance_details", {{"feet_raised", {{"ground_mm", 38.7}}}, {"head_unseen", {{"added_mm", 12.5}}}}}};
constexpr int kStatesLooked = 42;
constexpr std::pair<int, int> kScreens[] = {{390, 844}, {800, 1280}, {1280, 800}, {1920, 1080}};

class Screens : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (!test::Browser::installed()) return;
    folder_ = new test::TestFolder;
    browser_ = new test::Browser(folder_->path(""), {"--lang=en-GB"});
  }
  static void TearDownTestSuite() {
    delete std::exchange(browser_, nullptr);
    delete std::exchange(folder_, nullptr);
  }
  void SetUp() override {
    if (browser_ == nullptr) GTEST_SKIP() << "no chromium: scripts/deps browser";
    ASSERT_TRUE(browser_->ready()) << browser_->messages();
  }
  static bool shows(const std::string& code) {
    return browser_->wait_for("return document.body.dataset.code === '" + code + "'");
  }
  static std::string shown() {
    return browser_->run("return document.body.dataset.code + ' ' + document.body.dataset.stage");
  }
  static void open(const test::ShownPage& page, const std::string& query = "?lang=en") {
    browser_->go(page.url() + "/" + query);
    ASSERT_TRUE(browser_->wait_for("return typeof words !== 'undefined' && !!words.table && visit !== null"));
  }
  // By its button, as a person does.
  static void agree() {
    browser_->run("at('agree').click()");
    ASSERT_TRUE(browser_->wait_for("return visit.state === 'MEASURING'"));
  }
  // Brings the page into each of its states and calls `look` there.
  static void through_all_states(const std::function<void(const std::string& code)>& look);
  static inline test::TestFolder* folder_ = nullptr;
  static inline test::Browser* browser_ = nullptr;
};

void Screens::through_all_states(const std::function<void(const std::string& code)>& look) {
  const auto at = [&](const std::string& code) {
    EXPECT_TRUE(shows(code)) << code << " wanted, " << shown();
    look(code);
  };
  apps::LivePageSettings settings;
  settings.hand_over = {"127.0.0.1", 0};
  settings.visit.ask_facts = true;
  auto page = std::make_unique<test::ShownPage>(settings);
  ASSERT_NO_FATAL_FAILURE(open(*page));
  at("WELCOME");
  for (const char* code : {"NO_CAMERA", "MODELS_MISSING"}) {
    page->page().trouble(code);
    at(code);
  }
  page->page().trouble("");
  ASSERT_TRUE(shows("WELCOME"));
  browser_->run("at('agree').click()");
  at("FACTS");
  browser_->run("at('facts-skip').click()");
  ASSERT_TRUE(browser_->wait_for("return visit.state === 'MEASURING'"));
  for (const std::string_view code : kGuidanceNames) {
    if (code.empty()) continue;  // a bit without a code
    page->state(code == "TURN_ROUND" ? "TURNING" : "TRACKING", {std::string(code)});
    at(std::string(code));
  }
  for (const auto& [side, code] : {std::pair{"left", "ARMS_CLOSE_LEFT"}, {"right", "ARMS_CLOSE_RIGHT"}}) {
    page->state("TRACKING", {"ARMS_CLOSE", "MOVING"}, {{"arms_close", {side}}});
    at(code);
  }
  page->state("TURNING", {"TURN_ON"});
  at("TURN_ON");
  for (const int deg : {80, 100}) {
    page->page().publish({{"event", "frame"}, {"frames_used", 40}, {"frames_back", 10}, {"turned_deg", deg}});
    EXPECT_TRUE(browser_->wait_for("return at('count').textContent === '" + std::to_string(deg) + "°'"));
  }
  EXPECT_EQ(browser_->run("return String(sounds.played.includes('QUARTER'))"), "true");
  page->state("TRACKING", {});
  at("HOLD");
  page->page().publish({{"event", "camera"}, {"state", "LOST"}});
  at("CAMERA_LOST");
  page->page().publish({{"event", "camera"}, {"state", "PRESENT"}});
  at("HOLD");
  page->state("MEASURED", {});
  page->measured(987.6, "", kDoubted);
  at("DONE");
  browser_->run("at('open-figures').click()");
  EXPECT_TRUE(browser_->wait_for("return !at('figures').hidden && at('tryon').hidden"));
  at("DONE");
  // What stands beside an answer, as long as it gets.
  page->more_of_result = kBeside;
  page->measured(987.6, "", kDoubted, true);
  EXPECT_TRUE(browser_->wait_for("return !at('doubts').hidden"));
  browser_->run("at('try-on').click()");
  at("DONE");
  browser_->run("at('facts-open').click()");
  at("FACTS");
  browser_->run("at('facts-skip').click()");
  at("DONE");
  page->page().publish({{"event", "end"}});
  browser_->run("at('to-phone').click()");
  EXPECT_TRUE(browser_->wait_for("return !at('phone').hidden"));
  at("DONE");
  page.reset();
  at("SERVER_GONE");
  page = std::make_unique<test::ShownPage>();
  ASSERT_NO_FATAL_FAILURE(open(*page));
  ASSERT_NO_FATAL_FAILURE(agree());
  page->page().publish({{"event", "end"}});
  at("OVER");
}

TEST_F(Screens, EveryStateInEveryLanguageOnFourScreens) {
  int looked = 0;
  through_all_states([&](const std::string& code) {
    for (const auto& [width, height] : kScreens) {
      browser_->resize(width, height);
      const Json faults = browser_->run(kAllFaults);
      EXPECT_EQ(faults, Json::array()) << code << " on " << width << "x" << height;
      if (const char* kept = std::getenv("IM2FIT_SCREENSHOTS"))
        test::write_text(fmt::format("{}/{:03}-{}-{}.png", kept, looked, code, width), browser_->screenshot());
      looked += 5;
    }
  });
  EXPECT_EQ(looked, kStatesLooked * 4 * 5);
  EXPECT_EQ(browser_->run("return failures"), Json::array());
}

// In place of an avatar: as tall and as broad as a person, with its origin where a body's is.
constexpr const char* kFigure = R"js(
  const figure = new THREE.Group(), root = new THREE.Object3D();
  const trunk = new THREE.Mesh(new THREE.BoxBufferGeometry(0.6, HEIGHT, 0.3), new THREE.MeshLambertMaterial());
  trunk.position.y = HEIGHT / 2;
  root.name = hello.segments[0];
  figure.add(trunk, root);
  stage.stand(figure, hello.segments.map(() => hello.segments[0]));
  stage.draw();
)js";
// The share of the view's height that the figure has, and whether it is wholly in view.
constexpr const char* kBodyShare = R"js(
  stage.draw();
  const box = new THREE.Box3().setFromObject(stage.avatar), ys = [], xs = [];
  stage.camera.updateMatrixWorld();
  for (const x of [box.min.x, box.max.x]) for (const y of [box.min.y, box.max.y]) for (const z of [box.min.z, box.max.z]) {
    const p = new THREE.Vector3(x, y, z).project(stage.camera);
    xs.push(p.x); ys.push(p.y);
  }
  const seen = Math.max(...xs.map(Math.abs), ...ys.map(Math.abs)) <= 1;
  return seen ? (Math.max(...ys) - Math.min(...ys)) / 2 : -1;
)js";

TEST_F(Screens, TheBodyFillsTheViewAndTryingOnIsBesideIt) {
  apps::LivePageSettings settings;
  settings.hand_over = {"127.0.0.1", 0};
  test::ShownPage page(settings);
  ASSERT_NO_FATAL_FAILURE(open(page));
  ASSERT_NO_FATAL_FAILURE(agree());
  page.measured(987.6);
  ASSERT_TRUE(shows("DONE"));
  for (const char* height_m : {"1.50", "1.72", "2.05"}) {
    browser_->run("const HEIGHT = " + std::string(height_m) + ";" + kFigure);
    for (const auto& [width, height] : kScreens) {
      browser_->resize(width, height);
      browser_->run_until_called("requestAnimationFrame(() => requestAnimationFrame(arguments[0]))");
      EXPECT_GE(browser_->run(kBodyShare).get<double>(), 0.8) << height_m << " m on " << width << "x" << height;
      EXPECT_EQ(browser_->run(kAllFaults), Json::array()) << width << "x" << height;
    }
  }
  // Turned by a person it stays turned in other clothes, and one who walks stays in view.
  const std::string direction =
      "const d = stage.camera.position.clone().sub(stage.orbit.target).normalize(); return [d.x, d.z];";
  browser_->run("stage.camera.position.set(-3, 1, -2); stage.frame(stage.heightM)");
  const Json turned = browser_->run(direction);
  browser_->run("const HEIGHT = 2.05;" + std::string(kFigure));
  EXPECT_EQ(browser_->run(direction), turned);
  browser_->run("stage.avatar.children[1].add(stage.avatar.children[0]); stage.pose([1.5, 0, -1], [])");
  EXPECT_TRUE(browser_->wait_for("return Math.abs(stage.orbit.target.x - 1.5) < 0.01"));
  EXPECT_GE(browser_->run(kBodyShare).get<double>(), 0.8);
  // Both primary actions, the code in place of trying on, and the body does not move for it.
  const std::string view = "const r = at('stage').getBoundingClientRect(); return [r.top, r.height, r.width];";
  const Json before = browser_->run(view);
  browser_->run("at('to-phone').click()");
  ASSERT_TRUE(browser_->wait_for("return !at('phone').hidden && at('tryon').hidden"));
  EXPECT_EQ(browser_->run(view), before);
  // For a phone that scans nothing: the same address in letters, in groups that are no part of it.
  EXPECT_EQ(
      browser_->run("return at('address').textContent === offer.address && /#[0-9a-f]{32}$/.test(offer.address)"),
      true);
  EXPECT_EQ(browser_->run("return at('address').children.length"), 9);
  EXPECT_EQ(browser_->run(
                "const r = at('address').getBoundingClientRect(), p = at('panel').getBoundingClientRect();"
                "return r.height > 0 && r.right <= p.right && r.bottom <= at('actions').getBoundingClientRect().top"),
            true);
  browser_->run("at('try-on').click()");
  EXPECT_EQ(browser_->run("return !at('tryon').hidden && at('phone').hidden"), true);
  EXPECT_EQ(browser_->run("return [...document.querySelectorAll('#choices .main')].map((b) => b.id)"),
            (Json{"try-on", "to-phone"}));
  EXPECT_EQ(browser_->run("return at('delete').classList.contains('main')"), false);
  EXPECT_EQ(browser_->run("return failures"), Json::array());
}

TEST_F(Screens, FitIsToldInAShopsWords) {
  test::ShownPage page;
  ASSERT_NO_FATAL_FAILURE(open(page));
  ASSERT_NO_FATAL_FAILURE(agree());
  page.measured(987.6);
  ASSERT_TRUE(shows("DONE"));
  const auto told = [&](const std::string& language, const std::string& size) {
    browser_->run("words.language = '" + language + "'; showTexts();" +
                  "document.querySelector('#tryon [data-size=\"" + size + "\"]').click()");
    return browser_->run("return document.querySelector('#tryon .verdict').textContent").get<std::string>();
  };
  EXPECT_EQ(told("en", "M"), "M (your best size): fits");
  EXPECT_EQ(told("en", "S"), "S: a bit tight at the waist");
  EXPECT_EQ(told("en", "XS"), "XS: too tight at the chest, at the waist, and at the hips");
  EXPECT_EQ(told("de", "S"), "S: etwas eng an der Taille");
  EXPECT_EQ(told("es", "S"), "S: aprieta un poco en la cintura");
  EXPECT_EQ(told("fr", "XL"), "XL : un peu ample à la poitrine, à la taille et aux hanches");
  EXPECT_EQ(told("zh", "S"), "S：腰部稍紧");
}

TEST_F(Screens, WhatStandsBesideAnAnswerIsToldInPlainWords) {
  test::ShownPage page;
  ASSERT_NO_FATAL_FAILURE(open(page));
  ASSERT_NO_FATAL_FAILURE(agree());
  page.more_of_result = kBeside;
  page.measured(987.6);
  ASSERT_TRUE(shows("DONE"));
  const auto told = [&](const std::string& language) {
    browser_->run("words.language = '" + language + "'; showTexts()");
    return browser_->run("return at('doubts').hidden ? '' : at('doubts').textContent").get<std::string>();
  };
  EXPECT_EQ(told("en"),
            "You stood 3.9 cm above the floor; your height is counted from there. "
            "The top of your head was not seen, so your height is less accurate.");
  EXPECT_THAT(told("de"), testing::StartsWith("Sie standen 3,9 cm über dem Boden"));
  EXPECT_THAT(told("zh"), testing::HasSubstr("3.9 厘米"));
  browser_->run("words.language = 'en'; at('open-figures').click(); at('unit').click()");
  EXPECT_THAT(told("en"), testing::StartsWith("You stood 1.5 in above"));
  browser_->run("at('unit').click(); at('delete').click()");
  EXPECT_TRUE(browser_->wait_for("return at('doubts').hidden && !at('doubts').textContent"));
  ASSERT_NO_FATAL_FAILURE(agree());
  page.more_of_result = apps::Json::object();
  page.measured(987.6);
  ASSERT_TRUE(shows("DONE"));
  EXPECT_EQ(told("en"), "") << "nothing beside this answer";
}

// Two sizes: two bodies, wholly in view, each with one verdict below it, which follows its body round.
TEST_F(Screens, TwoSizesStandSideBySideWithAVerdictEach) {
  test::ShownPage page;
  ASSERT_NO_FATAL_FAILURE(open(page));
  ASSERT_NO_FATAL_FAILURE(agree());
  page.measured(987.6);
  ASSERT_TRUE(shows("DONE"));
  browser_->run("window.dispatchEvent(new Event('pointerdown'))");  // who compares stands before it
  browser_->run("const HEIGHT = 1.72;" + std::string(kFigure));
  // The room of this page makes nothing: a figure stands for what it would send.
  browser_->run(R"js(
    window.urls = [];
    fitting.ask = function () {
      window.urls.push([this.asked, this.askedBeside]);
      this.shown = this.asked;
      if (!this.askedBeside || this.askedBeside === this.shownBeside) return;
      stage.standBeside(stage.avatar.clone(), hello.segments.map(() => hello.segments[0]), this.wornIsSmaller());
      this.shownBeside = this.askedBeside;
    };)js");
  const std::string sides = R"js(
    return [...document.querySelectorAll('#sides .verdict')]
      .sort((a, b) => a.getBoundingClientRect().left - b.getBoundingClientRect().left).map((p) => p.textContent);)js";
  const std::string press = "document.querySelector('#tryon [data-size=";
  browser_->run("at('fitting-compare').click()");
  EXPECT_EQ(browser_->run(sides), (Json{"M: fits", "L: a bit loose at the chest, at the waist, and at the hips"}));
  EXPECT_EQ(browser_->run("return document.querySelectorAll('#tryon .verdict').length"), 0) << "one verdict each";
  EXPECT_THAT(browser_->run("return window.urls.pop()[1]").get<std::string>(), testing::HasSubstr("top_size=L"));
  browser_->run(press + "S]').click()");
  EXPECT_EQ(browser_->run(sides), (Json{"S: a bit tight at the waist", "M: fits"})) << "the earlier choice goes";
  EXPECT_EQ(browser_->run("return [...document.querySelectorAll('#tryon .sizes [aria-pressed=true]')]"
                          ".map((b) => b.dataset.size)"),
            (Json{"S", "M"}));
  for (const auto& [width, height] : kScreens) {
    browser_->resize(width, height);
    browser_->run_until_called("requestAnimationFrame(() => requestAnimationFrame(arguments[0]))");
    EXPECT_EQ(browser_->run(kAllFaults), Json::array()) << width << "x" << height;
    EXPECT_EQ(browser_->run(R"js(
      stage.draw();
      return [stage.avatar, stage.beside.avatar].every((body) => {
        const box = new THREE.Box3().setFromObject(body);
        return [box.min, box.max].every((p) => Math.abs(p.clone().project(stage.camera).x) <= 1);
      });)js"),
              true)
        << "both in view on " << width << "x" << height;
    EXPECT_EQ(browser_->run(R"js(
      const box = at('stage').getBoundingClientRect();
      return [...document.querySelectorAll('#sides .verdict')].every((p) => {
        const r = p.getBoundingClientRect();
        return r.left >= box.left && r.right <= box.right && r.bottom <= at('message').getBoundingClientRect().top + 1;
      });)js"),
              true)
        << width << "x" << height;
    if (const char* kept = std::getenv("IM2FIT_SCREENSHOTS"))
      test::write_text(fmt::format("{}/sides-{}.png", kept, width), browser_->screenshot());
  }
  // From behind the small one is on the right, and so are its words.
  browser_->run("stage.camera.position.set(0, 1, -4); stage.orbit.update(); stage.draw()");
  EXPECT_EQ(browser_->run(sides), (Json{"M: fits", "S: a bit tight at the waist"}));
  const std::string axe = test::axe_script();
  if (!axe.empty()) {
    EXPECT_EQ(test::axe_violations(*browser_, axe), Json::array());
  }
  browser_->run("at('fitting-compare').click()");
  EXPECT_EQ(
      browser_->run("return [at('sides').hidden, stage.beside, document.querySelectorAll('#tryon .verdict').length]"),
      (Json{true, nullptr, 1}));
  EXPECT_EQ(browser_->run("return stage.avatar.position.x"), 0);
  EXPECT_EQ(browser_->run("return failures"), Json::array());
}

// A PNG of 2 x 1 pixels.
constexpr std::array<unsigned char, 70> kLogo = {
    0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44, 0x52, 0x00, 0x00,
    0x00, 0x02, 0x00, 0x00, 0x00, 0x01, 0x08, 0x02, 0x00, 0x00, 0x00, 0x7b, 0x40, 0xe8, 0xdd, 0x00, 0x00, 0x00,
    0x0d, 0x49, 0x44, 0x41, 0x54, 0x78, 0xda, 0x63, 0xa8, 0x92, 0xb7, 0x05, 0x22, 0x00, 0x06, 0x5b, 0x01, 0xad,
    0xb3, 0xc0, 0xc8, 0x87, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};

// A shop's name, logo and colours, and whom the consent names: on every screen, in every language.
TEST_F(Screens, AShopsPageHasItsNameAndItsConsent) {
  apps::Shop shop;
  shop.name = "Müller & Söhne, Mode seit 1899";
  shop.accent = {"#7a1f3d", "#f2a7bd"};
  shop.logo = std::string(kLogo.begin(), kLogo.end());
  shop.consent = {"7",
                  "Müller & Söhne GmbH, Hauptstraße 1, 10115 Berlin",
                  {{"en", "to find your size {contact}"}, {"de", "um Ihre Größe zu finden"}},
                  "datenschutz@mueller.example"};
  std::string text;
  apps::LivePageSettings settings;
  settings.shop = shop;
  settings.hand_over = {"127.0.0.1", 0};
  settings.consented = [&](std::uint64_t, const std::string& accepted) { text = accepted; };
  test::ShownPage page(settings);
  ASSERT_NO_FATAL_FAILURE(open(page));
  const auto points = [&](const std::string& language) {
    browser_->run("words.language = '" + language + "'; showTexts()");
    return browser_->run("return at('consent-points').innerText").get<std::string>();
  };
  EXPECT_THAT(points("de"), testing::AllOf(testing::HasSubstr("Es misst: Müller & Söhne GmbH, Hauptstraße 1"),
                                           testing::HasSubstr("Wofür: um Ihre Größe zu finden"),
                                           testing::HasSubstr("datenschutz@mueller.example")));
  EXPECT_THAT(points("fr"), testing::HasSubstr("Dans quel but : to find your size {contact}"));
  EXPECT_EQ(browser_->run("return [document.title, at('shop').textContent, at('brand').hidden]"),
            (Json{"Müller & Söhne, Mode seit 1899", "Müller & Söhne, Mode seit 1899", false}));
  EXPECT_TRUE(browser_->wait_for("return at('logo').naturalWidth === 2"));
  for (const auto& [scheme, colour] : {std::pair{"light", "rgb(122, 31, 61)"}, {"dark", "rgb(242, 167, 189)"}}) {
    test::prefer_colours(*browser_, scheme);
    EXPECT_EQ(browser_->run("return getComputedStyle(at('agree')).backgroundColor"), colour) << scheme;
  }
  test::prefer_colours(*browser_, "light");
  const std::string axe = test::axe_script();
  const auto look = [&](const char* name) {
    for (const auto& [width, height] : kScreens) {
      browser_->resize(width, height);
      EXPECT_EQ(browser_->run(kAllFaults), Json::array()) << name << " on " << width << "x" << height;
      if (!axe.empty()) {
        EXPECT_EQ(test::axe_violations(*browser_, axe), Json::array()) << name << " on " << width;
      }
      if (const char* kept = std::getenv("IM2FIT_SCREENSHOTS"))
        test::write_text(fmt::format("{}/shop-{}-{}.png", kept, name, width), browser_->screenshot());
    }
  };
  look("welcome");
  browser_->run("words.language = 'de'; showTexts()");
  ASSERT_NO_FATAL_FAILURE(agree());
  EXPECT_EQ(text, "de-3+7");
  page.measured(987.6);
  ASSERT_TRUE(shows("DONE"));
  look("result");
  EXPECT_EQ(browser_->run("return failures"), Json::array());
}

// Who is recorded sees it from the consent on, in every language; nothing says that what is kept will be deleted.
TEST_F(Screens, ARecordedPersonIsTold) {
  const test::TestFolder sessions;
  apps::LivePageSettings settings;
  settings.desk.emplace();
  settings.desk->root = sessions.path("sessions");
  test::ShownPage page(settings);
  page.page().use_source({}, {});
  ASSERT_NO_FATAL_FAILURE(open(page));
  EXPECT_EQ(browser_->run("return at('recorded').hidden"), true);
  ASSERT_EQ(page.post_operator("/operator/begin", {{"language", "en"}, {"version", "1"}}).first, 200);
  ASSERT_TRUE(browser_->wait_for("return visit.state === 'MEASURING' && visit.recorded"));
  page.state("TRACKING", {"MOVING"});
  ASSERT_TRUE(shows("MOVING"));
  const std::string told = R"js(
    const wrong = [];
    for (const language of kLanguages) {
      words.language = language; showTexts();
      const text = at('recorded').innerText, consent = words.table.operator.consent;
      const dot = document.querySelector('#recorded .dot').getBoundingClientRect();
      if (!text.includes(words.of(WORDS)) || dot.width < 10) wrong.push(language);
      if (OPEN) for (const point of consent.points) if (!text.includes(point)) wrong.push(`${language}: ${point}`);
      if (at('delete').textContent !== words.of('delete_recording')) wrong.push(`${language}: delete`);
    }
    words.language = 'en'; showTexts();
    return wrong;)js";
  const auto told_as = [&](const char* key, bool open) {
    return browser_->run("const WORDS = '" + std::string(key) + "', OPEN = " + (open ? "true" : "false") + ";" +
                         told);
  };
  for (const auto& [width, height] : kScreens) {
    browser_->resize(width, height);
    EXPECT_EQ(told_as("recording", true), Json::array());
    EXPECT_EQ(browser_->run(kAllFaults), Json::array()) << width << "x" << height;
  }
  page.measured(911);
  ASSERT_TRUE(shows("DONE"));
  ASSERT_TRUE(browser_->wait_for("return at('left').textContent !== ''"));
  for (const auto& [width, height] : kScreens) {
    browser_->resize(width, height);
    EXPECT_EQ(told_as("recorded", false), Json::array());
    EXPECT_EQ(browser_->run(kAllFaults), Json::array()) << width << "x" << height;
  }
  EXPECT_THAT(browser_->run("return at('left').textContent").get<std::string>(),
              testing::AllOf(testing::HasSubstr("the recording stays"), testing::Not(testing::HasSubstr("deleted"))));
  browser_->run("at('recorded').open = true");
  EXPECT_EQ(told_as("recorded", true), Json::array()) << "the text stays to be read";
  browser_->run("at('delete').click()");
  ASSERT_TRUE(shows("WELCOME"));
  EXPECT_EQ(browser_->run("return at('recorded').hidden && at('not-deleted').hidden"), true);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(sessions.path("sessions")), {}), 0);
  // What could not be deleted is told.
  ASSERT_NO_FATAL_FAILURE(agree());
  page.measured(911);
  ASSERT_TRUE(shows("DONE"));
  browser_->run(
      "const real = window.fetch; window.fetch = async (...a) => { const r = await real(...a); return "
      "String(a[0]).endsWith('/delete') ? new Response('no', {status: 500}) : r; }; at('delete').click()");
  EXPECT_TRUE(browser_->wait_for("return !at('not-deleted').hidden && at('not-deleted').textContent.length > 10"));
}

TEST_F(Screens, MoreTimeStartsTheCountdownAgain) {
  test::ShownPage page;
  ASSERT_NO_FATAL_FAILURE(open(page));
  ASSERT_NO_FATAL_FAILURE(agree());
  page.measured(911);
  ASSERT_TRUE(browser_->wait_for("return at('left').textContent === 'Will be deleted in 118 s'"));
  browser_->run("at('more').click()");
  EXPECT_TRUE(browser_->wait_for("return at('left').textContent === 'Will be deleted in 120 s'"));
}

TEST_F(Screens, EveryGuidanceIsHeard) {
  test::ShownPage page;
  ASSERT_NO_FATAL_FAILURE(open(page));
  ASSERT_NO_FATAL_FAILURE(agree());
  for (const std::string_view code : kGuidanceNames) {
    if (code.empty()) continue;  // a bit without a code
    page.state("TRACKING", {std::string(code)});
    ASSERT_TRUE(shows(std::string(code)));
    EXPECT_EQ(browser_->run("return sounds.played[sounds.played.length - 1]"), code);
  }
  // The same again, after a while only.
  const auto count =
      browser_->run("sounds.say(sounds.last, sounds.lastAt + kRepeatMs - 1); return sounds.played.length");
  EXPECT_EQ(browser_->run("sounds.say(sounds.last, sounds.lastAt + kRepeatMs); return sounds.played.length"),
            count.get<int>() + 1);
  browser_->run("at('sound').click()");
  page.state("TRACKING", {"MOVING"});
  ASSERT_TRUE(shows("MOVING"));
  EXPECT_EQ(browser_->run("return sounds.played.length"), count.get<int>() + 1) << "switched off";
  EXPECT_EQ(browser_->run("return at('sound').getAttribute('aria-pressed')"), "false");
}

TEST_F(Screens, UnitsAndNumbersAreThoseOfTheRegion) {
  test::ShownPage page;
  page.page().permit();
  ASSERT_NO_FATAL_FAILURE(open(page));
  ASSERT_NO_FATAL_FAILURE(agree());
  page.measured(1000);
  const std::string chest =
      "return document.querySelector('tr[data-id=chest_girth]').cells[1].textContent + ' ' + "
      "at('unit-head').textContent";
  for (const auto& [region, text] : {std::pair{"en-US", "39.4 in"},
                                     {"en-GB", "100.0 cm"},
                                     {"de-DE", "100,0 cm"},
                                     {"fr-CA", "100,0 cm"},
                                     {"zh-CN", "100.0 厘米"}}) {
    ASSERT_NO_FATAL_FAILURE(open(page, std::string("?lang=") + region));
    ASSERT_TRUE(browser_->wait_for("return result !== null"));
    EXPECT_EQ(browser_->run(chest), text) << region;
  }
}

// Two tabs: a deletion in one holds in both, and a page left open over a restart shows nothing of before.
TEST_F(Screens, TwoTabsAndARestartShowNothingOfTheOneBefore) {
  auto page = std::make_unique<test::ShownPage>();
  const int port = page->port();
  ASSERT_NO_FATAL_FAILURE(open(*page));
  const std::string first = browser_->tab(), second = browser_->open_tab();
  browser_->show_tab(second);
  ASSERT_NO_FATAL_FAILURE(open(*page));
  ASSERT_NO_FATAL_FAILURE(agree());
  const std::string holds = "return document.documentElement.outerHTML.includes('91.1')";
  const std::string gone = "return !document.documentElement.outerHTML.includes('91.1') && result === null";
  page->measured(911);
  for (const std::string& tab : {second, first}) {
    browser_->show_tab(tab);
    ASSERT_TRUE(browser_->wait_for(holds));
  }
  browser_->run("at('delete').click()");
  for (const std::string& tab : {first, second}) {
    browser_->show_tab(tab);
    EXPECT_TRUE(shows("WELCOME"));
    EXPECT_EQ(browser_->run(gone), true);
  }
  ASSERT_NO_FATAL_FAILURE(agree());
  page->measured(911);
  ASSERT_TRUE(browser_->wait_for(holds));
  page.reset();
  ASSERT_TRUE(shows("SERVER_GONE"));
  EXPECT_EQ(browser_->run(gone), true) << "without the program there is no one to delete it";
  browser_->run("window.of_before = true");
  page = std::make_unique<test::ShownPage>(apps::LivePageSettings{}, port);
  const auto back = test::Clock::now();
  for (const std::string& tab : {second, first}) {
    browser_->show_tab(tab);
    EXPECT_TRUE(browser_->wait_for("return document.body.dataset.code === 'WELCOME'"));
    EXPECT_EQ(browser_->run(gone), true);
    EXPECT_EQ(browser_->run("return window.of_before === undefined"), true) << "the page of the new run";
  }
  EXPECT_LT(test::Clock::now() - back, std::chrono::seconds(3));
  browser_->show_tab(second);
  browser_->go("about:blank");
  browser_->show_tab(first);
}

// The program gets a touch of the page; without one the result goes from the screen, too.
TEST_F(Screens, ATouchKeepsTheResult) {
  apps::LivePageSettings settings;
  settings.visit.result_max = std::chrono::milliseconds(1200);
  test::ShownPage page(settings);
  ASSERT_NO_FATAL_FAILURE(open(page));
  ASSERT_NO_FATAL_FAILURE(agree());
  page.measured(911);
  const auto start = test::Clock::now();
  ASSERT_TRUE(shows("DONE"));
  while (test::Clock::now() - start < std::chrono::milliseconds(1800)) {
    browser_->run("touchedAt = 0; window.dispatchEvent(new Event('pointerdown'))");
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  EXPECT_EQ(browser_->run("return document.body.dataset.code"), "DONE");
  EXPECT_TRUE(shows("WELCOME"));
  EXPECT_GE(test::Clock::now() - start, std::chrono::milliseconds(2900));
  EXPECT_EQ(page.status_of("/result.json"), 404);
}

TEST_F(Screens, TheNinthScreenSaysThatThereIsNoRoom) {
  test::ShownPage page;
  std::vector<std::thread> others;
  for (int i = 0; i < apps::PageServer::kWatchersMax; ++i)
    others.emplace_back([c = std::make_shared<httplib::Client>(page.client())] {
      c->Get("/events", [](const char*, std::size_t) { return true; });
    });
  for (int i = 0; i < 400 && page.page().watchers() < apps::PageServer::kWatchersMax; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  browser_->go(page.url() + "/");
  EXPECT_TRUE(shows("TOO_MANY_SCREENS")) << shown();
  EXPECT_EQ(browser_->run(kAllFaults), Json::array());
  page.end();
  for (std::thread& other : others) other.join();
}

TEST_F(Screens, TheKeyboardIsEnough) {
  test::ShownPage page;
  ASSERT_NO_FATAL_FAILURE(open(page));
  // In the order of the page: languages, sound, consent; each shows that it has the focus.
  const Json order = browser_->run(R"js(
    return [...document.querySelectorAll('button, a, input, [tabindex]')].filter((e) => e.getClientRects().length > 0)
      .map((e) => [e.id || e.lang, e.tabIndex]);)js");
  Json wanted = Json::array();
  for (const char* id : {"en", "de", "es", "fr", "zh", "sound", "agree"}) wanted.push_back({id, 0});
  EXPECT_EQ(order, wanted);
  browser_->run("at('agree').focus()");
  browser_->devtools("Input.dispatchKeyEvent", {{"type", "keyDown"}, {"key", "Enter"}, {"text", "\r"}});
  browser_->devtools("Input.dispatchKeyEvent", {{"type", "keyUp"}, {"key", "Enter"}});
  EXPECT_TRUE(browser_->wait_for("return visit.state === 'MEASURING'"));
}

class Axe : public Screens {};

TEST_F(Axe, FindsNothingInAnyState) {
  const std::string axe = test::axe_script();
  if (axe.empty()) GTEST_SKIP() << "no axe-core: scripts/page-check";
  int looked = 0;
  for (const char* scheme : test::kColourSchemes) {
    test::prefer_colours(*browser_, scheme);
    through_all_states([&](const std::string& code) {
      EXPECT_EQ(test::axe_violations(*browser_, axe), Json::array()) << code << ", " << scheme;
      ++looked;
    });
  }
  EXPECT_EQ(looked, 2 * kStatesLooked);
}

}  // namespace
}  // namespace im2fit
