// SPDX-License-Identifier: Apache-2.0
// The whole way in Chromium: a person in a recording, the operator's form, a session, and `im2fit sessions measure`.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <regex>

#include "apps/sessions/store.h"
#include "browser.h"
#include "private_files.h"
#include "run_program.h"
#include "two_people.h"

namespace im2fit {
namespace {

using Json = nlohmann::json;

// The faults of the page as it stands, in every language.
constexpr const char* kFaults = R"js(
const found = [], before = words.language;
for (const language of kLanguages) {
  words.language = language;
  showTexts();
  const say = (what) => found.push(`${language}: ${what}`);
  const seen = (e) => e.getClientRects().length > 0;
  if (document.documentElement.lang !== language) say('lang');
  if (document.documentElement.scrollWidth > innerWidth) say(`${document.documentElement.scrollWidth} wide`);
  if (document.body.innerText.includes('undefined')) say('a text is missing');
  for (const e of document.querySelectorAll('[data-text]')) if (!e.textContent) say(`${e.dataset.text} says nothing`);
  for (const e of document.querySelectorAll('button, input, select, textarea')) {
    const r = e.getBoundingClientRect();
    if (seen(e) && (r.height < 44 || r.width < 44)) say(`${e.id || e.textContent} is ${r.width} x ${r.height}`);
    if (e.matches('input, select, textarea') && !e.labels.length && !e.getAttribute('aria-label')) say('no label');
  }
  const picture = at('sight').getBoundingClientRect(), title = document.querySelector('h1').getBoundingClientRect();
  if (seen(at('sight')) && picture.top < title.bottom) say('the picture covers the title');
}
words.language = before;
showTexts();
return found;
)js";

class OperatorPage : public testing::Test {
 protected:
  void SetUp() override {
    if (!test::Browser::installed()) GTEST_SKIP() << "no chromium: scripts/deps browser";
    if (!test::have_data()) GTEST_SKIP() << "no body, tracker or index file";
    test::write_two_people(folder_.path("two"), 60);
    test::write_text(folder_.path("password"), "correct horse battery\n");
    std::filesystem::permissions(folder_.path("password"), std::filesystem::perms::owner_read);
  }
  // Serves the recording; the address printed.
  std::string serve(const std::vector<std::string>& more) {
    std::vector<std::string> command = {IM2FIT_PROGRAM,
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
                                        "--port",
                                        "0",
                                        "--operator",
                                        "--operator-password-file",
                                        folder_.path("password"),
                                        "--sessions",
                                        root_};
    command.insert(command.end(), more.begin(), more.end());
    run_ = std::make_unique<test::BackgroundRun>(command, std::vector<std::pair<std::string, std::string>>{},
                                                 folder_.path("stderr"));
    const std::regex address("open (http://[^/]+)/");
    std::smatch found;
    for (const auto end = test::Clock::now() + test::kPatience; test::Clock::now() < end;) {
      const std::string printed = run_->messages();
      if (std::regex_search(printed, found, address)) return found[1];
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    ADD_FAILURE() << run_->messages();
    return "";
  }
  static void sign_in(test::Browser& browser) {
    EXPECT_TRUE(browser.wait_for("return words.table && document.activeElement === at('password')"));
    browser.run("at('password').value = 'correct horse battery'; at('sign-in').requestSubmit()");
  }
  const test::TestFolder folder_;
  const std::string root_ = folder_.path("sessions");
  std::unique_ptr<test::BackgroundRun> run_;
};

TEST_F(OperatorPage, FromAPersonToASessionThatIsMeasuredAgain) {
  const std::string url = serve({"--site", "shop 3"});
  test::Browser browser(folder_.path(""), {"--lang=en-GB"});
  ASSERT_TRUE(browser.ready()) << browser.messages();
  browser.go(url + "/operator?lang=en");
  ASSERT_TRUE(browser.wait_for("return words.table && document.activeElement === at('password')"));
  EXPECT_EQ(browser.run("return document.body.dataset.phase"), "SIGNED_OUT");
  browser.resize(390, 844);
  EXPECT_EQ(browser.run(kFaults), Json::array());
  browser.run("at('password').value = 'wrong'; at('sign-in').requestSubmit()");
  EXPECT_TRUE(browser.wait_for("return at('trouble').textContent === of('sign_in.wrong')"));
  sign_in(browser);
  EXPECT_EQ(browser.run("return document.cookie"), "") << "scripts do not get the session";
  ASSERT_TRUE(browser.wait_for("return document.body.dataset.phase === 'IDLE'")) << run_->messages();
  browser.run("at('begin').click()");
  // A joint's confidence is there while the person is in view.
  EXPECT_TRUE(browser.wait_for("return /^[0-9]+ %$/.test(at('joints').tBodies[0].rows[0].cells[1].textContent)"));
  EXPECT_EQ(browser.run("return at('joints').tBodies[0].rows.length"), 15);
  EXPECT_EQ(browser.run("return at('joints').tBodies[0].rows[4].cells[0].textContent"), "Right shoulder");
  EXPECT_EQ(
      browser.run("return kLanguages.flatMap((l) => joints.filter((j) => !words.tables[l].operator.joints[j]))"),
      Json::array());
  ASSERT_TRUE(browser.wait_for("return document.body.dataset.phase === 'MEASURED'"))
      << browser.run("return at('trouble').textContent");
  browser.run(R"js(
    at('person').value = 'P017'; at('height').value = '165,5'; at('weight').value = '61.2'; at('gender').value = 'female';
    at('clothing').value = 'bare'; at('add').value = 'waist_girth'; at('add').dispatchEvent(new Event('change'));
    const [, first, second] = at('readings').children[0].children;
    first.value = '80.1'; second.value = '80.6';)js");
  for (const auto& [width, height] : {std::pair{390, 844}, {800, 1280}, {1280, 800}}) {
    browser.resize(width, height);
    EXPECT_EQ(browser.run(kFaults), Json::array()) << width << "x" << height;
  }
  browser.run("at('form').requestSubmit()");
  ASSERT_TRUE(browser.wait_for("return sessions.length === 1")) << browser.run("return at('trouble').textContent");
  EXPECT_EQ(browser.run("return at('person').value"), "") << "the form is empty for the next person";
  EXPECT_EQ(browser.run("return failures"), Json::array());
  const std::string id = browser.run("return sessions[0].id");
  const auto record = sessions::read(root_, id);
  ASSERT_TRUE(record) << record.error().message;
  EXPECT_EQ(record->truth.height_mm, 1655);
  EXPECT_EQ(record->truth.tape.at("waist_girth").first, 801);
  EXPECT_EQ(record->site, "shop 3");
  EXPECT_THAT(test::all_files_in(root_ + "/" + id),
              testing::IsSupersetOf({"session.json", "result.json", "joints.csv", "recording/000000.png"}));
  EXPECT_THAT(test::readable_by_others(root_), testing::IsEmpty());

  const test::Run again =
      test::run_program({IM2FIT_PROGRAM, "sessions", "measure", id, "--root", root_, "--json", "--body",
                         test::body_path(), "--tracker", test::tracker_path(), "--index", test::index_path()});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  const Json both = Json::parse(again.out);
  for (const char* field : {"measurements", "joints", "paper", "body"})
    EXPECT_EQ(both["now"][field], both["then"][field]) << field << ": the recording holds what the engine saw";

  // Measured again, the session's region holds: nobody stands within this one.
  const std::string session = root_ + "/" + id + "/session.json", whole = test::read_text(session);
  Json elsewhere = Json::parse(whole);
  elsewhere["settings"]["region"] = "6,6,7,7";
  test::write_text(session, elsewhere.dump());
  const test::Run nobody =
      test::run_program({IM2FIT_PROGRAM, "sessions", "measure", id, "--root", root_, "--json", "--body",
                         test::body_path(), "--tracker", test::tracker_path(), "--index", test::index_path()});
  const Json now = Json::parse(nobody.out, nullptr, false)["now"];
  EXPECT_NE(now["state"], "MEASURED") << now.dump().substr(0, 500);
  test::write_text(session, whole);

  browser.run("document.querySelector('#list button:nth-of-type(2)').click()");  // replay
  EXPECT_TRUE(browser.wait_for("return Number(document.body.dataset.replayed) >= 3"));
  browser.run("const b = document.querySelector('#list button:last-of-type'); b.click(); b.click()");
  EXPECT_TRUE(browser.wait_for("return sessions.length === 0"));
  EXPECT_FALSE(sessions::read(root_, id));
  browser.run("at('sign-out').click()");
  EXPECT_TRUE(browser.wait_for("return document.body.dataset.phase === 'SIGNED_OUT'"));
  browser.go(url + "/operator?lang=en");
  EXPECT_TRUE(browser.wait_for("return words.table && document.activeElement === at('password')"));
  EXPECT_EQ(browser.run("return token"), "") << "the browser has nothing left of it";
}

class AxeOperator : public OperatorPage {};

TEST_F(AxeOperator, FindsNothingBeforeAndAfterAPerson) {
  const std::string axe = test::axe_script();
  if (axe.empty()) GTEST_SKIP() << "no axe-core: scripts/page-check";
  const std::string url = serve({});
  test::Browser browser(folder_.path(""), {"--lang=en-GB"});
  ASSERT_TRUE(browser.ready()) << browser.messages();
  browser.go(url + "/operator?lang=en");
  ASSERT_TRUE(browser.wait_for("return words.table && document.activeElement === at('password')"));
  for (const char* scheme : test::kColourSchemes) {
    test::prefer_colours(browser, scheme);
    EXPECT_EQ(test::axe_violations(browser, axe), Json::array()) << "signing in, " << scheme;
  }
  sign_in(browser);
  ASSERT_TRUE(browser.wait_for("return document.body.dataset.phase === 'IDLE'")) << run_->messages();
  for (const char* scheme : test::kColourSchemes) {
    test::prefer_colours(browser, scheme);
    EXPECT_EQ(test::axe_violations(browser, axe), Json::array()) << "before, " << scheme;
  }
  browser.run("at('begin').click(); addReading('waist_girth')");
  ASSERT_TRUE(browser.wait_for("return document.body.dataset.phase === 'MEASURED'"));
  for (const char* scheme : test::kColourSchemes) {
    test::prefer_colours(browser, scheme);
    EXPECT_EQ(test::axe_violations(browser, axe), Json::array()) << "after, " << scheme;
  }
}

// The region reaches the engine: a person outside of it is not measured, and is once it is taken away.
TEST_F(OperatorPage, PeopleAreMeasuredWhereTheOperatorSays) {
  const std::string url = serve({});
  test::Browser browser(folder_.path(""), {"--lang=en-GB"});
  ASSERT_TRUE(browser.ready()) << browser.messages();
  browser.go(url + "/operator?lang=en");
  sign_in(browser);
  ASSERT_TRUE(browser.wait_for("return document.body.dataset.phase === 'IDLE'")) << run_->messages();
  browser.run(R"js(
    window.outside = 0;
    stream.addEventListener('message', (message) => {
      const event = JSON.parse(message.data), left = (event.guidance_details || {}).left_out || [];
      window.outside += left.some((one) => one.reason === 'outside');
    });
    at('x0').value = '6'; at('x1').value = '7'; at('z0').value = '6'; at('z1').value = '7'; at('region-set').click();)js");
  ASSERT_TRUE(browser.wait_for("return at('region-now').textContent === of('region.held')"))
      << browser.run("return at('trouble').textContent");
  browser.run("at('begin').click()");
  EXPECT_TRUE(browser.wait_for("return window.outside > 0")) << "named as outside";
  EXPECT_EQ(browser.run("return document.body.dataset.phase"), "RECORDING");
  browser.run("at('region-set').disabled = false; at('region-set').click()");
  EXPECT_TRUE(browser.wait_for("return at('trouble').textContent.includes('being recorded')"));
  browser.run("at('discard').click()");
  ASSERT_TRUE(browser.wait_for("return document.body.dataset.phase === 'IDLE'"));
  browser.run("for (const id of kEdges) at(id).value = ''; at('region-set').click()");
  ASSERT_TRUE(browser.wait_for("return at('region-now').textContent === of('region.everywhere')"));
  browser.run("at('begin').click()");
  EXPECT_TRUE(browser.wait_for("return document.body.dataset.phase === 'MEASURED'"));
}

TEST_F(OperatorPage, IsRefusedWithoutAPassword) {
  for (const std::vector<std::string>& more : {std::vector<std::string>{},
                                               {"--host", "0.0.0.0"},
                                               {"--no-consent"},
                                               {"--operator-password-file", folder_.path("none")}}) {
    std::vector<std::string> command = {IM2FIT_PROGRAM, "serve", folder_.path("two"), "--operator", "--port", "0"};
    command.insert(command.end(), more.begin(), more.end());
    const test::Run run = test::run_program(command);
    EXPECT_EQ(run.exit_code, 1);
    EXPECT_TRUE(test::is_one_line_of(run.err, "im2fit")) << run.err;
  }
}

TEST_F(OperatorPage, AShopsFileThatIsBadEndsTheProgramAtItsStart) {
  const std::string path = folder_.path("shop.json");
  test::write_text(path,
                   R"({"schema": "im2fit.shop/1", "name": "Shop", "colours": {"light": {"accent": "#ffff00"}}})");
  const test::Run run =
      test::run_program({IM2FIT_PROGRAM, "serve", folder_.path("two"), "--shop", path, "--port", "0"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_TRUE(test::is_one_line_of(run.err, "im2fit")) << run.err;
  EXPECT_THAT(run.err,
              testing::HasSubstr(path + ": colours.light.accent: #ffff00 has a contrast of 1.0 with #f6f5f2"));
}

TEST_F(OperatorPage, StatisticsNeedConsentAndAFileOfTheirOwn) {
  const std::string path = folder_.path("visits.csv");
  const auto refused = [&](const std::vector<std::string>& more) {
    std::vector<std::string> command = {IM2FIT_PROGRAM, "serve", folder_.path("two"), "--port", "0",
                                        "--statistics", path};
    command.insert(command.end(), more.begin(), more.end());
    const test::Run run = test::run_program(command);
    EXPECT_EQ(run.exit_code, 1);
    EXPECT_TRUE(test::is_one_line_of(run.err, "im2fit")) << run.err;
    return run.err;
  };
  EXPECT_THAT(refused({"--no-consent"}), testing::HasSubstr("--statistics counts visits, which begin with consent"));
  test::write_text(path, "name,size\nAnna,M\n");
  EXPECT_THAT(refused({}), testing::HasSubstr(path + ":1: expected the columns period,what,name,count"));
  EXPECT_EQ(test::read_text(path), "name,size\nAnna,M\n") << "another file stays as it is";
}

// Exposure by systemd's own measure: 0 to 10, in tenths on its command line. The unit has 1.6; the network of this
// machine, which a page needs, is what im2fitd's 1.0 lacks.
TEST(ServeUnit, SystemdAcceptsItAndFindsLittleExposed) {
  const std::string analyze = "/usr/bin/systemd-analyze";
  if (!std::filesystem::exists(analyze)) GTEST_SKIP() << "no systemd-analyze here: apt-get install systemd";
  const test::TestFolder folder;
  std::string unit = test::read_text(IM2FIT_SERVE_UNIT);
  const auto at = unit.find("ExecStart=") + 10;
  unit.replace(at, unit.find(' ', at) - at, IM2FIT_PROGRAM);
  const std::string path = folder.path("im2fit-serve.service");
  test::write_text(path, unit);
  const auto verified = test::run_program({analyze, "--man=no", "verify", path});
  EXPECT_EQ(verified.exit_code, 0) << verified.err;
  EXPECT_EQ(verified.err, "");
  const auto rated = test::run_program({analyze, "--no-pager", "--offline=true", "--threshold=16", "security", path});
  EXPECT_EQ(rated.exit_code, 0) << rated.out;
  // Both find the fault.
  test::write_text(path, unit + "[Service]\nRestartSec=soon\n");
  EXPECT_NE(test::run_program({analyze, "--man=no", "verify", path}).err, "");
}

}  // namespace
}  // namespace im2fit
