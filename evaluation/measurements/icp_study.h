// SPDX-License-Identifier: Apache-2.0
// The paper's last figure: the fused depth of a person against the retrieved body in the measured pose, aligned by
// its joints, then by ICP.
#pragma once

#include <string>
#include <vector>

#include "evaluation/measurements/icp.h"
#include "evaluation/measurements/session.h"

namespace im2fit::lab {

struct IcpCase {
  std::string who;              // "man, 1783 mm, 78 kg"
  Cloud cloud;                  // mesh axes, where the joints put it
  std::vector<Vec3f> vertices;  // of the posed body
};
inline constexpr int kIcpIterations = 15;
inline constexpr double kIcpReachMm = 150;
inline constexpr std::size_t kIcpPointsMost = 6000;

// The first `count` of an evaluation's people who are measured, of at most four times as many.
Result<std::vector<IcpCase>> icp_cases(const SessionModels& models, const EvaluationOptions& options, int count);

struct IcpCurve {
  std::string method, who;
  std::vector<double> error_mm;  // by iteration, from 0
};
// Ours, a curve a case.
std::vector<IcpCurve> icp_curves(const body::BodyModel& model, const std::vector<IcpCase>& cases);

// Written by `references_bench icp`: the same cases under ours and PCL's. Errors name the file and the
// field.
Result<std::vector<IcpCurve>> read_icp_curves(const std::string& path);
std::string icp_json_of(const std::vector<IcpCurve>& curves);

}  // namespace im2fit::lab
