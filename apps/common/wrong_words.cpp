// SPDX-License-Identifier: Apache-2.0
#include "apps/common/wrong_words.h"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>

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

}  // namespace

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

std::string wrong_words(const CLI::App& app, const CLI::ParseError& error, int argc, const char* const* argv) {
  const Place place = place_of(app, argc, argv);
  const std::string unknown = unknown_word(place);
  return fmt::format("{} (see {} --help)", unknown.empty() ? error.what() : unknown, place.name);
}

}  // namespace im2fit::apps
