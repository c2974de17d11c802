// SPDX-License-Identifier: Apache-2.0
// The operator's part over a page that the test feeds with events: consent, recording, the form, sessions.
#include "apps/kiosk/operator_desk.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/file.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <functional>
#include <future>
#include <stdexcept>
#include <thread>

#include "apps/sessions/store.h"
#include "depth_folder.h"
#include "shown_page.h"

namespace im2fit {
namespace {

using apps::Json;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class Desk : public testing::Test {
 protected:
  void SetUp() override { open_page(); }
  void open_page() {
    page_.reset();
    apps::LivePageSettings settings;
    settings.desk.emplace();
    settings.desk->root = root_;
    settings.desk->site = site_;
    settings.desk->settings.frames = 5;
    settings.desk->settings.region = region_;
    settings.shop = shop_;
    settings.desk->tape = {{"waist_girth", {{"en", "Waist"}}}};
    settings.desk->measure = measure_;
    settings.erase_folder = erase_folder_;
    page_ = std::make_unique<test::ShownPage>(settings);
    hal::SourceInfo source;
    source.name = camera_;
    source.intrinsics.width = 64;
    source.intrinsics.height = 48;
    source.intrinsics.fx = source.intrinsics.fy = 60;
    source.intrinsics.cx = 31.5F;
    source.intrinsics.cy = 23.5F;
    page_->page().use_source(source, {"1.0.0", "a", "b", "c"}, diagnose_);
  }
  std::pair<int, std::string> post(const std::string& path, const Json& body) const {
    return page_->post_operator(path, body);
  }
  Json get(const std::string& path) const {
    return Json::parse(page_->operator_client().Get(path)->body, nullptr, false);
  }
  int status_of(const std::string& path) const { return page_->operator_client().Get(path)->status; }
  std::string phase() const { return get("/operator/state")["phase"]; }
  int begin() const { return post("/operator/begin", {{"language", "de"}, {"version", "1"}}).first; }
  void frame(std::uint64_t number) {
    page_->begin_person();
    std::vector<std::uint16_t> pixels(64 * 48, static_cast<std::uint16_t>(1000 + number));
    EngineResult result;
    result.user = 1;
    hal::FrameInfo info;
    info.sequence = number;
    info.host_ns = static_cast<std::int64_t>(number) * 33'000'000;
    page_->page().see({DepthView(pixels.data(), 64, 48), {}, info, {}, result});
  }
  Json job_done() const {
    for (int i = 0; i < 400; ++i) {
      Json state = get("/operator/state");
      if (state.contains("job") && state["job"]["running"] == false) return state["job"];
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return "it never ended";
  }
  std::size_t entries() const {
    std::error_code code;
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(root_, code), {}));
  }
  void measured_visit() {
    ASSERT_EQ(begin(), 200);
    for (std::uint64_t number = 0; number < 6; ++number) frame(number);
    page_->measured(987);
    ASSERT_EQ(phase(), "MEASURED");
  }
  const test::TestFolder folder_;
  std::string root_ = folder_.path("sessions"), site_ = "shop 3";
  std::function<Result<Json>(const std::string&)> measure_ = [](const std::string& id) -> Result<Json> {
    return Json{{"then", nullptr}, {"now", {{"of", id}}}};
  };
  std::function<void(const std::string&)> erase_folder_;
  std::string camera_ = "fake", region_;
  apps::DiagnosePicture diagnose_;
  std::optional<apps::Shop> shop_;
  std::unique_ptr<test::ShownPage> page_;
};

const Json kForm = {{"person", "P1"},
                    {"site", "shop 3"},
                    {"notes", "two\nlines"},
                    {"truth", {{"height_mm", 1700}, {"gender", "female"}, {"tape", {{"waist_girth", {800, 806}}}}}}};

// Of every visit's frames; people are on it while it is fresh, and never after their visit.
TEST_F(Desk, TheFloorFromAboveKeepsNobody) {
  EXPECT_EQ(status_of("/operator/plan"), 404);
  EXPECT_FALSE(get("/operator/state").contains("plan"));
  EXPECT_EQ(page_->client().Get("/operator/plan")->status, 401) << "the operator's alone";
  ASSERT_EQ(begin(), 200);
  std::vector<std::uint16_t> pixels(64 * 48, 2000);
  std::vector<std::uint8_t> mask(pixels.size());
  for (std::size_t i = 0; i < mask.size(); ++i) mask[i] = i % 64 > 28 && i % 64 < 36 ? 255 : 0;
  const Intrinsics k = {64, 48, 60, 60, 31.5F, 23.5F};
  EngineResult result;
  const auto see = [&] {
    page_->begin_person();
    page_->page().see({DepthView(pixels.data(), 64, 48), MaskView(mask.data(), 64, 48), {}, {}, result});
  };
  see();
  EXPECT_EQ(status_of("/operator/plan"), 404) << "the floor is not known";
  result.floor = {true, {0, -1, 0}, 1000};
  see();
  const auto plan =
      apps::floor_plan(DepthView(pixels.data(), 64, 48), MaskView(mask.data(), 64, 48), k, result.floor);
  const std::string with = *apps::picture_of(plan, true), without = *apps::picture_of(plan, false);
  ASSERT_NE(with, without);
  EXPECT_EQ(page_->operator_client().Get("/operator/plan")->body, with);
  EXPECT_EQ(get("/operator/state")["plan"], Json({1, true}));
  std::fill(mask.begin(), mask.end(), std::uint8_t{0});
  see();
  EXPECT_EQ(get("/operator/state")["plan"][0], 1) << "twice a second";
  ASSERT_EQ(post("/operator/discard", Json::object()).first, 200);
  EXPECT_EQ(page_->operator_client().Get("/operator/plan")->body, without);
  open_page();
  EXPECT_EQ(status_of("/operator/plan"), 404) << "of another camera";
}

// A plan is drawn outside the lock: when it is done, its visit may be over, or its camera another one.
class DeskAlone : public testing::Test {
 protected:
  static constexpr int kWidth = 64, kHeight = 48;
  static hal::SourceInfo camera(int width, int height) {
    hal::SourceInfo source;
    const auto w = static_cast<float>(width), h = static_cast<float>(height);
    source.intrinsics = {width, height, w, w, w / 2, h / 2};
    return source;
  }
  void look(std::uint64_t visit, int width = kWidth, int height = kHeight,
            const std::function<bool()>& again = nullptr) {
    const std::vector<std::uint16_t> pixels(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 2000);
    const std::vector<std::uint8_t> mask(pixels.size(), 255);
    EngineResult result;
    result.floor = {true, {0, -1, 0}, 1000};
    do {
      desk_.look(visit,
                 {DepthView(pixels.data(), width, height), MaskView(mask.data(), width, height), {}, {}, result});
    } while (again && again());
  }
  unsigned plan_status() { return desk_.answer({false, "/operator/plan", "", {}}).status; }
  const test::TestFolder folder_;
  apps::OperatorDesk desk_{{folder_.path("sessions"), "", {}, {}, nullptr}};
};

TEST_F(DeskAlone, APlanOfAVisitThatIsOverIsDropped) {
  desk_.use_source(camera(kWidth, kHeight), {});
  desk_.visit_over(4, true);
  look(4);
  EXPECT_EQ(plan_status(), 404U) << "it shows whom it is to forget";
  look(5);
  EXPECT_EQ(plan_status(), 200U);
}

// The engine's thread draws while the camera is exchanged.
TEST_F(DeskAlone, APlanOfTheCameraBeforeIsDropped) {
  constexpr int kSide = 639;  // every pixel of it is read
  std::atomic<bool> over{false};
  std::thread engine([&] { look(1, kSide, kSide, [&] { return !over; }); });
  int kept = 0;
  for (int i = 0; i < 20; ++i) {
    desk_.use_source(camera(kSide, kSide), {});
    std::this_thread::sleep_for(std::chrono::microseconds(500));
    desk_.use_source(camera(kWidth, kHeight), {});
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    kept += plan_status() == 200 ? 1 : 0;
  }
  over = true;
  engine.join();
  EXPECT_EQ(kept, 0);
}

TEST_F(Desk, AVisitIsRecordedAndSavedWithWhatTheFormSays) {
  EXPECT_EQ(phase(), "IDLE");
  EXPECT_EQ(get("/operator/form")["tape"][0]["id"], "waist_girth");
  EXPECT_EQ(post("/operator/save", kForm).first, 409) << "no one was measured";
  ASSERT_NO_FATAL_FAILURE(measured_visit());
  EXPECT_EQ(get("/operator/state")["recording"]["frames"], 6);
  EXPECT_THAT(*sessions::list(root_), IsEmpty());
  EXPECT_EQ(post("/operator/save", kForm).first, 202);
  const Json job = job_done();
  ASSERT_EQ(job["error"], "");
  const auto record = sessions::read(root_, job["id"]);
  ASSERT_TRUE(record) << record.error().message;
  EXPECT_EQ(record->person, "P1");
  EXPECT_EQ(record->truth.tape.at("waist_girth").second, 806);
  EXPECT_EQ(record->consent.version, "operator-de-1");
  EXPECT_EQ(record->consent.text_sha256, apps::consent_text("de")->sha256);
  EXPECT_EQ(record->camera.width, 64);
  EXPECT_EQ(record->versions.index, "c");
  EXPECT_EQ(record->settings.frames, 5);
  const std::string folder = *sessions::folder_of(root_, job["id"]);
  EXPECT_EQ(Json::parse(test::read_text(folder + "/result.json"))["measurements"]["chest_girth"]["value"], 987);
  EXPECT_THAT(test::read_text(folder + "/joints.csv"), HasSubstr("\n"));
  EXPECT_TRUE(std::filesystem::exists(folder + "/recording/000005.png"));
  EXPECT_FALSE(std::filesystem::exists(folder + "/recording/000006.png"));
  EXPECT_EQ(get("/operator/sessions")[0]["person"], "P1");
  const auto picture = page_->operator_client().Get("/operator/picture?number=5&id=" + job["id"].get<std::string>());
  EXPECT_EQ(picture->get_header_value("Content-Type"), "image/png");
  EXPECT_EQ(page_->operator_client().Get("/operator/picture?number=6&id=" + job["id"].get<std::string>())->status,
            404);
  EXPECT_EQ(phase(), "IDLE");
  EXPECT_EQ(begin(), 200) << "the next person, while the one before is still on the screen";
}

TEST_F(Desk, AnEngineThatBeginsAnewBeginsTheRecordingAnew) {
  ASSERT_EQ(begin(), 200);
  for (std::uint64_t number = 0; number < 4; ++number) frame(number);
  page_->page().begin_person(page_->page().permit());
  for (std::uint64_t number = 4; number < 7; ++number) frame(number);
  page_->measured(987);
  ASSERT_EQ(post("/operator/save", kForm).first, 202);
  const Json job = job_done();
  ASSERT_EQ(job["error"], "");
  int frames = 0;
  for (const auto& entry : std::filesystem::directory_iterator(*sessions::recording_of(root_, job["id"])))
    frames += entry.path().extension() == ".png";
  EXPECT_EQ(frames, 3);
}

TEST_F(Desk, NothingStaysOfWhoDeletesOrLeavesOrIsDiscarded) {
  ASSERT_NO_FATAL_FAILURE(measured_visit());
  EXPECT_EQ(entries(), 1U);
  EXPECT_EQ(page_->post("/delete", page_->visit()), 200) << "the person, on their own page";
  EXPECT_EQ(entries(), 0U);
  EXPECT_EQ(post("/operator/save", kForm).first, 409);
  ASSERT_NO_FATAL_FAILURE(measured_visit());
  EXPECT_EQ(post("/operator/discard", Json::object()).first, 200);
  EXPECT_EQ(entries(), 0U);
  EXPECT_EQ(page_->status_of("/result.json"), 404);
  ASSERT_EQ(begin(), 200);
  frame(0);
  page_.reset();
  EXPECT_EQ(entries(), 0U) << "the program ended";
}

TEST_F(Desk, DeleteOnThePersonsPageAlsoDeletesTheSavedSession) {
  ASSERT_NO_FATAL_FAILURE(measured_visit());
  ASSERT_EQ(post("/operator/save", kForm).first, 202);
  const std::string id = job_done()["id"], visit = page_->visit();
  ASSERT_TRUE(sessions::read(root_, id));
  EXPECT_FALSE(get("/operator/state").contains("erased"));
  EXPECT_EQ(page_->post("/delete", visit), 200);
  EXPECT_EQ(entries(), 0U);
  EXPECT_EQ(get("/operator/state")["erased"], id) << "the operator is told";
  EXPECT_EQ(page_->post("/delete", visit), 409);
  // Another person's Delete is not of this one's session, and who leaves without it has their session kept.
  ASSERT_NO_FATAL_FAILURE(measured_visit());
  EXPECT_FALSE(get("/operator/state").contains("erased"));
  ASSERT_EQ(post("/operator/save", kForm).first, 202);
  ASSERT_EQ(job_done()["error"], "");
  ASSERT_NO_FATAL_FAILURE(measured_visit());
  EXPECT_EQ(page_->post("/delete", page_->visit()), 200);
  EXPECT_EQ(entries(), 1U);
}

// The engine's frames go on while a slow disk deletes: its thread asks the page for every one of them.
TEST_F(Desk, ADeletionThatTakesItsTimeHoldsNoFrameUp) {
  ASSERT_NO_FATAL_FAILURE(measured_visit());
  ASSERT_EQ(post("/operator/save", kForm).first, 202);
  ASSERT_EQ(job_done()["error"], "");
  const std::string visit = page_->visit();
  const int root = ::open(root_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  ASSERT_EQ(::flock(root, LOCK_EX), 0);  // a deletion waits for it
  auto deleted = std::async(std::launch::async, [&] { return page_->post("/delete", visit); });
  EXPECT_EQ(deleted.wait_for(std::chrono::milliseconds(300)), std::future_status::timeout);
  auto asked = std::async(std::launch::async, [&] { return page_->page().permit(); });
  const bool went_on = asked.wait_for(std::chrono::seconds(3)) == std::future_status::ready;
  EXPECT_EQ(entries(), 1U) << "not deleted yet";
  ::close(root);
  EXPECT_TRUE(went_on);
  EXPECT_EQ(deleted.get(), 200);
  EXPECT_EQ(entries(), 0U) << "the answer comes after it is gone";
}

// One thread answers everybody: others get their answers while a slow disk deletes, whoever asked for it.
TEST_F(Desk, ADeletionThatTakesItsTimeHoldsNoOtherRequestUp) {
  for (const bool by_operator : {false, true}) {
    ASSERT_NO_FATAL_FAILURE(measured_visit());
    ASSERT_EQ(post("/operator/save", kForm).first, 202);
    const Json done = job_done();
    ASSERT_EQ(done["error"], "");
    const std::string visit = page_->visit();
    page_->operator_client();  // signs in
    const int root = ::open(root_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    ASSERT_EQ(::flock(root, LOCK_EX), 0);  // a deletion waits for it
    auto deleted = std::async(std::launch::async, [&] {
      return by_operator ? post("/operator/delete", {{"id", done["id"]}}).first : page_->post("/delete", visit);
    });
    EXPECT_EQ(deleted.wait_for(std::chrono::milliseconds(300)), std::future_status::timeout);
    auto others = std::async(std::launch::async, [&] {
      return std::vector{page_->status_of("/"), status_of("/operator/state"), page_->post("/touch", "another visit")};
    });
    const bool answered = others.wait_for(std::chrono::seconds(3)) == std::future_status::ready;
    EXPECT_EQ(entries(), 1U) << "not deleted yet";
    ::close(root);
    EXPECT_TRUE(answered) << by_operator;
    EXPECT_THAT(others.get(), testing::ElementsAre(200, 200, 409));
    EXPECT_EQ(deleted.get(), 200);
    EXPECT_EQ(entries(), 0U) << "the answer comes after it is gone";
    if (by_operator) {
      EXPECT_EQ(page_->post("/delete", visit), 200);
    }
  }
}

// The page ends while a deletion waits: its client is cut off, and what was begun is done.
TEST_F(Desk, APageThatEndsFinishesItsDeletions) {
  ASSERT_NO_FATAL_FAILURE(measured_visit());
  ASSERT_EQ(post("/operator/save", kForm).first, 202);
  ASSERT_EQ(job_done()["error"], "");
  const std::string visit = page_->visit();
  const int root = ::open(root_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  ASSERT_EQ(::flock(root, LOCK_EX), 0);
  auto deleted = std::async(std::launch::async, [&] { return page_->post("/delete", visit); });
  EXPECT_EQ(deleted.wait_for(std::chrono::milliseconds(300)), std::future_status::timeout);
  auto freed = std::async(std::launch::async, [&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(700));
    ::close(root);
  });
  page_->end();
  EXPECT_EQ(deleted.get(), 0) << "no answer";
  EXPECT_EQ(entries(), 0U);
}

// The next person's visit begins while the disk is still busy with what was to be deleted.
TEST_F(Desk, ADeletionThatWaitsDeletesTheSessionAlsoWhenTheNextVisitHasBegun) {
  std::promise<void> free;
  erase_folder_ = [gate = free.get_future().share()](const std::string&) { gate.wait(); };
  open_page();
  const bool begun = begin() == 200;
  frame(0);
  page_->measured(987, "out");
  const int saving = post("/operator/save", kForm).first;
  const std::string id = job_done()["id"], visit = page_->visit();
  auto deleted = std::async(std::launch::async, [&] { return page_->post("/delete", visit); });
  EXPECT_EQ(deleted.wait_for(std::chrono::milliseconds(300)), std::future_status::timeout);
  EXPECT_TRUE(sessions::read(root_, id)) << "not deleted yet";
  const int next = begin();
  free.set_value();
  EXPECT_TRUE(begun);
  EXPECT_EQ(saving, 202);
  EXPECT_EQ(next, 200);
  EXPECT_EQ(deleted.get(), 200);
  EXPECT_FALSE(sessions::read(root_, id)) << "the answer says that it is gone";
  EXPECT_EQ(phase(), "RECORDING") << "of the next person";
  EXPECT_EQ(entries(), 1U);
}

TEST_F(Desk, DeleteDuringSavingLeavesNothing) {
  for (int i = 0; i < 5; ++i) {
    ASSERT_NO_FATAL_FAILURE(measured_visit());
    const std::string visit = page_->visit();
    ASSERT_EQ(post("/operator/save", kForm).first, 202);
    EXPECT_EQ(page_->post("/delete", visit), 200);
    job_done();
    EXPECT_EQ(entries(), 0U) << i;
  }
}

// The disk is slow with it: what was saved while the person deleted it goes on the saving thread.
TEST_F(Desk, ADeletionAfterSavingHoldsNothingUp) {
  for (int i = 0; i < 3; ++i) {
    ASSERT_EQ(begin(), 200);
    for (std::uint64_t number = 0; number < 40; ++number) frame(number);
    page_->measured(987);
    const std::string visit = page_->visit();
    page_->operator_client();  // signs in
    const int root = ::open(root_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    ASSERT_EQ(::flock(root, LOCK_EX), 0);  // a deletion waits for it
    const int saving = post("/operator/save", kForm).first;
    auto deleted = std::async(std::launch::async, [&] { return page_->post("/delete", visit); });
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    auto told = std::async(std::launch::async, [&] { return status_of("/operator/state"); });
    const bool answered = told.wait_for(std::chrono::seconds(3)) == std::future_status::ready;
    ::close(root);
    EXPECT_TRUE(answered) << i;
    EXPECT_EQ(saving, 202);
    EXPECT_EQ(told.get(), 200);
    EXPECT_EQ(deleted.get(), 200);
    job_done();
    EXPECT_EQ(entries(), 0U) << i;
  }
}

TEST_F(Desk, DeleteOfASessionThatTheOperatorDeletedIsDone) {
  ASSERT_NO_FATAL_FAILURE(measured_visit());
  ASSERT_EQ(post("/operator/save", kForm).first, 202);
  EXPECT_EQ(post("/operator/delete", {{"id", job_done()["id"]}}).first, 200);
  EXPECT_EQ(page_->post("/delete", page_->visit()), 200);
}

TEST_F(Desk, ConsentOfAnotherTextOrDuringACustomersVisitIsNone) {
  EXPECT_EQ(post("/operator/begin", {{"language", "de"}, {"version", "0"}}).first, 409);
  EXPECT_EQ(post("/operator/begin", {{"language", "xx"}, {"version", "1"}}).first, 409);
  EXPECT_EQ(page_->post("/consent", page_->visit()), 200);
  EXPECT_EQ(begin(), 409);
  EXPECT_EQ(entries(), 0U);
  frame(0);
  page_->measured(987);
  EXPECT_EQ(phase(), "IDLE") << "a customer's visit is never recorded";
  EXPECT_EQ(entries(), 0U);
}

TEST_F(Desk, AFormThatIsWrongIsRefusedByItsFieldAndMayBeSentAgain) {
  ASSERT_NO_FATAL_FAILURE(measured_visit());
  const auto refused = [&](const Json& patch, const std::string& expected) {
    Json form = kForm;
    form.merge_patch(patch);
    const auto [status, text] = post("/operator/save", form);
    EXPECT_EQ(status, 400) << expected;
    EXPECT_THAT(text, HasSubstr(expected));
  };
  refused({{"person", ""}}, "person is missing");
  refused({{"person", Json::array()}}, "person is not a text");
  refused({{"truth", {{"height_mm", 170}}}}, "truth.height_mm is 170, expected 500 to 2500");
  refused({{"truth", {{"tape", {{"tail_length", {300}}}}}}}, "tail_length is not a measurement of the tape");
  refused({{"truth", {{"tape", {{"../x", {300}}}}}}}, "expected an id");
  refused({{"notes", std::string(5000, 'x')}}, "notes has 5000 bytes");
  EXPECT_EQ(post("/operator/save", Json::array()).first, 400);
  EXPECT_EQ(phase(), "MEASURED");
  EXPECT_EQ(post("/operator/save", kForm).first, 202);
  EXPECT_EQ(job_done()["error"], "");
}

TEST_F(Desk, ASessionNamesWhomTheShopsConsentNamed) {
  shop_ = apps::Shop{};
  shop_->name = "Shop";
  shop_->consent = {"7", "Shop GmbH", {{"en", "to find sizes"}, {"de", "für Größen"}}, "shop@x.example"};
  open_page();
  EXPECT_EQ(get("/operator/form")["shop"]["consent"]["operator"], "Shop GmbH");
  EXPECT_EQ(begin(), 409) << "the consent shown is not the shop's";
  ASSERT_EQ(post("/operator/begin", {{"language", "de"}, {"version", "1+7"}}).first, 200);
  frame(0);
  page_->measured(987);
  ASSERT_EQ(post("/operator/save", kForm).first, 202);
  const auto record = sessions::read(root_, job_done()["id"]);
  ASSERT_TRUE(record) << record.error().message;
  EXPECT_EQ(record->consent.version, "operator-de-1+7");
  EXPECT_EQ(record->consent.operator_name, "Shop GmbH");
  EXPECT_EQ(record->consent.purpose, "für Größen");
  EXPECT_EQ(record->consent.contact, "shop@x.example");
}

TEST_F(Desk, ARegionIsKeptForItsCamera) {
  EXPECT_EQ(get("/operator/state")["region"], (Json{{"text", ""}, {"fixed", false}, {"error", ""}}));
  EXPECT_FALSE(page_->page().region().region);
  EXPECT_EQ(post("/operator/region", {{"region", "-0.6,1.5,0.6,3"}}).first, 200);
  const apps::OperatorRegion set = page_->page().region();
  ASSERT_TRUE(set.region);
  EXPECT_EQ(set.region->x0_mm, -600);
  EXPECT_EQ(set.region->z1_mm, 3000);
  camera_ = "another";
  open_page();
  EXPECT_FALSE(page_->page().region().region);
  EXPECT_EQ(post("/operator/region", {{"region", "0,1,1,2"}}).first, 200);
  camera_ = "fake";
  open_page();
  EXPECT_EQ(get("/operator/state")["region"]["text"], "-0.6,1.5,0.6,3");
  ASSERT_TRUE(page_->page().region().region);
  EXPECT_EQ(page_->page().region().region->x1_mm, 600);
  const std::uint32_t before = page_->page().region().count;
  EXPECT_EQ(post("/operator/region", {{"region", ""}}).first, 200);
  EXPECT_NE(page_->page().region().count, before) << "the run behind the page is told";
  open_page();
  EXPECT_EQ(get("/operator/state")["region"]["text"], "");
  EXPECT_EQ(std::filesystem::status(root_ + "/.regions.json").permissions(),
            std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  EXPECT_THAT(*sessions::list(root_), IsEmpty()) << "it is no session";
}

TEST_F(Desk, NoRegionComesOfNonsense) {
  for (const auto& [body, expected] :
       {std::pair<Json, const char*>{{{"region", "0.6,1.5,-0.6,3"}}, "'0.6,1.5,-0.6,3' is not a region"},
        {{{"region", "1,2,3"}}, "is not a region: expected x0,z0,x1,z1 in metres"},
        {{{"region", "0,0,1e9,2"}}, "is not a region"},
        {{{"region", "nan,0,1,2"}}, "is not a region"},
        {{{"region", std::string(65, ' ')}}, "region has more than 64 characters"},
        {{{"region", 7}}, "region is not a text"},
        {Json::object(), "region is not a text"}}) {
    const auto [status, text] = post("/operator/region", body);
    EXPECT_EQ(status, 400) << body;
    EXPECT_THAT(text, HasSubstr(expected));
  }
  EXPECT_FALSE(page_->page().region().region);
  EXPECT_FALSE(std::filesystem::exists(root_ + "/.regions.json"));
  // A kept file that somebody has spoiled is named, people are measured everywhere, and the next region mends it.
  std::filesystem::create_directories(root_);
  for (const char* spoiled : {R"({"schema": "im2fit.regions/1", "cameras": {"fake": "1,2"}})", "{", "[]"}) {
    test::write_text(root_ + "/.regions.json", spoiled);
    open_page();
    EXPECT_THAT(std::string(get("/operator/state")["region"]["error"]), HasSubstr(".regions.json: ")) << spoiled;
    EXPECT_FALSE(page_->page().region().region);
    EXPECT_EQ(post("/operator/region", {{"region", "0,1,1,2"}}).first, 200);
    EXPECT_EQ(get("/operator/state")["region"]["error"], "");
  }
}

TEST_F(Desk, ARecordingHasOneRegionAndItsSessionNamesIt) {
  ASSERT_EQ(post("/operator/region", {{"region", "-1,1,1,4"}}).first, 200);
  ASSERT_EQ(begin(), 200);
  EXPECT_EQ(post("/operator/region", {{"region", "0,1,1,2"}}).first, 409);
  frame(0);
  page_->measured(987);
  ASSERT_EQ(post("/operator/region", {{"region", "0,1,1,2"}}).first, 200) << "for the next person";
  ASSERT_EQ(post("/operator/save", kForm).first, 202);
  EXPECT_EQ(sessions::read(root_, job_done()["id"])->settings.region, "-1,1,1,4");
}

TEST_F(Desk, TheCommandLinesRegionHolds) {
  region_ = "-1,1,1,4";
  open_page();
  EXPECT_EQ(get("/operator/state")["region"], (Json{{"text", region_}, {"fixed", true}, {"error", ""}}));
  const auto [status, text] = post("/operator/region", {{"region", ""}});
  EXPECT_EQ(status, 409);
  EXPECT_THAT(text, HasSubstr("--region of the command line holds"));
  EXPECT_EQ(page_->page().region().region->x0_mm, -1000);
}

// Of frames without a person for two seconds, and again each five; a person who comes ends it.
TEST_F(Desk, TheOperatorIsToldWhyNoPersonIsSeen) {
  int asked = 0;
  diagnose_ = [&](DepthView depth) {
    ++asked;
    EXPECT_EQ(depth.width, 64);
    return hal::DepthDiagnosis{hal::DiagnosisCode::unit, 0.25F, 0, "try --unit 0.25"};
  };
  open_page();
  ASSERT_EQ(page_->post("/consent", page_->visit()), 200);
  std::vector<std::uint16_t> pixels(64 * 48, 4000);
  const auto see = [&](double seconds, int user) {
    page_->begin_person();
    EngineResult result;
    result.user = user;
    if (user == 0) result.guidance = static_cast<GuidanceSet>(Guidance::no_person);
    hal::FrameInfo info;
    info.host_ns = static_cast<std::int64_t>(seconds * 1e9);
    page_->page().see({DepthView(pixels.data(), 64, 48), {}, info, {}, result});
  };
  for (const double seconds : {1.0, 2.0, 2.9}) see(seconds, 0);
  EXPECT_FALSE(get("/operator/state").contains("diagnosis"));
  for (const double seconds : {3.0, 4.0, 7.9}) see(seconds, 0);
  EXPECT_EQ(asked, 1);
  const Json told = get("/operator/state")["diagnosis"];
  EXPECT_EQ(told["code"], "UNIT");
  EXPECT_EQ(told["unit_mm"], 0.25);
  EXPECT_EQ(told["text"], "try --unit 0.25");
  see(8.0, 0);
  EXPECT_EQ(asked, 2);
  see(8.1, 1);
  EXPECT_FALSE(get("/operator/state").contains("diagnosis"));
  see(8.2, 0);
  EXPECT_EQ(asked, 2);
}

TEST_F(Desk, AnIdOfTheFormLeadsNowhereElse) {
  ASSERT_NO_FATAL_FAILURE(measured_visit());
  ASSERT_EQ(post("/operator/save", kForm).first, 202);
  const std::string id = job_done()["id"];
  test::write_text(folder_.path("session.json"), "{}");
  for (const std::string& bad : {std::string(".."), "../sessions/" + id, std::string("/etc"), id + "/..",
                                 std::string(), std::string("..%2F"), std::string(4000, 'a')}) {
    EXPECT_EQ(post("/operator/delete", {{"id", bad}}).first, 400) << bad;
    EXPECT_EQ(post("/operator/measure", {{"id", bad}}).first, 400) << bad;
    EXPECT_EQ(status_of("/operator/session?id=" + httplib::detail::encode_query_param(bad)), 400) << bad;
    EXPECT_EQ(status_of("/operator/picture?number=0&id=" + httplib::detail::encode_query_param(bad)), 400) << bad;
  }
  EXPECT_EQ(status_of("/operator/picture?number=-1&id=" + id), 400);
  EXPECT_EQ(status_of("/operator/picture?number=99999999999999999999&id=" + id), 404);
  EXPECT_TRUE(std::filesystem::exists(folder_.path("session.json")));
  EXPECT_EQ(post("/operator/measure", {{"id", id}}).first, 202);
  EXPECT_EQ(job_done()["result"]["now"]["of"], id);
  EXPECT_EQ(post("/operator/delete", {{"id", id}}).first, 200);
  EXPECT_EQ(entries(), 0U);
  EXPECT_EQ(post("/operator/delete", {{"id", id}}).first, 404);
}

// Of a shell in Latin-1, and over a folder that holds what ended the program.
class DeskAmongDamage : public Desk {
 protected:
  DeskAmongDamage() {
    root_ = folder_.path("caf\xe9");
    site_ = "caf\xe9";
    std::filesystem::create_directories(root_ + "/deep");
    const std::string nested = std::string(100'000, '[') + std::string(100'000, ']');
    test::write_text(root_ + "/deep/session.json", "{\"schema\": " + nested + "}");
    std::filesystem::create_symlink("loop", root_ + "/loop");
    std::filesystem::create_directories(root_ + "/.20260101-000000-aaaaaaaa.part/recording");
  }
};

TEST_F(DeskAmongDamage, ItIsNamedAndThePageGoesOn) {
  EXPECT_EQ(entries(), 2U) << "a killed program's recording goes at the start";
  const Json form = get("/operator/form");
  EXPECT_EQ(form["site"], "caf\xEF\xBF\xBD");
  const Json all = get("/operator/sessions");
  ASSERT_THAT(all, SizeIs(2));
  EXPECT_THAT(all[1]["damage"], HasSubstr("nested deeper than 64 levels"));
  EXPECT_THAT(all[0]["damage"], HasSubstr("loop: Too many levels of symbolic links"));
  EXPECT_EQ(page_->operator_client().Get("/operator/session?id=deep")->status, 400);
  measured_visit();
  EXPECT_EQ(post("/operator/save", kForm).first, 202);
  EXPECT_EQ(job_done()["error"], "");
  ASSERT_THAT(get("/operator/sessions"), SizeIs(3));
}

class DeskThatThrows : public Desk {
 protected:
  DeskThatThrows() {
    measure_ = [](const std::string&) -> Result<Json> { throw std::runtime_error("no more memory"); };
    std::filesystem::create_directories(root_ + "/one");
  }
};

TEST_F(DeskThatThrows, TheTaskFailsAndThePageGoesOn) {
  EXPECT_EQ(post("/operator/measure", {{"id", "one"}}).first, 202);
  EXPECT_EQ(job_done()["error"], "no more memory");
}

}  // namespace
}  // namespace im2fit
