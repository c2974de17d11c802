// SPDX-License-Identifier: Apache-2.0
// The connections to the page, and which of them must go: those that take too long, and the oldest when there are too
// many. Any thread may call anything.
#pragma once

#include <chrono>
#include <cstddef>
#include <list>
#include <mutex>
#include <string>

struct sockaddr;

namespace im2fit::apps {

struct VisitorLimits {
  // Chromium opens six to a host. A connection costs 16 KiB here and some of the system's.
  std::size_t visitors_max = 256;
  std::size_t of_one_address_max = 64;
  std::chrono::milliseconds asking_max{5000};      // for a request, from its first byte or the answer before it
  std::chrono::milliseconds answering_max{30000};  // for an answer: 1 MB over a slow wireless network takes 10 s
};

class Visitors {
 public:
  using Clock = std::chrono::steady_clock;
  enum class Doing { asking, answering, watching };  // watching, a stream, is not limited here

  struct Visitor {
    int socket = -1;
    std::string address;
    Doing doing = Doing::asking;
    Clock::time_point since;
  };

  explicit Visitors(const VisitorLimits& limits) : limits_(limits) {}
  // Makes room: ends the oldest connection without a request, else the oldest that is being answered, first of the
  // same address. The pointer is valid until left().
  Visitor* came(int socket, const sockaddr* address, Clock::time_point now);
  void left(const Visitor* visitor);
  void now_does(Visitor* visitor, Doing doing, Clock::time_point now);
  void cut_late(Clock::time_point now);
  std::size_t count() const;

 private:
  void make_room();
  Visitor* oldest_of(const std::string* address);

  const VisitorLimits limits_;
  mutable std::mutex mutex_;
  std::list<Visitor> visitors_;  // oldest first
};

// Ends a connection from this side; the thread that serves it notices and closes it.
void cut(int socket);

}  // namespace im2fit::apps
