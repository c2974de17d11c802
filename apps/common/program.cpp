// SPDX-License-Identifier: Apache-2.0
#include "apps/common/program.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <exception>

namespace im2fit::apps {
namespace {

std::string& program_name() {
  static std::string name = "im2fit";
  return name;
}

double now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::string duration(double seconds) {
  const auto whole = std::lround(seconds);
  return whole < 60 ? fmt::format("{} s", whole) : fmt::format("{} min {:02} s", whole / 60, whole % 60);
}

// Libraries for tools (fmt, JSON) throw; a program answers with one line.
Result<int> guarded(const Command& command) {
  try {
    return command();
  } catch (const std::exception& error) {
    return Error{ErrorCode::io, error.what()};
  }
}

}  // namespace

void print_error(const std::string& text) {
  std::string line = text;
  std::replace(line.begin(), line.end(), '\n', ' ');
  fmt::print(stderr, "{}: {}\n", program_name(), line);
}

int run_program(CLI::App& app, Command& chosen, int argc, char** argv) {
  program_name() = app.get_name();
  app.require_subcommand(1);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& asked) {  // --help, --version
    return app.exit(asked);
  } catch (const CLI::ParseError& error) {
    print_error(fmt::format("{} (see {} --help)", error.what(), app.get_name()));
    return kExitWrongUse;
  }
  const Result<int> code = guarded(chosen);
  const Status flushed = flush_output();
  if (code && flushed) return *code;
  print_error(code ? flushed.error().message : code.error().message);
  return kExitFailed;
}

Status flush_output() {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return Ok{};
  const int reason = errno;
  std::clearerr(stdout);
  return Error{ErrorCode::io, fmt::format("cannot write to standard output: {}", std::strerror(reason))};
}

Progress::Progress(std::string what, std::uint64_t total)
    : what_(std::move(what)), total_(total), terminal_(isatty(STDERR_FILENO) == 1), started_s_(now_s()) {}

Progress::~Progress() {
  if (terminal_ && shown_s_ > 0) fmt::print(stderr, "\r\033[K");
}

void Progress::update(std::uint64_t done, const std::string& note) {
  const double now = now_s();
  if (!terminal_ || (now - shown_s_ < 0.2 && done != total_)) return;
  shown_s_ = now;
  const double elapsed = std::max(1e-3, now - started_s_);
  const double rate = static_cast<double>(done) / elapsed;
  std::string line = total_ > 0 ? fmt::format("{}: {}/{}", what_, done, total_) : fmt::format("{}: {}", what_, done);
  line += fmt::format(", {:.1f}/s", rate);
  if (total_ > done && rate > 0) line += ", " + duration(static_cast<double>(total_ - done) / rate) + " left";
  if (!note.empty()) line += ", " + note;
  fmt::print(stderr, "\r\033[K{}", line);
  std::fflush(stderr);
}

}  // namespace im2fit::apps
