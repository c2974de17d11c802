// SPDX-License-Identifier: Apache-2.0
// The service manager's protocol, sd_notify(3): datagrams of NAME=value to $NOTIFY_SOCKET.
#pragma once

#include <cstdint>
#include <string>

namespace im2fit::daemon {

class Notifier {
 public:
  // From the environment; without NOTIFY_SOCKET nothing is ever sent.
  Notifier();
  ~Notifier();
  Notifier(const Notifier&) = delete;
  Notifier& operator=(const Notifier&) = delete;

  void send(const std::string& assignments) const;  // "READY=1\nSTATUS=..."; never blocks
  // WATCHDOG=1, at most four times in the interval the manager set; nothing when it set none for this process.
  void feed_watchdog(std::int64_t now_ns);

 private:
  int fd_ = -1;
  std::string address_;
  std::int64_t interval_ns_ = 0;
  std::int64_t fed_ns_ = 0;
};

}  // namespace im2fit::daemon
