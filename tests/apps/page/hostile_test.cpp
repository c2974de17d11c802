// SPDX-License-Identifier: Apache-2.0
// Clients that mean harm, many at once, against a page in a process of its own. Ten seconds; IM2FIT_HOSTILE_SECONDS
// makes it longer and stricter.
#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <httplib.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "apps/kiosk/page_server.h"

namespace im2fit::apps {
namespace {

using Clock = std::chrono::steady_clock;
constexpr int kHostile = 300;
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;  // memory and time are not the program's own
#else
constexpr bool kSanitized = false;
#endif

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

// A page in a child, until SIGTERM.
class ServedElsewhere {
 public:
  ServedElsewhere() {
    std::array<int, 2> pipe{};
    if (::pipe(pipe.data()) != 0) return;
    sigset_t term;
    sigemptyset(&term);
    sigaddset(&term, SIGTERM);
    pid_ = ::fork();
    if (pid_ == 0) {
      ::sigprocmask(SIG_BLOCK, &term, nullptr);
      {
        Board board;
        board.put("/avatar.glb", {"model/gltf-binary", std::string(3 << 20, 'x')});
        auto server = PageServer::open({"127.0.0.1", 0}, board);
        const std::string url = server ? (*server)->url() : "";
        if (::write(pipe[1], url.data(), url.size()) < 0) ::_exit(1);
        ::close(pipe[1]);
        int number = 0;
        sigwait(&term, &number);
      }
      ::_exit(0);
    }
    ::close(pipe[1]);
    std::array<char, 200> text{};
    const ssize_t count = ::read(pipe[0], text.data(), text.size());
    ::close(pipe[0]);
    if (count > 8) url_.assign(text.data(), static_cast<std::size_t>(count) - 1);
  }
  ~ServedElsewhere() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }
  ServedElsewhere(const ServedElsewhere&) = delete;
  ServedElsewhere& operator=(const ServedElsewhere&) = delete;
  const std::string& url() const { return url_; }
  int port() const { return std::stoi(url_.substr(url_.rfind(':') + 1)); }
  double memory_mb() const {
    std::ifstream statm("/proc/" + std::to_string(pid_) + "/statm");
    long all = 0, resident = 0;
    statm >> all >> resident;
    return static_cast<double>(resident * ::sysconf(_SC_PAGESIZE)) / 1e6;
  }
  void stop() const {
    ::kill(pid_, SIGSTOP);
    int status = 0;
    ::waitpid(pid_, &status, WUNTRACED);
  }
  void go_on() const { ::kill(pid_, SIGCONT); }
  // Milliseconds from SIGTERM to its end.
  double end() {
    const auto start = Clock::now();
    ::kill(pid_, SIGTERM);
    int status = 0;
    ::waitpid(pid_, &status, 0);
    pid_ = -1;
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    return ms_since(start);
  }

 private:
  pid_t pid_ = -1;
  std::string url_;
};

std::string gzip_bomb() {
  std::string zeros(64 << 20, '\0'), out(1 << 20, '\0');
  z_stream z{};
  deflateInit2(&z, 9, Z_DEFLATED, 15 + 16, 9, Z_DEFAULT_STRATEGY);
  z.next_in = reinterpret_cast<Bytef*>(zeros.data());
  z.avail_in = static_cast<uInt>(zeros.size());
  z.next_out = reinterpret_cast<Bytef*>(out.data());
  z.avail_out = static_cast<uInt>(out.size());
  deflate(&z, Z_FINISH);
  out.resize(z.total_out);
  deflateEnd(&z);
  return out;
}

// One that means harm: sends `start` at once and then `more` again and again, in pieces of `piece` bytes; reads
// nothing.
struct Harm {
  std::string start, more;
  std::size_t piece;
};
std::vector<Harm> harms() {
  const std::string get = "GET /avatar.glb HTTP/1.1\r\nHost: localhost\r\n";
  std::string ranges = "Range: bytes=0-";
  for (int i = 0; i < 500; ++i) ranges += ",0-";
  const std::string bomb = gzip_bomb();
  return {
      {"G", "E", 1},                                                                       // a byte a turn
      {get, "X", 1},                                                                       // a header that never ends
      {get, "X-Long: " + std::string(4000, 'y') + "\r\n", 1 << 16},                        // header lines without end
      {get + "Content-Length: 100000000000\r\n\r\n", std::string(1 << 16, 'z'), 1 << 16},  // a body of 100 GB
      {"POST / HTTP/1.1\r\nHost: localhost\r\nContent-Encoding: gzip\r\nContent-Length: " +
           std::to_string(bomb.size()) + "\r\n\r\n",
       bomb, 1 << 16},
      {get + ranges + "\r\n\r\n", "", 1},                   // all of it, many times, unread
      {get + "\r\n" + get + "\r\n" + get + "\r\n", "", 1},  // three at once, unread
      {"GET /events HTTP/1.1\r\nHost: localhost\r\n\r\n", "", 1},
      {"POST / HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n",
       "ffff\r\n" + std::string(65535, 'c') + "\r\n", 1 << 16},
      {"", "", 1},  // says nothing
  };
}

// A socket that is being connected.
int connect_to(int port) {
  const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<std::uint16_t>(port));
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (::connect(socket, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0 || errno == EINPROGRESS)
    return socket;
  ::close(socket);
  return -1;
}

// kHostile of them; a connection that is cut off is opened again.
class Crowd {
 public:
  explicit Crowd(int port) : port_(port), harms_(harms()), sockets_(kHostile, -1) {
    thread_ = std::thread([this] {
      while (!over_) {
        turn();
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
      }
    });
  }
  ~Crowd() {
    over_ = true;
    thread_.join();
    for (const int socket : sockets_)
      if (socket >= 0) ::close(socket);
  }
  Crowd(const Crowd&) = delete;
  Crowd& operator=(const Crowd&) = delete;

 private:
  void turn() {
    for (std::size_t i = 0; i < sockets_.size(); ++i) {
      const Harm& harm = harms_[i % harms_.size()];
      int& socket = sockets_[i];
      if (socket < 0) {
        socket = connect_to(port_);
        if (socket < 0) continue;
        ::send(socket, harm.start.data(), harm.start.size(), MSG_NOSIGNAL);
      }
      if (harm.more.empty()) {
        char first = 0;  // peeked, not read
        const ssize_t seen = ::recv(socket, &first, 1, MSG_PEEK);
        if (seen == 0 || (seen < 0 && errno != EAGAIN && errno != ENOTCONN)) ::close(std::exchange(socket, -1));
        continue;
      }
      const ssize_t sent = ::send(socket, harm.more.data(), std::min(harm.piece, harm.more.size()), MSG_NOSIGNAL);
      if (sent < 0 && errno != EAGAIN && errno != ENOTCONN) ::close(std::exchange(socket, -1));
    }
  }
  int port_;
  std::vector<Harm> harms_;
  std::vector<int> sockets_;
  std::atomic<bool> over_{false};
  std::thread thread_;
};

// What came of a crowd of some seconds.
struct Course {
  std::vector<double> asks_ms;
  double memory_mb = 0, end_ms = 0;
};

double ask_ms(const std::string& url) {
  httplib::Client client(url);
  client.set_read_timeout(60);
  const auto start = Clock::now();
  const auto answer = client.Get("/page.js");
  return answer && answer->status == 200 ? ms_since(start) : 1e9;
}

Course hold_out(std::chrono::seconds length) {
  Course course;
  ServedElsewhere page;
  if (page.url().empty()) return course;
  for (int i = 0; i < 20; ++i) ask_ms(page.url());
  const double before_mb = page.memory_mb();
  const Crowd crowd(page.port());
  for (const auto end = Clock::now() + length; Clock::now() < end;) {
    course.asks_ms.push_back(ask_ms(page.url()));
    course.memory_mb = std::max(course.memory_mb, page.memory_mb() - before_mb);
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  course.end_ms = page.end();
  return course;
}

double median(std::vector<double> of) {
  std::nth_element(of.begin(), of.begin() + static_cast<std::ptrdiff_t>(of.size() / 2), of.end());
  return of[of.size() / 2];
}

// A machine that builds beside this may delay any one request or end, so that medians are held to the bars and the
// worst to ten seconds. A longer run (IM2FIT_HOSTILE_SECONDS) needs an idle machine, and then the worst is held to
// the bars.
TEST(Hostile, AGoodClientIsAnsweredAndTheEndIsPrompt) {
  const char* given = std::getenv("IM2FIT_HOSTILE_SECONDS");
  const int rounds = given != nullptr ? 1 : 3;
  std::vector<double> asks_ms, ends_ms;
  double memory_mb = 0;
  for (int i = 0; i < rounds; ++i) {
    const Course course = hold_out(std::chrono::seconds(given != nullptr ? std::atoi(given) : 3));
    ASSERT_FALSE(course.asks_ms.empty());
    asks_ms.insert(asks_ms.end(), course.asks_ms.begin(), course.asks_ms.end());
    ends_ms.push_back(course.end_ms);
    memory_mb = std::max(memory_mb, course.memory_mb);
  }
  const double slowest_ms = *std::max_element(asks_ms.begin(), asks_ms.end());
  const double last_ms = *std::max_element(ends_ms.begin(), ends_ms.end());
  std::printf(
      "%d hostile connections, %zu good requests: median %.0f ms, slowest %.0f ms, memory %+.1f MB, ends after %.0f "
      "ms "
      "at most\n",
      kHostile, asks_ms.size(), median(asks_ms), slowest_ms, memory_mb, last_ms);
  const double slower = kSanitized ? 10 : 1;
  EXPECT_LT(median(asks_ms), 200 * slower);
  EXPECT_LT(slowest_ms, (given != nullptr ? 200 : 10000) * slower);
  EXPECT_LE(median(ends_ms), 500 * slower);
  EXPECT_LE(last_ms, (given != nullptr ? 500 : 10000) * slower);
  EXPECT_LE(memory_mb, kSanitized ? 2000 : 20);
}

// A page that must wait loses no turn: a client outside the queue would come again after a second.
TEST(Hostile, AllThatComeAtOnceFindRoomInTheQueue) {
  ServedElsewhere page;
  ASSERT_FALSE(page.url().empty());
  int allowed = 0;
  std::ifstream("/proc/sys/net/core/somaxconn") >> allowed;
  if (allowed < kHostile) GTEST_SKIP() << "this system queues " << allowed << " connections at most";
  page.stop();
  std::vector<int> sockets;
  int connected = 0;
  for (int i = 0; i < kHostile; ++i) {
    sockets.push_back(connect_to(page.port()));
    pollfd item{sockets.back(), POLLOUT, 0};
    connected += ::poll(&item, 1, 100) > 0 && (item.revents & POLLERR) == 0 ? 1 : 0;
    if (connected <= i) break;
  }
  page.go_on();
  EXPECT_EQ(connected, kHostile);
  EXPECT_LT(ask_ms(page.url()), 10000);
  for (const int socket : sockets) ::close(socket);
}

}  // namespace
}  // namespace im2fit::apps
