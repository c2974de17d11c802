// SPDX-License-Identifier: Apache-2.0
// What the page shows: the latest message of each kind, and files. Any thread may call anything.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

namespace im2fit::apps {

struct PageFile {
  std::string type;  // "image/png"
  std::string bytes;
};

class LaterAnswer;  // chores.h

// To a request with a query.
struct PageAnswer {
  unsigned status = 200;                           // HTTP
  std::shared_ptr<const PageFile> file = nullptr;  // with 200
  std::string text = {};                           // else a line for people
  // Not null: the answer that another thread is working on, in place of all of the above.
  std::shared_ptr<const LaterAnswer> later = nullptr;
};

class Board {
 public:
  // Replaces the last message of that kind: a slow reader misses some, never the latest. One line of text.
  void publish(const std::string& kind, std::string message);
  // Messages younger than `seen`, oldest first, as server-sent events (WHATWG HTML, 9.2.6); waits for one. "" when
  // none came in time or the board is closed. `seen` begins at 0.
  std::string wait(std::uint64_t& seen, std::chrono::milliseconds patience);
  // The number of the youngest message once there is one younger than `known`, the board is closed or patience ends.
  std::uint64_t await(std::uint64_t known, std::chrono::milliseconds patience);
  void put(const std::string& path, PageFile file);
  // New requests no longer get messages of these kinds or these files. A client that is reading one goes on reading.
  void withdraw(std::initializer_list<const char*> kinds, std::initializer_list<const char*> paths);
  std::shared_ptr<const PageFile> file(const std::string& path) const;  // null: no such file
  void close();                                                         // wakes waiting calls; nothing comes any more
  bool closed() const;

 private:
  mutable std::mutex mutex_;
  std::condition_variable news_;
  std::map<std::string, std::pair<std::uint64_t, std::string>> messages_;  // by kind: number, text
  std::map<std::string, std::shared_ptr<const PageFile>> files_;
  std::uint64_t published_ = 0;
  bool closed_ = false;
};

}  // namespace im2fit::apps
