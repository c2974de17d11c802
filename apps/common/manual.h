// SPDX-License-Identifier: Apache-2.0
// The manual page and the bash completion of a program, from the parts of its --help.
#pragma once

#include <optional>
#include <string>

namespace CLI {  // NOLINT(readability-identifier-naming): that of CLI11
class App;
}

namespace im2fit::apps {

std::string man_page(const CLI::App& app);         // section 1, troff
std::string bash_completion(const CLI::App& app);  // to be sourced

// What is printed when the whole command line is --man-page or --bash-completion, which --help does not list:
// packages are made with them. Nothing for any other command line.
std::optional<std::string> manual_asked(const CLI::App& app, int argc, const char* const* argv);

}  // namespace im2fit::apps
