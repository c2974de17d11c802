// SPDX-License-Identifier: Apache-2.0
// Clients that mean harm, many at once, against a page in a process of its own. Ten seconds; IM2FIT_HOSTILE_SECONDS
// makes it longer.
#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <httplib.h>
#include <netinet/in.h>
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

#include "apps/im2fit/page/page_server.h"

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

// kHostile of them; whoever is cut off comes again.
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
        socket = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
        sockaddr_in to{};
        to.sin_family = AF_INET;
        to.sin_port = htons(static_cast<std::uint16_t>(port_));
        to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        if (::connect(socket, reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0 && errno != EINPROGRESS) {
          ::close(std::exchange(socket, -1));
          continue;
        }
        ::send(socket, harm.start.data(), harm.start.size(), MSG_NOSIGNAL);
      }
      if (harm.more.empty()) {
        char first = 0;  // looked at, not read
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

TEST(Hostile, AGoodClientIsAnsweredAndTheEndIsPrompt) {
  ServedElsewhere page;
  ASSERT_FALSE(page.url().empty());
  const auto ask = [&] {
    httplib::Client client(page.url());
    client.set_read_timeout(20);
    const auto start = Clock::now();
    const auto answer = client.Get("/page.js");
    return answer && answer->status == 200 ? ms_since(start) : 1e9;
  };
  for (int i = 0; i < 20; ++i) ask();
  const double memory_before_mb = page.memory_mb();
  const char* given = std::getenv("IM2FIT_HOSTILE_SECONDS");
  const auto end = Clock::now() + std::chrono::seconds(given != nullptr ? std::atoi(given) : 8);
  double slowest_ms = 0, memory_mb = 0, end_ms = 0;
  int asked = 0;
  {
    const Crowd crowd(page.port());
    for (; Clock::now() < end; ++asked) {
      slowest_ms = std::max(slowest_ms, ask());
      memory_mb = std::max(memory_mb, page.memory_mb() - memory_before_mb);
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    end_ms = page.end();
  }
  std::printf("%d hostile connections, %d good requests: slowest %.0f ms, memory %+.1f MB, end after %.0f ms\n",
              kHostile, asked, slowest_ms, memory_mb, end_ms);
  EXPECT_GT(asked, 20);
  EXPECT_LT(slowest_ms, kSanitized ? 5000 : 200);
  EXPECT_LE(memory_mb, kSanitized ? 2000 : 20);
  EXPECT_LE(end_ms, kSanitized ? 5000 : 500);
}

}  // namespace
}  // namespace im2fit::apps
