// SPDX-License-Identifier: Apache-2.0
// im2fitd as a service manager runs it: its socket, its notifications, its end. Every wait is bounded.
#pragma once

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <chrono>
#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>

#include "background_run.h"

namespace im2fit::test {

inline sockaddr_un unix_address(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, path.data(), std::min(path.size(), sizeof address.sun_path - 1));
  return address;
}

// A client of the socket.
class Client {
 public:
  // Tries until the socket is there.
  explicit Client(const std::string& path) {
    const sockaddr_un address = unix_address(path);
    for (const auto end = Clock::now() + kPatience; Clock::now() < end;) {
      fd_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
      if (::connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return;
      ::close(fd_);
      fd_ = -1;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  }
  ~Client() {
    if (fd_ >= 0) ::close(fd_);
  }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;
  bool connected() const { return fd_ >= 0; }
  int fd() const { return fd_; }
  bool closed() const { return closed_; }

  // The next event; null when it is closed or silent for too long.
  nlohmann::json next(std::chrono::milliseconds patience = kPatience) {
    const auto end = Clock::now() + patience;
    for (;;) {
      if (const auto line_end = text_.find('\n'); line_end != std::string::npos) {
        const std::string line = text_.substr(0, line_end);
        text_.erase(0, line_end + 1);
        EXPECT_TRUE(nlohmann::json::accept(line)) << line;
        return nlohmann::json::parse(line, nullptr, false);
      }
      const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now());
      pollfd item{fd_, POLLIN, 0};
      if (closed_ || left.count() <= 0 || ::poll(&item, 1, static_cast<int>(left.count())) <= 0) return nullptr;
      std::array<char, 4096> buffer;
      const ssize_t count = ::read(fd_, buffer.data(), buffer.size());
      closed_ = count <= 0;
      if (count > 0) text_.append(buffer.data(), static_cast<std::size_t>(count));
    }
  }
  // The next event of that kind (and state).
  nlohmann::json next(const std::string& kind, const std::string& state = "") {
    for (;;) {
      nlohmann::json event = next();
      if (event.is_null()) return event;
      if (event["event"] == kind && (state.empty() || event["state"] == state)) return event;
    }
  }

 private:
  int fd_ = -1;
  bool closed_ = false;
  std::string text_;
};

// The manager's end of sd_notify.
class Manager {
 public:
  explicit Manager(std::string path) : path_(std::move(path)) {
    fd_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    const sockaddr_un address = unix_address(path_);
    EXPECT_EQ(::bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  }
  ~Manager() { ::close(fd_); }
  Manager(const Manager&) = delete;
  Manager& operator=(const Manager&) = delete;
  const std::string& path() const { return path_; }
  // The next message; nullopt when none comes in this time.
  std::optional<std::string> next(std::chrono::milliseconds patience = kPatience) {
    pollfd item{fd_, POLLIN, 0};
    if (::poll(&item, 1, static_cast<int>(patience.count())) <= 0) return std::nullopt;
    std::array<char, 4096> buffer;
    const ssize_t count = ::recv(fd_, buffer.data(), buffer.size(), 0);
    return std::string(buffer.data(), static_cast<std::size_t>(std::max<ssize_t>(0, count)));
  }
  // How often it received that, within a time.
  int count(const std::string& message, std::chrono::milliseconds time) {
    int found = 0;
    for (const auto end = Clock::now() + time; Clock::now() < end;)
      found += next(std::chrono::milliseconds(20)) == message ? 1 : 0;
    return found;
  }
  bool wait_for(const std::string& part) {
    for (const auto end = Clock::now() + kPatience; Clock::now() < end;)
      if (const auto message = next(); message && message->find(part) != std::string::npos) return true;
    return false;
  }

 private:
  std::string path_;
  int fd_ = -1;
};

class DaemonRun : public BackgroundRun {
 public:
  DaemonRun(const std::string& config, std::vector<std::pair<std::string, std::string>> environment,
            std::string stderr_path)
      : BackgroundRun({IM2FIT_DAEMON_PROGRAM, "--config", config}, without_body(std::move(environment)),
                      std::move(stderr_path)) {}

 private:
  static std::vector<std::pair<std::string, std::string>> without_body(
      std::vector<std::pair<std::string, std::string>> environment) {
    environment.emplace_back("IM2FIT_BODY", "");
    return environment;
  }
};

}  // namespace im2fit::test
