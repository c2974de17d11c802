// SPDX-License-Identifier: Apache-2.0
// The command line for commands: the part of CLI11 that they use, without its headers, which take a compiler longer
// than most commands do. Every function does the same as CLI11's function of that name.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <initializer_list>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

namespace CLI {  // NOLINT(readability-identifier-naming): that of CLI11
class App;
class Option;
}  // namespace CLI

namespace im2fit::apps::cli {

class Option {
 public:
  explicit Option(CLI::Option& option) : option_(&option) {}
  Option* capture_default_str();
  Option* check(const std::function<std::string(const std::string&)>& fault);  // "" when the text is fine
  Option* delimiter(char between);
  Option* description(const std::string& text);
  Option* excludes(Option* other);
  Option* excludes(const std::string& other);
  Option* needs(Option* other);
  Option* one_of(std::initializer_list<const char*> words);
  Option* one_of(std::initializer_list<int> numbers);
  Option* one_of(const std::vector<std::string>& words);
  template <class Number>
  Option* range(Number least, Number most) {  // inclusive
    if constexpr (std::is_floating_point_v<Number>)
      return real_range(least, most);
    else
      return whole_range(least, most);
  }
  Option* required();
  Option* type_name(const std::string& name);
  std::size_t count() const;  // how often it was given

 private:
  friend class App;
  Option* whole_range(std::int64_t least, std::int64_t most);
  Option* real_range(double least, double most);
  CLI::Option* option_;
};

// A program or a subcommand. Options and subcommands live as long as it does.
class App {
 public:
  App(const std::string& description, const std::string& name);  // a program
  ~App();
  App(const App&) = delete;
  App& operator=(const App&) = delete;

  Option* add_option(const std::string& name, int& value, const std::string& description);
  Option* add_option(const std::string& name, unsigned& value, const std::string& description);
  Option* add_option(const std::string& name, unsigned long& value, const std::string& description);
  Option* add_option(const std::string& name, unsigned long long& value, const std::string& description);
  Option* add_option(const std::string& name, float& value, const std::string& description);
  Option* add_option(const std::string& name, double& value, const std::string& description);
  Option* add_option(const std::string& name, std::string& value, const std::string& description);
  Option* add_option(const std::string& name, std::vector<std::string>& values, const std::string& description);
  // Given, it calls `take` with its text. Options take theirs in the order they were added.
  Option* add_option_function(const std::string& name, const std::function<void(const std::string&)>& take,
                              const std::string& description);
  Option* add_flag(const std::string& name, bool& value, const std::string& description);
  // Given, it sets `value` to `word`.
  Option* add_word_flag(const std::string& name, std::string& value, const std::string& word,
                        const std::string& description);
  // `NAME` or `NAME=CHOICE`: sets `value` to the word of the choice, without one of the first. Each is {choice,
  // word}.
  Option* add_choice_flag(const std::string& name, std::string& value,
                          const std::vector<std::pair<std::string, std::string>>& choices,
                          const std::string& description);
  Option* get_option(const std::string& name);  // throws for a name that was not added
  void remove_option(Option* option);
  App* add_subcommand(const std::string& name, const std::string& description);
  void callback(std::function<void()> chosen);
  void footer(const std::string& text);
  bool parsed() const;
  bool any_subcommand() const;  // was given; CLI11: !get_subcommands().empty()
  // For callbacks: the command line lacks this option. Ends parsing.
  [[noreturn]] static void missing(const std::string& option);
  CLI::App& native() { return *app_; }

 private:
  explicit App(CLI::App& subcommand);
  Option* keep(CLI::Option* option);
  std::unique_ptr<CLI::App> owned_;
  CLI::App* app_;
  std::deque<Option> options_;
  std::deque<std::unique_ptr<App>> subcommands_;
};

}  // namespace im2fit::apps::cli
