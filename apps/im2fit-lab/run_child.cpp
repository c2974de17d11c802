// SPDX-License-Identifier: Apache-2.0
#include "apps/im2fit-lab/run_child.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

extern char** environ;

namespace im2fit::apps {

Result<std::string> run_child(const std::vector<std::string>& words, ChildErrors errors) {
  std::array<int, 2> pipe_ends{};
  if (pipe2(pipe_ends.data(), O_CLOEXEC) != 0)
    return Error{ErrorCode::io, std::string("no pipe: ") + std::strerror(errno)};
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, pipe_ends[1], STDOUT_FILENO);
  if (errors == ChildErrors::hidden)
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  std::vector<char*> argv;
  argv.reserve(words.size() + 1);
  for (const auto& word : words) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  pid_t pid = 0;
  const int failure = posix_spawnp(&pid, argv[0], &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  close(pipe_ends[1]);
  std::string output;
  std::array<char, 4096> chunk{};
  for (ssize_t got = 0; failure == 0 && (got = read(pipe_ends[0], chunk.data(), chunk.size())) > 0;)
    output.append(chunk.data(), static_cast<std::size_t>(got));
  close(pipe_ends[0]);
  if (failure != 0)
    return Error{ErrorCode::not_found, words[0] + " cannot be started (" + std::strerror(failure) +
                                           "); scripts/deps installs what is needed"};
  int status = 0;
  while (waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    return Error{ErrorCode::io, "'" + words[0] + " " + (words.size() > 1 ? words[1] : "") + "' failed"};
  return output;
}

}  // namespace im2fit::apps
