// SPDX-License-Identifier: Apache-2.0
// im2fit tape list | show ID: what is measured, in words and in a picture.
#include <fmt/core.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/common/paths.h"
#include "apps/im2fit/commands.h"
#include "core/file.h"
#include "person/data_files.h"
#include "person/tape_file.h"
#include "report/tape_picture.h"
#include "report/text_table.h"

namespace im2fit::apps {
namespace {

using body::Tape;
using body::TapeDefinition;
using Json = nlohmann::ordered_json;

struct TapeOptions {
  std::vector<std::string> tapes;
  std::string id, out, drawn_on = "woman";
  std::string body = default_body_path();
  bool json = false;
};

Json standard(const std::string& name, const std::string& number) {
  return number.empty() ? Json(nullptr) : Json(name + " " + number);
}

Json names_json(const TapeDefinition& d) {
  Json names = Json::object();
  for (std::size_t i = 0; i < body::kTapeLanguages.size(); ++i)
    if (!d.names[i].empty()) names[std::string(body::kTapeLanguages[i])] = d.names[i];
  return names;
}

std::string point_words(const Tape& tape, body::PointRef ref) {
  const std::string& id = tape.points[static_cast<std::size_t>(ref.point)].id;
  return ref.side == body::PointRef::Side::own    ? id
         : ref.side == body::PointRef::Side::left ? "left " + id
                                                  : "right " + id;
}

Json definition_json(const Tape& tape, const TapeDefinition& d) {
  Json json = {{"id", d.id},
               {"name", names_json(d)},
               {"kind", std::string(name_of(d.kind))},
               {"unit", std::string(unit_of(d))},
               {"side", std::string(name_of(d.side))},
               {"pose", "relaxed"},
               {"iso_8559", standard("ISO 8559-1:2017", d.iso_8559)},
               {"iso_7250", standard("ISO 7250-1", d.iso_7250)},
               {"astm_d5219", standard("ASTM D5219", d.astm_d5219)},
               {"source", d.source}};
  if (!d.points.empty()) {
    Json points = Json::array();
    for (const body::PointRef ref : d.points) points.push_back(point_words(tape, ref));
    json["points"] = points;
    json["plane"] = std::string(name_of(d.plane));
  }
  if (d.search != body::TapeSearch::none)
    json["search"] = {{"for", std::string(name_of(d.search))},
                      {"from", std::round(1000 * static_cast<double>(d.search_from)) / 1000},
                      {"to", std::round(1000 * static_cast<double>(d.search_to)) / 1000}};
  if (!d.terms.empty()) {
    Json terms = Json::object();
    for (const body::TapeTerm& term : d.terms)
      terms[tape.definitions[static_cast<std::size_t>(term.definition)].id] = term.factor;
    json["terms"] = terms;
  }
  if (!d.reason.empty()) json["reason"] = d.reason;
  return json;
}

Result<int> run_list(const TapeOptions& options) {
  const auto tape = load_tapes(options.tapes);
  if (!tape) return tape.error();
  if (options.json) {
    Json all = Json::array();
    for (const TapeDefinition& d : tape->definitions) all.push_back(definition_json(*tape, d));
    fmt::print("{}\n", all.dump(1));
    return kExitOk;
  }
  // The last column is left alone: names are of any width.
  for (const TapeDefinition& d : tape->definitions)
    fmt::print("{:<26} {:<8} {:<10} {}\n", d.id, name_of(d.kind), d.iso_8559.empty() ? "-" : d.iso_8559, d.names[0]);
  return kExitOk;
}

Status draw(const Tape& tape, int index, const TapeOptions& options) {
  const bool svg = options.out.ends_with(".svg");
  if (!svg && !options.out.ends_with(".png"))
    return Error{ErrorCode::invalid_argument, options.out + ": pictures end in .svg or .png"};
  const auto model = load_body(options.body);
  if (!model) return model.error();
  body::Params params;
  params.gender = options.drawn_on == "man" ? 1 : 0;
  body::TapeMeasurer measurer(*model);
  std::vector<float> values(tape.definitions.size());
  measurer.measure(tape, params, values);
  const float value = values[static_cast<std::size_t>(index)];
  const TapeDefinition& d = tape.definitions[static_cast<std::size_t>(index)];
  if (std::isnan(value))
    return Error{ErrorCode::unsupported,
                 d.id + " is not measured on this body" + (d.reason.empty() ? "" : ": " + d.reason)};
  const TapePicture picture = draw_tape(*model, measurer.mesh(), measurer.lines(tape, index),
                                        fmt::format("{} {:.0f} {}", d.id, value, unit_of(d)));
  if (svg) return write_file_atomically(options.out, picture.svg);
  const auto png = picture.canvas.png();
  if (!png) return png.error();
  return write_file_atomically(options.out, *png);
}

Result<int> run_show(const TapeOptions& options) {
  const auto tape = load_tapes(options.tapes);
  if (!tape) return tape.error();
  const int index = definition_index(*tape, options.id);
  if (index < 0)
    return Error{ErrorCode::not_found,
                 "no measurement is called " + options.id + "; im2fit tape list prints all ids"};
  if (!options.out.empty())
    if (const auto drawn = draw(*tape, index, options); !drawn) return drawn.error();
  const Json json = definition_json(*tape, tape->definitions[static_cast<std::size_t>(index)]);
  if (options.json) {
    fmt::print("{}\n", json.dump(1));
    return kExitOk;
  }
  for (const auto& [key, value] : json.items())
    if (!value.is_null()) fmt::print("{:<11} {}\n", key, value.is_string() ? value.get<std::string>() : value.dump());
  return kExitOk;
}

void add_common(cli::App& sub, TapeOptions& options) {
  sub.add_option("--tape", options.tapes, "Your own measurements, see docs/tape.md")->type_name("YAML");
  sub.add_flag("--json", options.json, "As JSON");
}

}  // namespace

void add_tape(cli::App& app, Command& chosen) {
  cli::App* parent = app.add_subcommand("tape", "Measurements: list them, or show one");
  parent->footer("Examples:\n  im2fit tape list\n  im2fit tape show thigh_girth --out thigh.png");
  auto listed = std::make_shared<TapeOptions>();
  cli::App* list =
      add_command<TapeOptions>(*parent, chosen, "list", "List the measurements",
                               "  im2fit tape list\n  im2fit tape list --tape mine.yaml --json", listed, run_list);
  add_common(*list, *listed);
  auto shown = std::make_shared<TapeOptions>();
  cli::App* show = add_command<TapeOptions>(
      *parent, chosen, "show", "Show how a measurement is taken, and where on the body",
      "  im2fit tape show waist_girth\n  im2fit tape show across_back --out across_back.svg", shown, run_show);
  add_common(*show, *shown);
  show->add_option("id", shown->id, "Id, as im2fit tape list prints it")->required()->type_name("ID");
  show->add_option("--out", shown->out, "Picture to write, .svg or .png")->type_name("FILE");
  show->add_option("--on", shown->drawn_on, "Body in the picture")->one_of({"woman", "man"})->capture_default_str();
  show->add_option("--body", shown->body, "Body file")->type_name("FILE")->capture_default_str();
  parent->callback([parent] {
    if (!parent->any_subcommand()) cli::App::missing("list or show");
  });
}

}  // namespace im2fit::apps
