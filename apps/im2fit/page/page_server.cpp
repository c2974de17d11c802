// SPDX-License-Identifier: Apache-2.0
#include "apps/im2fit/page/page_server.h"

#include <httplib.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <string_view>
#include <thread>
#include <utility>

#include "apps/im2fit/page/web_files.h"

namespace im2fit::apps {
namespace {

constexpr auto kPatience = std::chrono::seconds(10);  // then a comment shows whether the client is still there
constexpr int kThreads = PageServer::kWatchersMax + 4;

bool is_local(std::string_view host) {
  return host == "localhost" || host == "::1" || host.starts_with("127.");
}

// Of "127.0.0.1:8017" or "[::1]:8017".
std::string_view host_of(std::string_view field) {
  if (field.starts_with('[')) return field.substr(1, field.find(']') - 1);
  return field.substr(0, field.rfind(':'));
}

// The library's own also lets a second program listen at the same port.
void reuse_address(int socket) {
  const int yes = 1;
  setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
}

}  // namespace

struct PageServer::Parts {
  explicit Parts(Board& b) : board(b) {}
  void answer(const httplib::Request& request, httplib::Response& response) const;
  void stream(httplib::Response& response);

  Board& board;
  httplib::Server server;
  std::thread thread;
  std::string url;
  std::atomic<int> watchers{0};
};

void PageServer::Parts::answer(const httplib::Request& request, httplib::Response& response) const {
  if (const WebFile* fixed = web_file(request.path)) {
    response.set_content(fixed->bytes.data(), fixed->bytes.size(), fixed->type);
  } else if (const auto file = board.file(request.path)) {
    response.set_content(file->bytes, file->type);
  } else {
    response.status = 404;
    response.set_content("nothing at " + request.path + " (yet)\n", "text/plain; charset=utf-8");
  }
}

void PageServer::Parts::stream(httplib::Response& response) {
  if (watchers.fetch_add(1) >= kWatchersMax) {
    watchers.fetch_sub(1);
    response.status = 503;
    response.set_content("too many are watching; close another page\n", "text/plain; charset=utf-8");
    return;
  }
  response.set_chunked_content_provider(
      "text/event-stream",
      [this, seen = std::uint64_t{0}](std::size_t, httplib::DataSink& sink) mutable {
        std::string text = board.wait(seen, kPatience);
        if (board.closed()) {
          sink.done();
          return true;
        }
        if (text.empty()) text = ": still here\n\n";
        return sink.write(text.data(), text.size());
      },
      [this](bool) { watchers.fetch_sub(1); });
}

Result<std::unique_ptr<PageServer>> PageServer::open(const PageAddress& address, Board& board) {
  auto made = std::make_unique<Parts>(board);
  Parts& parts = *made;
  httplib::Server& server = parts.server;
  server.new_task_queue = [] { return new httplib::ThreadPool(kThreads); };
  server.set_socket_options(reuse_address);
  server.set_default_headers({{"Cache-Control", "no-store"},
                              {"X-Content-Type-Options", "nosniff"},
                              {"Content-Security-Policy", "default-src 'self'; img-src 'self' data:"}});
  if (is_local(address.host))
    server.set_pre_routing_handler([](const httplib::Request& request, httplib::Response& response) {
      if (is_local(host_of(request.get_header_value("Host")))) return httplib::Server::HandlerResponse::Unhandled;
      response.status = 403;
      return httplib::Server::HandlerResponse::Handled;
    });
  server.Get("/events", [&parts](const httplib::Request&, httplib::Response& r) { parts.stream(r); });
  server.Get(".*", [&parts](const httplib::Request& q, httplib::Response& r) { parts.answer(q, r); });

  errno = 0;
  int port = address.port;
  if (port == 0)
    port = server.bind_to_any_port(address.host);
  else if (!server.bind_to_port(address.host, port))
    port = -1;
  if (port < 0)
    return Error{ErrorCode::io, "cannot listen at " + address.host + ":" + std::to_string(address.port) +
                                    (errno != 0 ? std::string(" (") + std::strerror(errno) + ")" : std::string()) +
                                    "; try another --port or --host"};
  const bool v6 = address.host.find(':') != std::string::npos;
  parts.url = "http://" + (v6 ? "[" + address.host + "]" : address.host) + ":" + std::to_string(port) + "/";
  parts.thread = std::thread([&server] { server.listen_after_bind(); });
  while (!server.is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));  // else stop() would not
  return std::unique_ptr<PageServer>(new PageServer(std::move(made)));
}

PageServer::PageServer(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

PageServer::~PageServer() {
  parts_->board.close();
  parts_->server.stop();
  parts_->thread.join();
}

const std::string& PageServer::url() const {
  return parts_->url;
}
int PageServer::watchers() const {
  return parts_->watchers;
}

}  // namespace im2fit::apps
