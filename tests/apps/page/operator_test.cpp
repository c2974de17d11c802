// SPDX-License-Identifier: Apache-2.0
// Access to the operator's part of the page: it needs the password and, to change anything, the page's token.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>
#include <sys/stat.h>

#include <atomic>
#include <fstream>
#include <memory>
#include <mutex>
#include <thread>

#include "apps/kiosk/operator_gate.h"
#include "apps/kiosk/page_server.h"
#include "depth_folder.h"

namespace im2fit::apps {
namespace {

using httplib::Headers;
constexpr const char* kPassword = "correct horse battery";
constexpr const char* kJson = "application/json";

class Operator : public testing::Test {
 protected:
  void SetUp() override {
    PageHandlers handlers;
    handlers.operator_password = kPassword;
    handlers.operate = [this](const PageRequest& request) {
      const std::lock_guard lock(mutex_);
      asked_.push_back(std::string(request.post ? "POST " : "GET ") + std::string(request.path));
      body_ = request.body;
      return PageAnswer{200, nullptr, "operated"};
    };
    auto server = PageServer::open({"127.0.0.1", 0}, board_, std::move(handlers));
    ASSERT_TRUE(server) << server.error().message;
    server_ = std::move(*server);
    url_ = server_->url().substr(0, server_->url().size() - 1);
  }
  httplib::Client client(const std::string& cookie = "") const {
    httplib::Client c(url_);
    c.set_read_timeout(20);
    if (!cookie.empty()) c.set_default_headers({{"Cookie", cookie}});
    return c;
  }
  httplib::Result sign_in(const std::string& password) const {
    return client().Post("/operator/sign-in", {{"Origin", url_}}, "{\"password\": \"" + password + "\"}", kJson);
  }
  // "im2fit_operator_PORT=..."; "": the password is wrong.
  std::string cookie(const std::string& password = kPassword) const {
    const auto answer = sign_in(password);
    const std::string set = answer && answer->status == 200 ? answer->get_header_value("Set-Cookie") : "";
    return set.substr(0, set.find(';'));
  }
  // Of its cookie.
  std::string name() const { return "im2fit_operator_" + url_.substr(url_.rfind(':') + 1); }
  // As the operator's page posts.
  Headers own(const std::string& cookie) const {
    return {{"Origin", url_}, {"X-Im2fit-Token", client(cookie).Get("/operator/token")->body}};
  }
  int post(const std::string& cookie, const Headers& headers, const std::string& body = "{}",
           const char* type = kJson) const {
    const auto answer = client(cookie).Post("/operator/save", headers, body, type);
    return answer ? answer->status : 0;
  }
  Board board_;
  std::mutex mutex_;
  std::vector<std::string> asked_;
  std::string body_;
  std::unique_ptr<PageServer> server_;
  std::string url_;
};

// A browser has one jar of cookies for all ports of a machine.
TEST_F(Operator, TwoOnOneMachineKeepASessionEach) {
  const std::string first = cookie();
  EXPECT_THAT(first, testing::StartsWith(name() + "="));
  PageHandlers handlers;
  handlers.operator_password = kPassword;
  handlers.operate = [](const PageRequest&) { return PageAnswer{200, nullptr, "the second"}; };
  auto second = PageServer::open({"127.0.0.1", 0}, board_, std::move(handlers));
  ASSERT_TRUE(second) << second.error().message;
  const std::string url = std::exchange(url_, (*second)->url().substr(0, (*second)->url().size() - 1));
  const std::string both = first + "; " + cookie();
  EXPECT_EQ(client(both).Get("/operator/state")->status, 200);
  EXPECT_EQ(client(first).Get("/operator/state")->status, 401);
  url_ = url;
  EXPECT_EQ(client(both).Get("/operator/state")->status, 200) << "signing in at the second did not sign out here";
}

TEST_F(Operator, WithoutOneThereIsNothing) {
  auto server = PageServer::open({"127.0.0.1", 0}, board_);
  ASSERT_TRUE(server);
  url_ = (*server)->url().substr(0, (*server)->url().size() - 1);
  for (const char* path : {"/operator", "/operator/token", "/operator/state"})
    EXPECT_EQ(client().Get(path)->status, 404) << path;
  EXPECT_EQ(client().Post("/operator/save", {{"Origin", url_}}, "", "")->status, 405);
}

TEST_F(Operator, NothingIsToldOrDoneWithoutThePassword) {
  for (const std::string& cookie :
       {std::string(), name() + "=", name() + "=x", name() + "=" + std::string(32, '0')}) {
    for (const char* path : {"/operator/token", "/operator/state", "/operator/../operator/state", "/operator/x"}) {
      const auto answer = client(cookie).Get(path);
      ASSERT_TRUE(answer) << path;
      EXPECT_NE(answer->status, 200) << path;
    }
    const auto asked = client(cookie).Get("/operator/state");
    EXPECT_EQ(asked->status, 401);
    EXPECT_THAT(asked->get_header_value("WWW-Authenticate"), testing::Not(testing::HasSubstr("Basic")))
        << "the browser would keep it";
    EXPECT_EQ(client(cookie).Post("/operator/save", {{"Origin", url_}}, "{}", kJson)->status, 401);
  }
  httplib::Client basic = client();
  basic.set_basic_auth("operator", kPassword);
  EXPECT_EQ(basic.Get("/operator/state")->status, 401);
  EXPECT_THAT(asked_, testing::IsEmpty());
  EXPECT_THAT(client().Get("/operator")->body, testing::HasSubstr("id=\"password\"")) << "where one signs in";
  const std::string good = cookie();
  EXPECT_EQ(client(good).Get("/operator/state")->body, "operated\n");
  EXPECT_EQ(client("a=b; " + good).Get("/operator/state")->status, 200);
  EXPECT_EQ(client().Get("/")->status, 200) << "a customer's page needs none";
}

TEST_F(Operator, IsNotServedWithoutAPassword) {
  PageHandlers handlers;
  handlers.operate = [](const PageRequest&) { return PageAnswer{}; };
  EXPECT_FALSE(PageServer::open({"127.0.0.1", 0}, board_, std::move(handlers)));
}

TEST_F(Operator, TheSessionIsACookieThatNoScriptAndNoOtherSiteGetsAndSigningOutEndsIt) {
  const auto answer = sign_in(kPassword);
  ASSERT_EQ(answer->status, 200);
  const std::string set = answer->get_header_value("Set-Cookie");
  for (const char* part : {"; Path=/operator", "; HttpOnly", "; SameSite=Strict"})
    EXPECT_THAT(set, testing::HasSubstr(part));
  EXPECT_THAT(set, testing::Not(testing::HasSubstr("Max-Age"))) << "it goes with the browser";
  const std::string mine = set.substr(0, set.find(';')), other = cookie();
  EXPECT_NE(mine, other);
  const Headers of_mine = own(mine);
  EXPECT_EQ(post(other, of_mine), 403) << "the token of another session";
  EXPECT_EQ(client(mine).Post("/operator/sign-out", {{"Origin", url_}}, "{}", kJson)->status, 403);
  EXPECT_EQ(client(mine).Post("/operator/sign-out", of_mine, "{}", kJson)->status, 200);
  EXPECT_EQ(client(mine).Get("/operator/state")->status, 401);
  EXPECT_EQ(post(mine, of_mine), 401);
  EXPECT_EQ(client(other).Get("/operator/state")->status, 200);
}

TEST_F(Operator, SigningInIsForThePageItselfAndInJson) {
  const std::string body = std::string(R"({"password": ")") + kPassword + "\"}";
  const auto status = [&](const Headers& headers, const std::string& text, const char* type) {
    return client().Post("/operator/sign-in", headers, text, type)->status;
  };
  EXPECT_EQ(status({}, body, kJson), 403) << "no Origin";
  EXPECT_EQ(status({{"Origin", "http://shop.example"}}, body, kJson), 403);
  EXPECT_EQ(status({{"Origin", url_}}, body, "text/plain"), 415);
  EXPECT_EQ(status({{"Origin", url_}}, "[]", kJson), 403);
  EXPECT_EQ(status({{"Origin", url_}}, R"({"password": 7})", kJson), 403);
  EXPECT_EQ(status({{"Origin", url_}}, R"({"password": ""})", kJson), 403);
  EXPECT_EQ(status({{"Origin", url_}}, body, kJson), 200);
}

// Somebody at the same address guesses without a pause: the operator goes on, may sign in, and guessing is slow.
TEST_F(Operator, IsNeverLockedOutByWrongPasswords) {
  const std::string before = cookie();
  std::atomic<bool> over{false};
  std::atomic<int> guesses{0};
  std::thread brute([&] {
    for (; !over; ++guesses) EXPECT_EQ(sign_in("not the password at all")->status, 403);
  });
  while (guesses <= OperatorGate::kWrongMax) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  const auto start = std::chrono::steady_clock::now();
  const int known = guesses;
  for (int i = 0; i < 50; ++i) EXPECT_EQ(client(before).Get("/operator/state")->status, 200);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::milliseconds(900)) << "who is signed in waits not";
  EXPECT_NE(cookie(), "") << "the right password is always served";
  EXPECT_NE(cookie(), "");
  const auto took = std::chrono::steady_clock::now() - start;
  over = true;
  brute.join();
  EXPECT_LE(guesses - known, took / OperatorGate::kSlowness + 2);
}

TEST_F(Operator, ADelayedAnswerDoesNotHoldUpTheEnd) {
  for (int i = 0; i < OperatorGate::kWrongMax; ++i) sign_in("wrong");
  std::thread waiting([&] { sign_in("wrong"); });
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  const auto start = std::chrono::steady_clock::now();
  server_.reset();
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::milliseconds(700));
  waiting.join();
}

TEST_F(Operator, OnlyItsOwnPagePosts) {
  const std::string me = cookie(), good = client(me).Get("/operator/token")->body;
  EXPECT_EQ(good.size(), 32U);
  EXPECT_EQ(post(me, {{"X-Im2fit-Token", good}}), 403) << "no Origin";
  EXPECT_EQ(post(me, {{"Origin", url_}}), 403) << "no token";
  EXPECT_EQ(post(me, {{"Origin", url_}, {"X-Im2fit-Token", std::string(32, '0')}}), 403);
  EXPECT_EQ(post(me, {{"Origin", url_}, {"X-Im2fit-Token", good.substr(1)}}), 403);
  EXPECT_EQ(post(me, {{"Origin", url_}, {"X-Im2fit-Token", ""}}), 403);
  EXPECT_EQ(post(me, {{"Origin", url_}, {"X-Im2fit-Token", good}, {"X-Im2fit-Token", good}}), 403) << "two of them";
  EXPECT_EQ(post(me, {{"Origin", "http://shop.example"}, {"X-Im2fit-Token", good}}), 403);
  EXPECT_EQ(post(me, {{"Origin", "null"}, {"X-Im2fit-Token", good}}), 403);
  EXPECT_EQ(post(me, {{"Origin", url_}, {"X-Im2fit-Token", good}, {"Sec-Fetch-Site", "cross-site"}}), 403);
  EXPECT_EQ(post(me, {{"Origin", url_}, {"X-Im2fit-Token", good}, {"Host", "shop.example"}}), 403);
  EXPECT_EQ(post(me, own(me), "a=b", "application/x-www-form-urlencoded"), 415)
      << "what a form of another site may send";
  EXPECT_EQ(post(me, own(me), "{}", "text/plain"), 415);
  EXPECT_EQ(client().Delete("/operator/save")->status, 405);
  EXPECT_THAT(asked_, testing::IsEmpty());
  EXPECT_EQ(post(me, own(me), R"({"a": 1})"), 200);
  EXPECT_EQ(body_, R"({"a": 1})");
}

TEST_F(Operator, ABodyHas64KilobytesAtMost) {
  const std::string me = cookie();
  const std::string whole(kBodyBytesMax, 'x');
  EXPECT_EQ(post(me, own(me), whole), 200);
  EXPECT_EQ(body_, whole);
  asked_.clear();
  // Refused from its length alone; a client that goes on sending may see the connection end instead.
  const int status = post(me, own(me), whole + "x");
  EXPECT_TRUE(status == 413 || status == 0) << status;
  Headers chunked = own(me);
  chunked.emplace("Transfer-Encoding", "chunked");
  const int unmeasured = post(me, chunked, "2\r\n{}\r\n0\r\n\r\n");
  EXPECT_TRUE(unmeasured == 411 || unmeasured == 400 || unmeasured == 0) << unmeasured;
  EXPECT_THAT(asked_, testing::IsEmpty());
  EXPECT_EQ(post(me, own(me)), 200) << "goes on serving";
}

TEST_F(Operator, OtherPathsStillTakeNoBody) {
  const std::string me = cookie();
  EXPECT_EQ(client().Post("/picture.png", own(me), "{}", kJson)->status, 405);
  EXPECT_EQ(client().Post("/operators", own(me), "{}", kJson)->status, 405);
  EXPECT_THAT(asked_, testing::IsEmpty());
}

TEST(OperatorGate, SecretsAreComparedWhole) {
  EXPECT_TRUE(same_secret("abc", "abc"));
  for (const char* other : {"", "a", "abd", "abcabc", "abcd", "xbc"})
    EXPECT_FALSE(same_secret("abc", other)) << other;
  EXPECT_FALSE(same_secret("", ""));
}

TEST(OperatorGate, LimitsWrongPasswordsByAddress) {
  OperatorGate gate(kPassword);
  OperatorGate::Time now{};
  const auto wait = [&](const std::string& address, const char* password = "wrong") {
    const OperatorGate::SignIn answer = gate.sign_in(password, address, now);
    EXPECT_EQ(answer.session.empty(), std::string(password) == "wrong");
    return answer.wait;
  };
  constexpr auto kNone = std::chrono::milliseconds(0);
  for (int i = 0; i < OperatorGate::kWrongMax; ++i) EXPECT_EQ(wait("10.0.0.1"), kNone);
  EXPECT_EQ(wait("10.0.0.1"), OperatorGate::kSlowness);
  EXPECT_EQ(wait("10.0.0.1", kPassword), OperatorGate::kSlowness) << "else a guess that does not wait would tell";
  EXPECT_EQ(wait("10.0.0.2"), kNone);
  EXPECT_EQ(wait("10.0.0.2", kPassword), kNone);
  now += OperatorGate::kWrongWindow;
  EXPECT_EQ(wait("10.0.0.1"), kNone);
  for (int i = 0; i < OperatorGate::kWrongMax; ++i) wait("2001:db8:1:2::" + std::to_string(i));
  EXPECT_EQ(wait("2001:db8:1:2:ffff::9"), OperatorGate::kSlowness) << "one network, one client";
  EXPECT_EQ(wait("2001:db8:1:3::9"), kNone);
  EXPECT_EQ(wait("::ffff:10.1.1.1"), kNone);
  for (std::size_t i = 0; i < 3 * OperatorGate::kAddressesMax; ++i) wait("10.1." + std::to_string(i));
  EXPECT_EQ(wait("10.3.3.3"), OperatorGate::kSlowness) << "of many addresses the later ones are counted together";
}

TEST(OperatorGate, ASessionEndsWhenNobodyUsesItAndAfterADay) {
  OperatorGate gate(kPassword);
  EXPECT_EQ(OperatorGate("").sign_in("", "a", {}).session, "") << "no password admits nobody";
  OperatorGate::Time now{};
  const std::string first = gate.sign_in(kPassword, "a", now).session;
  const std::string token = gate.token_of(first, true, now);
  EXPECT_EQ(token.size(), 32U);
  now += OperatorGate::kIdleMax - std::chrono::seconds(1);
  EXPECT_EQ(gate.token_of(first, true, now), token);
  now += OperatorGate::kIdleMax - std::chrono::seconds(1);
  EXPECT_EQ(gate.token_of(first, false, now), token) << "a poll keeps nothing";
  now += std::chrono::seconds(1);
  EXPECT_EQ(gate.token_of(first, true, now), "");
  const std::string second = gate.sign_in(kPassword, "a", now).session;
  const auto end = now + OperatorGate::kSessionMax;
  for (; now < end; now += std::chrono::minutes(10)) EXPECT_NE(gate.token_of(second, true, now), "");
  EXPECT_EQ(gate.token_of(second, true, now), "");
  std::vector<std::string> many;
  for (std::size_t i = 0; i <= OperatorGate::kSessionsMax; ++i)
    many.push_back(gate.sign_in(kPassword, "a", now += std::chrono::seconds(1)).session);
  EXPECT_EQ(gate.token_of(many[0], true, now), "") << "it made room";
  EXPECT_NE(gate.token_of(many[1], true, now), "");
  gate.sign_out(many[1]);
  EXPECT_EQ(gate.token_of(many[1], true, now), "");
  EXPECT_EQ(gate.token_of("", true, now), "");
}

// Customers are measured, and the page shows it, while the operator is away.
TEST(OperatorGate, WhatAPageThatNobodyTouchesAsksForKeepsNoSession) {
  for (const char* path : {"/operator/state", "/operator/plan", "/operator/statistics.csv", "/operator/sessions"}) {
    OperatorGate gate(kPassword);
    OperatorGate::Time now{};
    const std::string session = gate.sign_in(kPassword, "a", now).session;
    for (int minute = 1; minute < 30; ++minute) {
      now += std::chrono::minutes(1);
      EXPECT_NE(gate.token_of(session, !asked_untouched(path), now), "") << path;
    }
    now += std::chrono::minutes(1);
    EXPECT_EQ(gate.token_of(session, !asked_untouched(path), now), "") << path;
  }
  for (const char* path : {"/operator/token", "/operator/session", "/operator/picture"})
    EXPECT_FALSE(asked_untouched(path)) << path;
}

TEST(OperatorGate, APasswordFileIsItsOwnersAndLongEnough) {
  const test::TestFolder folder;
  const std::string path = folder.path("password");
  const auto written = [&](const std::string& text, mode_t mode) {
    test::write_text(path, text);
    ::chmod(path.c_str(), mode);
    return read_password(path);
  };
  EXPECT_FALSE(read_password(path));
  EXPECT_EQ(*written("correct horse battery\n", 0600), "correct horse battery");
  EXPECT_THAT(written("correct horse battery\n", 0644).error().message, testing::HasSubstr("chmod 600"));
  EXPECT_THAT(written("short\nand more of it\n", 0600).error().message, testing::HasSubstr("12 characters"));
  EXPECT_FALSE(written(std::string(300, 'x'), 0600));
  EXPECT_FALSE(written("with a \x1b control\n", 0600));
}

}  // namespace
}  // namespace im2fit::apps
