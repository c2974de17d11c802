// SPDX-License-Identifier: Apache-2.0
#include "hal/openni2/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <thread>
#include <utility>

extern char** environ;

namespace im2fit::hal {
namespace {

constexpr int kPipeBytes = 1 << 20;  // more than a 640 x 480 frame, so that the child decodes one ahead

Error system_error(const std::string& what, int code) {
  return {ErrorCode::io, what + ": " + std::strerror(code)};
}

Result<std::pair<int, int>> make_pipe() {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) return system_error("cannot make a pipe", errno);
  ::fcntl(ends[0], F_SETPIPE_SZ, kPipeBytes);  // smaller is slower, not wrong
  return std::pair{ends[0], ends[1]};
}

}  // namespace

Result<ChildProcess> ChildProcess::spawn(const std::string& program, const std::vector<std::string>& arguments) {
  auto pipe = make_pipe();
  if (!pipe) return pipe.error();
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, pipe->second, kPipeFd);
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 2, "/dev/null", O_WRONLY, 0);
#if defined(__GLIBC__)
  posix_spawn_file_actions_addclosefrom_np(&actions, kPipeFd + 1);
#endif
  std::vector<char*> argv{const_cast<char*>(program.c_str())};
  for (const auto& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  ChildProcess child;
  child.fd_ = pipe->first;
  const int code = ::posix_spawn(&child.pid_, program.c_str(), &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  ::close(pipe->second);
  if (code != 0) {
    child.pid_ = -1;
    return system_error("cannot start " + program, code);
  }
  return child;
}

Result<ChildProcess> ChildProcess::fork(const std::function<int(int)>& body) {
  auto pipe = make_pipe();
  if (!pipe) return pipe.error();
  ChildProcess child;
  child.fd_ = pipe->first;
  child.pid_ = ::fork();
  if (child.pid_ == 0) {
    for (int fd = 3; fd < 1024; ++fd)
      if (fd != pipe->second) ::close(fd);
    ::_exit(body(pipe->second));
  }
  const int code = errno;
  ::close(pipe->second);
  if (child.pid_ < 0) return system_error("cannot start a process", code);
  return child;
}

ChildProcess ChildProcess::reading(int fd) {
  ChildProcess child;
  child.fd_ = fd;
  return child;
}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept
    : pid_(std::exchange(other.pid_, -1)), fd_(std::exchange(other.fd_, -1)) {}

ChildProcess& ChildProcess::operator=(ChildProcess&& other) noexcept {
  if (this != &other) {
    end();
    pid_ = std::exchange(other.pid_, -1);
    fd_ = std::exchange(other.fd_, -1);
  }
  return *this;
}

ChildProcess::Read ChildProcess::read(void* to, std::size_t size, int timeout_ms, std::size_t& count) {
  count = 0;
  if (fd_ < 0) return Read::closed;
  pollfd item{fd_, POLLIN, 0};
  const int ready = ::poll(&item, 1, timeout_ms > 0 ? timeout_ms : 0);
  if (ready <= 0) return Read::nothing_yet;  // also when a signal came in between: the caller counts the time
  const ssize_t n = ::read(fd_, to, size);
  if (n < 0 && (errno == EINTR || errno == EAGAIN)) return Read::nothing_yet;
  if (n <= 0) return Read::closed;
  count = static_cast<std::size_t>(n);
  return Read::some;
}

std::string ChildProcess::end() {
  return finish(true);
}
std::string ChildProcess::reap() {
  return finish(false);
}

std::string ChildProcess::finish(bool kill) {
  if (fd_ >= 0) ::close(std::exchange(fd_, -1));
  if (pid_ <= 0) return "ended before";
  const pid_t pid = std::exchange(pid_, -1);
  int status = 0;
  pid_t done = 0;
  // A child whose pipe is closed is about to exit; one that has not after a second never will.
  for (int i = 0; !kill && i < 100; ++i) {
    done = ::waitpid(pid, &status, WNOHANG);
    if (done != 0) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  if (done == 0) {
    ::kill(pid, SIGKILL);
    while ((done = ::waitpid(pid, &status, 0)) < 0 && errno == EINTR) {
    }
  }
  if (done < 0) return "ended with an unknown status";  // the program ignores SIGCHLD
  if (WIFSIGNALED(status)) return "crashed (signal " + std::to_string(WTERMSIG(status)) + ")";
  return "exited with " + std::to_string(WEXITSTATUS(status));
}

}  // namespace im2fit::hal
