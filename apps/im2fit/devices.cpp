// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include <nlohmann/json.hpp>

#include "apps/im2fit/commands.h"
#include "formats/json_file.h"
#include "hal/open/open.h"

namespace im2fit::apps {
namespace {

struct DevicesOptions {
  bool json = false;
};

Result<int> run_devices(const DevicesOptions& options) {
  const auto devices = hal::list_devices();
  if (!devices) return devices.error();
  if (options.json) {
    nlohmann::ordered_json out = nlohmann::ordered_json::array();
    for (const auto& device : *devices) out.push_back({{"uri", device.uri}, {"name", device.name}});
    fmt::print("{}\n", json_text(out, 1));
    return kExitOk;
  }
  for (const auto& device : *devices) fmt::print("{}  {}\n", device.uri, device.name);
  if (devices->empty()) fmt::print(stderr, "no depth camera is connected; try synthetic, a .oni file or a folder\n");
  return kExitOk;
}

}  // namespace

void add_devices(cli::App& app, Command& chosen) {
  auto options = std::make_shared<DevicesOptions>();
  auto* sub = add_command<DevicesOptions>(app, chosen, "devices", "List connected depth cameras",
                                          "  im2fit devices\n  im2fit devices --json", options, run_devices);
  sub->add_flag("--json", options->json, "As JSON");
}

}  // namespace im2fit::apps
