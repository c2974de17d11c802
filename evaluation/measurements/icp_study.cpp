// SPDX-License-Identifier: Apache-2.0
#include "evaluation/measurements/icp_study.h"

#include <fmt/core.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "body/person_axes.h"
#include "core/file.h"
#include "person/avatar.h"

namespace im2fit::lab {
namespace {

constexpr int kTriedPerWanted = 4;

Eigen::Vector3d vec_of(Vec3f v) {
  return {double{v.x}, double{v.y}, double{v.z}};
}

Cloud fused_cloud(const Engine& engine, const Intrinsics& upright, const body::PersonAxes& axes) {
  const auto depth = engine.fused_depth_q4();
  const MaskView mask = engine.fused_mask();
  Cloud all;
  for (int v = 0; v < depth.height; ++v)
    for (int u = 0; u < depth.width; ++u) {
      if (mask.at(u, v) == 0 || depth.at(u, v) == 0) continue;
      const float z_mm = static_cast<float>(depth.at(u, v)) / 16;
      all.push_back(vec_of(axes.to_mesh(unproject(upright, static_cast<float>(u), static_cast<float>(v), z_mm))));
    }
  const std::size_t step = std::max<std::size_t>(1, (all.size() + kIcpPointsMost - 1) / kIcpPointsMost);
  Cloud downsampled;
  for (std::size_t i = 0; i < all.size(); i += step) downsampled.push_back(all[i]);
  return downsampled;
}

Result<std::optional<IcpCase>> icp_case(const SessionModels& models, const HeldOutPerson& person, Views views) {
  const auto engine = run_session(models, person, views, {});
  if (!engine) return engine.error();
  const EngineResult result = (*engine)->result();
  if (!result.measured) return std::optional<IcpCase>{};
  body::MeasurementFitter fitter(models.body);
  const auto body = body_of_answer(fitter, result.answer, result.measured_joints, result.floor, result.seen);
  if (!body) return body.error();
  std::vector<Vec3f> rest(static_cast<std::size_t>(models.body.vertex_count()));
  models.body.morph(body->params, rest);
  IcpCase out;
  const auto& truth = person.subject.truth;
  out.who =
      fmt::format("{}, {:.0f} mm, {:.0f} kg", person.subject.woman ? "woman" : "man",
                  truth[measurement_index(Measurement::stature)], truth[measurement_index(Measurement::weight)]);
  out.vertices.resize(rest.size());
  body::skin(models.body, rest, body::rest_skeleton(models.body, rest), body->pose, out.vertices);
  const Intrinsics upright = hal::rotate_upright(person.capture.intrinsics, person.capture.scene.rotate_deg);
  out.cloud = fused_cloud(**engine, upright, body::PersonAxes(result.measured_joints, result.floor));
  return std::optional<IcpCase>{std::move(out)};
}

}  // namespace

Result<std::vector<IcpCase>> icp_cases(const SessionModels& models, const EvaluationOptions& options, int count) {
  std::vector<IcpCase> cases;
  for (int i = 0; i < kTriedPerWanted * count && cases.size() < static_cast<std::size_t>(count); ++i) {
    const HeldOutPerson person = draw_person(models.body, options, static_cast<std::uint64_t>(i));
    auto made = icp_case(models, person, options.views);
    if (!made) return made.error();
    if (*made && !(*made)->cloud.empty()) cases.push_back(std::move(**made));
  }
  return cases;
}

std::vector<IcpCurve> icp_curves(const body::BodyModel& model, const std::vector<IcpCase>& cases) {
  std::vector<IcpCurve> curves;
  for (const IcpCase& c : cases) {
    const MeshSurface surface(c.vertices, model.body_triangles());
    curves.push_back(
        {"ours, point to plane", c.who, register_cloud(surface, c.cloud, kIcpIterations, kIcpReachMm).error_mm});
  }
  return curves;
}

std::string icp_json_of(const std::vector<IcpCurve>& curves) {
  nlohmann::ordered_json json = {
      {"schema", "im2fit.icp/1"}, {"label", "synthetic"}, {"curves", nlohmann::json::array()}};
  for (const IcpCurve& c : curves)
    json["curves"].push_back({{"method", c.method}, {"who", c.who}, {"error_mm", c.error_mm}});
  return json.dump(1) + "\n";
}

Result<std::vector<IcpCurve>> read_icp_curves(const std::string& path) {
  const auto bytes = read_file(path);
  if (!bytes) return bytes.error();
  const auto* text = reinterpret_cast<const char*>(bytes->data());
  const auto json = nlohmann::json::parse(text, text + bytes->size(), nullptr, false);
  const Error foreign{ErrorCode::corrupt, path + ": expected im2fit.icp/1 as references_bench icp writes it"};
  if (!json.is_object() || json.value("schema", "") != "im2fit.icp/1" || !json.contains("curves")) return foreign;
  std::vector<IcpCurve> curves;
  for (const auto& c : json["curves"]) {
    if (!c.is_object() || !c.contains("method") || !c["method"].is_string() || !c.contains("who") ||
        !c["who"].is_string() || !c.contains("error_mm") || !c["error_mm"].is_array())
      return foreign;
    IcpCurve curve{c["method"], c["who"], {}};
    for (const auto& value : c["error_mm"]) {
      if (!value.is_number()) return foreign;
      curve.error_mm.push_back(value);
    }
    curves.push_back(std::move(curve));
  }
  return curves;
}

}  // namespace im2fit::lab
