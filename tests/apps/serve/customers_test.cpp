// SPDX-License-Identifier: Apache-2.0
// A day of customers on the page, in as many seconds as it has hours: each gives consent, is measured, shown and
// forgotten, while phones and screens come, follow, leave half-way and fall silent. Long run: IM2FIT_CUSTOMERS=1000.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include "core/rng.h"
#include "shown_page.h"
#include "tests/devices/process_state.h"

namespace im2fit::apps {
namespace {

using std::chrono::milliseconds;

// A client that speaks by hand and may leave at any byte.
class Caller {
 public:
  explicit Caller(int port) : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(port));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const timeval patience{5, 0};
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    connected_ = ::connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0;
  }
  ~Caller() { ::close(socket_); }
  Caller(const Caller&) = delete;
  Caller& operator=(const Caller&) = delete;
  bool connected() const { return connected_; }
  void say(const std::string& text) const { (void)::send(socket_, text.data(), text.size(), MSG_NOSIGNAL); }
  // Until `end` was read; "" when it does not come.
  std::string hear(const std::string& end) const {
    std::string text;
    std::array<char, 4096> buffer;
    while (text.find(end) == std::string::npos) {
      const ssize_t count = ::recv(socket_, buffer.data(), buffer.size(), 0);
      if (count <= 0) return "";
      text.append(buffer.data(), static_cast<std::size_t>(count));
    }
    return text;
  }

 private:
  int socket_;
  bool connected_ = false;
};

// What of the process must not grow.
struct Held {
  long memory_kb = devices::resident_kb();
  int files = devices::open_files();
  int threads = devices::threads();
};

class Shop {
 public:
  explicit Shop(test::ShownPage& shown) : shown_(shown), get_(" HTTP/1.1\r\nHost: localhost\r\n\r\n") {}

  // One customer, from consent to the end; the numbers are theirs alone.
  void serve(int number) {
    const Caller screen(shown_.port());
    ASSERT_TRUE(screen.connected());
    screen.say("GET /events" + get_);
    const std::string told = screen.hear("\"event\":\"beat\"");
    const std::size_t at = told.find("\"id\":\"");
    ASSERT_NE(at, std::string::npos) << number << ": " << told;
    const std::string visit = told.substr(at + 6, 32);
    ASSERT_EQ(shown_.post("/consent", visit, "en-1"), 200) << number;
    for (const char* code : {"NO_PERSON", "TOO_NEAR", "MOVING"}) shown_.state("TRACKING", {code});
    // Whoever passes by: some leave in the middle of a request, some in the middle of an answer, some of a stream.
    std::vector<std::unique_ptr<Caller>> passers;
    for (int i = rng_.index(6); i > 0; --i) {
      passers.push_back(std::make_unique<Caller>(shown_.port()));
      const std::array<std::string, 4> words = {"GET /page.js" + get_, "GET /events" + get_, "GET /resu", ""};
      passers.back()->say(words[static_cast<std::size_t>(rng_.index(4))]);
    }
    const std::string chest = std::to_string(700 + number) + ".25";
    shown_.measured(std::stod(chest));
    EXPECT_NE(screen.hear(chest), "") << number;
    EXPECT_EQ(shown_.status_of("/result.json"), 200) << number;
    passers.clear();
    shown_.page().publish({{"event", "left"}, {"frame", 2}, {"person", 1}});
    // Most press "Delete"; the others' time runs out. The result goes before the next visit is published: a client
    // that connects in between gets the visit that is over.
    if (rng_.index(20) != 0) {
      ASSERT_EQ(shown_.post("/delete", visit), 200) << number;
    } else {
      // "": there was no room for one more to watch.
      std::string told_now = visit;
      for (int i = 0; i < 400 && (told_now.empty() || told_now == visit); ++i) {
        std::this_thread::sleep_for(milliseconds(10));
        told_now = shown_.visit();
      }
      ASSERT_NE(told_now, visit) << number;
    }
    ASSERT_EQ(shown_.status_of("/result.json"), 404) << number;
  }

 private:
  test::ShownPage& shown_;
  const std::string get_;
  Rng rng_{24};
};

TEST(Customers, ADayOfThemLeavesThePageAsItWas) {
  const char* given = std::getenv("IM2FIT_CUSTOMERS");
  const int customers = given != nullptr ? std::atoi(given) : 40;
  LivePageSettings settings;
  settings.visit.result_max = milliseconds(1000);  // a minute, in the shop
  test::ShownPage shown(settings);
  Shop shop(shown);
  Held early;
  for (int i = 0; i < customers && !testing::Test::HasFatalFailure(); ++i) {
    if (i == customers / 10) early = Held();
    shop.serve(i);
  }
  // Streams whose client has left are noticed with the next beat.
  for (int i = 0; i < 400 && shown.page().watchers() > 0; ++i) std::this_thread::sleep_for(milliseconds(10));
  EXPECT_EQ(shown.page().watchers(), 0);
  for (int i = 0; i < 400 && devices::open_files() > early.files; ++i) std::this_thread::sleep_for(milliseconds(10));
  const Held late;
  std::printf("%d customers: %ld kB, %d files and %d threads after a tenth; %ld kB, %d and %d at the end\n",
              customers, early.memory_kb, early.files, early.threads, late.memory_kb, late.files, late.threads);
  EXPECT_LE(late.files, early.files);
  EXPECT_LE(late.threads, early.threads);
  if (customers >= 500) {
    EXPECT_LE(late.memory_kb, early.memory_kb + 2048);
  }
}

}  // namespace
}  // namespace im2fit::apps
