// SPDX-License-Identifier: Apache-2.0
// live: guided and measured in the terminal.
#include <memory>

#include "apps/im2fit/commands.h"
#include "apps/im2fit/live_run.h"

namespace im2fit::apps {
namespace {

Result<int> run_alone(const LiveOptions& options) {
  return run_live(options, nullptr);
}

}  // namespace

void add_live(cli::App& app, Command& chosen) {
  auto options = std::make_shared<LiveOptions>();
  auto* sub = add_command<LiveOptions>(
      app, chosen, "live", "Guide and measure one person after another in front of a camera, until Ctrl-C",
      "  im2fit live openni2 --rotate 90 --view\n  im2fit live openni2 --count 1 --out me\n  im2fit live FOLDER "
      "--overlay pictures --overlay-every 5\n  im2fit live openni2 --json | ./kiosk",
      options, run_alone);
  add_live_options(*sub, *options);
  sub->add_option("--overlay", options->preview_renderer.overlay,
                  "Folder for pictures of all frames: skeleton over depth")
      ->type_name("DIR");
  sub->add_option("--overlay-every", options->preview_renderer.overlay_every, "Write a picture of every Nth frame")
      ->range(1, 1'000'000)
      ->capture_default_str();
  sub->add_flag("--view", options->preview_renderer.view,
                "Show the skeleton over depth in this terminal (on stderr), ten times a second");
}

}  // namespace im2fit::apps
