// SPDX-License-Identifier: Apache-2.0
// The local socket: every client gets every event, one line each, and may send lines. No client is ever waited for.
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/status.h"

namespace im2fit::daemon {

struct PublisherOptions {
  std::string path = {};
  unsigned mode = 0660;
  std::string group = {};  // "": the process's
  int clients_max = 16;
  std::size_t client_buffer_bytes = 256 * 1024;  // a client with more than this unread is dropped
};

// A line that a client sent, without its end.
struct ClientLine {
  std::uint64_t client = 0;
  bool too_long = false;  // more than kClientLineMax bytes: `text` is empty
  std::string text;
};
inline constexpr std::size_t kClientLineMax = 1024;
inline constexpr std::size_t kClientLinesMax = 8;  // of one client, waiting to be taken; further ones are dropped

// One thread.
class Publisher {
 public:
  // Errors: invalid_argument (path too long, no such group), io (also: another daemon listens there).
  static Result<std::unique_ptr<Publisher>> open(const PublisherOptions& options);
  // The errors of open() that can be found without making the socket.
  static Status check(const PublisherOptions& options);
  ~Publisher();  // closes the clients and removes the socket
  Publisher(const Publisher&) = delete;
  Publisher& operator=(const Publisher&) = delete;

  // Accepts waiting clients and sends each the `greeting` first; sends pending lines; drops clients that have gone.
  void serve(const std::string& greeting);
  void publish(const std::string& line);
  // What clients sent since the last call, also those that have gone; of each client in order.
  std::vector<ClientLine> take_lines();
  // To that client alone; nothing when it has gone.
  void answer(std::uint64_t client, const std::string& line);
  // The same of an answer that may be longer than client_buffer_bytes: until it is read it does not count there. One
  // at a time: not while owes().
  void answer_long(std::uint64_t client, const std::string& line);
  bool owes(std::uint64_t client) const;  // a long answer that the client has not read whole
  // Waits up to `timeout_ms` for clients to take the pending lines. For the end of the program.
  void flush(int timeout_ms);

  std::size_t clients() const { return clients_.size(); }
  std::uint64_t dropped() const { return dropped_; }  // for being slow

 private:
  struct Client {
    int fd = -1;
    std::uint64_t number = 0;
    std::string waiting;         // not yet taken by the system
    std::string sent;            // by the client, up to the next line end
    bool too_long = false;       // the line being sent
    std::size_t lines = 0;       // waiting to be taken
    std::size_t owed = 0;        // of `waiting`, up to the end of a long answer
    std::size_t long_bytes = 0;  // of that answer alone
  };
  explicit Publisher(PublisherOptions options) : options_(std::move(options)) {}
  bool send(Client& client);     // false: gone or too slow, and closed
  bool receive(Client& client);  // false: gone, and closed
  void let_go(Client& client);   // takes what it sent last, and closes
  void take_bytes(Client& client, std::string_view bytes);

  PublisherOptions options_;
  int fd_ = -1;
  bool bound_ = false;
  std::list<Client> clients_;
  std::vector<ClientLine> lines_;
  std::uint64_t accepted_ = 0;
  std::uint64_t dropped_ = 0;
};

}  // namespace im2fit::daemon
