// SPDX-License-Identifier: Apache-2.0
// Who must go when too many are connected, or take too long.
#include "apps/kiosk/visitors.h"

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <vector>

namespace im2fit::apps {
namespace {

using Clock = Visitors::Clock;

class Connections : public testing::Test {
 protected:
  ~Connections() override {
    for (const int socket : sockets_) ::close(socket);
  }
  // One that came from 10.0.0.`host`, and our end of it.
  Visitors::Visitor* come(Visitors& visitors, std::uint32_t host) {
    std::array<int, 2> pair{};
    EXPECT_EQ(::socketpair(AF_UNIX, SOCK_STREAM, 0, pair.data()), 0);
    sockets_.insert(sockets_.end(), pair.begin(), pair.end());
    ends_.push_back(pair[1]);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(0x0A000000U + host);
    return visitors.came(pair[0], reinterpret_cast<const sockaddr*>(&address), now_);
  }
  bool is_cut(std::size_t which) const {
    char byte = 0;
    return ::recv(ends_[which], &byte, 1, MSG_DONTWAIT) == 0;  // else nothing is there, and no end
  }
  Clock::time_point now_ = Clock::now();
  std::vector<int> sockets_, ends_;
};

VisitorLimits few() {
  VisitorLimits limits;
  limits.visitors_max = 4;
  limits.of_one_address_max = 2;
  return limits;
}

TEST_F(Connections, OneAddressTakesNoMoreThanItsPlaces) {
  Visitors visitors(few());
  come(visitors, 1);
  come(visitors, 2);
  come(visitors, 2);
  EXPECT_FALSE(is_cut(1));
  come(visitors, 2);  // the third of that address, the fourth in all
  EXPECT_FALSE(is_cut(0));
  EXPECT_TRUE(is_cut(1)) << "the oldest of its address";
  EXPECT_FALSE(is_cut(2));
  EXPECT_FALSE(is_cut(3));
}

TEST_F(Connections, TheOldestThatHasNotAskedMakesRoom) {
  Visitors visitors(few());
  visitors.now_does(come(visitors, 1), Visitors::Doing::watching, now_);
  visitors.now_does(come(visitors, 2), Visitors::Doing::answering, now_);
  come(visitors, 3);
  come(visitors, 4);
  come(visitors, 5);
  EXPECT_FALSE(is_cut(0));
  EXPECT_FALSE(is_cut(1));
  EXPECT_TRUE(is_cut(2));
  EXPECT_FALSE(is_cut(3));
}

TEST_F(Connections, WhoTakesTooLongIsCutAndAStreamIsNot) {
  Visitors visitors(few());
  come(visitors, 1);
  visitors.now_does(come(visitors, 2), Visitors::Doing::answering, now_);
  visitors.now_does(come(visitors, 3), Visitors::Doing::watching, now_);
  visitors.cut_late(now_ + few().asking_max);
  EXPECT_TRUE(is_cut(0));
  EXPECT_FALSE(is_cut(1));
  visitors.cut_late(now_ + few().answering_max);
  EXPECT_TRUE(is_cut(1));
  EXPECT_FALSE(is_cut(2));
}

}  // namespace
}  // namespace im2fit::apps
