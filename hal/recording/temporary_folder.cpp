// SPDX-License-Identifier: Apache-2.0
#include "hal/recording/temporary_folder.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <utility>

namespace im2fit::hal {

Result<TemporaryFolder> TemporaryFolder::make() {
  std::error_code code;
  const auto root = std::filesystem::temp_directory_path(code);
  if (code) return Error{ErrorCode::io, "there is no folder for temporary files: " + code.message() + "; set TMPDIR"};
  std::string name = (root / "im2fit-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr)
    return Error{ErrorCode::io, "cannot make a folder in " + root.string() + ": " + std::strerror(errno) +
                                    "; set TMPDIR to a folder with room"};
  TemporaryFolder folder(std::move(name));
  folder.watch();
  return folder;
}

TemporaryFolder::TemporaryFolder(TemporaryFolder&& other) noexcept
    : path_(std::exchange(other.path_, "")),
      pipe_(std::exchange(other.pipe_, -1)),
      watcher_(std::exchange(other.watcher_, -1)) {}

// The watcher is ended and not waited for: a child of this process may hold the pipe, too.
TemporaryFolder::~TemporaryFolder() {
  if (path_.empty()) return;
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
  // A program that waits for all its children may have taken this one's end: its number may be another's by now.
  if (watcher_ > 0 && ::waitpid(watcher_, nullptr, WNOHANG) == 0 && ::kill(watcher_, SIGKILL) == 0)
    while (::waitpid(watcher_, nullptr, 0) < 0 && errno == EINTR) {
    }
  if (pipe_ >= 0) ::close(pipe_);
}

#if defined(__ANDROID__)
// An app has its own place for temporary files, and the system's shell is not for it.
void TemporaryFolder::watch() {}
#else
namespace {

// In a program whose input and output are closed, a pipe could take their numbers, and what is printed would go
// there.
bool open_pipe(int (&ends)[2]) {
  constexpr int kFirst = STDERR_FILENO + 1;
  if (::pipe2(ends, O_CLOEXEC) != 0) return false;
  for (int& end : ends) {
    if (end >= kFirst) continue;
    const int low = std::exchange(end, ::fcntl(end, F_DUPFD_CLOEXEC, kFirst));
    ::close(low);
  }
  if (ends[0] >= 0 && ends[1] >= 0) return true;
  for (const int end : ends)
    if (end >= 0) ::close(end);
  return false;
}

}  // namespace

// Ctrl-C and hang-ups reach a whole group of processes: the shell is in another, and ignores them.
void TemporaryFolder::watch() {
  int ends[2];
  if (!open_pipe(ends)) return;
  posix_spawn_file_actions_t actions;
  posix_spawnattr_t attributes;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawnattr_init(&attributes);
  ::posix_spawn_file_actions_adddup2(&actions, ends[0], 0);
  ::posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
  ::posix_spawn_file_actions_addopen(&actions, 2, "/dev/null", O_WRONLY, 0);
  ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  ::posix_spawnattr_setpgroup(&attributes, 0);
  const std::string words[] = {"sh", "-c",
                               "trap '' INT TERM HUP; while read -r nothing; do :; done; rm -rf -- \"$0\"", path_};
  char* const arguments[] = {const_cast<char*>(words[0].c_str()), const_cast<char*>(words[1].c_str()),
                             const_cast<char*>(words[2].c_str()), const_cast<char*>(words[3].c_str()), nullptr};
  pid_t child = -1;
  const bool started = ::posix_spawn(&child, "/bin/sh", &actions, &attributes, arguments, environ) == 0;
  ::posix_spawnattr_destroy(&attributes);
  ::posix_spawn_file_actions_destroy(&actions);
  ::close(ends[0]);
  if (!started) {
    ::close(ends[1]);
    return;
  }
  pipe_ = ends[1];
  watcher_ = child;
}
#endif

}  // namespace im2fit::hal
