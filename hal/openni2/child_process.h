// SPDX-License-Identifier: Apache-2.0
// A child process that writes into a pipe of ours.
#pragma once

#include <sys/types.h>

#include <functional>
#include <string>
#include <vector>

#include "core/status.h"

namespace im2fit::hal {

// Movable owner of the process and of the pipe's reading end. The destructor kills and reaps: no zombie, no open
// file.
class ChildProcess {
 public:
  static constexpr int kPipeFd = 3;  // the pipe's number in the child

  // Starts `program` with `arguments`; stdin, stdout and stderr are /dev/null.
  static Result<ChildProcess> spawn(const std::string& program, const std::vector<std::string>& arguments);
  // Forks and runs `body`(pipe), whose result is the exit code.
  static Result<ChildProcess> fork(const std::function<int(int pipe)>& body);

  // Without a process: reads from `fd` and closes it. For tests of readers.
  static ChildProcess reading(int fd);

  ChildProcess() = default;
  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&& other) noexcept;
  ~ChildProcess() { end(); }

  bool running() const { return pid_ > 0; }
  pid_t pid() const { return pid_; }

  enum class Read { some, nothing_yet, closed };
  // Waits up to `timeout_ms` and reads at most `size` bytes; `count` gets their number.
  Read read(void* to, std::size_t size, int timeout_ms, std::size_t& count);
  // Kills, reaps, closes; returns how the process ended ("exited with 1", "crashed (signal 11)"). Harmless when
  // repeated.
  std::string end();
  // As end(), but lets a process that is ending by itself end.
  std::string reap();

 private:
  std::string finish(bool kill);
  pid_t pid_ = -1;
  int fd_ = -1;
};

}  // namespace im2fit::hal
