// SPDX-License-Identifier: Apache-2.0
// What a program does with a body file, done with one that may be damaged.
#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "body/look.h"
#include "body/measure.h"
#include "body/model.h"
#include "body/shape_space.h"
#include "body/skeleton.h"

namespace im2fit::fuzz {

// The largest person of a shape space: whether all that a fit would look at is finite.
inline bool use_space(const body::ShapeSpace& space) {
  bool sane = true;
  const auto sum = [&](const std::vector<float>& mean, const std::vector<float>& basis) {
    for (std::size_t i = 0; i < mean.size(); ++i) {
      float value = mean[i];
      for (std::size_t k = 0; k < space.shape_count; ++k) value += 5 * std::fabs(basis[i * space.shape_count + k]);
      sane &= std::isfinite(value);
    }
  };
  sum(space.point_mean, space.point_basis);
  sum(space.bone_mean, space.bone_basis);
  for (const SkinRecord& s : space.skin)
    for (std::size_t i = 0; i < 4; ++i) sane &= s.segment[i] < body::kSegmentCount && s.weight[i] >= 0;
  return sane;
}

// Nothing when the file is refused; else whether every vertex of a few bodies is finite.
inline std::optional<bool> use_body(std::vector<std::byte> bytes) {
  const auto model = body::BodyModel::parse(std::move(bytes), "fuzzed.i2b");
  if (!model) return std::nullopt;
  std::vector<Vec3f> mesh(static_cast<std::size_t>(model->vertex_count())), posed(mesh.size());
  bool sane = true;
  for (const float at : {0.0F, 0.4F, 1.0F}) {
    body::Params p;
    p.gender = p.weight = p.height = p.muscle = at;
    p.age_years = 18 + 70 * at;
    p.modifiers.assign(model->modifier_names().size(), at - 0.5F);
    model->morph(p, mesh);
    for (const Vec3f& v : mesh) sane &= std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
    const auto rest = body::rest_skeleton(*model, mesh);
    body::skin(*model, mesh, rest, body::psi_pose(rest), posed);
    (void)body::joints_of(*model, posed);
    for (const body::LookPart& part :
         {static_cast<const body::LookPart&>(body::skin_part(*model, mesh)), body::eyes_part(*model, mesh),
          body::hair_part(*model, mesh, {}, body::look_of(at))})
      for (const auto* vertices : {&part.positions, &part.normals})
        for (const Vec3f& v : *vertices) sane &= std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
  }
  return sane && use_space(model->shape_space());
}

}  // namespace im2fit::fuzz
