// SPDX-License-Identifier: Apache-2.0
// serve: live, with a page for a browser.
#include <fmt/core.h>

#include <chrono>
#include <memory>
#include <thread>
#include <utility>

#include "apps/im2fit/commands.h"
#include "apps/im2fit/live_run.h"
#include "apps/im2fit/page/live_page.h"

namespace im2fit::apps {
namespace {

struct ServeOptions {
  LiveOptions live;
  PageAddress address;
};

class PageListener final : public LiveListener {
 public:
  PageListener(LivePage& page, int frames_wanted) : page_(page), frames_wanted_(frames_wanted) {}
  void begin(const SessionOutcome& session) override {
    page_.begin(session.input.source->info().intrinsics, frames_wanted_);
    print_error("open " + page_.url() + " in a browser; Ctrl-C ends this");
  }
  void see(const FrameSeen& frame) override { page_.see(frame); }
  void publish(const Json& event) override { page_.publish(event); }
  Status measured(const SessionOutcome& session) override {
    if (!session.dressed) return Ok{};
    const body::Avatar& avatar = session.dressed->avatar;
    page_.may_try_on(
        {0, avatar.params, avatar.pose, session.person.result.answer.female > 0.5F, session.person.fits});
    return page_.measured(avatar, session.dressed->glb);
  }

 private:
  LivePage& page_;
  int frames_wanted_;
};

Result<int> run_serve(const ServeOptions& options) {
  auto page = LivePage::open(options.address, options.live.session.input.body);
  if (!page) return page.error();
  PageListener listener(**page, options.live.session.frames);
  auto code = run_live(options.live, &listener);
  // A recording is over sooner than people have read what it gave.
  while (code && !interrupted()) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  return code;
}

}  // namespace

void add_serve(cli::App& app, Command& chosen) {
  auto options = std::make_shared<ServeOptions>();
  auto* sub = add_command<ServeOptions>(
      app, chosen, "serve", "live, shown on a page for a browser: guidance, measurements, a 3D body that follows",
      "  im2fit serve openni2 --rotate 90\n  im2fit serve FOLDER --port 0\n  im2fit serve usb --rotate 90 --host "
      "0.0.0.0     whoever reaches this machine sees the camera's pictures",
      options, run_serve);
  add_live_options(*sub, options->live);
  sub->get_option("--count")->description("Measure so many people, then only show; 0: until Ctrl-C");
  sub->add_option("--host", options->address.host, "Address to listen at; another than 127.0.0.1 lets others look")
      ->capture_default_str();
  sub->add_option("--port", options->address.port, "Port; 0: any that is free")
      ->range(0, 65535)
      ->capture_default_str();
}

}  // namespace im2fit::apps
