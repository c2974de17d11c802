// SPDX-License-Identifier: Apache-2.0
// What a client may send to the page, through a socket pair: it ends, and what lies on the board is only given to
// requests that name this machine.
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "apps/kiosk/page_server.h"
#include "apps/kiosk/web_files.h"

namespace im2fit::apps {

const WebFile* web_file(std::string_view path) {
  static const WebFile page{"/", "text/html", "page", "packed", true};
  return path == "/" ? &page : nullptr;
}

// The server says so of a request whose answer threw: none may.
void print_error(const std::string& text) {
  std::fputs((text + "\n").c_str(), stderr);
  std::abort();
}

}  // namespace im2fit::apps

namespace {

constexpr const char* kSecret = "chest of a customer";

im2fit::apps::PageServer& server() {
  static im2fit::apps::Board board;
  static const auto made = [] {
    board.put("/result.json", {"application/json", kSecret});
    auto opened = im2fit::apps::PageServer::open({"127.0.0.1", 0}, board);
    if (!opened) std::abort();
    return std::move(*opened);
  }();
  return *made;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  int pair[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, pair) != 0) std::abort();
  if (!server().add(pair[1])) std::abort();
  std::string answer;
  // Sent in two pieces, so that the parser stops in the middle.
  const std::size_t half = size / 2;
  (void)!::send(pair[0], data, half, MSG_NOSIGNAL);
  (void)!::send(pair[0], data + half, size - half, MSG_NOSIGNAL);
  ::shutdown(pair[0], SHUT_WR);
  for (;;) {
    pollfd item{pair[0], POLLIN, 0};
    int ready = 0;
    do ready = ::poll(&item, 1, 8000);
    while (ready < 0 && errno == EINTR);  // the fuzzer's own alarm
    if (ready <= 0) __builtin_trap();     // the server's limit is 5 s
    char buffer[4096];
    const ssize_t count = ::recv(pair[0], buffer, sizeof buffer, 0);
    if (count <= 0) break;
    answer.append(buffer, static_cast<std::size_t>(count));
    if (answer.size() > 100'000) break;                                // many requests in one
    if (answer.find("text/event-stream") != std::string::npos) break;  // has no end
  }
  ::close(pair[0]);
  std::string text(reinterpret_cast<const char*>(data), size);
  for (char& c : text) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c;
  const bool named = text.find("localhost") != std::string::npos || text.find("127.") != std::string::npos ||
                     text.find("::1") != std::string::npos || text.find("[0") != std::string::npos;
  if (answer.find(kSecret) != std::string::npos && !named) __builtin_trap();
  return 0;
}
