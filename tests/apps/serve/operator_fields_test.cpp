// SPDX-License-Identifier: Apache-2.0
// The operator's page in Chromium, over a page that the test feeds: the region's fields, and why no person is seen.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "browser.h"
#include "depth_folder.h"
#include "shown_page.h"

namespace im2fit {
namespace {

using Json = nlohmann::json;

class OperatorFields : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (!test::Browser::installed()) return;
    profile_ = new test::TestFolder;
    browser_ = new test::Browser(profile_->path(""), {"--lang=en-GB"});
  }
  static void TearDownTestSuite() {
    delete std::exchange(browser_, nullptr);
    delete std::exchange(profile_, nullptr);
  }
  void SetUp() override {
    if (browser_ == nullptr) GTEST_SKIP() << "no chromium: scripts/deps browser";
    ASSERT_TRUE(browser_->ready()) << browser_->messages();
    browser_->resize(1280, 800);
  }
  // Signed in, with a camera.
  void open(const std::string& region = "", const std::string& language = "en", const std::string& statistics = "") {
    page_.reset();
    apps::LivePageSettings settings;
    settings.desk.emplace();
    settings.desk->root = folder_.path("sessions");
    settings.desk->settings.region = region;
    settings.statistics_path = statistics;
    page_ = std::make_unique<test::ShownPage>(settings);
    page_->page().use_source({}, {}, diagnose_);
    browser_->go(page_->url() + "/operator?lang=" + language);
    ASSERT_TRUE(browser_->wait_for("return words.table && document.activeElement === at('password')"));
    browser_->run(std::string("at('password').value = '") + test::ShownPage::kPassword +
                  "'; at('sign-in').requestSubmit()");
    ASSERT_TRUE(browser_->wait_for("return document.body.dataset.phase === 'IDLE'"));
  }
  // Fills in the fields and presses the button; what the page says to it.
  static std::string fault_of(const std::vector<std::string>& edges) {
    const char* ids[] = {"x0", "z0", "x1", "z1"};
    for (std::size_t i = 0; i < 4; ++i) browser_->run(std::string("at('") + ids[i] + "').value = '" + edges[i] + "'");
    return browser_->run("at('region-set').click(); return at('region-fault').textContent");
  }
  static bool now_says(const std::string& text) {
    return browser_->wait_for("return at('region-now').textContent === '" + text + "'");
  }
  static hal::SourceInfo camera() {
    hal::SourceInfo source;
    source.intrinsics = {320, 240, 290, 290, 159.5F, 119.5F};
    return source;
  }
  // A frame of a level camera 1 m above the floor, with a crate in the middle, 2 m away.
  void see_floor() {
    page_->begin_person();
    std::vector<std::uint16_t> pixels(320 * 240);
    for (int v = 0; v < 240; ++v)
      for (int u = 0; u < 320; ++u) {
        const float down = (static_cast<float>(v) - 119.5F) / 290, aside = (static_cast<float>(u) - 159.5F) / 290;
        float z = down > 0.18F ? 1000 / down : 5500;
        if (z > 2000 && std::fabs(aside) < 0.15F && down > 0.25F) z = 2000;
        pixels[static_cast<std::size_t>(v * 320 + u)] = static_cast<std::uint16_t>(z);
      }
    EngineResult result;
    result.floor = {true, {0, -1, 0}, 1000};
    page_->page().see({DepthView(pixels.data(), 320, 240), {}, {}, {}, result});
  }
  const test::TestFolder folder_;
  apps::DiagnosePicture diagnose_;
  std::unique_ptr<test::ShownPage> page_;
  static inline test::TestFolder* profile_ = nullptr;
  static inline test::Browser* browser_ = nullptr;
};

TEST_F(OperatorFields, ARegionIsSetInMetresAndNonsenseIsNamed) {
  ASSERT_NO_FATAL_FAILURE(open());
  EXPECT_TRUE(now_says("Measuring everywhere."));
  EXPECT_EQ(fault_of({"-0.6", "1.5", "", "3"}), "Fill in all four edges, or none");
  EXPECT_EQ(fault_of({"-0.6", "one", "0.6", "3"}), "Nearest, m: one is not a number");
  EXPECT_EQ(fault_of({"-0.6", "1.5", "0.6", "3e0"}), "Farthest, m: 3e0 is not a number");
  EXPECT_EQ(fault_of({"-0.6", "1.5", "60", "3"}), "Right edge, m: at most 20 m from the camera");
  EXPECT_EQ(fault_of({"0.6", "1.5", "-0.6", "3"}), "The left edge must be less than the right edge");
  EXPECT_EQ(fault_of({"-0.6", "3", "0.6", "3"}), "Nearest must be less than farthest");
  EXPECT_EQ(browser_->run("return document.activeElement.id"), "z0");
  EXPECT_FALSE(page_->page().region().region);
  EXPECT_EQ(fault_of({"-0,6", "1.5", "+0.6", "3"}), "Right edge, m: +0.6 is not a number");
  EXPECT_EQ(fault_of({"-0,6", "1,505", ".6", "3"}), "") << "a decimal comma is read";
  EXPECT_TRUE(now_says("Measuring only in this rectangle."));
  EXPECT_EQ(page_->page().region().region->z0_mm, 1505);
  ASSERT_NO_FATAL_FAILURE(open("", "de"));
  EXPECT_TRUE(browser_->wait_for("return at('x0').value === '-0,6' && at('z0').value === '1,505'"))
      << "kept, in the operator's own way of writing it";
  EXPECT_EQ(fault_of({"", "", "", ""}), "");
  EXPECT_TRUE(now_says("Gemessen wird überall."));
  EXPECT_FALSE(page_->page().region().region);
  EXPECT_EQ(browser_->run("return failures"), Json::array());
}

// The floor as the engine's frames show it, and a rectangle dragged on it with the mouse.
TEST_F(OperatorFields, ARegionIsDrawnOnTheFloorFromAbove) {
  ASSERT_NO_FATAL_FAILURE(open());
  EXPECT_TRUE(browser_->wait_for("return at('plan-help').textContent === of('region.no_plan')"));
  page_->page().use_source(camera(), {}, diagnose_);
  ASSERT_EQ(page_->post("/consent", page_->visit()), 200);
  see_floor();
  ASSERT_TRUE(
      browser_->wait_for("return document.body.dataset.plan && at('plan-help').textContent === of('region.draw')"));
  // The crate that the camera sees, in the middle 2 m away: brighter than the floor before it.
  const auto grey = [&](double x, double z) {
    return browser_
        ->run("const [x, z] = [" + std::to_string(x) + ", " + std::to_string(z) +
              "]; return at('plan').getContext('2d').getImageData((x + 3) * 120, 720 - z * 120, 1, 1).data[0]")
        .get<int>();
  };
  EXPECT_GT(grey(0.27, 2.02), grey(0.9, 2.83) + 40);
  EXPECT_GT(grey(0.9, 2.83), 40);
  EXPECT_EQ(grey(-2.6, 5.6), 0) << "nothing is seen there";
  // A picture that is cut off on its way is asked for again.
  browser_->run(
      "window.kept = get; window.cut = 0; window.unhandled = 0; "
      "window.addEventListener('unhandledrejection', () => { ++unhandled; }); "
      "get = async (path) => path === '/operator/plan' && cut++ === 0 ? "
      "{blob: () => Promise.reject(new Error('cut off'))} : kept(path); "
      "planSeen = ''");
  EXPECT_TRUE(browser_->wait_for("return cut > 1 && !!document.body.dataset.plan"));
  EXPECT_EQ(browser_->run("const count = unhandled; get = kept; return count"), 0);
  browser_->run("at('plan').scrollIntoView({block: 'center'})");
  const auto mouse = [&](const char* kind, double x, double z) {
    const Json box =
        browser_->run("const b = at('plan').getBoundingClientRect(); return [b.left, b.top, b.width, b.height]");
    browser_->devtools("Input.dispatchMouseEvent", {{"type", kind},
                                                    {"x", box[0].get<double>() + (x + 3) / 6 * box[2].get<double>()},
                                                    {"y", box[1].get<double>() + (1 - z / 6) * box[3].get<double>()},
                                                    {"button", "left"},
                                                    {"buttons", 1},
                                                    {"clickCount", 1}});
  };
  const auto drag = [&](double x0, double z0, double x1, double z1) {
    mouse("mousePressed", x0, z0);
    mouse("mouseMoved", (x0 + x1) / 2, (z0 + z1) / 2);
    mouse("mouseMoved", x1, z1);
    mouse("mouseReleased", x1, z1);
    return browser_->run("return kEdges.map((id) => at(id).value)");
  };
  EXPECT_EQ(drag(-0.61, 3.01, 0.59, 1.52), Json({"-0.6", "1.5", "0.6", "3"})) << "any corner first; steps of 50 mm";
  EXPECT_GT(grey(0.5, 2.9), grey(0.7, 2.9)) << "the rectangle is shown";
  mouse("mouseMoved", 2, 5);
  EXPECT_EQ(browser_->run("return at('x1').value"), "0.6") << "the button is up";
  EXPECT_EQ(drag(1, 1, 1.04, 2), Json({"-0.6", "1.5", "0.6", "3"})) << "less than a rectangle";
  EXPECT_FALSE(page_->page().region().region) << "Set sets it";
  browser_->run("at('region-set').click()");
  EXPECT_TRUE(now_says("Measuring only in this rectangle."));
  const auto region = page_->page().region().region;
  ASSERT_TRUE(region);
  EXPECT_EQ(region->x0_mm, -600);
  EXPECT_EQ(region->z1_mm, 3000);
  EXPECT_EQ(drag(-2.9, 2, 5, 9), Json({"-2.9", "2", "3", "6"})) << "as far as the plan goes";
  // Numbers move the rectangle, too.
  const int with = grey(0.53, 2.93);
  browser_->run("at('x1').value = '-2.5'; at('x1').dispatchEvent(new Event('input'))");
  EXPECT_LT(grey(0.53, 2.93), with - 10);
  for (const auto& [width, height] : {std::pair{390, 844}, {1280, 800}}) {
    browser_->resize(width, height);
    EXPECT_EQ(browser_->run("return document.documentElement.scrollWidth > innerWidth"), false);
  }
  // Of the command line: shown, not drawn.
  ASSERT_NO_FATAL_FAILURE(open("-0.5,1,0.5,2"));
  EXPECT_TRUE(browser_->wait_for("return at('plan-help').textContent === of('region.plan_fixed')"));
  browser_->run("at('plan').scrollIntoView({block: 'center'})");
  EXPECT_EQ(drag(-1, 1, 1, 3), Json({"-0.5", "1", "0.5", "2"}));
  EXPECT_EQ(browser_->run("return failures"), Json::array());
}

// The whole way: visits that end in each manner, the file, and the operator's page.
TEST_F(OperatorFields, VisitsAreCountedWithoutPersons) {
  const std::string path = folder_.path("visits.csv");
  ASSERT_NO_FATAL_FAILURE(open("", "en", path));
  EXPECT_EQ(browser_->run("return at('statistics-note').textContent"), "No visits yet");
  const auto agree = [&] { ASSERT_EQ(page_->post("/consent", page_->visit()), 200); };
  const auto see = [&](GuidanceSet guidance) {
    std::vector<std::uint16_t> pixels(64 * 48, 2000);
    page_->begin_person();
    EngineResult result;
    result.guidance = guidance;
    page_->page().see({DepthView(pixels.data(), 64, 48), {}, {}, {}, result});
  };
  agree();
  see(static_cast<GuidanceSet>(Guidance::moving));
  page_->measured(987);
  page_->measured(990, "", nullptr, true);  // a corrected fact is no other person
  EXPECT_EQ(page_->post("/delete", page_->visit()), 200);
  agree();
  for (int i = 0; i < 3; ++i) see(static_cast<GuidanceSet>(Guidance::no_person));
  for (int i = 0; i < 2; ++i) see(static_cast<GuidanceSet>(Guidance::moving));
  see(static_cast<GuidanceSet>(Guidance::too_near));
  EXPECT_EQ(page_->post("/delete", page_->visit()), 200);
  agree();
  see(static_cast<GuidanceSet>(Guidance::no_person));
  EXPECT_EQ(page_->post("/delete", page_->visit()), 200);
  EXPECT_EQ(page_->post("/delete", page_->visit()), 200) << "nobody had agreed";
  // One that the operator records is no customer's.
  ASSERT_EQ(page_->post_operator("/operator/begin", {{"language", "en"}, {"version", "1"}}).first, 200);
  page_->measured(987);
  ASSERT_EQ(page_->post_operator("/operator/discard", Json::object()).first, 200);
  const std::string day = apps::local_day(), month = day.substr(0, 7);
  const std::string expected = "period,what,name,count\n" + month + ",not_measured,LEFT,1\n" + month +
                               ",not_measured,MOVING,1\n" + month + ",size,M,1\n" + day + ",measured,,1\n" + day +
                               ",visits,,3\n";
  EXPECT_EQ(page_->operator_client().Get("/operator/statistics.csv")->body, expected);
  EXPECT_EQ(page_->status_of("/operator/statistics.csv"), 401) << "for the operator alone";
  browser_->run("loadStatistics()");
  EXPECT_TRUE(browser_->wait_for("return at('days').tBodies[0].innerText.replace(/\\s+/g, ' ').trim() === '" + day +
                                 " 3 1'"));
  EXPECT_EQ(browser_->run("return at('statistics-sizes').textContent"), "Sizes, " + month + ": M 1");
  EXPECT_EQ(browser_->run("return at('statistics-reasons').textContent"),
            "Not measured, " + month + ": left early 1 · Stand still 1");
  EXPECT_EQ(browser_->run("return [at('export').hidden, at('export').getAttribute('href')]"),
            (Json{false, "/operator/statistics.csv"}));
  for (const auto& [width, height] : {std::pair{390, 3000}, {1280, 1900}}) {
    browser_->resize(width, height);
    EXPECT_LE(browser_->run("return document.documentElement.scrollWidth").get<int>(), width);
    if (const char* kept = std::getenv("IM2FIT_SCREENSHOTS"))
      test::write_text(std::string(kept) + "/statistics-" + std::to_string(width) + ".png", browser_->screenshot());
  }
  if (const std::string axe = test::axe_script(); !axe.empty()) {
    EXPECT_EQ(test::axe_violations(*browser_, axe), Json::array());
  }
  EXPECT_EQ(browser_->run("return failures"), Json::array());
  page_.reset();
  EXPECT_EQ(test::read_text(path), expected);
  // The next run goes on, and the customer is told that counts remain.
  ASSERT_NO_FATAL_FAILURE(open("", "de", path));
  EXPECT_THAT(browser_->run("return at('statistics-reasons').textContent").get<std::string>(),
              testing::HasSubstr("früh gegangen 1"));
  browser_->go(page_->url() + "/?lang=en");
  EXPECT_TRUE(
      browser_->wait_for("return typeof words !== 'undefined' && !!words.table && "
                         "at('consent-points').innerText.includes('Counts of all people')"));
  ASSERT_NO_FATAL_FAILURE(open());
  EXPECT_THAT(browser_->run("return at('statistics-note').textContent").get<std::string>(),
              testing::HasSubstr("--statistics FILE"));
  browser_->go(page_->url() + "/?lang=en");
  EXPECT_TRUE(
      browser_->wait_for("return typeof words !== 'undefined' && !!words.table && "
                         "at('consent-points').innerText.length > 100"));
  EXPECT_EQ(browser_->run("return at('consent-points').innerText.includes('Counts of all people')"), false);
}

TEST_F(OperatorFields, TheCommandLinesRegionIsShown) {
  ASSERT_NO_FATAL_FAILURE(open("-1,1,1,4"));
  EXPECT_TRUE(
      now_says("Measuring only in this rectangle. Given when the program was started; it cannot be changed here."));
  EXPECT_EQ(browser_->run("return [at('z1').value, at('z1').readOnly, at('region-set').hidden]"),
            (Json{"4", true, true}));
}

TEST_F(OperatorFields, WhyNoPersonIsSeenIsToldWithTheOptionThatMendsIt) {
  hal::DepthDiagnosis found{hal::DiagnosisCode::unit, 0.1F, 0, "try --unit 0.1"};
  diagnose_ = [&](DepthView) { return found; };
  ASSERT_NO_FATAL_FAILURE(open());
  EXPECT_EQ(browser_->run("return at('diagnosis').hidden"), true);
  ASSERT_EQ(page_->post("/consent", page_->visit()), 200);
  std::vector<std::uint16_t> pixels(64 * 48, 4000);
  std::int64_t seconds = 0;
  const auto empty = [&] {
    page_->begin_person();
    EngineResult result;
    result.guidance = static_cast<GuidanceSet>(Guidance::no_person);
    hal::FrameInfo info;
    info.host_ns = (seconds += 10) * 1'000'000'000;
    page_->page().see({DepthView(pixels.data(), 64, 48), {}, info, {}, result});
  };
  empty();
  for (const auto& [diagnosis, told] :
       {std::pair{found, "The values have another unit than millimetres. Start with --unit 0.1."},
        {hal::DepthDiagnosis{hal::DiagnosisCode::unit, 0, 0, "see --unit"},
         "The values have another unit than millimetres. See --unit."},
        {hal::DepthDiagnosis{hal::DiagnosisCode::rotated, 0, 270, "try --rotate 270"},
         "The picture looks turned. Start with --rotate 270."}}) {
    found = diagnosis;
    empty();
    EXPECT_TRUE(browser_->wait_for("return !at('diagnosis').hidden && at('diagnosis-text').textContent === '" +
                                   std::string(told) + "'"))
        << told;
    for (const auto& [width, height] : {std::pair{390, 844}, {1280, 1400}}) {
      browser_->resize(width, height);
      EXPECT_LE(browser_->run("return document.documentElement.scrollWidth").get<int>(), width);
      if (const char* kept = std::getenv("IM2FIT_SCREENSHOTS"))
        test::write_text(std::string(kept) + "/operator-" + std::to_string(width) + ".png", browser_->screenshot());
    }
  }
  browser_->run("words.language = 'zh'; showTexts()");
  EXPECT_TRUE(browser_->wait_for("return at('diagnosis-text').textContent.includes('--rotate 270 启动')"));
  EXPECT_EQ(browser_->run("return failures"), Json::array());
}

}  // namespace
}  // namespace im2fit
