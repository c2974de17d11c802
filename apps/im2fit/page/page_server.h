// SPDX-License-Identifier: Apache-2.0
// A board over HTTP: its files, its messages as a stream at /events, and the page that shows them.
#pragma once

#include <memory>
#include <string>

#include "apps/im2fit/page/board.h"
#include "apps/im2fit/page/fitting_room.h"
#include "core/status.h"

namespace im2fit::apps {

struct PageAddress {
  std::string host = "127.0.0.1";
  int port = 8017;  // 0: any that is free
};

// One thread serves all connections, and waits for none of them: visitors.h limits their number and their time, a
// request's header is at most 16 KB, a body is not read at all. GET and HEAD only; host_check.h says whom it answers.
class PageServer {
 public:
  static constexpr int kWatchersMax = 8;  // streams at once; further ones are answered 503

  // Answers from here on, on two threads of its own. `board` must outlive it, and `fitting`, which answers
  // /tryon.glb, may be null. Errors: the address cannot be listened at.
  static Result<std::unique_ptr<PageServer>> open(const PageAddress& address, Board& board,
                                                  FittingRoom* fitting = nullptr);
  // Closes the board; streams get their end, everyone else is cut off. Takes less than half a second whatever clients
  // do.
  ~PageServer();
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;

  const std::string& url() const;  // "http://127.0.0.1:8017/"
  int watchers() const;            // streams open now
  // Serves a connected stream socket as one that was accepted, and owns it from here on.
  Status add(int socket);

 private:
  struct Parts;
  explicit PageServer(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace im2fit::apps
