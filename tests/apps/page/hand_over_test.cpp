// SPDX-License-Identifier: Apache-2.0
// A result for one phone: its token, the code that shows it, and the server where phones take it and find nothing
// else.
#include "apps/kiosk/hand_over.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "apps/kiosk/page_server.h"
#include "read_qr.h"

namespace im2fit::apps {
namespace {

using std::chrono::milliseconds;
using Time = HandOver::Time;

std::shared_ptr<const PageFile> result_of(const std::string& text) {
  return std::make_shared<const PageFile>(PageFile{"application/json", text});
}

TEST(HandOver, IsGivenOnceAndOnlyForItsToken) {
  HandOver hand_over(kHandOverMax);
  const Time now{};
  EXPECT_EQ(hand_over.take("", now), nullptr) << "nothing waits";
  const std::string token = hand_over.offer(result_of("first"), now);
  EXPECT_EQ(token.size(), 32U);
  std::string forged = token;
  forged.back() = forged.back() == '0' ? '1' : '0';
  for (const std::string& wrong : {std::string(), forged, token + "0", token.substr(1), std::string(5000, '0')})
    EXPECT_EQ(hand_over.take(wrong, now), nullptr) << wrong.size();
  const auto given = hand_over.take(token, now);
  ASSERT_NE(given, nullptr) << "wrong ones before it change nothing";
  EXPECT_EQ(given->bytes, "first");
  EXPECT_EQ(hand_over.take(token, now), nullptr);
}

TEST(HandOver, EndsWithTimeWithTheNextOneAndWhenForgotten) {
  HandOver hand_over(milliseconds(1000));
  Time now{};
  std::string token = hand_over.offer(result_of("a"), now);
  EXPECT_EQ(hand_over.take(token, now + milliseconds(1000)), nullptr);
  EXPECT_EQ(hand_over.take(token, now), nullptr) << "it is over for good";
  token = hand_over.offer(result_of("b"), now);
  const std::string next = hand_over.offer(result_of("c"), now);
  EXPECT_NE(next, token);
  EXPECT_EQ(hand_over.take(token, now), nullptr);
  EXPECT_EQ(hand_over.take(next, now + milliseconds(999))->bytes, "c");
  token = hand_over.offer(result_of("d"), now);
  hand_over.forget();
  EXPECT_EQ(hand_over.take(token, now), nullptr);
}

TEST(QrCode, IsReadAsTheTextItWasMadeOf) {
  if (!test::kReadsQr) GTEST_SKIP() << "no ZXing here: scripts/deps test";
  for (const std::string& text :
       {std::string("http://192.168.1.20:8018/#0123456789abcdef0123456789abcdef"), std::string("x"),
        std::string("http://[fd00::1234:5678:9abc:def0]:65535/#0123456789abcdef0123456789abcdef"),
        std::string(1000, 'q')}) {
    const auto code = qr_code(text);
    ASSERT_TRUE(code) << code.error().message;
    EXPECT_EQ(test::read_qr_path(code->path, code->side), text);
  }
  EXPECT_EQ(qr_code("").error().code, ErrorCode::invalid_argument);
  EXPECT_EQ(qr_code(std::string(3000, 'q')).error().code, ErrorCode::invalid_argument);
}

class Phones : public testing::Test {
 protected:
  void SetUp() override {
    PageHandlers handlers;
    handlers.take = [this](std::string_view token) -> PageAnswer {
      const std::lock_guard lock(mutex_);
      asked_.emplace_back(token);
      return token == "right" ? PageAnswer{200, result_of("{}"), ""} : PageAnswer{404, nullptr, "nothing there"};
    };
    // Whatever stands on a board, phones are not to see it.
    board_.put("/result.json", {"application/json", "{}"});
    auto server = PageServer::open({"127.0.0.1", 0}, board_, std::move(handlers));
    ASSERT_TRUE(server) << server.error().message;
    server_ = std::move(*server);
    url_ = server_->url().substr(0, server_->url().size() - 1);
  }
  int post(const httplib::Headers& headers, const std::string& body = "") const {
    const auto answer = httplib::Client(url_).Post("/take", headers, body, "text/plain");
    return answer ? answer->status : 0;
  }
  Board board_;
  std::mutex mutex_;
  std::vector<std::string> asked_;
  std::unique_ptr<PageServer> server_;
  std::string url_;
};

TEST_F(Phones, FindThePageThatTakesAndNothingElse) {
  httplib::Client client(url_);
  for (const char* path : {"/", "/handed.js", "/words.js", "/page.css", "/lang/en.json", "/lang/zh.json"})
    EXPECT_EQ(client.Get(path)->status, 200) << path;
  EXPECT_THAT(client.Get("/")->body, testing::HasSubstr("/handed.js"));
  EXPECT_EQ(client.Get("/", {{"Sec-Fetch-Site", "cross-site"}})->status, 200) << "a scanner that is a page itself";
  for (const char* path :
       {"/result.json", "/events", "/picture.png", "/avatar.glb", "/page.js", "/operator", "/operator/token",
        "/tryon.glb?visit=1", "/handed.html", "/index.html", "/lang/../page.js"})
    EXPECT_EQ(client.Get(path)->status, 404) << path;
  EXPECT_EQ(client.Get("/take")->status, 405);
  for (const char* path : {"/", "/hand-over", "/consent", "/delete"})
    EXPECT_EQ(client.Post(path, {{"Origin", url_}}, "", "text/plain")->status, 405) << path;
  EXPECT_TRUE(asked_.empty()) << "to look at the page takes nothing";
}

TEST_F(Phones, TakeByThePageItselfAlone) {
  const httplib::Headers token = {{"X-Im2fit-Token", "right"}};
  const auto with = [&](const std::string& name, const std::string& value) {
    httplib::Headers headers = token;
    headers.emplace(name, value);
    return headers;
  };
  EXPECT_EQ(post(token), 403) << "no Origin";
  EXPECT_EQ(post(with("Origin", "http://evil.example")), 403);
  EXPECT_EQ(post({{"Origin", url_}}), 403) << "no token: a form cannot send one";
  EXPECT_EQ(post({{"Origin", url_}, {"X-Im2fit-Token", "right"}, {"Sec-Fetch-Site", "cross-site"}}), 403);
  EXPECT_EQ(post({{"Origin", url_}, {"X-Im2fit-Token", "right"}, {"X-Im2fit-Token", "right"}}), 403);
  EXPECT_NE(post(with("Origin", url_), "a body"), 200);
  EXPECT_TRUE(asked_.empty());
  EXPECT_EQ(post({{"Origin", url_}, {"X-Im2fit-Token", "wrong"}}), 404);
  EXPECT_EQ(post(with("Origin", url_)), 200);
  EXPECT_EQ(asked_, (std::vector<std::string>{"wrong", "right"}));
}

}  // namespace
}  // namespace im2fit::apps
