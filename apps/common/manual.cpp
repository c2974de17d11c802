// SPDX-License-Identifier: Apache-2.0
#include "apps/common/manual.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <string_view>
#include <vector>

namespace im2fit::apps {
namespace {

std::vector<const CLI::App*> subcommands_of(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App*) { return true; });
}
std::vector<const CLI::Option*> options_of(const CLI::App& app) {
  return app.get_options([](const CLI::Option*) { return true; });
}

// troff: escapes backslashes and hyphens. A line that begins with a dot or an apostrophe is not read as a request.
std::string troff(const std::string& text) {
  std::string out;
  bool line_begins = true;
  for (const char c : text) {
    if (line_begins && (c == '.' || c == '\'')) out += "\\&";
    if (c == '\\')
      out += "\\e";
    else if (c == '-')
      out += "\\-";
    else
      out += c;
    line_begins = c == '\n';
  }
  return out;
}

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

// "--out DIR", "SOURCE".
std::string words_of(const CLI::Option& option) {
  std::string words = option.get_name(option.get_positional(), true);
  const std::string type = option.get_type_size() > 0 ? option.get_type_name() : "";
  return type.empty() || option.get_positional() ? words : words + " " + type;
}

// How many threads there are depends on the machine a page is made on.
bool has_lasting_default(const CLI::Option& option) {
  return !option.get_default_str().empty() && option.get_name().find("threads") == std::string::npos;
}

void append_options(std::string& out, const CLI::App& app) {
  for (const CLI::Option* option : options_of(app)) {
    out += ".TP\n\\fB" + troff(words_of(*option)) + "\\fR\n" + troff(option->get_description());
    if (has_lasting_default(*option)) out += " [" + troff(option->get_default_str()) + "]";
    if (option->get_required()) out += " (required)";
    out += '\n';
  }
}

// Examples and notes keep their lines.
void append_footer(std::string& out, const CLI::App& app) {
  const std::string footer = app.get_footer();
  if (!footer.empty()) out += ".PP\n.nf\n" + troff(footer) + "\n.fi\n";
}

void append_commands(std::string& out, const CLI::App& app, const std::string& path) {
  for (const CLI::App* sub : subcommands_of(app)) {
    const std::string name = path + sub->get_name();
    out += ".SS \"" + troff(name) + "\"\n" + troff(sub->get_description()) + ".\n";
    append_options(out, *sub);
    append_footer(out, *sub);
    append_commands(out, *sub, name + " ");
  }
}

// A word for a place in a shell script: only letters of option and command names.
std::string word(const std::string& text) {
  std::string out;
  for (const char c : text)
    if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_') out += c;
  return out;
}

// A case for every command: its subcommands and options.
void append_cases(std::string& out, const CLI::App& app, const std::string& path) {
  out += "    '" + path + "') words='";
  for (const CLI::App* sub : subcommands_of(app)) out += word(sub->get_name()) + " ";
  for (const CLI::Option* option : options_of(app))
    for (const std::string& name : option->get_lnames()) out += "--" + word(name) + " ";
  if (out.back() == ' ') out.pop_back();
  out += "' ;;\n";
  for (const CLI::App* sub : subcommands_of(app)) append_cases(out, *sub, path + " " + word(sub->get_name()));
}

void collect_commands(std::vector<std::string>& names, const CLI::App& app) {
  for (const CLI::App* sub : subcommands_of(app)) {
    names.push_back(word(sub->get_name()));
    collect_commands(names, *sub);
  }
}

}  // namespace

std::string man_page(const CLI::App& app) {
  const std::string name = app.get_name();
  std::string out = ".\\\" Made by " + name + " --man-page.\n.TH " + upper(name) + " 1 \"\" \"im2fit\"\n.SH NAME\n" +
                    troff(name) + " \\- " + troff(app.get_description()) + "\n.SH SYNOPSIS\n.B " + troff(name) + "\n";
  out += subcommands_of(app).empty() ? "[OPTIONS]\n" : "COMMAND [OPTIONS]\n";
  out += ".SH DESCRIPTION\n" + troff(app.get_description()) + "\n";
  append_footer(out, app);
  out += ".SH OPTIONS\n";
  append_options(out, app);
  if (!subcommands_of(app).empty()) out += ".SH COMMANDS\n";
  append_commands(out, app, "");
  return out;
}

std::string bash_completion(const CLI::App& app) {
  const std::string name = word(app.get_name());
  std::string function = "_" + name;
  std::replace(function.begin(), function.end(), '-', '_');
  std::vector<std::string> commands;
  collect_commands(commands, app);
  std::sort(commands.begin(), commands.end());
  commands.erase(std::unique(commands.begin(), commands.end()), commands.end());
  std::string known;
  for (const std::string& command : commands) known += (known.empty() ? "" : "|") + command;
  std::string out = "# Made by " + name + " --bash-completion.\n" + function +
                    "() {\n  local word path='' words='' current=${COMP_WORDS[COMP_CWORD]}\n"
                    "  for word in \"${COMP_WORDS[@]:1:COMP_CWORD-1}\"; do\n    case $word in\n";
  if (!known.empty()) out += "      " + known + ") path+=\" $word\" ;;\n";
  out += "      *) ;;\n    esac\n  done\n  case $path in\n";
  append_cases(out, app, "");
  out += "  esac\n  mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$current\")\n}\ncomplete -o default -F " +
         function + " " + name + "\n";
  return out;
}

std::optional<std::string> manual_asked(const CLI::App& app, int argc, const char* const* argv) {
  if (argc != 2) return std::nullopt;
  const std::string_view asked = argv[1];
  if (asked == "--man-page") return man_page(app);
  if (asked == "--bash-completion") return bash_completion(app);
  return std::nullopt;
}

}  // namespace im2fit::apps
