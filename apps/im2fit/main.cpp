// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <string_view>

#include "apps/im2fit/commands.h"

namespace {

struct NamedCommand {
  std::string_view name;
  void (*add)(im2fit::apps::cli::App& app, im2fit::apps::Command& chosen);
};

}  // namespace

int main(int argc, char** argv) {
  using namespace im2fit::apps;
  cli::App app{"Measures a person with one depth camera: body measurements, a clothing size and a 3D body.",
               "im2fit"};
  app.footer(
      "SOURCE is openni2[:URI], usb[:SERIAL], v4l2:/dev/videoN, synthetic[:SEED], a recording (.oni, .mkv, .bag, "
      ".zip) or a depth folder.\n"
      "Exit codes: 0 success, 1 failure, 2 wrong arguments, 3 no measurement.");
  Command chosen;
  constexpr NamedCommand kCommands[] = {
    {"devices", add_devices},
    {"measure", add_measure},
    {"measure-scan", add_measure_scan},
    {"live", add_live},
    {"record", add_record},
    {"convert", add_convert},
    {"tape", add_tape},
    {"try", add_try},
    {"models", add_models},
    {"compare", add_compare},
    {"sessions", add_sessions},
#if IM2FIT_HAVE_PAGE
    {"serve", add_serve},
#endif
  };
  // The options of the command that was named, and no others: all of them take longer than the program's start.
  const std::string_view first = argc > 1 ? argv[1] : "";
  const bool named = std::any_of(std::begin(kCommands), std::end(kCommands),
                                 [&](const NamedCommand& command) { return command.name == first; });
  for (const NamedCommand& command : kCommands)
    if (named ? command.name == first : first != "--version") command.add(app, chosen);
  return run_program(app, chosen, argc, argv);
}
