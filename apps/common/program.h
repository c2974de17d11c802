// SPDX-License-Identifier: Apache-2.0
// What both programs share: exit codes, one-line errors, and the way from the command line to a command.
#pragma once

#include <functional>
#include <string>

#include "apps/common/cli.h"
#include "core/status.h"

namespace im2fit::apps {

inline constexpr int kExitOk = 0;
inline constexpr int kExitFailed = 1;
inline constexpr int kExitWrongUse = 2;
inline constexpr int kExitNoMeasurement = 3;

// A command's work, chosen by the command line; returns the exit code.
using Command = std::function<Result<int>()>;

// Parses, runs the function that the parsed subcommand put into `chosen`, prints an error as one line on stderr.
// --help exits 0, bad words exit 2, errors exit 1.
int run_program(cli::App& app, Command& chosen, int argc, char** argv);

// A subcommand whose options live in `Options` and whose work is `run(options)`.
template <class Options>
cli::App* add_command(cli::App& app, Command& chosen, const std::string& name, const std::string& description,
                      const std::string& examples, std::shared_ptr<Options> options,
                      Result<int> (*run)(const Options&)) {
  cli::App* sub = app.add_subcommand(name, description);
  sub->footer("Examples:\n" + examples);
  sub->callback([&chosen, options, run] { chosen = [options, run] { return run(*options); }; });
  return sub;
}

// Flushes stdout. Error: a full disk or a closed pipe behind it. Only the first is reported, later calls succeed.
Status flush_output();

// `text` as one line for stderr: "PROGRAM: text".
void print_error(const std::string& text);

}  // namespace im2fit::apps
