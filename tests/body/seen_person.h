// SPDX-License-Identifier: Apache-2.0
// A person before a perfect camera, from the front and from behind: meshes of body/model, pictures of synth's
// renderer, nothing of body/fit's.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "body/fit/shape_fitter.h"
#include "body/skeleton.h"
#include "body_pack.h"
#include "train/population/population.h"
#include "train/render/raster.h"

// For tests that fit: skips without a body file that has a shape space.
#define IM2FIT_NEEDS_SPACE()                       \
  IM2FIT_NEEDS_BODY();                             \
  if (real_body()->shape_space().point_count == 0) \
  GTEST_SKIP() << body_pack_path() << " has no shape space: run im2fit-lab fetch"

namespace im2fit::body {

struct SeenPerson {
  static constexpr int kWidth = 480, kHeight = 640;
  static constexpr float kCameraHeightMm = 950;

  std::vector<Vec3f> rest;
  std::vector<std::vector<Vec3f>> in_camera;  // body vertices as each camera sees them
  std::vector<std::vector<std::uint16_t>> depth_q4;
  std::vector<std::vector<std::uint8_t>> mask;
  std::vector<FitView> views;  // front, back

  SeenPerson(const BodyModel& model, lab::Family family, std::uint64_t seed, std::uint64_t index,
             float distance_mm = 2400, float spread_deg = 16) {
    const auto subject = lab::draw_subject(model, family, seed, index);
    rest.resize(static_cast<std::size_t>(model.vertex_count()));
    lab::morph_subject(model, subject, rest);
    const Skeleton skeleton = rest_skeleton(model, rest);
    std::vector<Vec3f> posed(rest.size());
    skin(model, rest, skeleton, relaxed_pose(skeleton, spread_deg), posed);
    for (const bool back : {false, true}) see(model, posed, distance_mm, back);
    for (std::size_t v = 0; v < 2; ++v) {
      views[v].depth_q4 = {depth_q4[v].data(), kWidth, kHeight, kWidth};
      views[v].mask = {mask[v].data(), kWidth, kHeight, kWidth};
    }
  }

 private:
  void see(const BodyModel& model, std::span<const Vec3f> posed, float distance_mm, bool back) {
    const auto bodies = posed.first(static_cast<std::size_t>(model.body_vertex_count()));
    const float floor = std::min_element(bodies.begin(), bodies.end(), [](Vec3f a, Vec3f b) { return a.y < b.y; })->y;
    const auto to_camera = [&](Vec3f p) {
      const float side = back ? -1.0F : 1.0F;
      return Vec3f{side * p.x, kCameraHeightMm + floor - p.y, distance_mm - side * p.z};
    };
    FitView view;
    view.intrinsics = {kWidth, kHeight, 575.8F, 575.8F, 239.5F, 319.5F};
    view.joints = joints_of(model, posed);
    for (Vec3f& p : view.joints.position_mm) p = to_camera(p);
    view.floor = {true, {0, -1, 0}, kCameraHeightMm};
    std::vector<Vec3f>& mesh = in_camera.emplace_back();
    for (const Vec3f& p : bodies) mesh.push_back(to_camera(p));
    lab::CleanView clean(kWidth, kHeight);
    const std::uint8_t label = lab::kPerson;
    lab::MeshRaster().draw(mesh, model.body_triangles(), {&label, 1}, true, view.intrinsics,
                           lab::whole(kWidth, kHeight), clean);
    auto& depth = depth_q4.emplace_back();
    auto& inside = mask.emplace_back();
    for (const float inverse : clean.inverse_depth) {
      depth.push_back(inverse > 0 ? static_cast<std::uint16_t>(16 / inverse + 0.5F) : std::uint16_t{0});
      inside.push_back(inverse > 0 ? 255 : 0);
    }
    views.push_back(view);
  }
};

}  // namespace im2fit::body
