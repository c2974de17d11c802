// SPDX-License-Identifier: Apache-2.0
// A board over HTTP: its files, its messages as a stream at /events, and the page that shows them.
#pragma once

#include <memory>
#include <string>

#include "apps/im2fit/page/board.h"
#include "core/status.h"

namespace im2fit::apps {

struct PageAddress {
  std::string host = "127.0.0.1";
  int port = 8017;  // 0: any that is free
};

class PageServer {
 public:
  static constexpr int kWatchersMax = 8;  // streams at once; further ones are answered 503

  // Answers from here on, on threads of its own. `board` must outlive it. At an address of this machine alone (127.*,
  // ::1, localhost) only requests that name such a host are answered: pages from elsewhere whose name was made to
  // lead here (DNS rebinding) see nothing. Errors: the address cannot be listened at.
  static Result<std::unique_ptr<PageServer>> open(const PageAddress& address, Board& board);
  ~PageServer();  // closes the board
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;

  const std::string& url() const;  // "http://127.0.0.1:8017/"
  int watchers() const;            // streams open now

 private:
  struct Parts;
  explicit PageServer(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace im2fit::apps
