// SPDX-License-Identifier: Apache-2.0
// A frame of clothes on a body that moves: a median man whose arms sink and rise by two degrees a frame, in a
// T-shirt, in trousers and in both. cloth/body is the same with nothing on: the body posed and skinned, its grid
// built. cloth/moving is both as a page shows them: the rough meshes, their offsets, and those as bytes each third
// frame.
//
// The body: IM2FIT_BODY, else the cache's. Without one there is no case, and standard error reports it.
#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "bench/frame/room.h"
#include "bench/kernels/cases.h"
#include "body/measure.h"
#include "garment/drape/dressing_pose.h"
#include "garment/drape/moving_clothes.h"
#include "garment/drape/offset_wire.h"
#include "garment/drape/outfit.h"
#include "person/garment_file.h"

namespace im2fit::bench {
namespace {

constexpr float kChestMm = 1000;  // the size's
constexpr int kSettleFrames = 12;

struct Dressed {
  std::shared_ptr<body::BodyModel> model;
  std::unique_ptr<body::Outfit> outfit;
  std::unique_ptr<body::MovingClothes> moving;  // instead of the outfit
  std::vector<body::Pose> poses;
  body::Skeleton skeleton;
  std::string told;
  std::size_t next = 0;

  void step() {
    next = (next + 1) % poses.size();
    if (!moving) return outfit->frame(poses[next]);
    moving->frame(poses[next]);
    if (next % 3 != 0) return;
    moving->find_offsets();
    told.clear();
    for (std::size_t i = 0; i < moving->size(); ++i) body::append_offsets(moving->offsets(i), told);
  }
  void move_roughly() { moving = std::make_unique<body::MovingClothes>(*model, std::move(outfit), skeleton); }
};

std::shared_ptr<Dressed> dressed_in(const std::shared_ptr<body::BodyModel>& model,
                                    const std::vector<const char*>& garments) {
  const Wardrobe& wardrobe = builtin_wardrobe();
  std::vector<body::Outfit::Piece> pieces;
  for (const char* id : garments) {
    const body::GarmentPattern& pattern = *wardrobe.garment(id);
    pieces.push_back(body::Outfit::piece(pattern, body::cut_body(wardrobe.regression, false, kChestMm),
                                         *wardrobe.fabric(pattern.fabric), true));
  }
  body::Params params;
  params.gender = 1;
  params.age_years = 35;
  params.height = 0.55F;
  std::vector<Vec3f> rest(static_cast<std::size_t>(model->vertex_count()));
  model->morph(params, rest);
  const body::Skeleton skeleton = body::rest_skeleton(*model, rest);
  const auto dressed = std::make_shared<Dressed>();
  dressed->model = model;
  dressed->outfit = std::make_unique<body::Outfit>(*model, std::move(pieces));
  for (const float spread : {16.0F, 18.0F, 20.0F, 22.0F, 20.0F, 18.0F})
    dressed->poses.push_back(body::relaxed_pose(skeleton, spread));
  dressed->skeleton = skeleton;
  dressed->outfit->dress(rest, skeleton, dressed->poses[0]);
  for (int i = 0; i < kSettleFrames; ++i) dressed->step();
  return dressed;
}

}  // namespace

Cases cloth_cases(std::string_view only) {
  const std::string path = file_of("IM2FIT_BODY", "body.i2b", "");
  auto loaded = body::BodyModel::load(path);
  if (!loaded) {
    std::fprintf(stderr, "cloth: no body in %s: no case\n", path.c_str());
    return {};
  }
  const auto model = std::make_shared<body::BodyModel>(std::move(*loaded));
  Cases cases;
  const auto add = [&](const std::string& kernel, const std::vector<const char*>& garments, bool moving = false) {
    if (!only.empty() && !only.starts_with(kernel) && !kernel.starts_with(only)) return;
    const auto dressed = dressed_in(model, garments);
    double vertices = 0;
    for (std::size_t i = 0; i < dressed->outfit->size(); ++i)
      vertices += static_cast<double>(dressed->outfit->cloth(i).mesh().vertex_count());
    if (moving) dressed->move_roughly();
    Case one;
    one.kernel = kernel;
    one.variant = "best";
    one.items = vertices;
    one.item = "vertex";
    one.run = [dressed] { dressed->step(); };
    cases.push_back(std::move(one));
  };
  add("cloth/body", {});
  add("cloth/t_shirt", {"t_shirt"});
  add("cloth/trousers", {"trousers"});
  add("cloth/both", {"trousers", "t_shirt"});
  add("cloth/moving", {"trousers", "t_shirt"}, true);
  return cases;
}

}  // namespace im2fit::bench
