// SPDX-License-Identifier: Apache-2.0
#include "bench/index/plain_pca.h"

#include <Eigen/Dense>

namespace im2fit::bench {

// Apart from the searching, which is compiled for the machine: Eigen must be the same everywhere in a program.
PlainPca PlainPca::fit(std::span<const float> rows, std::size_t size, std::size_t dimensions) {
  using Rows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const auto n = static_cast<Eigen::Index>(rows.size() / size);
  const auto width = static_cast<Eigen::Index>(size), kept = static_cast<Eigen::Index>(dimensions);
  Rows x = Eigen::Map<const Rows>(rows.data(), n, width);
  const Eigen::RowVectorXf mean = x.colwise().mean();
  x.rowwise() -= mean;
  const Eigen::MatrixXd covariance = (x.transpose() * x).cast<double>() / static_cast<double>(n);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(covariance);
  const Rows axes = solver.eigenvectors().rightCols(kept).rowwise().reverse().transpose().cast<float>();
  PlainPca pca;
  pca.mean_.assign(mean.begin(), mean.end());
  pca.axes_.assign(axes.data(), axes.data() + axes.size());
  pca.explained_ = solver.eigenvalues().tail(kept).sum() / solver.eigenvalues().sum();
  return pca;
}

}  // namespace im2fit::bench
