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
  void serve(const std::string& password) {
    PageHandlers handlers;
    handlers.operator_password = password;
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
  httplib::Client client(const std::string& password = "") const {
    httplib::Client c(url_);
    c.set_read_timeout(20);
    if (!password.empty()) c.set_basic_auth("operator", password);
    return c;
  }
  std::string token(const std::string& password = "") const {
    const auto answer = client(password).Get("/operator/token");
    return answer ? answer->body : "";
  }
  // As the operator's page posts.
  Headers own() const { return {{"Origin", url_}, {"X-Im2fit-Token", token()}}; }
  int post(const Headers& headers, const std::string& body = "{}", const char* type = kJson) const {
    const auto answer = client().Post("/operator/save", headers, body, type);
    return answer ? answer->status : 0;
  }
  Board board_;
  std::mutex mutex_;
  std::vector<std::string> asked_;
  std::string body_;
  std::unique_ptr<PageServer> server_;
  std::string url_;
};

TEST_F(Operator, WithoutOneThereIsNothing) {
  auto server = PageServer::open({"127.0.0.1", 0}, board_);
  ASSERT_TRUE(server);
  url_ = (*server)->url().substr(0, (*server)->url().size() - 1);
  for (const char* path : {"/operator", "/operator/token", "/operator/state"})
    EXPECT_EQ(client().Get(path)->status, 404) << path;
  EXPECT_EQ(client().Post("/operator/save", {{"Origin", url_}}, "", "")->status, 405);
}

TEST_F(Operator, NothingIsToldOrDoneWithoutThePassword) {
  ASSERT_NO_FATAL_FAILURE(serve(kPassword));
  for (const char* path : {"/operator", "/operator/token", "/operator/state", "/operator/../operator/state"}) {
    const auto answer = client().Get(path);
    ASSERT_TRUE(answer) << path;
    EXPECT_NE(answer->status, 200) << path;
  }
  const auto asked = client().Get("/operator");
  EXPECT_EQ(asked->status, 401);
  EXPECT_THAT(asked->get_header_value("WWW-Authenticate"), testing::HasSubstr("Basic realm="));
  EXPECT_EQ(client().Post("/operator/save", {{"Origin", url_}}, "{}", kJson)->status, 401);
  EXPECT_THAT(asked_, testing::IsEmpty());
  EXPECT_EQ(client(kPassword).Get("/operator")->status, 200);
  EXPECT_EQ(client(kPassword).Get("/operator/state")->body, "operated\n");
  EXPECT_EQ(client().Get("/")->status, 200) << "a customer's page needs none";
}

TEST_F(Operator, WrongPasswordsAreFewASecond) {
  ASSERT_NO_FATAL_FAILURE(serve(kPassword));
  int refused = 0, too_many = 0;
  for (const char* wrong : {"correct horse batterx", "correct horse batter", "correct horse battery ", "x",
                            "operator", "correct horse", "Correct horse battery", "y", "z"}) {
    const int status = client(wrong).Get("/operator/state")->status;
    refused += status == 401;
    too_many += status == 429;
  }
  EXPECT_EQ(refused + too_many, 9);
  EXPECT_GE(too_many, 1);
  EXPECT_THAT(asked_, testing::IsEmpty());
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));
  EXPECT_EQ(client(kPassword).Get("/operator/state")->status, 200);
}

TEST_F(Operator, OnlyItsOwnPagePosts) {
  ASSERT_NO_FATAL_FAILURE(serve(""));
  const std::string good = token();
  EXPECT_EQ(good.size(), 32U);
  EXPECT_EQ(post({{"X-Im2fit-Token", good}}), 403) << "no Origin";
  EXPECT_EQ(post({{"Origin", url_}}), 403) << "no token";
  EXPECT_EQ(post({{"Origin", url_}, {"X-Im2fit-Token", std::string(32, '0')}}), 403);
  EXPECT_EQ(post({{"Origin", url_}, {"X-Im2fit-Token", good.substr(1)}}), 403);
  EXPECT_EQ(post({{"Origin", url_}, {"X-Im2fit-Token", ""}}), 403);
  EXPECT_EQ(post({{"Origin", url_}, {"X-Im2fit-Token", good}, {"X-Im2fit-Token", good}}), 403) << "two of them";
  EXPECT_EQ(post({{"Origin", "http://shop.example"}, {"X-Im2fit-Token", good}}), 403);
  EXPECT_EQ(post({{"Origin", "null"}, {"X-Im2fit-Token", good}}), 403);
  EXPECT_EQ(post({{"Origin", url_}, {"X-Im2fit-Token", good}, {"Sec-Fetch-Site", "cross-site"}}), 403);
  EXPECT_EQ(post({{"Origin", url_}, {"X-Im2fit-Token", good}, {"Host", "shop.example"}}), 403);
  EXPECT_EQ(post(own(), "a=b", "application/x-www-form-urlencoded"), 415) << "what a form of another site may send";
  EXPECT_EQ(post(own(), "{}", "text/plain"), 415);
  EXPECT_EQ(client().Delete("/operator/save")->status, 405);
  EXPECT_THAT(asked_, testing::IsEmpty());
  EXPECT_EQ(post(own(), R"({"a": 1})"), 200);
  EXPECT_EQ(body_, R"({"a": 1})");
}

TEST_F(Operator, ABodyHas64KilobytesAtMost) {
  ASSERT_NO_FATAL_FAILURE(serve(""));
  const std::string whole(kBodyBytesMax, 'x');
  EXPECT_EQ(post(own(), whole), 200);
  EXPECT_EQ(body_, whole);
  asked_.clear();
  // Refused from its length alone; a client that goes on sending may see the connection end instead.
  const int status = post(own(), whole + "x");
  EXPECT_TRUE(status == 413 || status == 0) << status;
  Headers chunked = own();
  chunked.emplace("Transfer-Encoding", "chunked");
  const int unmeasured = post(chunked, "2\r\n{}\r\n0\r\n\r\n");
  EXPECT_TRUE(unmeasured == 411 || unmeasured == 400 || unmeasured == 0) << unmeasured;
  EXPECT_THAT(asked_, testing::IsEmpty());
  EXPECT_EQ(post(own()), 200) << "goes on serving";
}

TEST_F(Operator, OtherPathsStillTakeNoBody) {
  ASSERT_NO_FATAL_FAILURE(serve(""));
  EXPECT_EQ(client().Post("/picture.png", own(), "{}", kJson)->status, 405);
  EXPECT_EQ(client().Post("/operators", own(), "{}", kJson)->status, 405);
  EXPECT_THAT(asked_, testing::IsEmpty());
}

TEST(OperatorGate, SecretsAreComparedWhole) {
  EXPECT_TRUE(same_secret("abc", "abc"));
  for (const char* other : {"", "a", "abd", "abcabc", "abcd", "xbc"})
    EXPECT_FALSE(same_secret("abc", other)) << other;
  EXPECT_FALSE(same_secret("", ""));
  EXPECT_NE(OperatorGate("").token(), OperatorGate("").token());
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
