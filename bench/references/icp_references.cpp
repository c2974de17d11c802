// SPDX-License-Identifier: Apache-2.0
// The paper's last figure with PCL beside us: the same people's fused depth against the same retrieved bodies, the
// same error after each iteration.
//   references_bench icp --out FILE [--people 4] [--condition noise] [--body FILE] [--joint-model FILE] [--index
//   FILE]
// `im2fit-lab eval --icp-references FILE` draws it.
#include <pcl/point_types.h>
#include <pcl/registration/icp.h>

#include <CLI/CLI.hpp>
#include <cstdio>

#include "apps/common/paths.h"
#include "bench/references/reference.h"
#include "core/file.h"
#include "evaluation/measurements/conditions.h"
#include "evaluation/measurements/icp.h"
#include "person/data_files.h"

namespace im2fit::bench {
namespace {

using lab::Cloud;
using PclCloud = pcl::PointCloud<pcl::PointXYZ>;

PclCloud::Ptr pcl_cloud_of(const Cloud& points) {
  PclCloud::Ptr cloud(new PclCloud);
  for (const Eigen::Vector3d& p : points)
    cloud->push_back({static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())});
  return cloud;
}

// pcl::IterativeClosestPoint, as the paper had it: point to point, onto the body's vertices, an iteration at a time
// so that each can be judged by the same distances as ours.
std::vector<double> pcl_errors(const lab::MeshSurface& surface, const lab::IcpCase& its, std::size_t body_vertices) {
  PclCloud::Ptr body(new PclCloud);
  for (std::size_t i = 0; i < body_vertices; ++i)
    body->push_back({its.vertices[i].x, its.vertices[i].y, its.vertices[i].z});
  pcl::IterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> icp;
  icp.setInputSource(pcl_cloud_of(its.cloud));
  icp.setInputTarget(body);
  icp.setMaxCorrespondenceDistance(lab::kIcpReachMm);
  icp.setMaximumIterations(1);
  Eigen::Matrix4f motion = Eigen::Matrix4f::Identity();
  std::vector<double> errors;
  for (int i = 0; i <= lab::kIcpIterations; ++i) {
    Eigen::Isometry3d so_far(motion.cast<double>());
    errors.push_back(lab::mean_distance_mm(surface, its.cloud, so_far));
    PclCloud moved;
    icp.align(moved, motion);
    motion = icp.getFinalTransformation();
  }
  return errors;
}

struct Options {
  std::string out, condition = "noise";
  int people = 4;
  std::string body = made_body_path(), joint_model = made_tracker_path(), index = made_index_path();
};

Result<std::vector<lab::IcpCurve>> measure(const Options& options) {
  const auto condition = lab::condition_of(options.condition, {});
  if (!condition) return condition.error();
  const auto body = load_body(options.body);
  if (!body) return body.error();
  const auto tracker = Tracker::load(options.joint_model);
  if (!tracker) return tracker.error();
  const auto index = load_index(options.index);
  if (!index) return index.error();
  const auto cases = lab::icp_cases({*body, tracker->model(), *index}, condition->options, options.people);
  if (!cases) return cases.error();
  std::vector<lab::IcpCurve> curves = lab::icp_curves(*body, *cases);
  for (const lab::IcpCase& its : *cases) {
    const lab::MeshSurface surface(its.vertices, body->body_triangles());
    curves.push_back({"PCL " PCL_VERSION_PRETTY ", point to point", its.who,
                      pcl_errors(surface, its, static_cast<std::size_t>(body->body_vertex_count()))});
  }
  return curves;
}

}  // namespace

int icp_references(int argc, char** argv) {
  Options options;
  CLI::App app{"ICP of depth and retrieved body: ours beside PCL's", "references_bench icp"};
  app.add_option("--out", options.out, "JSON to write, for im2fit-lab eval --icp-references")->required();
  app.add_option("--people", options.people)->check(CLI::Range(1, 100))->capture_default_str();
  app.add_option("--condition", options.condition)->capture_default_str();
  app.add_option("--body", options.body)->capture_default_str();
  app.add_option("--joint-model", options.joint_model)->capture_default_str();
  app.add_option("--index", options.index)->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  const auto curves = measure(options);
  const auto written =
      curves ? write_file_atomically(options.out, lab::icp_json_of(*curves)) : Status(curves.error());
  if (!written) {
    std::fprintf(stderr, "references_bench: %s\n", written.error().message.c_str());
    return 1;
  }
  for (const auto& curve : *curves)
    std::printf("%-32s %-26s %6.1f mm, then %6.1f mm\n", curve.method.c_str(), curve.who.c_str(),
                curve.error_mm.front(), curve.error_mm.back());
  return 0;
}

}  // namespace im2fit::bench
