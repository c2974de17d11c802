// SPDX-License-Identifier: Apache-2.0
// Work that may wait for a disk, on a thread of its own: the server's thread, which serves all, goes on.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "apps/kiosk/board.h"

namespace im2fit::apps {

// An answer that is being worked on. Any thread.
class LaterAnswer {
 public:
  void give(PageAnswer answer);
  std::optional<PageAnswer> given() const;  // nothing: not yet

 private:
  mutable std::mutex mutex_;
  std::optional<PageAnswer> answer_;
};

class Chores {
 public:
  Chores() = default;
  ~Chores();  // after all work is done
  Chores(const Chores&) = delete;
  Chores& operator=(const Chores&) = delete;
  // Does not wait: the answer comes `later`. One after the other, in the order given; what throws is answered 500.
  // Where no thread can be made, the work is done at once, before the answer returns: what was to be deleted goes.
  // Any thread; without a lock that the work takes.
  PageAnswer run(std::function<PageAnswer()> work);

 private:
  struct Chore {
    std::function<PageAnswer()> work;
    std::shared_ptr<LaterAnswer> answer;
  };
  static void do_one(Chore chore);
  void do_all();

  std::mutex mutex_;  // of all below
  std::condition_variable changed_;
  std::deque<Chore> waiting_;
  bool ending_ = false;
  std::thread thread_;  // from the first chore on
};

}  // namespace im2fit::apps
