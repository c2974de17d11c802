// SPDX-License-Identifier: Apache-2.0
#include "apps/common/cli.h"

#include <CLI/CLI.hpp>
#include <utility>

namespace im2fit::apps::cli {

Option* Option::capture_default_str() {
  option_->capture_default_str();
  return this;
}
Option* Option::check(const std::function<std::string(const std::string&)>& fault) {
  option_->check(fault);
  return this;
}
Option* Option::delimiter(char between) {
  option_->delimiter(between);
  return this;
}
Option* Option::description(const std::string& text) {
  option_->description(text);
  return this;
}
Option* Option::excludes(Option* other) {
  option_->excludes(other->option_);
  return this;
}
Option* Option::excludes(const std::string& other) {
  option_->excludes(other);
  return this;
}
Option* Option::needs(Option* other) {
  option_->needs(other->option_);
  return this;
}
Option* Option::one_of(std::initializer_list<const char*> words) {
  return one_of(std::vector<std::string>(words.begin(), words.end()));
}
Option* Option::one_of(std::initializer_list<int> numbers) {
  option_->check(CLI::IsMember(std::vector<int>(numbers)));
  return this;
}
Option* Option::one_of(const std::vector<std::string>& words) {
  option_->check(CLI::IsMember(words));
  return this;
}
Option* Option::required() {
  option_->required();
  return this;
}
Option* Option::type_name(const std::string& name) {
  option_->type_name(name);
  return this;
}
std::size_t Option::count() const {
  return option_->count();
}
Option* Option::whole_range(std::int64_t least, std::int64_t most) {
  option_->check(CLI::Range(least, most));
  return this;
}
Option* Option::real_range(double least, double most) {
  option_->check(CLI::Range(least, most));
  return this;
}

App::App(const std::string& description, const std::string& name)
    : owned_(std::make_unique<CLI::App>(description, name)), app_(owned_.get()) {}
App::App(CLI::App& subcommand) : app_(&subcommand) {}
App::~App() = default;

Option* App::keep(CLI::Option* option) {
  return &options_.emplace_back(*option);
}
Option* App::add_option(const std::string& name, int& value, const std::string& description) {
  return keep(app_->add_option(name, value, description));
}
Option* App::add_option(const std::string& name, unsigned& value, const std::string& description) {
  return keep(app_->add_option(name, value, description));
}
Option* App::add_option(const std::string& name, unsigned long& value, const std::string& description) {
  return keep(app_->add_option(name, value, description));
}
Option* App::add_option(const std::string& name, unsigned long long& value, const std::string& description) {
  return keep(app_->add_option(name, value, description));
}
Option* App::add_option(const std::string& name, float& value, const std::string& description) {
  return keep(app_->add_option(name, value, description));
}
Option* App::add_option(const std::string& name, double& value, const std::string& description) {
  return keep(app_->add_option(name, value, description));
}
Option* App::add_option(const std::string& name, std::string& value, const std::string& description) {
  return keep(app_->add_option(name, value, description));
}
Option* App::add_option(const std::string& name, std::vector<std::string>& values, const std::string& description) {
  return keep(app_->add_option(name, values, description));
}
Option* App::add_flag(const std::string& name, bool& value, const std::string& description) {
  return keep(app_->add_flag(name, value, description));
}
Option* App::add_option_function(const std::string& name, const std::function<void(const std::string&)>& take,
                                 const std::string& description) {
  return keep(app_->add_option_function<std::string>(name, take, description));
}
Option* App::add_word_flag(const std::string& name, std::string& value, const std::string& word,
                           const std::string& description) {
  return keep(app_->add_flag_callback(
      name, [&value, word] { value = word; }, description));
}
Option* App::add_choice_flag(const std::string& name, std::string& value,
                             const std::vector<std::pair<std::string, std::string>>& choices,
                             const std::string& description) {
  auto* option = app_->add_flag(name + "{" + choices.front().first + "}", value, description);
  std::string names;
  for (const auto& [choice, word] : choices) names += (names.empty() ? "" : "|") + choice;
  option->transform(CLI::CheckedTransformer(choices).description("=" + names));
  return keep(option);
}
Option* App::get_option(const std::string& name) {
  return keep(app_->get_option(name));
}
void App::remove_option(Option* option) {
  app_->remove_option(option->option_);
}
App* App::add_subcommand(const std::string& name, const std::string& description) {
  return subcommands_.emplace_back(new App(*app_->add_subcommand(name, description))).get();
}
void App::callback(std::function<void()> chosen) {
  app_->callback(std::move(chosen));
}
void App::footer(const std::string& text) {
  app_->footer(text);
}
bool App::parsed() const {
  return app_->parsed();
}
bool App::any_subcommand() const {
  return !app_->get_subcommands().empty();
}
void App::missing(const std::string& option) {
  throw CLI::RequiredError(option);
}

}  // namespace im2fit::apps::cli
