// SPDX-License-Identifier: Apache-2.0
// Clothes that move on the page while a person does: which clients get frames, for how long, how many bytes, and the
// browser's picture. IM2FIT_CLOTH_PICTURES=FOLDER keeps the browser's pictures.
#include "apps/kiosk/live_cloth.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "apps/kiosk/live_page.h"
#include "body/export/export.h"
#include "browser.h"
#include "data_paths.h"
#include "depth_folder.h"
#include "evaluation/garment/drape_quality.h"
#include "garment/drape/dressing_pose.h"
#include "garment/drape/offset_wire.h"
#include "person/builtin_tape.h"
#include "person/dressing.h"
#include "report/result_json.h"
#include "shown_page.h"
#include "train/dressed/dressed_people.h"

namespace im2fit::apps {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;
using Query = std::vector<std::pair<std::string, std::string>>;
constexpr auto kFramePeriod = std::chrono::microseconds(33'333);
constexpr float kCameraHeightMm = 1000;

// A man of the model, measured by its own tape. He moves, and is seen without an error.
class MovingPerson : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    auto model = body::BodyModel::load(test::body_path());
    if (!model) return;
    model_ = new body::BodyModel(std::move(*model));
    person_ = new lab::DressedPerson(lab::example_people(*model_)[1]);
    poses_ = new std::vector<lab::NamedPose>(lab::dressed_poses(*model_, *person_));
  }
  static void TearDownTestSuite() {
    delete poses_;
    delete person_;
    delete model_;
    model_ = nullptr;
  }
  void SetUp() override {
    if (model_ == nullptr) GTEST_SKIP() << "no body file";
  }
  static Customer customer(const std::string& visit) {
    Customer c;
    c.visit = visit;
    c.params = person_->params;
    c.pose = (*poses_)[0].pose;
    c.fits = fits_of(builtin_wardrobe(), builtin_size_system(), 0, builtin_tape(), person_->tape, {});
    return c;
  }
  static Query query(const std::string& visit) {
    return {{"visit", visit}, {"top", "t_shirt"}, {"top_size", "M"}, {"bottom", "trousers"}, {"bottom_size", "M"}};
  }
  static const body::Pose& pose(const std::string& name) {
    for (const auto& p : *poses_)
      if (p.name == name) return p.pose;
    ADD_FAILURE() << name;
    return (*poses_)[0].pose;
  }
  static PageAnswer made(FittingRoom& room, const Query& query) {
    PageAnswer answer = room.ask(query);
    for (int i = 0; i < 3000 && answer.status == 202; ++i) {
      std::this_thread::sleep_for(milliseconds(20));
      answer = room.ask(query);
    }
    EXPECT_EQ(answer.status, 200U) << answer.text;
    return answer;
  }
  // The fifteen joints, as a camera a metre above the floor has them.
  static JointSet seen(const body::Pose& pose) {
    std::vector<Vec3f> mesh(person_->rest.size());
    body::skin(*model_, person_->rest, person_->skeleton, pose, mesh);
    float low = mesh[0].y;
    for (int v = 0; v < model_->body_vertex_count(); ++v) low = std::min(low, mesh[static_cast<std::size_t>(v)].y);
    JointSet joints = body::joints_of(*model_, mesh);
    for (Vec3f& p : joints.position_mm) p = {p.x, kCameraHeightMm + low - p.y, 2300 - p.z};
    return joints;
  }
  static FloorPlane floor() { return {true, {0, -1, 0}, kCameraHeightMm}; }
  static inline body::BodyModel* model_ = nullptr;
  static inline lab::DressedPerson* person_ = nullptr;
  static inline std::vector<lab::NamedPose>* poses_ = nullptr;
};

TEST_F(MovingPerson, NothingIsSimulatedUnlessAPageAsks) {
  std::atomic<std::uint32_t> moved{0};
  FittingRoom room(
      test::body_path(), [](const std::string&) {}, [&](std::uint32_t number) { moved = number; });
  room.welcome(customer("one"));
  EXPECT_EQ(room.ask_cloth(query("one")).status, 404U) << "not made yet";
  made(room, query("one"));
  const auto follow = [&](int frames) {
    for (int i = 0; i < frames; ++i) {
      room.follow(body::between(pose("relaxed"), pose("arms-level"), static_cast<float>(i % 10) / 10));
      std::this_thread::sleep_for(kFramePeriod);
    }
  };
  follow(10);
  EXPECT_EQ(moved, 0U) << "no page has asked";
  EXPECT_EQ(room.ask_cloth(query("one")).status, 202U);
  for (int i = 0; i < 100 && moved < 2; ++i) follow(3);
  EXPECT_GE(moved, 2U);
  const auto answer = room.ask_cloth(query("one"));
  ASSERT_EQ(answer.status, 200U) << answer.text;
  const auto message = body::read_cloth_message(answer.file->bytes);
  ASSERT_TRUE(message) << message.error().message;
  EXPECT_EQ(message->garments.size(), 2U);
  EXPECT_GE(message->number, 2U);
}

TEST_F(MovingPerson, NothingOfOnePersonIsToldToTheNext) {
  FittingRoom room(test::body_path(), [](const std::string&) {});
  room.welcome(customer("one"));
  made(room, query("one"));
  EXPECT_EQ(room.ask_cloth(query("one")).status, 202U);
  for (int i = 0; i < 200 && room.ask_cloth(query("one")).status != 200; ++i) {
    room.follow(pose("arms-level"));
    std::this_thread::sleep_for(kFramePeriod);
  }
  EXPECT_EQ(room.ask_cloth(query("one")).status, 200U);
  room.follow(pose("relaxed"));
  room.forget();
  EXPECT_EQ(room.ask_cloth(query("one")).status, 404U);
  room.welcome(customer("two"));
  EXPECT_EQ(room.ask_cloth(query("one")).status, 404U);
  EXPECT_EQ(room.ask_cloth(query("two")).status, 404U);
  made(room, query("two"));
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(room.ask_cloth(query("two")).status, 202U) << "nothing has moved for them";
    std::this_thread::sleep_for(milliseconds(20));
  }
  // Other clothes than those that were got last do not move, and bare skin has none.
  const Query bare = {{"visit", "two"}};
  made(room, bare);
  EXPECT_EQ(room.ask_cloth(bare).status, 404U);
  EXPECT_EQ(room.ask_cloth(query("two")).status, 409U);
  made(room, query("two"));
  EXPECT_EQ(room.ask_cloth(query("two")).status, 202U);
  EXPECT_EQ(room.ask_cloth(Query{{"top", "t_shirt"}}).status, 400U);
}

// A page on which this person was measured, and an engine that sees them move.
class MovingPage {
 public:
  MovingPage(const lab::DressedPerson& person, const body::BodyModel& model, const Customer& customer) {
    LivePageSettings settings;
    settings.visit.ask = false;
    settings.visit.result_max = std::chrono::hours(1);
    settings.body_path = test::body_path();
    shown_ = std::make_unique<test::ShownPage>(settings);
    const body::Avatar avatar{&model, person.params, customer.pose};
    const auto glb = body::glb_of(avatar);
    EXPECT_TRUE(glb);
    shown_->page().permit();
    shown_->page().may_try_on(customer);
    EXPECT_TRUE(shown_->page().measured(avatar, *glb));
    animator_ = std::make_unique<AvatarAnimator>(*AvatarAnimator::create(avatar));
    Json result = {{"measurements", Json::object()},
                   {"sex", {{"female", 0}}},
                   {"views", "front"},
                   {"clothing", {{"answered_as", "bare"}}},
                   {"fit", Json::array()}};
    for (const GarmentFit& fit : customer.fits) result["fit"].push_back(Json::parse(fit_json(fit)));
    shown_->page().publish({{"event", "measured"}, {"frames", 30}, {"person", 1}, {"result", result}});
    result_.user = 1;
    result_.has_joints = true;
  }
  test::ShownPage& shown() { return *shown_; }
  const AvatarAnimator& animator() const { return *animator_; }
  // One frame; milliseconds that the engine's thread spends on the page.
  double see(const JointSet& joints, const FloorPlane& floor) {
    result_.display_joints = joints;
    result_.floor = floor;
    const auto start = Clock::now();
    shown_->page().see({DepthView(depth_.data(), 240, 320), MaskView(mask_.data(), 240, 320), {}, {}, result_});
    const double took = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
    std::this_thread::sleep_for(kFramePeriod);
    return took;
  }

 private:
  std::unique_ptr<test::ShownPage> shown_;
  std::unique_ptr<AvatarAnimator> animator_;
  EngineResult result_;
  std::vector<std::uint16_t> depth_ = std::vector<std::uint16_t>(240UL * 320UL, 3000);
  std::vector<std::uint8_t> mask_ = std::vector<std::uint8_t>(240UL * 320UL, 0);
};

// A page's own script in a browser: joints and cloth together, and none of it after "Delete".
TEST_F(MovingPerson, ABrowserShowsClothThatMovesWithThem) {
  if (!test::Browser::installed()) GTEST_SKIP() << "no chromium: scripts/deps browser";
  test::TestFolder folder;
  const Customer who = customer("");
  MovingPage page(*person_, *model_, who);
  test::Browser browser(folder.path(""), {"--window-size=700,700"});
  ASSERT_TRUE(browser.ready()) << browser.messages();
  browser.go(page.shown().url() + "/?lang=en");
  ASSERT_TRUE(browser.wait_for("return document.body.dataset.avatar === '1'")) << browser.run("return failures");
  ASSERT_TRUE(browser.wait_for("return fitting.shown !== null")) << browser.run("return [fitting.status, failures]");
  ASSERT_EQ(browser.run("return stage.cloth.garments.length"), 2);

  // Where each vertex of cloth is drawn, mm; without offsets: where the skeleton alone takes it.
  const std::string places =
      "const skinned = (mesh, places) => { const out = [], p = new THREE.Vector3(), q = new THREE.Vector3();"
      "  const m = new THREE.Matrix4(), index = mesh.geometry.attributes.skinIndex.array,"
      "        weights = mesh.geometry.attributes.skinWeight, weight = weights.array,"
      "        one = weights.normalized ? 65535 : 1; mesh.skeleton.update();"
      "  for (let v = 0; 3 * v < places.length; ++v) {"
      "    p.fromArray(places, 3 * v).applyMatrix4(mesh.bindMatrix); q.set(0, 0, 0);"
      "    for (let k = 0; k < 4; ++k) { const w = weight[4 * v + k] / one; if (!w) continue;"
      "      m.fromArray(mesh.skeleton.boneMatrices, 16 * index[4 * v + k]);"
      "      q.addScaledVector(p.clone().applyMatrix4(m), w); }"
      "    q.applyMatrix4(mesh.bindMatrixInverse).applyMatrix4(mesh.matrixWorld);"
      "    out.push(...[q.x, q.y, q.z].map((c) => Math.round(1e4 * c) / 10)); } return out; };"
      "stage.avatar.updateMatrixWorld(true); const all = [];"
      "for (const g of stage.cloth.garments) { let mesh = null;"
      "  stage.avatar.traverse((o) => { if (o.geometry === g.geometry) mesh = o; });"
      "  all.push([skinned(mesh, g.geometry.attributes.position.array), skinned(mesh, g.rest)]); } return all;";
  const auto outfit = dress(builtin_wardrobe(), *model_, person_->params, who.pose, false,
                            everyday_clothes(builtin_wardrobe(), who.fits));
  ASSERT_TRUE(outfit);
  body::BodySurface skin(*model_);
  body::Pose last = pose("relaxed");
  double first_number = 0;
  int stops = 0;
  for (const char* name : {"relaxed", "stride"}) {
    const body::Pose& to = pose(name);
    constexpr int kWay = 25, kStay = 20;
    for (int i = 1; i <= kWay + kStay; ++i)
      page.see(seen(body::between(last, to, std::min(1.0F, static_cast<float>(i) / kWay))), floor());
    last = to;
    // A page that this machine kept from hearing the program for three seconds dresses them anew.
    const std::string moves =
        "return Boolean(stage.cloth) && stage.cloth.garments.length === 2 && stage.cloth.number > " +
        std::to_string(first_number);
    const auto end = Clock::now() + std::chrono::seconds(60);
    while (browser.run(moves) != true && Clock::now() < end) page.see(seen(to), floor());
    ASSERT_EQ(browser.run(moves), true) << name << browser.run("return [clothLink.query, failures]");
    // Pose and cloth are not of one moment here: docs/garments.md has how much is inside where they are. A busy
    // machine needs some seconds until both are of the person who stands still.
    struct Shown {
      lab::Inside inside, by_skeleton;
      float most_mm = 0;  // apart
    };
    std::vector<Shown> shown;
    const auto settled = [&] {
      return shown.size() == 2 && shown[0].inside.share < 0.02F && shown[1].inside.share < 0.02F;
    };
    for (int attempt = 0; attempt < 20 && !settled(); ++attempt) {
      for (int i = 0; attempt > 0 && i < kStay; ++i) page.see(seen(to), floor());
      std::this_thread::sleep_for(milliseconds(500));  // the last frame sent is on the screen
      browser.run(
          "for (let i = 0; i < 40; ++i) stage.glide();"
          "stage.cloth.arrived = false; stage.cloth.advance(performance.now(), true); stage.draw();");
      const body::Pose stands = page.animator().pose(seen(to), floor());
      std::vector<Vec3f> mesh(person_->rest.size());
      body::skin(*model_, person_->rest, person_->skeleton, stands, mesh);
      skin.put(mesh);
      const Json all = browser.run(places);
      ASSERT_EQ(all.size(), 2U);
      shown.clear();
      for (std::size_t g = 0; g < all.size(); ++g) {
        std::vector<Vec3f> at[2];
        for (const std::size_t skinned : {0U, 1U}) {
          const std::vector<float> numbers = all[g][skinned];
          for (std::size_t i = 0; i + 2 < numbers.size(); i += 3)
            at[skinned].push_back({numbers[i], numbers[i + 1], numbers[i + 2]});
          ASSERT_EQ(at[skinned].size(), (*outfit)->cloth(g).mesh().vertex_count());
        }
        Shown one = {lab::judge_inside(skin, (*outfit)->cloth(g), at[0]),
                     lab::judge_inside(skin, (*outfit)->cloth(g), at[1])};
        for (std::size_t v = 0; v < at[0].size(); ++v) one.most_mm = std::max(one.most_mm, norm(at[0][v] - at[1][v]));
        std::printf(
            "%-10s %zu: inside %.2f %%, deepest %.0f mm; by the skeleton alone %.2f %%, %.0f mm; at most %.0f mm "
            "apart\n",
            name, g, 100.0 * one.inside.share, one.inside.deepest_mm, 100.0 * one.by_skeleton.share,
            one.by_skeleton.deepest_mm, one.most_mm);
        shown.push_back(one);
      }
    }
    EXPECT_TRUE(settled()) << name << ": cloth stays inside the body";
    first_number = browser.run("return stage.cloth.number");
    if (const char* kept = std::getenv("IM2FIT_CLOTH_PICTURES"))
      test::write_text(std::string(kept) + "/" + std::to_string(stops) + "-" + name + ".png", browser.screenshot());
    for (const Shown& one : shown) {
      if (stops == 0) break;
      EXPECT_GT(one.most_mm, 5) << name << ": it is simulated";
      EXPECT_LT(one.most_mm, 400) << name << ": and on the person";
    }
    ++stops;
  }
  EXPECT_EQ(browser.run("return failures"), Json::array());

  const std::string query = browser.run("return fitting.shown");
  EXPECT_EQ(page.shown().status_of("/cloth.bin?" + query), 200);
  browser.run("at('delete').click()");
  EXPECT_TRUE(browser.wait_for("return clothLink.query === '' && stage.cloth === null"));
  EXPECT_EQ(page.shown().status_of("/cloth.bin?" + query), 404);
}

// As the page's script requests frames: the bytes per second, and the delay of the engine's thread.
TEST_F(MovingPerson, TakesLessThan300KilobytesASecond) {
  MovingPage page(*person_, *model_, customer(""));
  std::string visit = page.shown().visit();
  std::string path;
  for (const auto& [name, value] : query(visit)) path += (path.empty() ? "?" : "&") + name + "=" + value;
  for (int i = 0; i < 3000 && page.shown().status_of("/tryon.glb" + path) == 202; ++i)
    std::this_thread::sleep_for(milliseconds(20));
  ASSERT_EQ(page.shown().status_of("/tryon.glb" + path), 200);

  std::atomic<bool> over{false};
  std::atomic<std::size_t> events{0}, cloth{0}, frames{0};
  std::thread client([&] {
    httplib::Client other = page.shown().client();
    other.set_keep_alive(true);
    const auto take = [&] {
      const auto answer = other.Get("/cloth.bin" + path);
      if (!answer || answer->status != 200) return;
      ++frames;
      cloth += answer->body.size();
      for (const auto& [name, value] : answer->headers) cloth += name.size() + value.size() + 4;
    };
    take();
    page.shown().client().Get("/events", [&](const char* data, std::size_t size) {
      events += size;
      if (std::string_view(data, size).find("\"event\":\"cloth\"") != std::string_view::npos) take();
      return !over;
    });
  });
  const auto run = [&](int count) {
    std::vector<double> took;
    for (int i = 0; i < count; ++i)
      took.push_back(page.see(seen(body::between(pose("relaxed"), pose("arms-level"),
                                                 0.5F - 0.5F * std::cos(0.1F * static_cast<float>(i)))),
                              floor()));
    std::sort(took.begin(), took.end());
    return took;
  };
  run(30);
  events = cloth = frames = 0;
  const auto began = Clock::now();
  const auto took = run(120);
  const double seconds = std::chrono::duration<double>(Clock::now() - began).count();
  const double events_kb = static_cast<double>(events) / seconds / 1000,
               cloth_kb = static_cast<double>(cloth) / seconds / 1000;
  std::printf(
      "%.1f frames a second; %.0f kB/s of events, %.0f kB/s of cloth, %.1f times a second; a frame keeps the "
      "engine's thread for %.2f ms in the middle, %.2f at most\n",
      120 / seconds, events_kb, cloth_kb, static_cast<double>(frames) / seconds, took[took.size() / 2], took.back());
  over = true;
  page.see(seen(pose("relaxed")), floor());
  client.join();
  EXPECT_LT(events_kb + cloth_kb, 300);
  EXPECT_GT(frames, 0U);
  EXPECT_LE(static_cast<double>(frames) / seconds, 11.5);
  EXPECT_LT(took[took.size() / 2], 10);
}

}  // namespace
}  // namespace im2fit::apps
