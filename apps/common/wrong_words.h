// SPDX-License-Identifier: Apache-2.0
// What was wrong with a command line, for the person who typed it: the word, what may have been meant, whose help to
// read.
#pragma once

#include <string>
#include <vector>

namespace CLI {  // NOLINT(readability-identifier-naming): that of CLI11
class App;
class ParseError;
}  // namespace CLI

namespace im2fit::apps {

// One line: "measure has no --rotat; did you mean --rotate? (see im2fit measure --help)".
std::string wrong_words(const CLI::App& app, const CLI::ParseError& error, int argc, const char* const* argv);

// Of `words` the one that takes the fewest letters to insert, delete, replace or swap with their neighbour; "" when
// that are more than a third of `word`, rounded up.
std::string nearest_word(const std::string& word, const std::vector<std::string>& words);

}  // namespace im2fit::apps
