// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <exception>
#include <string>
#include <utility>

#include "apps/common/manual.h"
#include "apps/im2fitd/config.h"
#include "apps/im2fitd/daemon.h"
#include "apps/im2fitd/log.h"
#include "apps/im2fitd/notify.h"

namespace im2fit::daemon {
namespace {

struct Words {
  std::string config = "/etc/im2fit/im2fitd.yaml";
  bool check = false;
};

void catch_signals() {
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGHUP, [](int) { SignalWishes::reload = true; });
  for (const int number : {SIGTERM, SIGINT}) std::signal(number, [](int) { SignalWishes::stop = true; });
}

Status serve(const Words& words) {
  auto config = load_config(words.config);
  if (!config) return config.error();
  if (words.check) return Daemon::check(*config);
  catch_signals();
  Notifier notifier;
  for (;;) {
    auto daemon = Daemon::create(*config, words.config, notifier);
    if (!daemon) return daemon.error();
    auto next = (*daemon)->run();
    if (!next) return next.error();
    if (!*next) break;
    config = std::move(**next);
  }
  notifier.send("STOPPING=1\nSTATUS=stopped");
  log(Level::info, "stopped");
  return Ok{};
}

}  // namespace
}  // namespace im2fit::daemon

int main(int argc, char** argv) {
  using namespace im2fit::daemon;
  CLI::App app{"Measures one person after another in front of a camera and sends the results over a local socket.",
               "im2fitd"};
  app.footer(
      "Runs under systemd: see im2fitd.service and docs/daemon.md. Exit codes: 0 stopped, 1 failure, 2 wrong "
      "arguments.");
  Words words;
  app.set_version_flag("--version", std::string("im2fitd ") + IM2FIT_VERSION, "Print the version and exit");
  app.add_option("--config", words.config, "Configuration file")->type_name("YAML")->capture_default_str();
  app.add_flag("--check", words.check, "Check the configuration and its files, then exit");
  if (const auto manual = im2fit::apps::manual_asked(app, argc, argv))
    return std::fputs(manual->c_str(), stdout) >= 0 && std::fflush(stdout) == 0 ? 0 : 1;
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& help) {
    return app.exit(help);
  } catch (const CLI::ParseError& error) {
    log(Level::error, std::string(error.what()) + " (see im2fitd --help)");
    return 2;
  }
  try {
    const auto done = serve(words);
    if (done) return 0;
    log(Level::error, done.error().message);
  } catch (const std::exception& error) {  // libraries for JSON and text throw
    log(Level::error, error.what());
  }
  return 1;
}
