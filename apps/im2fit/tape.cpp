// SPDX-License-Identifier: Apache-2.0
// im2fit tape list | show ID: the measurements, in words and in a picture.
#include "body/tape.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "apps/common/paths.h"
#include "apps/im2fit/commands.h"
#include "core/file.h"
#include "formats/json_file.h"
#include "person/data_files.h"
#include "person/tape_file.h"
#include "report/canvas.h"
#include "report/text_table.h"

namespace im2fit::apps {
namespace {

struct TapePicture {
  Canvas canvas{1, 1};
  std::string svg;
};

constexpr int kBodyHeight = 820;  // pixels
constexpr int kPanelWidth = 480;
constexpr int kMargin = 40;
constexpr int kHeight = kBodyHeight + 2 * kMargin;
constexpr float kHiddenMm = 12;  // so far behind the skin a line is hidden: tapes bridge hollows and cut corners
constexpr float kStepMm = 2;     // of a line
constexpr Rgb kPaper = {255, 255, 255}, kLine = {208, 32, 48}, kInk = {40, 40, 40};

// One view: across the picture, up, and towards the viewer, mm.
struct View {
  bool side;
  int left;  // of the panel, pixels
  float middle, low, scale;
  float across(const Vec3f& p) const { return side ? -p.z : p.x; }
  float near(const Vec3f& p) const { return side ? p.x : p.z; }
  float x(const Vec3f& p) const {
    return static_cast<float>(left) + kPanelWidth / 2.0F + (across(p) - middle) * scale;
  }
  float y(const Vec3f& p) const { return static_cast<float>(kHeight - kMargin) - (p.y - low) * scale; }
};

struct Surface {
  std::vector<float> nearest = std::vector<float>(static_cast<std::size_t>(2 * kPanelWidth * kHeight), -1e9F);
  float& at(int x, int y) { return nearest[static_cast<std::size_t>(y * 2 * kPanelWidth + x)]; }
};

std::string upper(std::string text) {
  for (char& c : text) c = c == '_' ? ' ' : static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

void fill(const View& view, const std::array<Vec3f, 3>& t, Surface& surface, Canvas& canvas) {
  const Vec3f n = normalized(cross(t[1] - t[0], t[2] - t[0]));
  const float facing = view.side ? n.x : n.z;
  if (facing <= 0) return;
  const auto grey = static_cast<std::uint8_t>(120 + 100 * facing);
  const std::array<float, 3> x = {view.x(t[0]), view.x(t[1]), view.x(t[2])};
  const std::array<float, 3> y = {view.y(t[0]), view.y(t[1]), view.y(t[2])};
  const int x0 = std::max(view.left, static_cast<int>(std::floor(*std::min_element(x.begin(), x.end()))));
  const int x1 =
      std::min(view.left + kPanelWidth - 1, static_cast<int>(std::ceil(*std::max_element(x.begin(), x.end()))));
  const int y0 = std::max(0, static_cast<int>(std::floor(*std::min_element(y.begin(), y.end()))));
  const int y1 = std::min(kHeight - 1, static_cast<int>(std::ceil(*std::max_element(y.begin(), y.end()))));
  const float area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
  if (area == 0) return;
  for (int py = y0; py <= y1; ++py)
    for (int px = x0; px <= x1; ++px) {
      const float fx = static_cast<float>(px), fy = static_cast<float>(py);
      const float b = ((fx - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (fy - y[0])) / area;
      const float c = ((x[1] - x[0]) * (fy - y[0]) - (fx - x[0]) * (y[1] - y[0])) / area;
      if (b < 0 || c < 0 || b + c > 1) continue;
      const float depth = (1 - b - c) * view.near(t[0]) + b * view.near(t[1]) + c * view.near(t[2]);
      if (depth <= surface.at(px, py)) continue;
      surface.at(px, py) = depth;
      canvas.set(px, py, {grey, grey, grey});
    }
}

bool hidden(const View& view, const Vec3f& p, Surface& surface) {
  const int x = static_cast<int>(std::lround(view.x(p))), y = static_cast<int>(std::lround(view.y(p)));
  if (x < 0 || x >= 2 * kPanelWidth || y < 0 || y >= kHeight) return false;
  return view.near(p) < surface.at(x, y) - kHiddenMm;
}

void draw_segment(const View& view, const Vec3f& a, const Vec3f& b, Surface& surface, TapePicture& picture) {
  const int steps = 1 + static_cast<int>(norm(b - a) / kStepMm);
  for (int i = 0; i < steps; ++i) {
    const Vec3f p = a + (b - a) * (static_cast<float>(i) / static_cast<float>(steps));
    const Vec3f q = a + (b - a) * (static_cast<float>(i + 1) / static_cast<float>(steps));
    const bool behind = hidden(view, p, surface) && hidden(view, q, surface);
    picture.canvas.line(view.x(p), view.y(p), view.x(q), view.y(q), behind ? 1.5F : 3.0F, kLine,
                        behind ? 0.4F : 1.0F);
    picture.svg += fmt::format("<path class=\"{}\" d=\"M{:.1f} {:.1f}L{:.1f} {:.1f}\"/>\n", behind ? "h" : "t",
                               view.x(p), view.y(p), view.x(q), view.y(q));
  }
}

// The silhouette as runs of pixels, a stroke a run.
std::string silhouette(Surface& surface) {
  std::string path;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < 2 * kPanelWidth; ++x) {
      if (surface.at(x, y) < -1e8F) continue;
      const int from = x;
      while (x < 2 * kPanelWidth && surface.at(x, y) >= -1e8F) ++x;
      path += fmt::format("M{} {}h{}", from, y, x - from);
    }
  return path;
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '&' ? "&amp;" : c == '<' ? "&lt;" : std::string(1, c);
  return out;
}

// `mesh`: posed, as TapeMeasurer::mesh(). What the body hides is drawn pale.
TapePicture draw_tape(const body::BodyModel& model, std::span<const Vec3f> mesh, const body::TapeLines& lines,
                      const std::string& title) {
  Vec3f low = mesh[0], high = low;
  for (const Vec3f& v : mesh.first(static_cast<std::size_t>(model.body_vertex_count()))) {
    low = {std::min(low.x, v.x), std::min(low.y, v.y), std::min(low.z, v.z)};
    high = {std::max(high.x, v.x), std::max(high.y, v.y), std::max(high.z, v.z)};
  }
  const float scale = std::min(kBodyHeight / (high.y - low.y), (kPanelWidth - 20) / (high.x - low.x));
  const std::array<View, 2> views = {
      {{false, 0, (low.x + high.x) / 2, low.y, scale}, {true, kPanelWidth, -(low.z + high.z) / 2, low.y, scale}}};
  TapePicture picture;
  picture.canvas = Canvas(2 * kPanelWidth, kHeight);
  picture.canvas.rectangle(0, 0, 2 * kPanelWidth, kHeight, kPaper);
  Surface surface;
  for (const View& view : views)
    for (const auto& t : model.body_triangles())
      fill(view,
           {mesh[static_cast<std::size_t>(t[0])], mesh[static_cast<std::size_t>(t[1])],
            mesh[static_cast<std::size_t>(t[2])]},
           surface, picture.canvas);
  for (const View& view : views)
    for (const auto& line : lines)
      for (std::size_t i = 1; i < line.size(); ++i) draw_segment(view, line[i - 1], line[i], surface, picture);
  picture.canvas.text(16, 12, upper(title), 2, kInk);
  picture.svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\">\n"
      "<title>{2}</title>\n<style>.b{{stroke:#bbb}}.t{{stroke:#d02030;stroke-width:3;stroke-linecap:round}}"
      ".h{{stroke:#d02030;stroke-opacity:.4;stroke-width:1.5}}</style>\n"
      "<rect width=\"{0}\" height=\"{1}\" fill=\"#fff\"/>\n<path class=\"b\" d=\"{3}\"/>\n{4}"
      "<text x=\"16\" y=\"26\" font-family=\"sans-serif\" font-size=\"16\" fill=\"#282828\">{2}</text>\n</svg>\n",
      2 * kPanelWidth, kHeight, escaped(title), silhouette(surface), picture.svg);
  return picture;
}

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
    fmt::print("{}\n", json_text(all, 1));
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
  if (auto named = check_named_by_variable(options.body); !named) return named.error();
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
    fmt::print("{}\n", json_text(json, 1));
    return kExitOk;
  }
  for (const auto& [key, value] : json.items())
    if (!value.is_null())
      fmt::print("{:<11} {}\n", key, value.is_string() ? value.get<std::string>() : json_text(value));
  return kExitOk;
}

void add_common(cli::App& sub, TapeOptions& options) {
  sub.add_option("--tape", options.tapes, "Your own measurement definitions, see docs/tape.md")->type_name("YAML");
  sub.add_flag("--json", options.json, "As JSON");
}

}  // namespace

void add_tape(cli::App& app, Command& chosen) {
  cli::App* parent = app.add_subcommand("tape", "List the measurement definitions, or show one");
  parent->footer("Examples:\n  im2fit tape list\n  im2fit tape show thigh_girth --out thigh.png");
  auto listed = std::make_shared<TapeOptions>();
  cli::App* list =
      add_command<TapeOptions>(*parent, chosen, "list", "List the measurements",
                               "  im2fit tape list\n  im2fit tape list --tape mine.yaml --json", listed, run_list);
  add_common(*list, *listed);
  auto shown = std::make_shared<TapeOptions>();
  cli::App* show = add_command<TapeOptions>(
      *parent, chosen, "show", "Show how and where on the body a measurement is taken",
      "  im2fit tape show waist_girth\n  im2fit tape show across_back --out across_back.svg", shown, run_show);
  add_common(*show, *shown);
  show->add_option("id", shown->id, "Id of the measurement, from im2fit tape list")->required()->type_name("ID");
  show->add_option("--out", shown->out, "Picture to write, .svg or .png")->type_name("FILE");
  show->add_option("--on", shown->drawn_on, "Body in the picture")->one_of({"woman", "man"})->capture_default_str();
  show->add_option("--body", shown->body, "Body file")->type_name("FILE")->capture_default_str();
  parent->callback([parent] {
    if (!parent->any_subcommand()) cli::App::missing("list or show");
  });
}

}  // namespace im2fit::apps
