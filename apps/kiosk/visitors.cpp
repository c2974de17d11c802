// SPDX-License-Identifier: Apache-2.0
#include "apps/kiosk/visitors.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>

namespace im2fit::apps {
namespace {

std::string text_of(const sockaddr* address) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  if (address == nullptr) return "";
  if (address->sa_family == AF_INET)
    ::inet_ntop(AF_INET, &reinterpret_cast<const sockaddr_in*>(address)->sin_addr, text.data(), text.size());
  if (address->sa_family == AF_INET6)
    ::inet_ntop(AF_INET6, &reinterpret_cast<const sockaddr_in6*>(address)->sin6_addr, text.data(), text.size());
  return text.data();
}

}  // namespace

void cut(int socket) {
  ::shutdown(socket, SHUT_RDWR);
}

Visitors::Visitor* Visitors::came(int socket, const sockaddr* address, Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  visitors_.push_back({socket, text_of(address), Doing::asking, now});
  make_room();
  return &visitors_.back();
}

void Visitors::left(const Visitor* visitor) {
  const std::lock_guard lock(mutex_);
  visitors_.remove_if([&](const Visitor& v) { return &v == visitor; });
}

void Visitors::now_does(Visitor* visitor, Doing doing, Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  visitor->doing = doing;
  visitor->since = now;
}

Visitors::Visitor* Visitors::oldest_of(const std::string* address) {
  for (const Doing doing : {Doing::asking, Doing::answering})
    for (auto it = visitors_.begin(); it != std::prev(visitors_.end()); ++it)  // not the one that just came
      if (it->socket >= 0 && it->doing == doing && (address == nullptr || it->address == *address)) return &*it;
  return nullptr;
}

void Visitors::make_room() {
  const std::string& address = visitors_.back().address;
  const auto of_address = std::count_if(visitors_.begin(), visitors_.end(),
                                        [&](const Visitor& v) { return v.socket >= 0 && v.address == address; });
  const auto all = std::count_if(visitors_.begin(), visitors_.end(), [](const Visitor& v) { return v.socket >= 0; });
  Visitor* leaving = nullptr;
  if (static_cast<std::size_t>(of_address) > limits_.of_one_address_max) leaving = oldest_of(&address);
  if (leaving == nullptr && static_cast<std::size_t>(all) > limits_.visitors_max) leaving = oldest_of(nullptr);
  if (leaving == nullptr) return;
  cut(leaving->socket);
  leaving->socket = -1;  // gone as far as counts go
}

void Visitors::cut_late(Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  for (Visitor& visitor : visitors_) {
    if (visitor.socket < 0 || visitor.doing == Doing::watching) continue;
    const auto patience = visitor.doing == Doing::asking ? limits_.asking_max : limits_.answering_max;
    if (now - visitor.since < patience) continue;
    cut(visitor.socket);
    visitor.socket = -1;
  }
}

std::size_t Visitors::count() const {
  const std::lock_guard lock(mutex_);
  return visitors_.size();
}

}  // namespace im2fit::apps
