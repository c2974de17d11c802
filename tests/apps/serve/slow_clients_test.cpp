// SPDX-License-Identifier: Apache-2.0
// Six clients that read more slowly than the page sends, and one that reads nothing: the thread that feeds the page
// never waits for them, and nothing piles up. Four seconds; IM2FIT_SLOW_SECONDS=1200 is the long run, on an idle
// machine and stricter.
#include <fcntl.h>
#include <malloc.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <thread>
#include <utility>
#include <vector>

#include "shown_page.h"
#include "tests/devices/process_state.h"

namespace im2fit {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

constexpr int kSlow = 6;
constexpr auto kTurn = milliseconds(100);
constexpr int kTurnsUnread =
    200;  // 20 s: a stream that nobody reads is cut off after 15, without a message to its client
constexpr auto kFramePeriod = std::chrono::microseconds(33'333);

// What a test before this one has freed is handed out again as new pages, so that pages say nothing here.
long allocated_kb() {
  const struct mallinfo2 heap = ::mallinfo2();
  return static_cast<long>((heap.uordblks + heap.hblkhd) / 1024);
}

// One that asks for `path` and then takes `bytes` a turn; asks again when it was answered, cut off or, if it takes
// none, after kTurnsUnread.
class SlowClient {
 public:
  SlowClient(int port, const std::string& path, std::size_t bytes)
      : port_(port),
        request_("GET " + path + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n"),
        bytes_(bytes) {}
  ~SlowClient() {
    if (socket_ >= 0) ::close(socket_);
  }
  SlowClient(const SlowClient&) = delete;
  SlowClient& operator=(const SlowClient&) = delete;

  void turn() {
    if (socket_ < 0) return connect();
    if (bytes_ == 0) {
      if (++turns_ % kTurnsUnread == 0) ::close(std::exchange(socket_, -1));
      return;
    }
    std::array<char, 4096> buffer{};
    const ssize_t count = ::recv(socket_, buffer.data(), std::min(bytes_, buffer.size()), MSG_DONTWAIT);
    if (count > 0) taken_ += static_cast<std::size_t>(count);
    if (count == 0 || (count < 0 && errno != EAGAIN)) ::close(std::exchange(socket_, -1));
  }
  std::size_t taken() const { return taken_; }
  int connected() const { return connected_; }

 private:
  void connect() {
    socket_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const int room = 4096;  // the system's own would hold a minute of events
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &room, sizeof room);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(port_));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0) {
      ::close(std::exchange(socket_, -1));
      return;
    }
    ++connected_;
    (void)::send(socket_, request_.data(), request_.size(), MSG_NOSIGNAL);
  }
  int port_;
  std::string request_;
  std::size_t bytes_;
  int socket_ = -1;
  std::size_t taken_ = 0;
  int connected_ = 0;
  int turns_ = 0;
};

// Frames as an engine hands them over, thirty a second: someone stands there and breathes.
class Feeder {
 public:
  explicit Feeder(test::ShownPage& page) : page_(page), depth_(240UL * 320UL, 3000), mask_(depth_.size(), 0) {
    k_.width = 240;
    k_.height = 320;
    k_.fx = k_.fy = 290;
    k_.cx = 120;
    k_.cy = 160;
    page_.page().begin(k_, 30);
    result_.user = 1;
    result_.has_joints = true;
    for (std::size_t j = 0; j < kJointCount; ++j) {
      result_.display_joints.position_mm[j] = {20.0F * static_cast<float>(j), 100, 2000};
      result_.display_joints.confidence[j] = 1;
    }
  }
  // Milliseconds that the engine's thread spends on the page.
  double feed(std::uint64_t number) {
    for (int v = 60; v < 300; ++v)
      for (int u = 80; u < 160; ++u) {
        const auto at = static_cast<std::size_t>(v) * 240 + static_cast<std::size_t>(u);
        depth_[at] = static_cast<std::uint16_t>(2000 + (7 * number + 13 * at) % 23);
        mask_[at] = 255;
      }
    ++result_.frames_used;
    page_.page().permit();
    const auto start = Clock::now();
    page_.page().see({DepthView(depth_.data(), 240, 320), MaskView(mask_.data(), 240, 320), {}, {}, result_});
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
  }

 private:
  test::ShownPage& page_;
  std::vector<std::uint16_t> depth_;
  std::vector<std::uint8_t> mask_;
  Intrinsics k_;
  EngineResult result_;
};

TEST(SlowClients, NeitherKeepTheEngineWaitingNorPileAnythingUp) {
  const char* given = std::getenv("IM2FIT_SLOW_SECONDS");
  const auto length = std::chrono::seconds(given != nullptr ? std::atoi(given) : 4);
  apps::LivePageSettings settings;
  settings.visit.ask = false;
  settings.visit.result_max = std::chrono::hours(24);  // no one touches the page
  test::ShownPage page(settings);
  Feeder feeder(page);
  page.measured(987.6);
  std::vector<std::unique_ptr<SlowClient>> clients;
  // Of some 45 kB a second; two take pictures instead, a byte and a kilobyte at a time.
  const std::pair<const char*, std::size_t> kinds[kSlow + 1] = {
      {"/events", 20},     {"/events", 200},       {"/events", 1000}, {"/events", 2500},
      {"/picture.png", 1}, {"/picture.png", 1000}, {"/events", 0}};
  for (const auto& [path, bytes] : kinds) clients.push_back(std::make_unique<SlowClient>(page.port(), path, bytes));
  std::atomic<bool> over{false};
  std::thread crowd([&] {
    while (!over) {
      for (auto& client : clients) client->turn();
      std::this_thread::sleep_for(kTurn);
    }
  });

  std::vector<double> fed_ms, asked_ms;
  long early_kb = 0, most_kb = 0;  // allocated
  long early_pages_kb = 0;
  const auto start = Clock::now();
  for (std::uint64_t number = 0; Clock::now() < start + length; ++number) {
    fed_ms.push_back(feeder.feed(number));
    if (number % 15 == 14) {
      const auto asked = Clock::now();
      EXPECT_EQ(page.status_of("/result.json"), 200);
      asked_ms.push_back(std::chrono::duration<double, std::milli>(Clock::now() - asked).count());
      // A fifth of the time is for buffers and heaps to find their sizes.
      const long now_kb = allocated_kb();
      if (Clock::now() < start + length / 5) {
        early_kb = std::max(early_kb, now_kb);
        early_pages_kb = devices::resident_kb();
      } else {
        most_kb = std::max(most_kb, now_kb);
      }
    }
    std::this_thread::sleep_until(start + kFramePeriod * (number + 1));
  }
  over = true;
  crowd.join();
  std::sort(fed_ms.begin(), fed_ms.end());
  std::sort(asked_ms.begin(), asked_ms.end());
  std::printf(
      "%zu frames in %.0f s: a frame keeps the engine for %.2f ms in the middle, %.2f ms at most; a good client "
      "waits for %.1f ms, %.1f ms at most; allocated %+ld kB, pages %+ld kB; the one that reads nothing came %d "
      "times\n",
      fed_ms.size(), std::chrono::duration<double>(Clock::now() - start).count(), fed_ms[fed_ms.size() / 2],
      fed_ms.back(), asked_ms[asked_ms.size() / 2], asked_ms.back(), most_kb - early_kb,
      devices::resident_kb() - early_pages_kb, clients.back()->connected());
  for (int i = 0; i < kSlow; ++i) EXPECT_GT(clients[static_cast<std::size_t>(i)]->taken(), 0U) << i;
  EXPECT_EQ(clients.back()->taken(), 0U);
  // There was news to the end.
  EXPECT_GT(clients[2]->taken(), static_cast<std::size_t>(1000 * length.count()));
  // A machine that builds beside this stops anything for tens of milliseconds; a client that is waited for stops the
  // engine for seconds.
  EXPECT_LT(fed_ms[fed_ms.size() / 2], 10);
  EXPECT_LT(fed_ms.back(), given != nullptr ? 33 : 1000);
  EXPECT_LT(asked_ms[asked_ms.size() / 2], 200);
  EXPECT_LT(most_kb - early_kb, 2000);
}

}  // namespace
}  // namespace im2fit
