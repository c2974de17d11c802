// SPDX-License-Identifier: Apache-2.0
#include "apps/common/program.h"

#include <fmt/core.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <string>
#include <vector>

#include "apps/common/manual.h"
#include "core/text.h"

namespace im2fit::apps {
namespace {

// Optimal string alignment (Damerau-Levenshtein without edits inside a swap).
std::size_t distance(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
  for (std::size_t j = 0; j <= b.size(); ++j) d[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i)
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, replaced});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  return d[a.size()][b.size()];
}

// Of `words` the one that takes the fewest letters to insert, delete, replace or swap with their neighbour; "" when
// that are more than a third of `word`, rounded up.
std::string nearest_word(const std::string& word, const std::vector<std::string>& words) {
  std::string best;
  std::size_t fewest = (word.size() + 2) / 3 + 1;
  for (const std::string& candidate : words) {
    const std::size_t edits = distance(word, candidate);
    if (edits >= fewest) continue;
    fewest = edits;
    best = candidate;
  }
  return best;
}

std::vector<const CLI::App*> subcommands_of(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App*) { return true; });
}

std::vector<std::string> long_options_of(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options([](const CLI::Option*) { return true; }))
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

// The subcommand that the first words name, and the words after it.
struct Place {
  const CLI::App* command;
  std::string name;
  std::vector<std::string> rest;
};
Place place_of(const CLI::App& app, int argc, const char* const* argv) {
  Place place{&app, app.get_name(), {}};
  int i = 1;
  for (bool deeper = true; deeper && i < argc;) {
    deeper = false;
    for (const CLI::App* sub : subcommands_of(*place.command))
      if (sub->get_name() == argv[i]) {
        place.command = sub;
        place.name += " " + sub->get_name();
        ++i;
        deeper = true;
        break;
      }
  }
  for (; i < argc; ++i) place.rest.emplace_back(argv[i]);
  return place;
}

std::string not_known(const std::string& owner, const std::string& word, const std::vector<std::string>& words) {
  const std::string near = nearest_word(word, words);
  return fmt::format("{} has no {}{}", owner, word, near.empty() ? "" : "; did you mean " + near + "?");
}

std::string unknown_word(const Place& place) {
  const auto subs = subcommands_of(*place.command);
  if (!subs.empty() && !place.rest.empty() && place.rest.front()[0] != '-') {
    std::vector<std::string> names;
    for (const CLI::App* sub : subs) names.push_back(sub->get_name());
    return not_known(place.name, place.rest.front(), names);
  }
  const std::vector<std::string> known = long_options_of(*place.command);
  for (const std::string& given : place.rest) {
    const std::string word = given.substr(0, given.find('='));
    if (word == "--") break;
    if (word.rfind("--", 0) == 0 && std::find(known.begin(), known.end(), word) == known.end())
      return not_known(place.name, word, known);
  }
  return "";
}

// One line: "measure has no --rotat; did you mean --rotate? (see im2fit measure --help)".
std::string wrong_words(const CLI::App& app, const CLI::ParseError& error, int argc, const char* const* argv) {
  const Place place = place_of(app, argc, argv);
  const std::string unknown = unknown_word(place);
  return fmt::format("{} (see {} --help)", unknown.empty() ? error.what() : unknown, place.name);
}

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
