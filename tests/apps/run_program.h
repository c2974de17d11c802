// SPDX-License-Identifier: Apache-2.0
// Starts a program as a shell does, and captures its output.
#pragma once

#include <fcntl.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace im2fit::test {

struct Run {
  int exit_code = -1;  // -1: ended by a signal or given up after the timeout
  std::string out;
  std::string err;
};

struct RunOptions {
  std::optional<rlim_t> file_bytes_max;                          // writes beyond fail, as on a full disk
  std::vector<std::pair<std::string, std::string>> environment;  // "" unsets
  std::string stdout_path;                                       // "": kept in Run::out
  int timeout_s = 60;
};

namespace detail {

[[noreturn]] inline void become(std::vector<char*>& argv, int out, int err, const RunOptions& options) {
  if (!options.stdout_path.empty()) out = ::open(options.stdout_path.c_str(), O_WRONLY | O_CLOEXEC);
  ::dup2(out, STDOUT_FILENO);
  ::dup2(err, STDERR_FILENO);
  for (const auto& [name, value] : options.environment) {
    if (value.empty())
      ::unsetenv(name.c_str());
    else
      ::setenv(name.c_str(), value.c_str(), 1);
  }
  if (options.file_bytes_max) {
    // Ignored, the signal leaves an error of write(), as a full disk does.
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{*options.file_bytes_max, *options.file_bytes_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ::execv(argv[0], argv.data());
  ::_exit(127);
}

// Reads both pipes to their ends; false when the time is over.
inline bool drain(std::array<int, 2> pipes, std::array<std::string*, 2> texts, int timeout_s) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(timeout_s);
  std::array<pollfd, 2> polled{pollfd{pipes[0], POLLIN, 0}, pollfd{pipes[1], POLLIN, 0}};
  while (polled[0].fd >= 0 || polled[1].fd >= 0) {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
    if (left.count() <= 0 || ::poll(polled.data(), polled.size(), static_cast<int>(left.count())) == 0) return false;
    for (std::size_t i = 0; i < polled.size(); ++i) {
      if (polled[i].fd < 0 || polled[i].revents == 0) continue;
      std::array<char, 4096> buffer;
      const ssize_t count = ::read(polled[i].fd, buffer.data(), buffer.size());
      if (count > 0)
        texts[i]->append(buffer.data(), static_cast<std::size_t>(count));
      else
        polled[i].fd = -1;
    }
  }
  return true;
}

}  // namespace detail

inline Run run_program(std::vector<std::string> command, const RunOptions& options = {}) {
  std::vector<char*> argv;
  argv.reserve(command.size() + 1);
  for (std::string& word : command) argv.push_back(word.data());
  argv.push_back(nullptr);
  std::array<int, 2> out{}, err{};
  Run run;
  if (::pipe2(out.data(), O_CLOEXEC) != 0 || ::pipe2(err.data(), O_CLOEXEC) != 0) return run;
  const pid_t child = ::fork();
  if (child == 0) detail::become(argv, out[1], err[1], options);
  ::close(out[1]);
  ::close(err[1]);
  if (!detail::drain({out[0], err[0]}, {&run.out, &run.err}, options.timeout_s)) {
    run.err += "(given up after " + std::to_string(options.timeout_s) + " s)";
    ::kill(child, SIGKILL);
  }
  ::close(out[0]);
  ::close(err[0]);
  int status = 0;
  ::waitpid(child, &status, 0);
  if (WIFEXITED(status)) run.exit_code = WEXITSTATUS(status);
  return run;
}

// Exactly one line on stderr, beginning with the program's name and saying more than it.
inline bool is_one_line_of(const std::string& text, const std::string& program) {
  const std::string head = program + ": ";
  return text.size() > head.size() + 10 && text.rfind(head, 0) == 0 && text.find('\n') == text.size() - 1;
}

}  // namespace im2fit::test
