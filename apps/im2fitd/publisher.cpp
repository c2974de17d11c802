// SPDX-License-Identifier: Apache-2.0
#include "apps/im2fitd/publisher.h"

#include <grp.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>
#include <utility>

#include "apps/im2fitd/log.h"

namespace im2fit::daemon {
namespace {

Error failed(const std::string& what, const std::string& path) {
  return {ErrorCode::io, "cannot " + what + " the socket " + path + ": " + std::strerror(errno)};
}

sockaddr_un address_of(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, path.data(), path.size());
  return address;
}

Error no_socket(const std::string& path) {
  return {ErrorCode::io, path + " exists and is not a socket; choose another socket.path or remove it"};
}

// A socket a killed daemon left behind blocks the address; one that answers is not ours to take.
Status clear_away(const std::string& path) {
  struct stat about {};
  if (::lstat(path.c_str(), &about) != 0) return Ok{};
  if (!S_ISSOCK(about.st_mode)) return no_socket(path);
  const int probe = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  const sockaddr_un address = address_of(path);
  const bool refused =
      ::connect(probe, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 && errno == ECONNREFUSED;
  ::close(probe);
  if (!refused)
    return Error{ErrorCode::io, "another program listens at " + path + "; stop it or choose another socket.path"};
  ::unlink(path.c_str());
  return Ok{};
}

Result<gid_t> group_number(const std::string& name) {
  errno = 0;
  const group* found = ::getgrnam(name.c_str());  // NOLINT(concurrency-mt-unsafe): before threads start
  if (found != nullptr) return found->gr_gid;
  return Error{ErrorCode::invalid_argument, "socket.group: there is no group \"" + name + "\" on this machine"};
}

}  // namespace

Status Publisher::check(const PublisherOptions& options) {
  if (options.path.empty() || options.path.size() >= sizeof(sockaddr_un::sun_path))
    return Error{ErrorCode::invalid_argument, "socket.path \"" + options.path + "\" has " +
                                                  std::to_string(options.path.size()) + " bytes, expected 1 to " +
                                                  std::to_string(sizeof(sockaddr_un::sun_path) - 1)};
  struct stat about {};
  if (::lstat(options.path.c_str(), &about) == 0 && !S_ISSOCK(about.st_mode)) return no_socket(options.path);
  if (options.group.empty()) return Ok{};
  const auto number = group_number(options.group);
  return number ? Status(Ok{}) : number.error();
}

Result<std::unique_ptr<Publisher>> Publisher::open(const PublisherOptions& options) {
  if (auto sound = check(options); !sound) return sound.error();
  if (auto clear = clear_away(options.path); !clear) return clear.error();
  std::unique_ptr<Publisher> made(new Publisher(options));
  made->fd_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (made->fd_ < 0) return failed("make", options.path);
  const sockaddr_un address = address_of(options.path);
  const mode_t mask = ::umask(0177);  // until its mode is set only we may connect
  const int bound = ::bind(made->fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address);
  const int reason = errno;
  ::umask(mask);
  errno = reason;
  if (bound != 0) return failed("make", options.path);
  made->bound_ = true;
  if (!options.group.empty()) {
    const auto number = group_number(options.group);
    if (!number) return number.error();
    if (::chown(options.path.c_str(), static_cast<uid_t>(-1), *number) != 0) return failed("give away", options.path);
  }
  if (::chmod(options.path.c_str(), options.mode) != 0) return failed("set the mode of", options.path);
  if (::listen(made->fd_, 16) != 0) return failed("listen at", options.path);
  return made;
}

Publisher::~Publisher() {
  for (const Client& client : clients_) ::close(client.fd);
  if (fd_ >= 0) ::close(fd_);
  if (bound_) ::unlink(options_.path.c_str());
}

void Publisher::serve(const std::string& greeting) {
  // First, so that a client that has gone takes no place.
  for (auto it = clients_.begin(); it != clients_.end();) it = receive(*it) ? std::next(it) : clients_.erase(it);
  for (;;) {
    const int fd = ::accept4(fd_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (fd < 0) break;
    if (clients_.size() >= static_cast<std::size_t>(options_.clients_max)) {
      ::close(fd);
      log(Level::warning, "a client was refused: " + std::to_string(clients_.size()) + " are connected");
      continue;
    }
    clients_.push_back({fd, ++accepted_, greeting, {}, false, 0, 0, 0});
    if (!receive(clients_.back())) clients_.pop_back();
  }
  for (auto it = clients_.begin(); it != clients_.end();) it = send(*it) ? std::next(it) : clients_.erase(it);
}

// At most 16 KB a turn, so that no client keeps the others waiting.
bool Publisher::receive(Client& client) {
  std::array<char, 4096> bytes;
  for (int i = 0; i < 4; ++i) {
    const ssize_t count = ::recv(client.fd, bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (count > 0) {
      take_bytes(client, {bytes.data(), static_cast<std::size_t>(count)});
      continue;
    }
    if (count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR)) return true;
    // No more bytes will come. A client that has closed only that half still reads.
    pollfd item{client.fd, POLLIN, 0};
    if (count == 0 && ::poll(&item, 1, 0) >= 0 && (item.revents & (POLLHUP | POLLERR)) == 0) return true;
    ::close(client.fd);
    return false;
  }
  return true;
}

void Publisher::let_go(Client& client) {
  std::array<char, kClientLineMax + 1> bytes;
  const ssize_t count = ::recv(client.fd, bytes.data(), bytes.size(), MSG_DONTWAIT);
  if (count > 0) take_bytes(client, {bytes.data(), static_cast<std::size_t>(count)});
  ::close(client.fd);
}

void Publisher::take_bytes(Client& client, std::string_view bytes) {
  while (!bytes.empty()) {
    const std::size_t end = bytes.find('\n');
    client.sent += bytes.substr(0, end);
    if (client.sent.size() > kClientLineMax) {
      client.sent.clear();
      client.too_long = true;
    }
    if (end == std::string_view::npos) return;
    bytes.remove_prefix(end + 1);
    if (client.lines < kClientLinesMax) {
      ++client.lines;
      lines_.push_back({client.number, client.too_long, client.too_long ? std::string() : client.sent});
    }
    client.sent.clear();
    client.too_long = false;
  }
}

std::vector<ClientLine> Publisher::take_lines() {
  for (Client& client : clients_) client.lines = 0;
  return std::exchange(lines_, {});
}

void Publisher::answer(std::uint64_t client, const std::string& line) {
  for (auto it = clients_.begin(); it != clients_.end(); ++it) {
    if (it->number != client) continue;
    it->waiting += line;
    if (!send(*it)) clients_.erase(it);
    return;
  }
}

void Publisher::answer_long(std::uint64_t client, const std::string& line) {
  for (Client& one : clients_) {
    if (one.number != client) continue;
    one.owed = one.waiting.size() + line.size();
    one.long_bytes = line.size();
  }
  answer(client, line);
}

bool Publisher::owes(std::uint64_t client) const {
  for (const Client& one : clients_)
    if (one.number == client) return one.owed > 0;
  return false;
}

bool Publisher::send(Client& client) {
  while (!client.waiting.empty()) {
    const ssize_t count =
        ::send(client.fd, client.waiting.data(), client.waiting.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (count > 0) {
      client.waiting.erase(0, static_cast<std::size_t>(count));
      client.owed -= std::min(client.owed, static_cast<std::size_t>(count));
      continue;
    }
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) break;
    let_go(client);
    return false;
  }
  const std::size_t allowed = std::min(client.owed, client.long_bytes);
  if (client.waiting.size() - allowed <= options_.client_buffer_bytes) return true;
  ++dropped_;
  log(Level::warning, "client " + std::to_string(client.number) + " reads too slowly and was dropped");
  ::close(client.fd);
  return false;
}

void Publisher::publish(const std::string& line) {
  for (auto it = clients_.begin(); it != clients_.end();) {
    it->waiting += line;
    it = send(*it) ? std::next(it) : clients_.erase(it);
  }
}

void Publisher::flush(int timeout_ms) {
  for (int waited_ms = 0; waited_ms < timeout_ms; waited_ms += 10) {
    bool all = true;
    for (auto it = clients_.begin(); it != clients_.end();) {
      const bool there = send(*it);
      all = all && (!there || it->waiting.empty());
      it = there ? std::next(it) : clients_.erase(it);
    }
    if (all) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

}  // namespace im2fit::daemon
