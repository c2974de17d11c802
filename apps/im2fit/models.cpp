// SPDX-License-Identifier: Apache-2.0
// im2fit models list | install FILE | verify [FILE]: the models a device measures with.
#include <fmt/core.h>

#include <nlohmann/json.hpp>

#include "apps/common/pack/packs.h"
#include "apps/common/paths.h"
#include "apps/im2fit/commands.h"
#include "core/text.h"
#include "formats/json_file.h"

namespace im2fit::apps {
namespace {

using Json = nlohmann::ordered_json;

struct ModelsOptions {
  std::string pack, directory;
  bool json = false;
};

struct Place {
  std::string directory;
  bool used = false;
  bool has_manifest = false;
  PackManifest manifest;
};

// What IM2FIT_MODELS names, then directories that hold all three models, in the order they are looked for.
Result<std::vector<Place>> places() {
  std::vector<Place> found;
  if (const std::string models = environment("IM2FIT_MODELS"); !models.empty()) {
    Place place;
    place.directory = models;
    place.used = true;
    if (is_model_pack(models)) {
      auto pack = open_pack(models);
      if (!pack) return pack.error();
      place.manifest = std::move(pack->manifest);
      place.has_manifest = true;
    } else if (auto manifest = installed_manifest(models)) {
      place.manifest = std::move(*manifest);
      place.has_manifest = true;
    }
    found.push_back(std::move(place));
  }
  for (const std::string& directory : model_directories()) {
    if (!holds_models(directory)) continue;
    Place place;
    place.directory = directory;
    place.used = found.empty();
    auto manifest = installed_manifest(directory);
    if (!manifest && manifest.error().code != ErrorCode::not_found) return manifest.error();
    place.has_manifest = static_cast<bool>(manifest);
    if (manifest) place.manifest = std::move(*manifest);
    found.push_back(std::move(place));
  }
  return found;
}

Json place_json(const Place& place) {
  Json json = {{"directory", place.directory}, {"used", place.used}};
  json["pack"] = place.has_manifest ? *parse_json<Json>(manifest_json(place.manifest), kManifestName) : Json(nullptr);
  return json;
}

Result<int> run_list(const ModelsOptions& options) {
  const auto found = places();
  if (!found) return found.error();
  if (options.json) {
    Json all = Json::array();
    for (const Place& place : *found) all.push_back(place_json(place));
    fmt::print("{}\n", json_text(all, 1));
    return kExitOk;
  }
  if (found->empty()) {
    std::string looked;
    for (const std::string& directory : model_directories()) looked += (looked.empty() ? "" : ", ") + directory;
    return Error{ErrorCode::not_found, "no models in " + looked + "; get a pack and run im2fit models install FILE"};
  }
  for (const Place& place : *found) {
    const std::string what = place.has_manifest
                                 ? fmt::format("pack {}, {} people, licence {}", excerpt(place.manifest.version),
                                               place.manifest.people, excerpt(place.manifest.licence))
                                 : "not from a pack";
    fmt::print("{} {}  {}\n", place.used ? "*" : " ", printable(place.directory), what);
  }
  return kExitOk;
}

Result<int> run_install(const ModelsOptions& options) {
  const auto pack = open_pack(options.pack);
  if (!pack) return pack.error();
  const std::string directory = options.directory.empty() ? user_data_directory() : options.directory;
  if (auto ok = install_pack(*pack, directory); !ok) return ok.error();
  if (auto ok = verify_installed(pack->manifest, directory); !ok) return ok.error();
  fmt::print("models {} ({} people, licence {}) in {}\n", excerpt(pack->manifest.version), pack->manifest.people,
             excerpt(pack->manifest.licence), printable(directory));
  return kExitOk;
}

void print_intact(const std::string& what, const PackManifest& manifest) {
  fmt::print("{}: intact, models {}, {} files\n", printable(what), excerpt(manifest.version), manifest.files.size());
}

Result<int> run_verify(const ModelsOptions& options) {
  const std::string used = options.directory.empty() ? environment("IM2FIT_MODELS") : "";
  const std::string file = options.pack.empty() && is_model_pack(used) ? used : options.pack;
  if (!file.empty()) {
    const auto pack = open_pack(file);
    if (!pack) return pack.error();
    if (auto ok = verify_pack(*pack); !ok) return ok.error();
    print_intact(file, pack->manifest);
    return kExitOk;
  }
  const std::string installed = used.empty() ? model_directory() : used;
  const std::string directory = options.directory.empty() ? installed : options.directory;
  const auto manifest = installed_manifest(directory);
  if (!manifest) return manifest.error();
  if (auto ok = verify_installed(*manifest, directory); !ok) return ok.error();
  print_intact(directory, *manifest);
  return kExitOk;
}

}  // namespace

void add_models(cli::App& app, Command& chosen) {
  cli::App* parent = app.add_subcommand("models", "List, install or verify models");
  parent->footer("Examples:\n  im2fit models install im2fit-models-1.0.0.i2p\n  im2fit models list");
  auto listed = std::make_shared<ModelsOptions>();
  cli::App* list =
      add_command<ModelsOptions>(*parent, chosen, "list", "List the installed models; * marks the ones in use",
                                 "  im2fit models list --json", listed, run_list);
  list->add_flag("--json", listed->json, "As JSON");
  auto installed = std::make_shared<ModelsOptions>();
  cli::App* install = add_command<ModelsOptions>(
      *parent, chosen, "install", "Install a model pack",
      "  im2fit models install im2fit-models-1.0.0.i2p\n  im2fit models install PACK --to /usr/share/im2fit",
      installed, run_install);
  install->add_option("PACK", installed->pack, "The pack, a .i2p file")->required()->type_name("FILE");
  install->add_option("--to", installed->directory, "Directory to install to (default: the user's data directory)")
      ->type_name("DIR");
  auto verified = std::make_shared<ModelsOptions>();
  cli::App* verify = add_command<ModelsOptions>(
      *parent, chosen, "verify", "Compare a pack, or the installed models, with the checksums",
      "  im2fit models verify\n  im2fit models verify PACK.i2p", verified, run_verify);
  verify->add_option("PACK", verified->pack, "A pack (default: the installed models)")->type_name("FILE");
  verify->add_option("--in", verified->directory, "Directory of the installed models (default: the ones in use)")
      ->type_name("DIR");
  parent->callback([parent] {
    if (!parent->any_subcommand()) cli::App::missing("list, install or verify");
  });
}

}  // namespace im2fit::apps
