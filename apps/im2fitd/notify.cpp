// SPDX-License-Identifier: Apache-2.0
#include "apps/im2fitd/notify.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <charconv>
#include <cstddef>
#include <cstring>

#include "apps/common/paths.h"

namespace im2fit::daemon {

namespace {

std::int64_t number(const std::string& text) {
  std::int64_t value = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  return code == std::errc() && end == text.data() + text.size() && value > 0 ? value : 0;
}

}  // namespace

Notifier::Notifier() : address_(environment("NOTIFY_SOCKET")) {
  if (address_.empty() || address_.size() >= sizeof(sockaddr_un::sun_path)) return;
  if (address_[0] == '@')
    address_[0] = '\0';  // the abstract namespace
  else if (address_[0] != '/')
    return;
  fd_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  const std::string pid = environment("WATCHDOG_PID");
  if (pid.empty() || number(pid) == ::getpid()) interval_ns_ = 1000 * number(environment("WATCHDOG_USEC"));
}

Notifier::~Notifier() {
  if (fd_ >= 0) ::close(fd_);
}

void Notifier::send(const std::string& assignments) const {
  if (fd_ < 0) return;
  sockaddr_un to{};
  to.sun_family = AF_UNIX;
  std::memcpy(to.sun_path, address_.data(), address_.size());
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + address_.size());
  [[maybe_unused]] const auto sent = ::sendto(fd_, assignments.data(), assignments.size(), MSG_NOSIGNAL,
                                              reinterpret_cast<const sockaddr*>(&to), size);
}

void Notifier::feed_watchdog(std::int64_t now_ns) {
  if (interval_ns_ == 0 || (fed_ns_ != 0 && now_ns - fed_ns_ < interval_ns_ / 4)) return;
  fed_ns_ = now_ns;
  send("WATCHDOG=1");
}

}  // namespace im2fit::daemon
