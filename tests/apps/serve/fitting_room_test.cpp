// SPDX-License-Identifier: Apache-2.0
// Trying clothes on: valid requests, the avatars made, and the browser's picture.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstring>
#include <nlohmann/json.hpp>
#include <thread>

#include "apps/kiosk/live_page.h"
#include "body/export/export.h"
#include "body/measure.h"
#include "body/model_data.h"
#include "body/tape.h"
#include "browser.h"
#include "data_paths.h"
#include "depth_folder.h"
#include "person/builtin_tape.h"
#include "person/dressing.h"
#include "report/result_json.h"

namespace im2fit::apps {
namespace {

using testing::HasSubstr;
using Query = std::vector<std::pair<std::string, std::string>>;

// A woman of the model, measured by the tape itself.
class Fitting : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    auto model = body::BodyModel::load(test::body_path());
    if (!model) return;
    model_ = new body::BodyModel(std::move(*model));
    customer_ = new Customer;
    customer_->visit = "one";
    customer_->woman = true;
    customer_->params.gender = 0;
    customer_->params.age_years = 35;
    std::vector<Vec3f> rest(static_cast<std::size_t>(model_->vertex_count()));
    model_->morph(customer_->params, rest);
    customer_->pose = body::relaxed_pose(body::rest_skeleton(*model_, rest), body::relaxed_spread_deg(*model_, rest));
    std::vector<float> values(builtin_tape().definitions.size());
    body::TapeMeasurer(*model_).measure(builtin_tape(), customer_->params, values);
    customer_->fits = fits_of(builtin_wardrobe(), builtin_size_system(), 1, builtin_tape(), values, {});
  }
  static void TearDownTestSuite() {
    delete customer_;
    delete model_;
    model_ = nullptr;
  }
  void SetUp() override {
    if (model_ == nullptr) GTEST_SKIP() << "no body file";
  }
  // Asks again until it is made.
  static PageAnswer made(FittingRoom& room, const Query& query) {
    PageAnswer answer = room.ask(query);
    for (int i = 0; i < 3000 && answer.status == 202; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      answer = room.ask(query);
    }
    return answer;
  }
  static nlohmann::json document_of(const PageAnswer& answer) {
    const std::string& glb = answer.file->bytes;
    std::uint32_t length = 0;
    std::memcpy(&length, glb.data() + 12, sizeof length);
    return nlohmann::json::parse(glb.substr(20, length));
  }
  static inline body::BodyModel* model_ = nullptr;
  static inline Customer* customer_ = nullptr;
};

TEST_F(Fitting, RefusesWhatIsNoQuery) {
  FittingRoom room(test::body_path(), [](const std::string&) {});
  const Query whole = {{"visit", "one"}, {"top", "t_shirt"}, {"top_size", "M"}};
  EXPECT_EQ(room.ask(whole).status, 404U);  // no person is here
  room.welcome(*customer_);
  const std::pair<Query, const char*> refused[] = {
      {{{"top", "t_shirt"}, {"top_size", "M"}}, "visit"},
      {{{"visit", "one"}, {"visit", "one"}}, "twice"},
      {{{"visit", "one"}, {"top", "t_shirt"}}, "top_size"},
      {{{"visit", "one"}, {"bottom_size", "M"}}, "bottom"},
      {{{"visit", "one"}, {"top", "trousers"}, {"top_size", "M"}}, "no top"},
      {{{"visit", "one"}, {"bottom", "t_shirt"}, {"bottom_size", "M"}}, "no bottom"},
      {{{"visit", "one"}, {"top", "../t_shirt"}, {"top_size", "M"}}, "no top"},
      {{{"visit", "one"}, {"top", "t_shirt"}, {"top_size", "m"}}, "no size"},
      {{{"visit", "one"}, {"colours", "red"}}, "colours"},
      {{{"visit", "one"}, {"hat", "M"}}, "field"},
  };
  for (const auto& [query, why] : refused) {
    const auto answer = room.ask(query);
    EXPECT_EQ(answer.status, 400U) << why;
    EXPECT_THAT(answer.text, HasSubstr(why));
  }
  EXPECT_EQ(room.ask(Query{{"visit", "two"}}).status, 404U);
  room.forget();
  EXPECT_EQ(room.ask(whole).status, 404U);
}

TEST_F(Fitting, MakesWhatWasAskedForLastAndKeepsIt) {
  std::atomic<int> said{0};
  FittingRoom room(test::body_path(), [&](const std::string& visit) { said += visit == "one"; });
  room.welcome(*customer_);
  const auto bare = made(room, {{"visit", "one"}});
  ASSERT_EQ(bare.status, 200U) << bare.text;
  const bool has_look = !model_->data().look.empty();  // then eyes and hair follow
  EXPECT_EQ(document_of(bare)["materials"].size(), has_look ? 3U : 1U);
  EXPECT_EQ(room.ask(Query{{"visit", "one"}}).file, bare.file);  // kept
  // Of two that wait the latter is made.
  const Query first = {{"visit", "one"}, {"top", "t_shirt"}, {"top_size", "XS"}};
  const Query ease = {{"visit", "one"}, {"bottom_size", "L"}, {"bottom", "shorts"}, {"colours", "ease"}};
  EXPECT_EQ(room.ask(first).status, 202U);
  const auto shorts = made(room, ease);
  ASSERT_EQ(shorts.status, 200U) << shorts.text;
  const auto document = document_of(shorts);
  ASSERT_EQ(document["materials"].size(), has_look ? 4U : 2U);
  EXPECT_EQ(document["materials"][1]["name"], "shorts");
  const auto& cloth = document["meshes"][0]["primitives"][1]["attributes"];
  ASSERT_TRUE(cloth.contains("COLOR_0"));
  EXPECT_EQ(document["accessors"][cloth["COLOR_0"].get<std::size_t>()]["count"],
            document["accessors"][cloth["POSITION"].get<std::size_t>()]["count"]);
  EXPECT_LT(shorts.file->bytes.size(), 3U << 20U);
  EXPECT_GE(said, 2);
  // The next person finds nothing of this one.
  Customer next = *customer_;
  next.visit = "two";
  room.welcome(next);
  EXPECT_EQ(room.ask(ease).status, 404U);
}

// One hue from dark to light, and no spot: over a breast a T-shirt is hardly darker than beside it, in any size.
TEST_F(Fitting, TheMapOfEaseIsCalm) {
  FittingRoom room(test::body_path(), [](const std::string&) {});
  room.welcome(*customer_);
  for (const char* size : {"XS", "M"}) {
    const auto shirt = made(room, {{"visit", "one"}, {"top", "t_shirt"}, {"top_size", size}, {"colours", "ease"}});
    ASSERT_EQ(shirt.status, 200U) << shirt.text;
    const auto document = document_of(shirt);
    const std::string& glb = shirt.file->bytes;
    std::uint32_t json_bytes = 0;
    std::memcpy(&json_bytes, glb.data() + 12, sizeof json_bytes);
    const auto data_of = [&](const nlohmann::json& accessor) {
      const auto& view = document["bufferViews"][accessor["bufferView"].get<std::size_t>()];
      return glb.data() + 20 + json_bytes + 8 + view.value("byteOffset", 0) + accessor.value("byteOffset", 0);
    };
    const auto& attributes = document["meshes"][0]["primitives"][1]["attributes"];
    const auto& colour = document["accessors"][attributes["COLOR_0"].get<std::size_t>()];
    const auto& position = document["accessors"][attributes["POSITION"].get<std::size_t>()];
    const char *colours = data_of(colour), *positions = data_of(position);
    const auto count = colour["count"].get<std::size_t>();
    std::vector<std::array<float, 3>> points(count);
    std::memcpy(points.data(), positions, count * sizeof points[0]);
    float top = 0;
    for (const auto& p : points) top = std::max(top, p[1]);
    std::vector<int> front;  // the trunk's, from the collar down to the waist
    for (std::size_t i = 0; i < count; ++i) {
      const auto* c = reinterpret_cast<const unsigned char*>(colours) + 4 * i;
      ASSERT_LE(c[1], c[0]) << "greenish";
      ASSERT_LE(c[0], c[2]) << "reddish";
      const auto& p = points[i];
      if (p[2] > 0.03F && std::abs(p[0]) < 0.14F && p[1] < top - 0.12F && p[1] > top - 0.36F) front.push_back(c[0]);
    }
    ASSERT_GT(front.size(), 200U);
    std::sort(front.begin(), front.end());
    const int darkest = front.front(), usual = front[front.size() / 2];
    RecordProperty(std::string("spot_") + size, usual - darkest);
    EXPECT_LE(usual - darkest, 60) << size << ": of 255; " << front.size() << " vertices";
  }
}

// Garments, sizes, bare and the map of ease, in Chromium, on a page as wide as a telephone's as well.
TEST_F(Fitting, ABrowserTriesClothesOn) {
  if (!test::Browser::installed()) GTEST_SKIP() << "no chromium: scripts/deps browser";
  test::TestFolder folder;
  LivePageSettings settings;
  settings.address.port = 0;
  settings.visit.ask = false;
  settings.body_path = test::body_path();
  auto page = LivePage::open(settings);
  ASSERT_TRUE(page) << page.error().message;
  const body::Avatar avatar{model_, customer_->params, customer_->pose};
  const auto glb = body::glb_of(avatar);
  ASSERT_TRUE(glb);
  (*page)->begin({}, 30);
  (*page)->permit();
  (*page)->may_try_on(*customer_);
  ASSERT_TRUE((*page)->measured(avatar, *glb));
  Json result = {{"measurements", Json::object()},
                 {"sex", {{"female", 1}}},
                 {"views", "front"},
                 {"clothing", {{"answered_as", "bare"}}},
                 {"fit", Json::array()}};
  for (const GarmentFit& fit : customer_->fits) {
    Json json = Json::parse(fit_json(fit));
    if (fit.garment == "shorts") json["fits"] = false;
    result["fit"].push_back(json);
  }
  (*page)->publish({{"event", "measured"}, {"frames", 30}, {"person", 1}, {"result", result}});

  test::Browser browser(folder.path(""), {"--window-size=390,844"});
  ASSERT_TRUE(browser.ready()) << browser.messages();
  browser.go((*page)->url());
  ASSERT_TRUE(browser.wait_for("return document.body.dataset.avatar === '1'")) << browser.run("return failures");
  ASSERT_EQ(browser.run("return document.getElementById('tryon').hidden"), false);
  const auto materials = [&] {
    return browser.run(
        "const m = []; stage.avatar.traverse((o) => { if (o.material) m.push(o.material.name); });"
        "return m;");
  };
  const bool has_look = !model_->data().look.empty();
  const auto with_look = [&](nlohmann::json names) {
    for (const char* name : {"eyes", "hair"})
      if (has_look) names.push_back(name);
    return names;
  };
  // The texture is shown, not only sent: the page's policy lets three.js read it out of the .glb.
  if (has_look) {
    EXPECT_TRUE(browser.wait_for(
        "let shown = 0; stage.avatar.traverse((o) => { if (o.material && o.material.map && o.material.map.image)"
        " shown += o.material.map.image.width >= 16 ? 1 : 0; }); return shown >= 3;"));
  }
  const auto press = [&](const std::string& selector) {
    EXPECT_EQ(
        browser.run("const b = document.querySelector('" + selector + "'); if (b) b.click(); return Boolean(b);"),
        true)
        << selector;
    EXPECT_TRUE(browser.wait_for("return fitting.shown !== null && fitting.shown === fitting.asked"))
        << browser.run("return [fitting.asked, fitting.shown, fitting.status, failures]");
  };
  const auto part = [&](const std::string& name) {
    browser.run("document.querySelector('#tryon [data-part=" + name + "]').click()");
  };
  const std::string verdict = "return document.querySelector('#tryon .verdict').textContent";
  EXPECT_THAT(browser.run(verdict).get<std::string>(), HasSubstr("(your best size): "));
  part("bottom");
  press("#fitting-bottom [data-garment=skirt]");
  EXPECT_EQ(materials(), with_look({"skin", "skirt", "t_shirt"}));
  press("#fitting-bottom [data-garment=shorts]");
  // Nothing is called best that does not fit.
  EXPECT_THAT(browser.run(verdict).get<std::string>(), HasSubstr("(the closest size, none fits): "));
  press("#fitting-bottom [data-garment=skirt]");
  // Trousers that stand out of a shirt's hem by some millimetres are not seen.
  const auto drawn_nearer = [&] {
    return browser.run(
        "const m = []; stage.avatar.traverse((o) => { if (o.material && o.material.polygonOffset && "
        "o.material.polygonOffsetUnits < -500) m.push(o.material.name); }); return m;");
  };
  EXPECT_EQ(drawn_nearer(), nlohmann::json::array({"t_shirt"}));
  part("top");
  press("#fitting-top [data-garment=dress]");
  EXPECT_EQ(drawn_nearer(), nlohmann::json::array());
  EXPECT_EQ(materials(), with_look({"skin", "dress"}));
  press("#fitting-top [data-garment=t_shirt]");
  EXPECT_EQ(materials(), with_look({"skin", "skirt", "t_shirt"})) << "what the dress took the place of comes back";
  press("#fitting-top .sizes button:last-child");
  EXPECT_THAT(browser.run(verdict).get<std::string>(), HasSubstr("3XL: a bit loose at the "));
  EXPECT_THAT(browser.run("return fitting.shown").get<std::string>(), HasSubstr("top_size=3XL"));
  press("#fitting-ease");
  EXPECT_EQ(
      browser.run("let n = 0; stage.avatar.traverse((o) => { if (o.geometry && o.geometry.attributes.color) ++n; });"
                  "return n;"),
      2);
  const auto keep = [&](const char* name) {
    if (const char* kept = std::getenv("IM2FIT_SCREENSHOTS"))
      test::write_text(std::string(kept) + "/fitting-" + name + ".png", browser.screenshot());
  };
  press("#fitting-top [data-size=S]");
  keep("ease");
  // Two sizes: the room makes one after the other; a third takes the place of the first, and one stays.
  const std::string both = "return fitting.shownBeside !== null && !fitting.pending() && stage.beside !== null";
  press("#fitting-compare");
  ASSERT_TRUE(browser.wait_for(both)) << browser.run("return [fitting.askedBeside, fitting.status, failures]");
  EXPECT_THAT(browser.run("return fitting.shownBeside").get<std::string>(), HasSubstr("top_size=M"));
  EXPECT_THAT(browser.run("return fitting.shown").get<std::string>(), HasSubstr("top_size=S"));
  press("#fitting-top [data-size=XL]");
  ASSERT_TRUE(browser.wait_for(both));
  EXPECT_THAT(browser.run("return fitting.shownBeside").get<std::string>(), HasSubstr("top_size=S"));
  EXPECT_EQ(browser.run("return stage.avatarLeft"), false) << "the larger on the right";
  browser.resize(1280, 800);
  browser.run("window.dispatchEvent(new Event('pointerdown'))");
  browser.run_until_called("requestAnimationFrame(() => requestAnimationFrame(arguments[0]))");
  keep("two-ease");
  press("#fitting-ease");
  ASSERT_TRUE(browser.wait_for(both));
  browser.run_until_called("requestAnimationFrame(() => requestAnimationFrame(arguments[0]))");
  keep("two");
  press("#fitting-compare");
  EXPECT_EQ(browser.run("return [stage.beside, stage.avatar.position.x]"), (nlohmann::json{nullptr, 0}));
  press("#fitting-bare");
  EXPECT_EQ(materials(), with_look(nlohmann::json::array({"skin"})));
  browser.resize(390, 844);
  // Nothing is wider than the screen, and nothing went wrong that only a console hears of.
  EXPECT_EQ(browser.run("return document.documentElement.scrollWidth <= window.innerWidth"), true);
  EXPECT_EQ(browser.run("return failures"), nlohmann::json::array());
}

}  // namespace
}  // namespace im2fit::apps
