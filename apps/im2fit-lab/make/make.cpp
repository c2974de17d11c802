// SPDX-License-Identifier: Apache-2.0
#include "apps/im2fit-lab/make/make.h"

#include <string>
#include <vector>

#include "apps/im2fit-lab/commands.h"

namespace im2fit::apps {
namespace {

struct Maker {
  const char* name;
  int (*make)(int argc, char** argv);
};
constexpr Maker kMakers[] = {
    {"avatar-plate", make_avatar_plate},
    {"cut-regression", make_cut_regression},
#if IM2FIT_HAVE_EVALUATION
    {"error-correlation", make_error_correlation},
#endif
    {"garment-plate", make_garment_plate},
#if IM2FIT_HAVE_EVALUATION
    {"garment-sheets", make_garment_sheets},
    {"garment-sizes", make_garment_sizes},
#endif
    {"measurement-regression", make_measurement_regression},
    {"tape-regression", make_tape_regression},
    {"tape-table", make_tape_table},
    {"wardrobe-table", make_wardrobe_table},
};

struct MakeCommand {
  std::string what;
  std::vector<std::string> words;  // the maker's own
};

Result<int> run_make(const MakeCommand& options) {
  for (const Maker& maker : kMakers) {
    if (options.what != maker.name) continue;
    std::vector<std::string> words = {options.what};
    words.insert(words.end(), options.words.begin(), options.words.end());
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    return maker.make(static_cast<int>(words.size()), argv.data());
  }
  return Error{ErrorCode::unsupported, "im2fit-lab make has no " + options.what};
}

}  // namespace

void add_make(cli::App& app, Command& chosen) {
  auto options = std::make_shared<MakeCommand>();
  auto* sub = add_command<MakeCommand>(
      app, chosen, "make",
      "Make tables compiled into the library and pictures of the manual, for developers of im2fit",
      "  im2fit-lab make tape-table data/tape > person/builtin_tape.inc\n"
      "  im2fit-lab make garment-plate body.i2b plate.png",
      options, run_make);
  std::vector<std::string> names;
  for (const Maker& maker : kMakers) names.emplace_back(maker.name);
  sub->add_option("WHAT", options->what, "Table or picture to make; without further arguments, its usage is printed")
      ->one_of(names)
      ->required();
  sub->add_option("WORDS", options->words, "Its files and options; put -- before options");
}

}  // namespace im2fit::apps
