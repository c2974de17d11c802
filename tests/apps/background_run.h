// SPDX-License-Identifier: Apache-2.0
// A program that runs beside the test, killed at the latest with this. Every wait is bounded.
#pragma once

#include <chrono>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "run_program.h"
#include "written_files.h"

namespace im2fit::test {

using Clock = std::chrono::steady_clock;
inline constexpr auto kPatience = std::chrono::seconds(40);

class BackgroundRun {
 public:
  BackgroundRun(std::vector<std::string> command, std::vector<std::pair<std::string, std::string>> environment,
                std::string stderr_path)
      : stderr_path_(std::move(stderr_path)) {
    std::vector<char*> argv;
    for (std::string& word : command) argv.push_back(word.data());
    argv.push_back(nullptr);
    // Emptied before there are two of us: messages() must not find the output of a run before this one.
    const int err = ::open(stderr_path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    pid_ = ::fork();
    if (pid_ != 0) {
      ::close(err);
      return;
    }
    RunOptions options;
    options.environment = std::move(environment);
    detail::become(argv, err, err, options);
  }
  ~BackgroundRun() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }
  BackgroundRun(const BackgroundRun&) = delete;
  BackgroundRun& operator=(const BackgroundRun&) = delete;
  void signal(int number) const { ::kill(pid_, number); }
  pid_t pid() const { return pid_; }
  std::string messages() const { return read_text(stderr_path_); }
  // Its exit code; -1 when it was killed or does not end.
  int wait() {
    for (const auto end = Clock::now() + kPatience; Clock::now() < end;) {
      int status = 0;
      if (::waitpid(pid_, &status, WNOHANG) == pid_) {
        pid_ = -1;
        return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return -1;
  }

 private:
  pid_t pid_ = -1;
  std::string stderr_path_;
};

}  // namespace im2fit::test
