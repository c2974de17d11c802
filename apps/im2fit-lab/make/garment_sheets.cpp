// SPDX-License-Identifier: Apache-2.0
// im2fit-lab make garment-sheets BODY.i2b DIR [--quick] [--only PERSON] [GARMENT...]; --quick: at rest alone. PERSON:
// one of the examples, or person-17: a held-out one by its number, as the drapes' test names them. Contact sheets of
// dressed people: DIR/PERSON.png (front, slant, side, back at rest), DIR/PERSON-poses.png, and DIR/motion.png (12
// frames of arms that rise and sink). What each drape measures goes to stdout.
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

#include "apps/im2fit-lab/make/make.h"
#include "core/file.h"
#include "evaluation/garment/drape_quality.h"
#include "garment/drape/dressing_pose.h"
#include "report/dressed_picture.h"
#include "train/common/stopwatch.h"
#include "train/dressed/dressed_people.h"

namespace {

using namespace im2fit;
using namespace im2fit::lab;

constexpr PictureView kViews[] = {kFrontView, kSlantView, kLeftView, kBackView};

bool write(const Canvas& canvas, const std::string& path) {
  const auto png = canvas.png();
  const Status written = png ? write_file_atomically(path, *png) : Status(png.error());
  if (!written) std::fprintf(stderr, "im2fit-lab make garment-sheets: %s\n", written.error().message.c_str());
  return static_cast<bool>(written);
}

void paste(const Canvas& from, Canvas& to, int left, int top) {
  for (int y = 0; y < from.height(); ++y)
    for (int x = 0; x < from.width(); ++x) to.set(left + x, top + y, from.at(x, y));
}

PictureFrame frame_of(const body::BodyModel& model, const body::Outfit& outfit, const DressedPerson& person) {
  float low = 1e9F;
  for (const Vec3f& v : outfit.body().first(static_cast<std::size_t>(model.body_vertex_count())))
    low = std::min(low, v.y);
  PictureFrame frame;
  frame.middle_z_mm = person.skeleton.head[0].z;
  frame.low_mm = low - 40;
  frame.high_mm = low + 1940;
  return frame;
}

void report(const char* person, const char* pose, const std::vector<std::string>& names, const body::Outfit& outfit) {
  for (std::size_t i = 0; i < outfit.size(); ++i) {
    const DrapeQuality q = judge(outfit, i);
    std::printf(
        "%-13s %-11s %-10s strain %.2f %% p95 %.1f peak %.0f  inside %.2f %% %.1f mm  folds %.2f mm  rim %.1f mm  "
        "hem %.0f of %.0f mm%s\n",
        person, pose, names[i].c_str(), 100.0 * q.strain_mean, 100.0 * q.strain_p95, 100.0 * q.strain_peak,
        100.0 * q.inside_share, q.inside_deepest_mm, q.folds_mm, q.hem_roughness_mm,
        hem_girth_mm(outfit.cloth(i), false), hem_girth_mm(outfit.cloth(i), true), q.finite ? "" : "  NOT FINITE");
  }
}

// All examples, or the one named `only`. Empty where no example has that name.
std::vector<DressedPerson> people_of(const body::BodyModel& model, const std::string& only) {
  const std::string_view kDrawn = "person-";
  if (only.starts_with(kDrawn)) {
    const std::string_view digits = std::string_view(only).substr(kDrawn.size());
    std::uint64_t number = 0;
    const auto [end, error] = std::from_chars(digits.begin(), digits.end(), number);
    if (error != std::errc{} || end != digits.end()) return {};
    return {drawn_person(model, number)};
  }
  auto people = example_people(model);
  if (!only.empty()) std::erase_if(people, [&](const DressedPerson& p) { return p.name != only; });
  return people;
}

int run(const char* path, const std::string& folder, const std::vector<std::string>& names, bool quick,
        const std::string& only) {
  const auto model = body::BodyModel::load(path);
  if (!model) {
    std::fprintf(stderr, "im2fit-lab make garment-sheets: %s\n", model.error().message.c_str());
    return 1;
  }
  std::vector<LinearColour> colours;
  for (const std::string& id : names) {
    const body::GarmentPattern* pattern = builtin_wardrobe().garment(id);
    const auto own = id.ends_with(".yaml") ? load_garment(id) : Result<body::GarmentPattern>(Error{});
    if (pattern == nullptr && !own) {
      std::fprintf(stderr, "im2fit-lab make garment-sheets: no garment is called %s; %s\n", id.c_str(),
                   own.error().message.c_str());
      return 2;
    }
    colours.push_back(own ? own->colour : pattern->colour);
  }
  const auto people = people_of(*model, only);
  if (people.empty()) {
    std::fprintf(
        stderr,
        "im2fit-lab make garment-sheets: %s is not there; people are thin-, median- and heavy-, man and woman, and "
        "person-NUMBER\n",
        only.c_str());
    return 2;
  }
  for (const DressedPerson& person : people) {
    Stopwatch watch;
    body::Outfit outfit(*model, pieces_for(person, names));
    const double built_ms = 1e3 * watch.lap();
    const auto poses = dressed_poses(*model, person);
    outfit.dress(person.rest, person.skeleton, poses[0].pose);
    const double dressed_ms = 1e3 * watch.lap();
    for (int i = 0; i < 22; ++i) outfit.frame(poses[0].pose);  // 30 since it stood still
    const auto before = positions_of(outfit.cloth(0));
    outfit.frame(poses[0].pose);
    const Motion motion = motion_since(outfit.cloth(0), before);
    std::printf("%-13s %zu vertices, built in %.0f ms, dressed in %.0f ms; at rest %.3f mm a frame, most %.2f\n",
                person.name.c_str(), outfit.cloth(0).mesh().vertex_count(), built_ms, dressed_ms, motion.rms_mm,
                motion.most_mm);
    report(person.name.c_str(), "relaxed", names, outfit);
    PictureFrame frame = frame_of(*model, outfit, person);
    frame.width = 400;
    frame.height = 860;
    const auto whose = person.woman ? body::LookOf::woman : body::LookOf::man;
    if (!write(draw_outfit(*model, outfit, whose, colours, kViews, frame), folder + "/" + person.name + ".png"))
      return 1;
    if (quick) continue;
    frame.width = 300;
    frame.height = 420;
    constexpr PictureView kTwo[] = {kFrontView, kSlantView};
    Canvas sheet(5 * 2 * frame.width, 2 * frame.height);
    for (std::size_t i = 0; i < poses.size(); ++i) {
      outfit.move_to(poses[i].pose, 20);
      for (int k = 0; k < 20; ++k) outfit.frame(poses[i].pose);
      report(person.name.c_str(), poses[i].name.c_str(), names, outfit);
      paste(draw_outfit(*model, outfit, whose, colours, kTwo, frame), sheet,
            static_cast<int>(i % 5) * 2 * frame.width, static_cast<int>(i / 5) * frame.height);
      outfit.move_to(poses[0].pose, 20);
    }
    if (!write(sheet, folder + "/" + person.name + "-poses.png")) return 1;
    if (person.name != "median-man") continue;
    Canvas frames(6 * frame.width, 2 * frame.height);
    for (int i = 0; i < 12; ++i) {
      const float share = static_cast<float>(i < 6 ? i + 1 : 11 - i) / 6;
      constexpr int kFrames = 4;  // of each picture: the arms rise in 0.8 s
      outfit.move_to(body::between(poses[0].pose, poses[3].pose, share), kFrames);
      paste(draw_outfit(*model, outfit, whose, colours, std::span(kTwo).first(1), frame), frames,
            (i % 6) * frame.width, (i / 6) * frame.height);
    }
    if (!write(frames, folder + "/motion.png")) return 1;
  }
  return 0;
}

}  // namespace

namespace im2fit::apps {

int make_garment_sheets(int argc, char** argv) {
  if (argc < 3 || std::string_view(argv[1]) == "--help") {
    std::fprintf(stderr, "im2fit-lab make garment-sheets BODY.i2b DIR [--quick] [--only PERSON] [GARMENT...]\n");
    return 2;
  }
  std::vector<std::string> names;
  bool quick = false;
  std::string only;
  for (int i = 3; i < argc; ++i) {
    if (std::string_view(argv[i]) == "--quick")
      quick = true;
    else if (std::string_view(argv[i]) == "--only" && i + 1 < argc)
      only = argv[++i];
    else
      names.emplace_back(argv[i]);  // ids and files
  }
  if (names.empty()) names = {"trousers", "t_shirt"};
  return run(argv[1], argv[2], names, quick, only);
}

}  // namespace im2fit::apps
