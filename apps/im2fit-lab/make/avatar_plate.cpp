// SPDX-License-Identifier: Apache-2.0
// im2fit-lab make avatar-plate BODY.i2b OUT.png [--heads]
// Eight avatars of different build, front and side, a body 1.87 m tall 600 pixels high: docs/pictures/avatars.png.
// --heads: their heads instead, as large, to judge faces and hair by.
#include <algorithm>
#include <cstdio>
#include <string>
#include <string_view>

#include "apps/im2fit-lab/make/make.h"
#include "body/measure.h"
#include "core/file.h"
#include "report/dressed_picture.h"
#include "train/dressed/dressed_people.h"
#include "train/population/solve.h"

namespace {

using namespace im2fit;
using namespace im2fit::lab;

struct Build {
  const char* name;
  bool woman;
  double stature_mm, body_mass_index;
  float muscle, age_years;
  std::array<float, 3> race;  // of Params: faces that differ
};
constexpr Build kBuilds[] = {
    {"slim man", false, 1780, 18.5, 0.45F, 27, {0.1F, 0.1F, 0.8F}},
    {"median man", false, 1760, 24, 0.5F, 38, {0.1F, 0.8F, 0.1F}},
    {"heavy man", false, 1750, 34, 0.35F, 52, {0.1F, 0.1F, 0.8F}},
    {"tall man", false, 1930, 25, 0.55F, 33, {0.8F, 0.1F, 0.1F}},
    {"slim woman", true, 1660, 18.5, 0.45F, 25, {0.1F, 0.7F, 0.2F}},
    {"median woman", true, 1640, 23, 0.5F, 40, {0.1F, 0.1F, 0.8F}},
    {"heavy woman", true, 1650, 35, 0.35F, 50, {0.7F, 0.1F, 0.2F}},
    {"short woman", true, 1500, 23, 0.5F, 62, {0.2F, 0.2F, 0.6F}},
};
constexpr int kColumns = 4, kWidth = 230, kHeight = 660;
constexpr float kFloorMm = 50, kTopMm = 2007;  // of the picture, from the floor

PictureFrame frame_of(const body::BodyModel& model, const body::Outfit& outfit, bool head) {
  float low = 1e9F, high = -1e9F;
  for (const Vec3f& v : outfit.body().first(static_cast<std::size_t>(model.body_vertex_count()))) {
    low = std::min(low, v.y);
    high = std::max(high, v.y);
  }
  PictureFrame frame;
  frame.width = head ? 400 : kWidth;
  frame.height = head ? 400 : kHeight;
  frame.low_mm = head ? high - 300 : low - kFloorMm;
  frame.high_mm = head ? high + 50 : low + kTopMm;
  return frame;
}

int run(const char* path, const char* out, bool heads) {
  const auto model = body::BodyModel::load(path);
  if (!model) {
    std::fprintf(stderr, "im2fit-lab make avatar-plate: %s\n", model.error().message.c_str());
    return 1;
  }
  constexpr PictureView kViews[] = {kFrontView, kLeftView};
  constexpr int kCount = static_cast<int>(std::size(kBuilds));
  const int width = 2 * (heads ? 400 : kWidth), height = heads ? 400 : kHeight;
  Canvas plate(kColumns * width, (kCount + kColumns - 1) / kColumns * height);
  for (int i = 0; i < kCount; ++i) {
    const Build& build = kBuilds[i];
    body::Params params;
    params.gender = build.woman ? 0 : 1;
    params.age_years = build.age_years;
    params.muscle = build.muscle;
    params.race = build.race;
    body::solve_stature_and_weight(*model, params, build.stature_mm,
                                   build.body_mass_index * build.stature_mm * build.stature_mm * 1e-6);
    const DressedPerson person = dressed_person(*model, build.name, build.woman, params);
    body::Outfit bare(*model, {});
    bare.dress(person.rest, person.skeleton, dressed_poses(*model, person)[0].pose);
    PictureFrame frame = frame_of(*model, bare, heads);
    frame.middle_z_mm = person.skeleton.head[heads ? 4 : 0].z + (heads ? 30.0F : 0.0F);
    const Canvas drawn =
        draw_outfit(*model, bare, build.woman ? body::LookOf::woman : body::LookOf::man, {}, kViews, frame);
    for (int y = 0; y < drawn.height(); ++y)
      for (int x = 0; x < drawn.width(); ++x)
        plate.set(i % kColumns * width + x, i / kColumns * height + y, drawn.at(x, y));
  }
  const auto png = plate.png();
  const Status written = png ? write_file_atomically(out, *png) : Status(png.error());
  if (written) return 0;
  std::fprintf(stderr, "im2fit-lab make avatar-plate: %s\n", written.error().message.c_str());
  return 1;
}

}  // namespace

namespace im2fit::apps {

int make_avatar_plate(int argc, char** argv) {
  const bool heads = argc == 4 && std::string_view(argv[3]) == "--heads";
  if (argc != 3 && !heads) {
    std::fprintf(stderr, "im2fit-lab make avatar-plate BODY.i2b OUT.png [--heads]\n");
    return 2;
  }
  return run(argv[1], argv[2], heads);
}

}  // namespace im2fit::apps
