// SPDX-License-Identifier: Apache-2.0
// im2fit try GARMENT: how each size would sit on a measured person, and the person in one of them.
#include <fmt/core.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/common/paths.h"
#include "apps/im2fit/commands.h"
#include "body/export/export.h"
#include "body/measure.h"
#include "core/file.h"
#include "garment/drape/wear.h"
#include "person/builtin_tape.h"
#include "person/data_files.h"
#include "person/dressing.h"
#include "person/garment_file.h"
#include "person/measured_body.h"
#include "report/dressed_picture.h"
#include "report/result_json.h"
#include "report/text_table.h"

namespace im2fit::apps {
namespace {

struct TryOptions {
  std::string garment, size, result, out;
  std::string body = default_body_path();
  std::vector<std::string> size_charts;
  bool json = false;
};

Result<body::GarmentPattern> pattern_of(const std::string& name) {
  if (name.ends_with(".yaml")) return load_garment(name);
  const Wardrobe& wardrobe = builtin_wardrobe();
  if (const body::GarmentPattern* pattern = wardrobe.garment(name)) return *pattern;
  std::string all;
  for (const body::GarmentPattern& p : wardrobe.garments) all += (all.empty() ? "" : ", ") + p.id;
  return Error{ErrorCode::not_found,
               "no garment is called " + name + "; there are " + all + ", and files that end in .yaml"};
}

Result<SizeSystem> charts_of(const std::vector<std::string>& paths) {
  if (paths.empty()) return builtin_size_system();
  std::vector<SizeChart> charts;
  for (const std::string& path : paths) {
    auto chart = load_size_chart(path);
    if (!chart) return chart.error();
    charts.push_back(std::move(*chart));
  }
  return make_size_system(std::move(charts));
}

std::string table_of(const GarmentFit& fit) {
  std::vector<std::string> header = {"size"};
  for (const std::string& id : fit.region_ids) header.push_back(id + " ease mm");
  header.emplace_back("");
  TextTable table(header);
  for (std::size_t i = 0; i < fit.sizes.size(); ++i) {
    std::vector<std::string> row = {fit.sizes[i].size};
    for (const RegionFit& region : fit.sizes[i].regions)
      row.push_back(fmt::format("{:.0f} +- {:.0f} {}", region.ease_mm, (region.high_mm - region.low_mm) / 2,
                                name_of(region.verdict)));
    row.emplace_back(i == fit.best ? "best" : "");
    table.add(row);
  }
  return table.text();
}

Status draw(const TryOptions& options, const body::GarmentPattern& pattern, const MeasuredBody& person,
            float chest_mm, const body::BodyModel& model) {
  std::vector<Vec3f> rest(static_cast<std::size_t>(model.vertex_count()));
  model.morph(person.params, rest);
  const body::Skeleton skeleton = body::rest_skeleton(model, rest);
  const body::Pose pose = body::relaxed_pose(skeleton, body::relaxed_spread_deg(model, rest));
  const Wardrobe& wardrobe = builtin_wardrobe();
  const Worn worn[] = {{&pattern, chest_mm}};
  const auto outfit = dress(wardrobe, model, person.params, pose, person.female > 0.5F, worn);
  if (!outfit) return outfit.error();
  if (options.out.ends_with(".glb")) {
    body::Avatar avatar{&model, person.params, pose};
    const body::ClothLook looks[] = {{pattern.id, pattern.colour}};
    body::wear(avatar, **outfit, looks);
    return body::write_glb(avatar, options.out);
  }
  PictureFrame frame;
  frame.width = 360;
  frame.height = 760;
  frame.middle_z_mm = skeleton.head[0].z;
  float low = 1e9F, high = -1e9F;
  for (const Vec3f& v : (*outfit)->body().first(static_cast<std::size_t>(model.body_vertex_count()))) {
    low = std::min(low, v.y);
    high = std::max(high, v.y);
  }
  frame.low_mm = low - 40;
  frame.high_mm = high + 40;
  constexpr PictureView kViews[] = {kFrontView, kSlantView, kLeftView, kBackView};
  const LinearColour colours[] = {pattern.colour};
  const auto png = draw_outfit(model, **outfit, person.female > 0.5F ? body::LookOf::woman : body::LookOf::man,
                               colours, kViews, frame)
                       .png();
  if (!png) return png.error();
  return write_file_atomically(options.out, *png, Readable::by_owner);
}

Result<int> run(const TryOptions& options) {
  if (!options.out.empty() && !options.out.ends_with(".png") && !options.out.ends_with(".glb"))
    return Error{ErrorCode::invalid_argument, options.out + ": pictures end in .png, avatars in .glb"};
  const auto pattern = pattern_of(options.garment);
  if (!pattern) return pattern.error();
  const auto charts = charts_of(options.size_charts);
  if (!charts) return charts.error();
  if (auto named = check_named_by_variable(options.body); !named) return named.error();
  const auto model = load_body(options.body);
  if (!model) return model.error();
  const auto person = read_measured_body(options.result, *model);
  if (!person) return person.error();
  const auto girths = girths_for(*pattern, builtin_tape(), person->tape_values, person->tape_intervals);
  if (!girths) return girths.error();
  const bool woman = person->female > 0.5F;
  const GarmentFit fit = fit_garment(*pattern, builtin_wardrobe().regression, charts->cut_by(woman), woman, *girths);
  std::size_t chosen = fit.best;
  if (!options.size.empty()) {
    chosen = 0;
    while (chosen < fit.sizes.size() && fit.sizes[chosen].size != options.size) ++chosen;
    if (chosen == fit.sizes.size()) {
      std::string all;
      for (const SizeFit& size : fit.sizes) all += (all.empty() ? "" : ", ") + size.size;
      return Error{ErrorCode::not_found, "no size is called " + options.size + "; " + fit.chart + " has " + all};
    }
  }
  const body::CutBody cut = body::cut_body(builtin_wardrobe().regression, woman, fit.sizes[chosen].chest_mm);
  if (const auto checked = body::check_cut(*pattern, cut); !checked) return checked.error();
  if (!options.out.empty())
    if (const auto drawn = draw(options, *pattern, *person, fit.sizes[chosen].chest_mm, *model); !drawn)
      return drawn.error();
  if (options.json) {
    fmt::print("{}", fit_json(fit));
    return kExitOk;
  }
  fmt::print("{}\n{} ({}): {}\n", table_of(fit), fit.garment, fit.chart, advice_words(fit));
  if (chosen != fit.best) {
    fmt::print("{}:", fit.sizes[chosen].size);
    for (std::size_t r = 0; r < fit.region_ids.size(); ++r)
      fmt::print(" {} {} ({:.0f} mm)", fit.region_ids[r], name_of(fit.sizes[chosen].regions[r].verdict),
                 fit.sizes[chosen].regions[r].ease_mm);
    fmt::print("\n");
  }
  return kExitOk;
}

}  // namespace

void add_try(cli::App& app, Command& chosen) {
  auto options = std::make_shared<TryOptions>();
  cli::App* sub = add_command<TryOptions>(
      app, chosen, "try", "Report how each size of a garment fits a measured person, and which size to buy",
      "  im2fit measure person.oni --out me\n  im2fit try t_shirt --result me/result.json\n"
      "  im2fit try trousers --size L --result me/result.json --out trousers.png",
      options, run);
  sub->add_option("garment", options->garment, "t_shirt, trousers and so on, or a file (docs/garments.md)")
      ->required()
      ->type_name("GARMENT");
  sub->add_option("--result", options->result, "result.json of the person, written by im2fit measure")
      ->required()
      ->type_name("FILE");
  sub->add_option("--size", options->size, "Size to draw and to report (default: the best)")->type_name("SIZE");
  sub->add_option("--out", options->out, "File for the dressed person: a picture (.png) or an avatar (.glb)")
      ->type_name("FILE");
  sub->add_option("--size-chart", options->size_charts,
                  "Size chart file(s), see docs/result.md (default: EN 13402-3)")
      ->type_name("CSV");
  sub->add_option("--body", options->body, "Body file")->type_name("FILE")->capture_default_str();
  sub->add_flag("--json", options->json, "As JSON");
}

}  // namespace im2fit::apps
