// SPDX-License-Identifier: Apache-2.0
#include "apps/common/program.h"

#include <fmt/core.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>

#include "apps/common/manual.h"
#include "apps/common/wrong_words.h"
#include "core/text.h"

namespace im2fit::apps {
namespace {

std::string& program_name() {
  static std::string name = "im2fit";
  return name;
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
  // On a terminal progress may stand in this line (apps/common/progress.h).
  const char* clear = ::isatty(STDERR_FILENO) == 1 ? "\r\033[K" : "";
  fmt::print(stderr, "{}{}: {}\n", clear, program_name(), printable(text));
}

int run_program(cli::App& program, Command& chosen, int argc, char** argv) {
  CLI::App& app = program.native();
  program_name() = app.get_name();
  app.require_subcommand(1);
  app.set_version_flag("--version", app.get_name() + " " + IM2FIT_VERSION, "Print the version and exit");
  if (const auto manual = manual_asked(app, argc, argv)) {
    fmt::print("{}", *manual);
    return flush_output() ? kExitOk : kExitFailed;
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& asked) {  // --help, --version
    return app.exit(asked);
  } catch (const CLI::ParseError& error) {
    print_error(wrong_words(app, error, argc, argv));
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

}  // namespace im2fit::apps
