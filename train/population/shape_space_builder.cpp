// SPDX-License-Identifier: Apache-2.0
#include "train/population/shape_space_builder.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "body/fit/shape_points.h"
#include "body/skeleton.h"
#include "train/common/linear_algebra.h"
#include "train/common/parallel.h"
#include "train/population/ood_subjects.h"
#include "train/population/population.h"
#include "train/population/surface_smoother.h"

namespace im2fit::lab {
namespace {

using body::kPointValues;
using body::Quad;

Vec3f corner(std::span<const Vec3f> mesh, const Quad& quad, std::size_t i) {
  return mesh[static_cast<std::size_t>(quad[i])];
}

void describe(const body::BodyModel& model, const std::vector<Quad>& quads, std::span<const Vec3f> mesh,
              std::span<float> points, std::span<float> bones) {
  const auto put = [](std::span<float> out, std::size_t at, Vec3f v) {
    out[at] = v.x;
    out[at + 1] = v.y;
    out[at + 2] = v.z;
  };
  for (std::size_t i = 0; i < quads.size(); ++i) {
    const auto c = [&](std::size_t k) { return corner(mesh, quads[i], k); };
    put(points, i * kPointValues, (c(0) + c(1) + c(2) + c(3)) * 0.25F);
    put(points, i * kPointValues + 3, c(2) - c(0));
    put(points, i * kPointValues + 6, c(3) - c(1));
  }
  const body::Skeleton skeleton = body::rest_skeleton(model, mesh);
  for (std::size_t s = 0; s < static_cast<std::size_t>(body::kSegmentCount); ++s) {
    put(bones, 3 * s, skeleton.head[s]);
    put(bones, 3 * (s + static_cast<std::size_t>(body::kSegmentCount)), skeleton.tail[s]);
  }
}

}  // namespace

body::ShapeSpace build_shape_space(const body::BodyModel& model, const ShapeSpaceOptions& options) {
  body::ShapeSpace space;
  std::vector<Vec3f> mesh(static_cast<std::size_t>(model.vertex_count()));
  model.morph({}, mesh);
  const std::vector<Quad> quads = body::quads_at_equal_area(model, mesh, static_cast<std::size_t>(options.points));
  for (const Quad& quad : quads) space.skin.push_back(body::skin_of_quad(model, quad));
  space.point_count = quads.size();
  space.shape_count = static_cast<std::size_t>(options.shapes);

  const auto people = static_cast<std::ptrdiff_t>(options.people);
  const auto width = static_cast<std::ptrdiff_t>(quads.size() * kPointValues);
  const auto bones = static_cast<std::ptrdiff_t>(body::kBoneValues);
  using Rows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  Rows all(people, width + bones);
  const SurfaceSmoother smoother(model);
  for_each_item(options.people, options.threads, [&](int i) {
    const auto number = static_cast<std::uint64_t>(i);
    // Pairs of a man and a woman by turns.
    std::vector<Vec3f> own(static_cast<std::size_t>(model.vertex_count()));
    const Subject subject = i % 6 < 2   ? draw_ood_subject(model, options.seed, number, kOodTrunk, own, &smoother)
                            : i % 6 < 4 ? draw_ood_subject(model, options.seed, number, kOodAllOver)
                                        : draw_subject(model, Family::training, options.seed, number);
    morph_subject(model, subject, own);
    float* row = all.data() + i * (width + bones);
    describe(model, quads, own, {row, static_cast<std::size_t>(width)}, {row + width, body::kBoneValues});
  });

  const Eigen::RowVectorXf mean = all.colwise().mean();
  all.rowwise() -= mean;
  // Components of the middles alone: the diagonals and bones follow them.
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(people, people);
  Rows middles(people, static_cast<std::ptrdiff_t>(quads.size()) * 3);
  for (std::ptrdiff_t q = 0; q < static_cast<std::ptrdiff_t>(quads.size()); ++q)
    middles.middleCols(3 * q, 3) = all.middleCols(static_cast<std::ptrdiff_t>(kPointValues) * q, 3);
  gram = (middles * middles.transpose()).cast<double>();
  const SymmetricEigen eigen = symmetric_eigen(gram);
  space.point_basis.resize(static_cast<std::size_t>(width) * space.shape_count);
  space.bone_basis.resize(body::kBoneValues * space.shape_count);
  for (std::size_t k = 0; k < space.shape_count; ++k) {
    // Scores of unit variance; the sign is the solver's whim: the first person's score is positive.
    Eigen::VectorXd score = eigen.vectors.col(people - 1 - static_cast<std::ptrdiff_t>(k));
    if (score(0) < 0) score = -score;
    score *= std::sqrt(static_cast<double>(people));
    const Eigen::VectorXf basis = all.transpose() * (score / static_cast<double>(people)).cast<float>();
    for (std::ptrdiff_t i = 0; i < width; ++i)
      space.point_basis[static_cast<std::size_t>(i) * space.shape_count + k] = basis(i);
    for (std::ptrdiff_t i = 0; i < bones; ++i)
      space.bone_basis[static_cast<std::size_t>(i) * space.shape_count + k] = basis(width + i);
  }
  space.point_mean.assign(mean.data(), mean.data() + width);
  space.bone_mean.assign(mean.data() + width, mean.data() + width + bones);
  return space;
}

}  // namespace im2fit::lab
