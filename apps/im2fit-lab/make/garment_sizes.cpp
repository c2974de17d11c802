// SPDX-License-Identifier: Apache-2.0
// im2fit-lab make garment-sizes BODY.i2b [--people N] [--only PERSON] [--sizes XS,M,...] [--worst N] [--sheet
// FILE.png] [--hems] [GARMENT...]: every garment, alone, in every size of the chart on standing people: skin seen
// through, cloth's inside, rims, hems. Six examples, or so many held-out people (PERSON: as make garment-sheets has
// them). The table begins with the worst drapes; FILE.png has those in pictures, faults as dots (skin red, inside
// blue).
// --hems: where hems lie above their plane, by the place in the pattern: what to draw lower there.
#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "apps/im2fit-lab/make/make.h"
#include "core/file.h"
#include "evaluation/garment/standing_quality.h"
#include "person/builtin_tape.h"
#include "person/garment_fit.h"
#include "report/dressed_picture.h"
#include "train/dressed/dressed_people.h"

namespace {

using namespace im2fit;
using namespace im2fit::lab;

constexpr int kCellWidth = 170, kCellHeight = 300, kTextHeight = 14, kColumns = 4;
constexpr std::size_t kCellViews[] = {0, 2, 4, 6};  // of standing_view: front, left, back, right
constexpr float kRimMm = 2.5F, kHemShare = 0.9F;    // the goals
constexpr float kHemBandMm = 100;                   // a hem's points lie within, sleeves' hems higher

struct SizesOptions {
  std::string body, sheet, only;
  int people = 0;  // 0: the examples
  std::size_t worst = 40;
  int scale = 1;  // of the sheet's pictures
  bool hems = false;
  std::vector<std::string> sizes, garments;
};

struct Case {
  std::size_t person = 0;
  const body::GarmentPattern* pattern = nullptr;
  const SizeRow* row = nullptr;
  int from_best = 0;  // sizes larger than the one the wearer would buy
  StandingQuality quality;
  // How far from the goals: 1 and more misses one.
  double badness() const {
    return quality.skin_px + quality.crossed_px / 10.0 + std::max(0.0F, quality.rim_mm - kRimMm) +
           std::max(0.0F, kHemShare - quality.hem_share) * 10;
  }
};

std::vector<std::string> split(std::string_view words) {
  std::vector<std::string> out;
  while (!words.empty()) {
    const std::size_t comma = std::min(words.find(','), words.size());
    out.emplace_back(words.substr(0, comma));
    words.remove_prefix(std::min(comma + 1, words.size()));
  }
  return out;
}

template <class T>
bool read_number(std::string_view text, T& out) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out);
  return error == std::errc{} && end == text.data() + text.size();
}

std::vector<DressedPerson> people_of(const body::BodyModel& model, const SizesOptions& options) {
  std::vector<DressedPerson> people;
  const std::string_view kDrawn = "person-";
  if (options.only.starts_with(kDrawn)) {
    std::uint64_t number = 0;
    if (read_number(std::string_view(options.only).substr(kDrawn.size()), number))
      people.push_back(drawn_person(model, number));
    return people;
  }
  if (options.people == 0) people = example_people(model);
  if (!options.only.empty()) std::erase_if(people, [&](const DressedPerson& p) { return p.name != options.only; });
  for (int i = 0; i < options.people; ++i) people.push_back(drawn_person(model, static_cast<std::uint64_t>(i)));
  return people;
}

// Nothing: the cut is refused, or the fabric is missing.
std::optional<body::Outfit::Piece> piece_of(const DressedPerson& person, const body::GarmentPattern& pattern,
                                            const SizeRow& row) {
  const Wardrobe& wardrobe = builtin_wardrobe();
  const float leg = person.tape[static_cast<std::size_t>(definition_index(builtin_tape(), "inside_leg"))];
  const body::CutBody cut =
      body::turned_up(body::cut_body(wardrobe.regression, person.woman, size_chest_mm(row)), leg);
  const body::Fabric* fabric = wardrobe.fabric(pattern.fabric);
  if (fabric == nullptr || !body::check_cut(pattern, cut)) return std::nullopt;
  return body::Outfit::piece(pattern, cut, *fabric);
}

// Nullptr: it cannot be cut.
std::unique_ptr<body::Outfit> dressed(const body::BodyModel& model, const DressedPerson& person, const Case& one) {
  auto piece = piece_of(person, *one.pattern, *one.row);
  if (!piece) return nullptr;
  std::vector<body::Outfit::Piece> pieces;
  pieces.push_back(std::move(*piece));
  auto outfit = std::make_unique<body::Outfit>(model, std::move(pieces));
  outfit->dress(person.rest, person.skeleton, dressed_poses(model, person)[0].pose);
  return outfit;
}

std::string words_of(const DressedPerson& person, const Case& one) {
  char words[160];
  std::snprintf(words, sizeof words, "%s %s %s (%+d): skin %d inside %d rim %.1f hems %.0f %% %.0f",
                person.name.c_str(), one.pattern->id.c_str(), one.row->size.c_str(), one.from_best,
                one.quality.skin_px, one.quality.crossed_px, one.quality.rim_mm, 100.0 * one.quality.hem_share,
                one.quality.hem_off_mm);
  return words;
}

void draw_case(const body::BodyModel& model, const DressedPerson& person, const Case& one, Canvas& sheet, int left,
               int top, int scaled) {
  const auto outfit = dressed(model, person, one);
  if (!outfit) return;
  PictureFrame frame;
  frame.width = scaled * kCellWidth;
  frame.height = scaled * kCellHeight - kTextHeight;
  float low = 1e9F, high = -1e9F, out = 0;
  const float z = person.skeleton.head[0].z, x = person.skeleton.head[0].x;
  for (std::size_t v = 0; v < outfit->cloth(0).mesh().vertex_count(); ++v) {
    const Vec3f p = outfit->cloth(0).position(v);
    low = std::min(low, p.y);
    high = std::max(high, p.y);
    out = std::max({out, std::fabs(p.x - x), std::fabs(p.z - z)});
  }
  const float tall =
      std::max(high - low + 80, 2 * (out + 20) * static_cast<float>(frame.height) / static_cast<float>(frame.width));
  frame.low_mm = (low + high - tall) / 2;
  frame.high_mm = (low + high + tall) / 2;
  frame.middle_x_mm = x;
  frame.middle_z_mm = z;
  std::vector<PictureView> views;
  for (const std::size_t view : kCellViews) views.push_back(standing_view(view));
  const std::vector<LinearColour> colours = {one.pattern->colour};
  const Canvas drawn =
      draw_outfit(model, *outfit, person.woman ? body::LookOf::woman : body::LookOf::man, colours, views, frame);
  for (int row = 0; row < drawn.height(); ++row)
    for (int column = 0; column < drawn.width(); ++column)
      sheet.set(left + column, top + kTextHeight + row, drawn.at(column, row));
  const float scale = static_cast<float>(frame.height) / tall;
  for (const SeenFault& fault : one.quality.faults)
    for (std::size_t k = 0; k < views.size(); ++k) {
      if (kCellViews[k] != fault.view) continue;
      const float aside = views[k].cosine * (fault.place.x - x) - views[k].sine * (fault.place.z - z);
      sheet.disc(
          static_cast<float>(left) + (static_cast<float>(k) + 0.5F) * static_cast<float>(frame.width) + aside * scale,
          static_cast<float>(top + kTextHeight) + (frame.high_mm - fault.place.y) * scale, 1,
          fault.skin ? Rgb{255, 0, 0} : Rgb{0, 90, 255});
    }
  std::string words = words_of(person, one);
  for (char& c : words) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  sheet.text(left + 2, top + 3, words, 1, {20, 20, 20});
}

// One line a garment, of the cases within `reach` sizes of the best.
void print_summary(const std::vector<Case>& cases, const std::vector<const body::GarmentPattern*>& patterns,
                   int reach) {
  std::printf("%-20s %7s | %10s %10s | %10s %10s | %8s %8s | %8s %8s\n", "garment", "drapes", "with skin", "skin px",
              "w. inside", "inside px", "rims >", "largest", "hems <", "least");
  for (const body::GarmentPattern* pattern : patterns) {
    std::size_t drapes = 0, skin = 0, crossed = 0, rims = 0, hems = 0;
    long skin_px = 0, crossed_px = 0;
    float rim = 0, hem = 1;
    for (const Case& one : cases) {
      if (one.pattern != pattern || std::abs(one.from_best) > reach) continue;
      ++drapes;
      skin += one.quality.skin_px > 0 ? 1U : 0U;
      crossed += one.quality.crossed_px > 0 ? 1U : 0U;
      rims += one.quality.rim_mm > kRimMm ? 1U : 0U;
      hems += one.quality.hem_share < kHemShare ? 1U : 0U;
      skin_px += one.quality.skin_px;
      crossed_px += one.quality.crossed_px;
      rim = std::max(rim, one.quality.rim_mm);
      hem = std::min(hem, one.quality.hem_share);
    }
    std::printf("%-20s %7zu | %10zu %10ld | %10zu %10ld | %8zu %8.1f | %8zu %6.0f %%\n", pattern->id.c_str(), drapes,
                skin, skin_px, crossed, crossed_px, rims, rim, hems, 100.0 * hem);
  }
}

// Of a garment's lowest hem in the best size and its neighbours: mean and standard deviation over drapes, by the
// place from the first to the last x of a panel's hem.
void print_hems(const std::vector<Case>& cases, const body::GarmentPattern& pattern) {
  constexpr int kPlaces = 10;
  struct Sums {
    double count = 0, sum = 0, squares = 0;
  };
  std::array<std::array<Sums, kPlaces + 1>, 2> sums{};  // front and back; a seam's vertex is in both
  for (const Case& one : cases) {
    if (one.pattern != &pattern || std::abs(one.from_best) > 1) continue;
    float lowest = 1e9F, x_low = 1e9F, x_high = -1e9F;
    for (const HemPoint& point : one.quality.hem_points) lowest = std::min(lowest, point.place.y);
    const auto is_lowest = [&](const HemPoint& point) { return point.place.y < lowest + kHemBandMm; };
    for (const HemPoint& point : one.quality.hem_points) {
      if (!is_lowest(point)) continue;
      x_low = std::min(x_low, point.place.x);
      x_high = std::max(x_high, point.place.x);
    }
    for (const HemPoint& point : one.quality.hem_points) {
      if (!is_lowest(point) || x_high <= x_low) continue;
      const auto at = static_cast<std::size_t>(std::lround((point.place.x - x_low) / (x_high - x_low) * kPlaces));
      for (const std::uint8_t layer : {body::kFrontLayer, body::kBackLayer}) {
        if (point.layer != layer && point.layer != body::kBothLayers) continue;
        Sums& of = sums[layer][at];
        const auto above = static_cast<double>(point.above_mm);
        of.count += 1;
        of.sum += above;
        of.squares += above * above;
      }
    }
  }
  for (const std::uint8_t layer : {body::kFrontLayer, body::kBackLayer}) {
    std::printf("%-20s %-5s", pattern.id.c_str(), layer == body::kFrontLayer ? "front" : "back");
    for (const Sums& of : sums[layer]) {
      const double mean = of.count > 0 ? of.sum / of.count : 0;
      const double variance = of.count > 0 ? std::max(0.0, of.squares / of.count - mean * mean) : 0;
      std::printf(" | %+6.1f (%4.1f)", mean, std::sqrt(variance));
    }
    std::printf("\n");
  }
}

int run(const SizesOptions& options) {
  const auto model = body::BodyModel::load(options.body);
  if (!model) {
    std::fprintf(stderr, "im2fit-lab make garment-sizes: %s\n", model.error().message.c_str());
    return 1;
  }
  std::vector<const body::GarmentPattern*> patterns;
  for (const body::GarmentPattern& pattern : builtin_wardrobe().garments)
    if (options.garments.empty() || std::count(options.garments.begin(), options.garments.end(), pattern.id) > 0)
      patterns.push_back(&pattern);
  if (patterns.empty() || patterns.size() < options.garments.size()) {
    std::fprintf(stderr, "im2fit-lab make garment-sizes: GARMENT is one of");
    for (const body::GarmentPattern& pattern : builtin_wardrobe().garments)
      std::fprintf(stderr, " %s", pattern.id.c_str());
    std::fprintf(stderr, "\n");
    return 2;
  }
  const auto people = people_of(*model, options);
  if (people.empty()) {
    std::fprintf(
        stderr,
        "im2fit-lab make garment-sizes: %s is not there; people are thin-, median- and heavy-, man and woman, "
        "and person-NUMBER\n",
        options.only.c_str());
    return 2;
  }
  std::vector<Case> cases;
  for (std::size_t p = 0; p < people.size(); ++p) {
    const DressedPerson& person = people[p];
    const SizeChart& chart = person.woman ? builtin_size_system().women : builtin_size_system().men;
    for (const body::GarmentPattern* pattern : patterns) {
      const float best_mm = bought_chest_mm(person, *pattern);
      int best = 0;
      for (std::size_t r = 0; r < chart.rows.size(); ++r)
        if (size_chest_mm(chart.rows[r]) <= best_mm) best = static_cast<int>(r);
      for (std::size_t r = 0; r < chart.rows.size(); ++r) {
        const SizeRow& row = chart.rows[r];
        if (!options.sizes.empty() && std::count(options.sizes.begin(), options.sizes.end(), row.size) == 0) continue;
        Case one{p, pattern, &row, static_cast<int>(r) - best, {}};
        const auto outfit = dressed(*model, person, one);
        if (!outfit) {
          std::fprintf(stderr, "im2fit-lab make garment-sizes: %s in %s cannot be cut\n", pattern->id.c_str(),
                       row.size.c_str());
          return 1;
        }
        one.quality = judge_standing(*model, *outfit, 0);
        cases.push_back(std::move(one));
      }
    }
    std::fprintf(stderr, "\r%zu of %zu people", p + 1, people.size());
  }
  std::fprintf(stderr, "\n");
  if (cases.empty()) {
    std::fprintf(stderr,
                 "im2fit-lab make garment-sizes: the charts have none of these sizes; XS, S, M, L, XL, XXL, 3XL\n");
    return 2;
  }
  std::stable_sort(cases.begin(), cases.end(),
                   [](const Case& l, const Case& r) { return l.badness() > r.badness(); });
  const std::size_t shown = std::min(options.worst, cases.size());
  for (std::size_t i = 0; i < shown; ++i) std::printf("%s\n", words_of(people[cases[i].person], cases[i]).c_str());
  constexpr int kAll = 1000;
  std::printf("\nall sizes (rims over %.1f mm; hems with less than %.0f %% of their points within %.0f mm)\n", kRimMm,
              100.0 * kHemShare, kHemOffMm);
  print_summary(cases, patterns, kAll);
  std::printf("\nthe best size and its neighbours\n");
  print_summary(cases, patterns, 1);
  if (options.hems) {
    std::printf("\nhems above their plane, mm (standard deviation), from the panel's least x to its largest\n");
    for (const body::GarmentPattern* pattern : patterns) print_hems(cases, *pattern);
  }
  if (options.sheet.empty()) return 0;
  const int tall = options.scale * kCellHeight, rows = (static_cast<int>(shown) + kColumns - 1) / kColumns;
  const int wide = options.scale * kCellWidth * static_cast<int>(std::size(kCellViews));
  Canvas sheet(std::clamp(static_cast<int>(shown), 1, kColumns) * wide, std::max(1, rows) * tall);
  sheet.rectangle(0, 0, sheet.width(), sheet.height(), {255, 255, 255});
  for (std::size_t i = 0; i < shown; ++i)
    draw_case(*model, people[cases[i].person], cases[i], sheet, static_cast<int>(i) % kColumns * wide,
              static_cast<int>(i) / kColumns * tall, options.scale);
  const auto png = sheet.png();
  const Status written = png ? write_file_atomically(options.sheet, *png) : Status(png.error());
  if (!written) std::fprintf(stderr, "im2fit-lab make garment-sizes: %s\n", written.error().message.c_str());
  return written ? 0 : 1;
}

}  // namespace

namespace im2fit::apps {

int make_garment_sizes(int argc, char** argv) {
  SizesOptions options;
  bool right = argc >= 2 && std::string_view(argv[1]) != "--help";
  for (int i = 1; i < argc && right; ++i) {
    const std::string_view word = argv[i];
    const bool value = i + 1 < argc;
    if (word == "--people" && value)
      right = read_number(argv[++i], options.people) && options.people > 0;
    else if (word == "--worst" && value)
      right = read_number(argv[++i], options.worst);
    else if (word == "--scale" && value)
      right = read_number(argv[++i], options.scale) && options.scale > 0 && options.scale <= 8;
    else if (word == "--only" && value)
      options.only = argv[++i];
    else if (word == "--sizes" && value)
      options.sizes = split(argv[++i]);
    else if (word == "--sheet" && value)
      options.sheet = argv[++i];
    else if (word == "--hems")
      options.hems = true;
    else if (word.starts_with("--"))
      right = false;
    else if (options.body.empty())
      options.body = word;
    else
      options.garments.emplace_back(word);
  }
  if (!right || options.body.empty()) {
    std::fprintf(stderr,
                 "im2fit-lab make garment-sizes BODY.i2b [--people N] [--only PERSON] [--sizes XS,M,...] [--worst N] "
                 "[--sheet FILE.png [--scale N]] [--hems] [GARMENT...]\n");
    return 2;
  }
  return run(options);
}

}  // namespace im2fit::apps
