// SPDX-License-Identifier: Apache-2.0
#include "apps/kiosk/page_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>

#include <chrono>
#include <iterator>
#include <memory>
#include <new>
#include <regex>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

namespace im2fit::apps {
namespace {

using testing::HasSubstr;

class Served : public testing::Test {
 protected:
  void SetUp() override {
    auto server = PageServer::open({"127.0.0.1", 0}, board_);
    ASSERT_TRUE(server) << server.error().message;
    server_ = std::move(*server);
  }
  httplib::Client client() const {
    httplib::Client c(server_->url().substr(0, server_->url().size() - 1));
    c.set_read_timeout(20);
    return c;
  }
  // A client that reads the stream until it ends or holds `enough`.
  struct Watcher {
    Watcher(httplib::Client c, std::string enough)
        : thread([this, client = std::make_shared<httplib::Client>(std::move(c)), enough = std::move(enough)] {
            ended = bool(client->Get("/events", [&](const char* data, std::size_t size) {
              text.append(data, size);
              return text.find(enough) == std::string::npos;
            }));
          }) {}
    ~Watcher() { join(); }
    void join() {
      if (thread.joinable()) thread.join();
    }
    std::string text;
    bool ended = false;  // by the server
    std::thread thread;
  };
  bool watched_by(int count) const {
    for (int i = 0; i < 2000 && server_->watchers() != count; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    return server_->watchers() == count;
  }
  Board board_;
  std::unique_ptr<PageServer> server_;
};

TEST_F(Served, ThePageAndAllItAsksForAreThere) {
  board_.put("/shop.css", {"text/css", std::string(501, ' ')});  // of a shop, which LivePage puts there
  const auto page = client().Get("/");
  ASSERT_TRUE(page);
  EXPECT_EQ(page->status, 200);
  EXPECT_THAT(page->get_header_value("Content-Type"), HasSubstr("text/html"));
  EXPECT_THAT(page->get_header_value("Content-Security-Policy"), HasSubstr("default-src 'self'"));
  const std::regex linked(R"re((?:src|href)="(/[^"]+\.(?:js|css))")re");
  int found = 0;
  for (std::sregex_iterator at(page->body.begin(), page->body.end(), linked), end; at != end; ++at, ++found) {
    const auto file = client().Get((*at)[1].str());
    ASSERT_TRUE(file) << (*at)[1];
    EXPECT_EQ(file->status, 200) << (*at)[1];
    EXPECT_GT(file->body.size(), 500U) << (*at)[1];
  }
  EXPECT_EQ(found, 16);
  // Nothing of another machine.
  EXPECT_EQ(page->body.find("http"), std::string::npos);
}

TEST_F(Served, FilesOfTheBoardAppearWhenTheyAreThere) {
  EXPECT_EQ(client().Get("/picture.png")->status, 404);
  board_.put("/picture.png", {"image/png", std::string("\0binary", 7)});
  const auto file = client().Get("/picture.png?3");
  EXPECT_EQ(file->status, 200);
  EXPECT_EQ(file->body, std::string("\0binary", 7));
  EXPECT_EQ(file->get_header_value("Content-Type"), "image/png");
  EXPECT_EQ(file->get_header_value("Cache-Control"), "no-store");
  EXPECT_EQ(client().Get("/../etc/passwd")->status, 404);
  EXPECT_EQ(client().Post("/picture.png", "x", "text/plain")->status, 405);
}

TEST_F(Served, EveryAnswerKeepsOtherSitesOut) {
  board_.put("/result.json", {"application/json", "{}"});
  for (const char* path : {"/", "/result.json", "/page.js", "/nothing"}) {
    const auto answer = client().Get(path);
    ASSERT_TRUE(answer) << path;
    EXPECT_EQ(answer->get_header_value("Cross-Origin-Resource-Policy"), "same-origin") << path;
    EXPECT_THAT(answer->get_header_value("Content-Security-Policy"), HasSubstr("frame-ancestors 'none'")) << path;
    EXPECT_EQ(answer->get_header_value("X-Content-Type-Options"), "nosniff") << path;
    EXPECT_EQ(answer->get_header_value("Referrer-Policy"), "no-referrer") << path;
  }
}

// three.js is the larger part of the page; it was compressed anew, for seconds, at every request.
TEST_F(Served, ScriptsOfOthersAreCompressedBeforehandAndKept) {
  const auto page = client().Get("/");
  const std::regex three(R"re("(/three\.[0-9a-f]{12}\.js)")re");
  std::smatch found;
  ASSERT_TRUE(std::regex_search(page->body, found, three));
  const auto plain = client().Get(found[1].str(), {{"Accept-Encoding", "identity, gzip;q=0"}});
  const auto gzip = client().Get(found[1].str(), {{"Accept-Encoding", "br, gzip"}});  // the client expands it
  for (const auto* answer : {&plain, &gzip}) {
    EXPECT_EQ((*answer)->status, 200);
    EXPECT_THAT((*answer)->get_header_value("Cache-Control"), HasSubstr("immutable"));
    EXPECT_EQ((*answer)->get_header_value("Vary"), "Accept-Encoding");
  }
  EXPECT_EQ(plain->get_header_value("Content-Encoding"), "");
  EXPECT_EQ(gzip->get_header_value("Content-Encoding"), "gzip");
  EXPECT_EQ(plain->body, gzip->body);
  EXPECT_GT(plain->body.size(), 3 * std::stoul(gzip->get_header_value("Content-Length")));
}

// Nothing here reads a body: who sends one, of a length or in pieces, is cut off.
// Answers run in a library in C, through which no exception may go.
TEST_F(Served, AHandlerThatThrowsFailsAloneAndThePageGoesOn) {
  PageHandlers handlers;
  handlers.operator_password = "correct horse battery";
  handlers.operate = [](const PageRequest& request) -> PageAnswer {
    if (request.path == "/operator/state") throw std::runtime_error("as JSON does of text that is no UTF-8");
    return {200, nullptr, "operated"};
  };
  handlers.facts = [](std::string_view, std::string_view) -> PageAnswer { throw std::bad_alloc(); };
  auto server = PageServer::open({"127.0.0.1", 0}, board_, std::move(handlers));
  ASSERT_TRUE(server) << server.error().message;
  server_ = std::move(*server);
  const std::string origin = server_->url().substr(0, server_->url().size() - 1);
  const auto signed_in = client().Post("/operator/sign-in", {{"Origin", origin}},
                                       R"({"password": "correct horse battery"})", "application/json");
  ASSERT_EQ(signed_in->status, 200);
  const std::string set = signed_in->get_header_value("Set-Cookie");
  const httplib::Headers cookie = {{"Cookie", set.substr(0, set.find(';'))}};
  testing::internal::CaptureStderr();
  for (int i = 0; i < 3; ++i) {
    const auto thrown = client().Get("/operator/state", cookie);
    ASSERT_TRUE(thrown);
    EXPECT_EQ(thrown->status, 500);
    const auto posted =
        client().Post("/facts", {{"Origin", origin}, {"X-Im2fit-Visit", "1"}}, "{}", "application/json");
    ASSERT_TRUE(posted);
    EXPECT_EQ(posted->status, 500);
    EXPECT_EQ(posted->body, "this failed; reload the page\n");
  }
  EXPECT_EQ(client().Get("/operator/form", cookie)->status, 200);
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_NE(log.find("the page failed to answer GET /operator/state: as JSON does of text that is no UTF-8\n"),
            std::string::npos)
      << log;
  EXPECT_NE(log.find("POST /facts"), std::string::npos) << log;
}

TEST_F(Served, WhoSendsABodyIsNotAnswered) {
  EXPECT_TRUE(client().Get("/", {{"Content-Length", "0"}}));
  EXPECT_FALSE(client().Get("/", {{"Content-Length", "5"}}));
  EXPECT_FALSE(client().Get("/", {{"Transfer-Encoding", "chunked"}}));
}

TEST_F(Served, OnlyNamesOfThisMachineAreAnswered) {
  const std::pair<const char*, int> verdicts[] = {{"localhost", 200},
                                                  {"localhost:1", 200},
                                                  {"LocalHost:8017", 200},
                                                  {"localhost.:8017", 200},
                                                  {"127.0.0.1", 200},
                                                  {"127.0.0.1:8017", 200},
                                                  {"127.255.0.9:65535", 200},
                                                  {"[::1]:8017", 200},
                                                  {"127.attacker.example", 403},
                                                  {"127.0.0.1.attacker.example:8017", 403},
                                                  {"[::1].evil.com", 403},
                                                  {"localhost:evil.com", 403},
                                                  {"localhost:80@evil.com", 403},
                                                  {"localhost:", 403},
                                                  {"localhost:0", 403},
                                                  {"127.0.0.1:65536", 403},
                                                  {"127.1", 403},
                                                  {"im2fit.example:8017", 403},
                                                  {"localhost.example", 403},
                                                  {"10.0.0.7", 403}};
  static_assert(std::size(verdicts) == 20);
  for (const auto& [host, status] : verdicts) EXPECT_EQ(client().Get("/", {{"Host", host}})->status, status) << host;
  EXPECT_NE(client().Get("/", {{"Host", ""}})->status, 200);
  EXPECT_NE(client().Get("/", {{"Host", "localhost"}, {"Host", "evil.com"}})->status, 200);
}

// By https too: from behind a proxy that encrypts.
TEST_F(Served, OnlyThePageItselfMayAsk) {
  const std::pair<const char*, int> verdicts[] = {{"http://localhost:8017", 200},  {"HTTP://LOCALHOST:8017", 200},
                                                  {"http://evil.example", 403},    {"null", 403},
                                                  {"https://localhost:8017", 200}, {"http://localhost:8018", 403}};
  for (const auto& [origin, status] : verdicts)
    EXPECT_EQ(client().Get("/", {{"Host", "localhost:8017"}, {"Origin", origin}})->status, status) << origin;
  for (const auto& [site, status] :
       {std::pair{"same-origin", 200}, {"none", 200}, {"cross-site", 403}, {"same-site", 403}})
    EXPECT_EQ(client().Get("/", {{"Host", "localhost:8017"}, {"Sec-Fetch-Site", site}})->status, status) << site;
}

TEST_F(Served, TheStreamTellsWhatWasAndWhatComes) {
  board_.publish("hello", R"({"event":"hello"})");
  Watcher watcher(client(), "two");
  ASSERT_TRUE(watched_by(1));
  board_.publish("state", "two");
  watcher.join();
  EXPECT_EQ(watcher.text.rfind("retry: 1000\n\ndata: {\"event\":\"hello\"}\n\n", 0), 0U) << watcher.text;
}

TEST_F(Served, NotMoreWatchThanThereAreThreadsFor) {
  std::vector<std::unique_ptr<Watcher>> watchers;
  for (int i = 0; i < PageServer::kWatchersMax; ++i) watchers.push_back(std::make_unique<Watcher>(client(), "never"));
  ASSERT_TRUE(watched_by(PageServer::kWatchersMax));
  EXPECT_EQ(client().Get("/events")->status, 503);
  EXPECT_EQ(client().Get("/")->status, 200);
  // The end does not wait for them to leave.
  server_.reset();
  for (auto& watcher : watchers) {
    watcher->join();
    EXPECT_TRUE(watcher->ended);
  }
}

// A server whose /facts remembers what it was given.
class FactsServed : public Served {
 protected:
  void SetUp() override {
    PageHandlers handlers;
    handlers.facts = [this](std::string_view visit, std::string_view body) {
      given_.emplace_back(visit, body);
      return PageAnswer{body == "refused" ? 400U : 202U, nullptr, "said by the handler"};
    };
    auto server = PageServer::open({"127.0.0.1", 0}, board_, std::move(handlers));
    ASSERT_TRUE(server) << server.error().message;
    server_ = std::move(*server);
  }
  httplib::Headers own(const std::string& visit = "v") const {
    return {{"Origin", server_->url().substr(0, server_->url().size() - 1)}, {"X-Im2fit-Visit", visit}};
  }
  int post(const httplib::Headers& headers, const std::string& body = "{}",
           const std::string& type = "application/json") const {
    const auto answer = client().Post("/facts", headers, body, type);
    return answer ? answer->status : 0;
  }
  std::vector<std::pair<std::string, std::string>> given_;  // visit, body
};

TEST_F(FactsServed, TheHandlerGetsTheVisitAndTheBody) {
  EXPECT_EQ(post(own("visit"), R"({"age":35})"), 202);
  EXPECT_EQ(post(own("visit"), "refused"), 400);
  EXPECT_EQ(post(own(), std::string(kFactsBytesMax, ' ')), 202);
  ASSERT_EQ(given_.size(), 3U);
  EXPECT_EQ(given_[0], (std::pair<std::string, std::string>{"visit", R"({"age":35})"}));
  EXPECT_EQ(given_[2].second.size(), kFactsBytesMax);
  EXPECT_EQ(client().Post("/facts", own(), "refused", "application/json")->body, "said by the handler\n");
}

TEST_F(FactsServed, NoOtherSiteAndNoOddRequestReachesIt) {
  httplib::Headers headers = own();
  headers.erase("X-Im2fit-Visit");
  EXPECT_EQ(post(headers), 403) << "no visit: a form of another site cannot send one";
  EXPECT_EQ(post({{"X-Im2fit-Visit", "v"}}), 403) << "no Origin";
  EXPECT_EQ(post({{"X-Im2fit-Visit", "v"}, {"Origin", "http://evil.example"}}), 403);
  EXPECT_EQ(post({{"X-Im2fit-Visit", "v"}, {"Origin", "null"}}), 403);
  headers = own();
  headers.emplace("Sec-Fetch-Site", "cross-site");
  EXPECT_EQ(post(headers), 403);
  headers = own();
  headers.emplace("Host", "evil.example");
  EXPECT_EQ(post(headers), 403);
  EXPECT_EQ(post(own(std::string(kActionTextMax + 1, 'a'))), 400);
  EXPECT_EQ(post(own(), "{}", "text/plain"), 415) << "a form can send that without asking";
  EXPECT_EQ(post(own(), std::string(kFactsBytesMax + 1, ' ')), 413);
  headers = own();
  headers.emplace("Transfer-Encoding", "chunked");
  EXPECT_NE(post(headers), 202);
  EXPECT_EQ(client().Get("/facts")->status, 405);
  EXPECT_THAT(given_, testing::IsEmpty());
}

TEST_F(Served, WithoutTheOptionThereIsNoForm) {
  const httplib::Headers own = {{"Origin", server_->url().substr(0, server_->url().size() - 1)},
                                {"X-Im2fit-Visit", "v"}};
  EXPECT_EQ(client().Post("/facts", own, "", "application/json")->status, 405);
  EXPECT_EQ(client().Get("/facts")->status, 404);
}

TEST_F(Served, APortInUseAndAnAddressThatIsNotOursAreErrors) {
  const std::string port = server_->url().substr(server_->url().rfind(':') + 1);
  Board other;
  const auto again = PageServer::open({"127.0.0.1", std::stoi(port)}, other);
  ASSERT_FALSE(again);
  EXPECT_THAT(again.error().message, HasSubstr("--port"));
  EXPECT_THAT(again.error().message, HasSubstr("in use"));
  EXPECT_FALSE(PageServer::open({"192.0.2.1", 0}, other));  // RFC 5737: no machine's
}

}  // namespace
}  // namespace im2fit::apps
