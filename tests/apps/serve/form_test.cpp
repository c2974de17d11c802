// SPDX-License-Identifier: Apache-2.0
// The optional form in Chromium: one screen, one touch to skip it, values by touch alone, a doubted fact corrected.
#include <gmock/gmock.h>

#include <string>
#include <thread>

#include "browser.h"
#include "shown_page.h"

namespace im2fit {
namespace {

using Json = nlohmann::json;

class Form : public testing::Test {
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
    apps::LivePageSettings settings;
    settings.visit.ask_facts = true;
    page_ = std::make_unique<test::ShownPage>(settings);
    browser_->resize(800, 1280);
  }
  // Up to the form of the first visit.
  void open(const std::string& language = "en-GB") {
    browser_->go(page_->url() + "/?lang=" + language);
    ASSERT_TRUE(browser_->wait_for("return typeof words !== 'undefined' && !!words.table && visit !== null"));
    browser_->run("at('agree').click()");
    ASSERT_TRUE(browser_->wait_for("return document.body.dataset.stage === 'facts'"));
  }
  static void click(const std::string& selector, int times = 1) {
    browser_->run("const e = document.querySelector('" + selector + "'); for (let i = 0; i < " +
                  std::to_string(times) + "; ++i) e.click()");
  }
  static std::string fact(const std::string& name, const std::string& part) {
    return ".fact[data-fact=" + name + "] " + part;
  }
  static void more(const std::string& name, int times) { click(fact(name, ".step.more"), times); }
  static void less(const std::string& name, int times) { click(fact(name, ".step.less"), times); }
  static std::string value_of(const std::string& name) {
    return browser_->run("return document.querySelector('" + fact(name, ".value") + "').textContent");
  }
  static std::string text_of(const std::string& id) { return browser_->run("return at('" + id + "').innerText"); }
  static bool measures() { return browser_->wait_for("return visit.state === 'MEASURING'"); }
  KnownFacts facts() { return page_->page().reported(1).facts; }

  std::unique_ptr<test::ShownPage> page_;
  static inline test::TestFolder* folder_ = nullptr;
  static inline test::Browser* browser_ = nullptr;
};

// In every language, both units, values and none: nothing to scroll, nothing cut off, nothing too small for a finger.
TEST_F(Form, IsOneScreenOnPhonesAndTablets) {
  ASSERT_NO_FATAL_FAILURE(open());
  constexpr std::pair<int, int> kScreens[] = {{360, 640}, {640, 360}, {390, 844}, {800, 1280}, {1280, 800}};
  int looked = 0;
  for (const auto& [width, height] : kScreens) {
    browser_->resize(width, height);
    for (const char* given : {"null", "start"}) {
      const Json faults = browser_->run(std::string("const given = '") + given + R"js(';
        const found = [], root = document.documentElement, before = words.language;
        for (const [fact, number] of Object.entries(kNumbers)) {
          facts.values[fact] = given === 'null' ? null : number.start;
        }
        for (const inches of [false, true]) for (const language of kLanguages) {
          words.inches = inches;
          words.language = language;
          showTexts();
          const say = (what) => found.push(`${language} ${inches}: ${what}`);
          if (root.scrollHeight > innerHeight) say(`${root.scrollHeight} high`);
          if (root.scrollWidth > innerWidth) say(`${root.scrollWidth} wide`);
          for (const e of document.querySelectorAll('#facts button, #facts label, nav button')) {
            const r = e.getBoundingClientRect();
            if (r.height < 44 || r.width < 44) say(`${e.textContent} is ${r.width} x ${r.height}`);
            if (r.bottom > innerHeight || r.right > innerWidth || r.top < 0) say(`${e.textContent} off the screen`);
            if (e.scrollWidth > e.clientWidth + 1) say(`${e.textContent} cut off`);
          }
          for (const e of document.querySelectorAll('#facts .name, #facts .segments span')) {
            if (e.scrollWidth > e.clientWidth + 1) say(`${e.textContent} cut off`);
          }
        }
        words.inches = false;
        words.language = before;
        showTexts();
        return found;)js");
      EXPECT_EQ(faults, Json::array()) << width << "x" << height << ", " << given;
      ++looked;
    }
  }
  EXPECT_EQ(looked, 10);
  EXPECT_EQ(browser_->run("return failures"), Json::array());
}

TEST_F(Form, OneTouchSkipsIt) {
  ASSERT_NO_FATAL_FAILURE(open());
  more("weight", 3);
  click("#facts-skip");
  ASSERT_TRUE(measures());
  EXPECT_GT(page_->page().reported(1).count, 0U);
  EXPECT_EQ(facts().given(), 0U) << "what was touched before is not sent";
}

// A value that nobody touched is not a fact, whatever stands there to begin with.
TEST_F(Form, GoOnSendsTouchedValuesAlone) {
  ASSERT_NO_FATAL_FAILURE(open());
  EXPECT_EQ(value_of("stature"), "not given");
  more("weight", 3);
  EXPECT_EQ(value_of("weight"), "72 kg") << "the first touch takes the start value";
  more("age", 1);
  click(fact("age", ".value"));
  EXPECT_EQ(value_of("age"), "not given") << "taken back";
  click("#facts-scale");
  click("#facts-go");
  ASSERT_TRUE(measures());
  EXPECT_EQ(facts().given(), bit_of(KnownFact::weight));
  EXPECT_FLOAT_EQ(facts().weight_kg.value, 72);
  EXPECT_FLOAT_EQ(facts().weight_kg.sd, kScaleSdKg);
  // Nothing of it stays on the page.
  EXPECT_EQ(browser_->run("return [facts.given(), localStorage.length, sessionStorage.length, document.cookie]"),
            Json::parse(R"([{}, 0, 0, ""])"));
}

TEST_F(Form, TakesFeetAndPounds) {
  ASSERT_NO_FATAL_FAILURE(open());
  click("#facts-unit");
  more("stature", 1);
  EXPECT_EQ(value_of("stature"), "5′ 7″");
  more("stature", 4);
  EXPECT_EQ(value_of("stature"), "5′ 11″");
  less("weight", 5);
  EXPECT_EQ(value_of("weight"), "150 lb");
  click("input[value=man]");
  more("age", 1);
  less("age", 4);
  EXPECT_EQ(value_of("age"), "31 years");
  click("#facts-go");
  ASSERT_TRUE(measures());
  EXPECT_FLOAT_EQ(facts().stature_mm.value, 71 * 25.4F);
  EXPECT_FLOAT_EQ(facts().weight_kg.value, 150 * 0.45359237F);
  EXPECT_FLOAT_EQ(facts().weight_kg.sd, kStatedWeightSdKg);
  EXPECT_FLOAT_EQ(facts().age_years.value, 31.5F);
  EXPECT_EQ(facts().sex, KnownSex::man);
}

TEST_F(Form, AButtonHeldDownGoesOn) {
  ASSERT_NO_FATAL_FAILURE(open());
  const Json at = browser_->run("const r = document.querySelector('" + fact("weight", ".step.more") +
                                "').getBoundingClientRect(); return [r.x + r.width / 2, r.y + r.height / 2]");
  const auto mouse = [&](const char* type) {
    browser_->devtools("Input.dispatchMouseEvent",
                       {{"type", type}, {"x", at[0]}, {"y", at[1]}, {"button", "left"}, {"clickCount", 1}});
  };
  mouse("mousePressed");
  EXPECT_TRUE(browser_->wait_for("return facts.values.weight > 78"));
  mouse("mouseReleased");
  const Json value = browser_->run("return facts.values.weight");
  std::this_thread::sleep_for(std::chrono::milliseconds(600));
  EXPECT_EQ(browser_->run("return facts.values.weight"), value) << "released";
}

// A weight that does not fit: said kindly, corrected by one touch and without a new measurement.
TEST_F(Form, ADoubtedWeightIsCorrected) {
  ASSERT_NO_FATAL_FAILURE(open());
  click("#facts-skip");
  ASSERT_TRUE(measures());
  apps::Json known = {{"given",
                       {{"stature", {{"value", 1720}, {"sd", 20}, {"unit", "mm"}}},
                        {"weight", {{"value", 130}, {"sd", 0.7}, {"unit", "kg"}}},
                        {"age", {{"value", 35.5}, {"sd", 0.5}, {"unit", "years"}}},
                        {"sex", "woman"}}},
                      {"used", {"stature", "sex"}},
                      {"doubted", {"weight"}}};
  page_->measured(987.6, "", known);
  ASSERT_TRUE(browser_->wait_for("return document.body.dataset.stage === 'result'"));
  EXPECT_THAT(text_of("told"), testing::HasSubstr("Taken into account: your height and your sex."));
  EXPECT_THAT(text_of("told"), testing::HasSubstr("Your weight does not fit what the camera saw. Please check it."));
  click("#facts-open");
  EXPECT_EQ(browser_->run("return document.body.dataset.stage"), "facts");
  EXPECT_EQ(value_of("weight"), "130 kg") << "what was given stands there";
  EXPECT_EQ(value_of("age"), "35 years");
  EXPECT_EQ(browser_->run("return [facts.scale, facts.sex, document.activeElement.id]"),
            Json::parse(R"([true, "woman", "facts"])"));
  EXPECT_THAT(text_of("facts-why"), testing::HasSubstr("Your weight does not fit"));
  click("#facts-skip");
  EXPECT_EQ(browser_->run("return document.body.dataset.stage"), "result") << "back, and nothing is sent";
  EXPECT_EQ(facts().given(), 0U);
  click("#facts-open");
  less("weight", 60);
  click("#facts-go");
  ASSERT_TRUE(browser_->wait_for("return at('told').innerText.includes('calculating again')"));
  EXPECT_FLOAT_EQ(facts().weight_kg.value, 70);
  EXPECT_FLOAT_EQ(facts().stature_mm.value, 1720);
  known["used"] = {"stature", "weight", "sex"};
  known["doubted"] = apps::Json::array();
  page_->measured(911, "", known, true);
  ASSERT_TRUE(browser_->wait_for("return at('told').innerText.includes('your weight')"));
  EXPECT_EQ(text_of("told").find("does not fit"), std::string::npos);
  EXPECT_EQ(browser_->run("return document.querySelector('tr[data-id=chest_girth]').cells[1].textContent"), "91.1");
  click("#delete");
  ASSERT_TRUE(browser_->wait_for("return document.body.dataset.code === 'WELCOME'"));
  EXPECT_EQ(browser_->run("return [facts.given(), facts.result, at('told').innerText]"),
            Json::parse(R"([{}, null, ""])"));
  EXPECT_EQ(browser_->run("return failures"), Json::array());
}

// Without the option nothing of it is to be seen.
TEST_F(Form, WithoutTheOptionThereIsNone) {
  page_ = std::make_unique<test::ShownPage>();
  browser_->go(page_->url() + "/?lang=en");
  ASSERT_TRUE(browser_->wait_for("return typeof words !== 'undefined' && !!words.table && visit !== null"));
  browser_->run("at('agree').click()");
  ASSERT_TRUE(measures());
  page_->measured(987.6);
  ASSERT_TRUE(browser_->wait_for("return document.body.dataset.stage === 'result'"));
  EXPECT_EQ(text_of("told"), "");
}

}  // namespace
}  // namespace im2fit
