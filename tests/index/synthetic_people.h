// SPDX-License-Identifier: Apache-2.0
// A world whose best possible answer is known: shape -> features, linear (or mildly bent), with strong pose nuisance
// and correlated noise.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <vector>

#include "core/rng.h"
#include "index/index.h"
#include "train/index/builder.h"

namespace im2fit::index::testing {

inline float age_of(std::uint64_t subject) {
  return 18 + 0.3F * static_cast<float>(subject % 190);
}

struct World {
  int features = 120;
  int shapes = 6;
  int poses = 5;
  double bend = 0;  // share of the quadratic terms
  Eigen::MatrixXd by_shape, by_pose, by_noise, truth_by_shape;

  explicit World(double bend_share = 0) : bend(bend_share) {
    Rng rng(42);
    const auto draw = [&](int rows, int cols, double sd) {
      Eigen::MatrixXd m(rows, cols);
      for (int i = 0; i < rows; ++i)
        for (int j = 0; j < cols; ++j) m(i, j) = rng.normal(0, sd);
      return m;
    };
    by_shape = draw(features, shapes, 1.0);
    by_pose = draw(features, poses, 3.0);
    by_noise = draw(features, 20, 0.5);  // correlated
    truth_by_shape = draw(static_cast<int>(kMeasurementCount), shapes, 30.0);
  }

  Eigen::VectorXd shape_of(std::uint64_t subject) const {
    Rng rng = Rng::for_item(7, 1, subject);
    Eigen::VectorXd s(shapes);
    for (int i = 0; i < shapes; ++i) s(i) = rng.normal();
    return s;
  }

  Sample sample(std::uint64_t subject, std::uint64_t capture, int frame_count = 1) const {
    const Eigen::VectorXd s = shape_of(subject);
    Rng rng = Rng::for_item(8, subject, capture);
    Eigen::VectorXd pose(poses), common(20), own(features);
    for (auto& v : pose) v = rng.normal();
    for (auto& v : common) v = rng.normal();
    for (auto& v : own) v = rng.normal();
    Eigen::VectorXd bent = s;
    for (int i = 0; i < shapes; ++i) bent(i) += bend * (s(i) * s((i + 1) % shapes) + 0.5 * (s(i) * s(i) - 1));
    const Eigen::VectorXd x =
        by_shape * bent + by_pose * pose + (by_noise * common + own) / std::sqrt(static_cast<double>(frame_count));
    Sample out;
    out.subject = subject;
    out.frame_count = frame_count;
    for (int i = 0; i < features; ++i) out.feature.push_back(static_cast<float>(100 + 10 * x(i)));
    const Eigen::VectorXd y = truth_by_shape * s;
    for (std::size_t m = 0; m < kMeasurementCount; ++m)
      out.truth[m] = static_cast<float>(1000 + y(static_cast<int>(m)));
    out.woman = s(0) > 0;
    out.age_years = age_of(subject);
    for (int i = 0; i < shapes; ++i) out.body.push_back(static_cast<float>(s(i)));
    return out;
  }

  // E[truth | feature] of the straight world (bend 0), from the generating matrices: no learning could do better.
  MeasurementValues best_answer(const Sample& q) const {
    Eigen::VectorXd x(features);
    for (int i = 0; i < features; ++i)
      x(i) = (static_cast<double>(q.feature[static_cast<std::size_t>(i)]) - 100) / 10;
    const Eigen::MatrixXd covariance = by_shape * by_shape.transpose() + by_pose * by_pose.transpose() +
                                       by_noise * by_noise.transpose() +
                                       Eigen::MatrixXd::Identity(features, features);
    if (posterior_.size() == 0) posterior_ = truth_by_shape * by_shape.transpose() * covariance.inverse();
    const Eigen::VectorXd y = posterior_ * x;
    MeasurementValues out{};
    for (std::size_t m = 0; m < kMeasurementCount; ++m) out[m] = static_cast<float>(1000 + y(static_cast<int>(m)));
    return out;
  }

  mutable Eigen::MatrixXd posterior_;
};

inline constexpr std::uint64_t kFreshSubjects = 1'000'000;  // never trained on

inline BuildOptions options_for(const World& world) {
  BuildOptions o;
  o.for_unknown_makes = false;  // all people are of one make
  o.provenance = "synthetic people, seed 42";
  o.population_version = 7;
  o.population_seed = 77;
  o.groups = {{"first", 20}, {"second", static_cast<std::uint32_t>(world.features) - 20}};
  return o;
}

inline std::vector<std::byte> build(const World& world, int subjects, int captures, bool vary_frames = false) {
  std::vector<Sample> samples;
  for (int s = 0; s < subjects; ++s)
    for (int c = 0; c < captures; ++c)
      samples.push_back(world.sample(static_cast<std::uint64_t>(s), static_cast<std::uint64_t>(c),
                                     vary_frames ? 1 + (s * 7 + c) % 16 : 1));
  auto bytes = build_index(options_for(world), source_of(samples));
  return bytes ? std::move(*bytes) : std::vector<std::byte>{};
}

}  // namespace im2fit::index::testing
