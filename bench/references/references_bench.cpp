// SPDX-License-Identifier: Apache-2.0
// Our kernels against alternatives a user could pick: the same cloud, the same run, one thread, processor time.
//   references_bench [--full] [--json FILE]
//   references_bench icp --out FILE ...        (icp_references.cpp)
// --full adds FPFH of the whole 640x480 cloud, which takes the references a minute or more each. Machines drift by a
// factor of two while this runs, so ours is timed before and after theirs and only the ratio is to be quoted.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/references/reference.h"
#include "kernels/fpfh/fpfh.h"
#include "kernels/normals/normals.h"
#include "perception/fuse/decimate.h"
#include "tests/perception/analytic_figure.h"

namespace im2fit::bench {
namespace {

constexpr Intrinsics k640 = {480, 640, 575.8F, 575.8F, 239.5F, 319.5F};
constexpr Intrinsics k320 = {240, 320, 287.9F, 287.9F, 119.5F, 159.5F};
constexpr float kDistanceMm = 2075;  // 43,000 points at 640x480
constexpr double kRadiusM = 0.2, kNormalRadiusM = 0.03, kVoxelM = 0.02;
constexpr float kMaxStepMm = 60;

struct Scene {
  explicit Scene(const Intrinsics& k)
      : name(std::to_string(k.height) + "x" + std::to_string(k.width)),
        figure(test::standing_figure(0, kDistanceMm)),
        cloud(test::render_cloud(figure, k, 2.0, 0.05, 0.02, 7)),
        exact(test::render_cloud(figure, k, 2.0, 0, 0, 7)) {
    for (std::size_t i = 0; i < cloud.x.size(); ++i) {
      const Vec3f p = Vec3f{cloud.x[i], cloud.y[i], cloud.z[i]} * 0.001F;
      organised.position_m.push_back(p);
      depth_q4.push_back(std::isnan(p.x) ? std::uint16_t{0}
                                         : static_cast<std::uint16_t>(std::lround(cloud.z[i] * 16)));
      mask.push_back(std::isnan(p.x) ? 0 : 255);
      if (std::isnan(p.x)) continue;
      points.position_m.push_back(p);
      points.normal.push_back({cloud.nx[i], cloud.ny[i], cloud.nz[i]});
      true_normal.push_back({exact.nx[i], exact.ny[i], exact.nz[i]});
    }
    for (const Vec3f& j : figure.joints.position_mm) keypoints_m.push_back(j * 0.001F);
  }
  OrganisedCloud organised_cloud() const {
    return {cloud.intrinsics, cloud.x.data(),  cloud.y.data(), cloud.z.data(),
            cloud.nx.data(),  cloud.ny.data(), cloud.nz.data()};
  }

  std::string name;
  test::Figure figure;
  test::FigureCloud cloud, exact;  // the same points; normals with errors, and without
  Points organised, points;
  std::vector<Vec3f> true_normal, keypoints_m;
  std::vector<std::uint16_t> depth_q4;
  std::vector<std::uint8_t> mask;
};

// Median over up to 15 runs, as many as half a second allows.
double median_ms(const std::function<void()>& run) {
  std::vector<double> spent;
  const double begin = cpu_ms();
  do {
    const double start = cpu_ms();
    run();
    spent.push_back(cpu_ms() - start);
  } while (spent.size() < 15 && cpu_ms() - begin < 500);
  std::nth_element(spent.begin(), spent.begin() + static_cast<std::ptrdiff_t>(spent.size() / 2), spent.end());
  return spent[spent.size() / 2];
}

double theirs_median_ms(const std::function<double()>& run) {
  std::vector<double> spent;
  double total = 0;
  do {
    spent.push_back(run());
    total += spent.back();
  } while (spent.size() < 7 && total < 500);
  std::nth_element(spent.begin(), spent.begin() + static_cast<std::ptrdiff_t>(spent.size() / 2), spent.end());
  return spent[spent.size() / 2];
}

class Report {
 public:
  void print(const std::string& what, const std::string& reference, double theirs_ms, const std::string& tier,
             double ours_ms, const std::string& note) {
    std::printf("%-34s %-14s %10.2f ms   %-9s", what.c_str(), reference.c_str(), theirs_ms, tier.c_str());
    if (ours_ms > 0)
      std::printf(" %10.3f ms %8.1fx", ours_ms, theirs_ms / ours_ms);
    else
      std::printf(" %13s %9s", "", "");
    std::printf("   %s\n", note.c_str());
    std::fflush(stdout);
    nlohmann::json row = {
        {"what", what}, {"reference", reference}, {"theirs_ms", theirs_ms}, {"tier", tier}, {"note", note}};
    if (ours_ms > 0) row.update({{"ours_ms", ours_ms}, {"ratio", theirs_ms / ours_ms}});
    rows_.push_back(row);
  }
  bool write(const char* path) const {
    std::ofstream file(path);
    file << rows_.dump(1) << '\n';
    return file.flush().good();
  }

 private:
  nlohmann::json rows_ = nlohmann::json::array();
};

// Every tier of a kernel that can run here, before and after the references; `note` judges its last answer. `run`
// calls the variant it is given.
template <class Variants, class Run>
void compare(Report& report, const std::string& what, const Variants& variants, Run run,
             const std::vector<std::pair<std::string, std::function<double()>>>& references,
             const std::function<std::string(const std::string& reference)>& note) {
  const auto measure = [&] {
    std::map<std::string, double> ms;
    for (const auto& variant : variants) {
      if (variant.tier == Tier::ref || !tier_available(variant.tier)) continue;
      ms[variant.name] = median_ms([&] { run(variant.function); });
    }
    return ms;
  };
  for (const auto& [reference, theirs] : references) {
    auto ours = measure();
    const double theirs_ms = theirs_median_ms(theirs);
    for (const auto& [tier, ms] : measure()) ours[tier] = (ours[tier] + ms) / 2;
    for (const auto& [tier, ms] : ours) report.print(what, reference, theirs_ms, tier, ms, note(reference));
  }
}

std::string l1_note(std::span<const float> ours, const std::vector<float>& theirs) {
  if (theirs.size() != ours.size()) return "describes all its points";
  double worst = 0, total = 0;
  int described = 0;
  for (std::size_t k = 0; k < kJointCount; ++k) {
    if (std::isnan(theirs[k * kFpfhSize])) continue;
    double l1 = 0;
    for (std::size_t b = k * kFpfhSize; b < (k + 1) * kFpfhSize; ++b)
      l1 += std::fabs(double{ours[b]} - double{theirs[b]});
    worst = std::max(worst, l1);
    total += l1;
    ++described;
  }
  char text[96];
  std::snprintf(text, sizeof text, "L1 of 300 at %d joints: mean %.5f, worst %.5f", described, total / described,
                worst);
  return text;
}

// Mean angle to the true normals and the share without one, towards the camera or away alike.
std::string angle_note(std::span<const Vec3f> normals, std::span<const Vec3f> truth) {
  double total = 0;
  std::size_t known = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (std::isnan(normals[i].x)) continue;
    total += std::acos(std::min(1.0, std::fabs(double{dot(normals[i], truth[i])})));
    ++known;
  }
  char text[96];
  std::snprintf(text, sizeof text, "%.1f deg mean, %.0f %% missing", total / static_cast<double>(known) * 57.29578,
                100.0 * static_cast<double>(truth.size() - known) / static_cast<double>(truth.size()));
  return text;
}

using References = std::vector<std::unique_ptr<Reference>>;
using Contenders = std::vector<std::pair<std::string, std::function<double()>>>;

void normals(Report& report, const Scene& s, const References& references) {
  const Intrinsics& k = s.cloud.intrinsics;
  const int radius_px = static_cast<int>(std::lround(kNormalRadiusM * 1000 * double{k.fx} / double{kDistanceMm}));
  const std::size_t size = s.cloud.x.size();
  std::vector<float> nx(size), ny(size), nz(size);
  std::vector<Vec3f> theirs;
  Contenders contenders;
  for (const auto& reference : references)
    contenders.push_back({reference->name(), [&] { return reference->normals(s.points, kNormalRadiusM, theirs); }});
#ifdef IM2FIT_REFERENCES_PCL
  contenders.push_back({"PCL integral", [&] {
                          std::vector<Vec3f> all;
                          const double ms = pcl_integral_normals(s.organised, k.width, k.height, all);
                          theirs.clear();
                          for (std::size_t i = 0; i < size; ++i)
                            if (s.mask[i] != 0) theirs.push_back(all[i]);
                          return ms;
                        }});
#endif
  compare(
      report, "normals, r = 3 cm, " + s.name, kNormalsKernels,
      [&](auto* function) {
        function(k, s.cloud.x.data(), s.cloud.y.data(), s.cloud.z.data(), radius_px, kMaxStepMm, nx.data(), ny.data(),
                 nz.data());
      },
      contenders,
      [&](const std::string&) {
        std::vector<Vec3f> ours;
        for (std::size_t i = 0; i < size; ++i)
          if (s.mask[i] != 0) ours.push_back({nx[i], ny[i], nz[i]});
        return "ours " + angle_note(ours, s.true_normal) + "; theirs " + angle_note(theirs, s.true_normal);
      });
}

void exact_fpfh(Report& report, const Scene& s, const References& references) {
  FpfhWorkspace work(s.cloud.intrinsics.width, s.cloud.intrinsics.height);
  std::array<float, kFpfhSize * kJointCount> ours{};
  std::vector<float> theirs;
  Contenders contenders;
  for (const auto& reference : references)
    contenders.push_back(
        {reference->name(), [&] { return reference->fpfh(s.points, s.keypoints_m, kRadiusM, theirs); }});
  compare(
      report, "exact FPFH, 15 joints, " + s.name, kFpfhKernels,
      [&](auto* function) { function(s.organised_cloud(), s.figure.joints.position_mm, kFpfhRadiusMm, work, ours); },
      contenders, [&](const std::string&) { return l1_note(ours, theirs); });
}

// Ours: the 20 mm grid of the fused depth, its normals, FPFH at the joints. Theirs: 2 cm voxels, normals, FPFH.
void device_descriptor(Report& report, const Scene& s, const References& references) {
  const int step = grid_step_px(s.cloud.intrinsics, kDistanceMm);
  const Intrinsics k = grid_intrinsics(s.cloud.intrinsics, step);
  const auto size = static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height);
  std::array<std::vector<float>, 6> plane;
  for (auto& p : plane) p.resize(size);
  FpfhWorkspace work(k.width, k.height);
  std::array<float, kFpfhSize * kJointCount> ours{};
  const Intrinsics& full = s.cloud.intrinsics;
  const auto downsample = [&] {
    decimate({s.depth_q4.data(), full.width, full.height}, {s.mask.data(), full.width, full.height}, k, step,
             plane[0], plane[1], plane[2]);
  };
  const auto describe = [&](auto* function) {
    const OrganisedCloud cloud = {
        k, plane[0].data(), plane[1].data(), plane[2].data(), plane[3].data(), plane[4].data(), plane[5].data()};
    function(cloud, s.figure.joints.position_mm, kFpfhRadiusMm, work, ours);
  };
  // The variant of the FPFH is named; grid and normals are the best of the machine.
  const auto whole = [&](auto* function) {
    downsample();
    fastest(kNormalsKernels)(k, plane[0].data(), plane[1].data(), plane[2].data(), 1, kMaxStepMm, plane[3].data(),
                             plane[4].data(), plane[5].data());
    describe(function);
  };
  Contenders all, fpfh_only, same_points;
  std::map<std::string, Points> voxels;
  Points grid_points;
  std::vector<float> out;
  whole(fastest(kFpfhKernels));
  for (std::size_t i = 0; i < size; ++i) {
    if (std::isnan(plane[0][i])) continue;
    grid_points.position_m.push_back(Vec3f{plane[0][i], plane[1][i], plane[2][i]} * 0.001F);
    grid_points.normal.push_back({plane[3][i], plane[4][i], plane[5][i]});
  }
  for (const auto& reference : references) {
    Points& own = voxels[reference->name()];
    all.push_back({reference->name(), [&] {
                     double ms = reference->voxels(s.points, kVoxelM, own);
                     ms += reference->normals(own, kNormalRadiusM, own.normal);
                     return ms + reference->fpfh(own, s.keypoints_m, kRadiusM, out);
                   }});
    fpfh_only.push_back({reference->name(), [&] { return reference->fpfh(own, s.keypoints_m, kRadiusM, out); }});
    same_points.push_back(
        {reference->name(), [&] { return reference->fpfh(grid_points, s.keypoints_m, kRadiusM, out); }});
  }
  const auto note = [&](const std::string& reference) {
    return std::to_string(grid_points.position_m.size()) + " grid points, " +
           std::to_string(voxels[reference].position_m.size()) + " voxels";
  };
  compare(report, "20 mm descriptor, " + s.name, kFpfhKernels, whole, all, note);
  compare(report, "20 mm FPFH only, " + s.name, kFpfhKernels, describe, fpfh_only, note);
  compare(report, "FPFH of our grid's points, " + s.name, kFpfhKernels, describe, same_points,
          [&](const std::string&) { return l1_note(ours, out); });

  Contenders downsamplers;
  for (const auto& reference : references)
    downsamplers.push_back(
        {reference->name(), [&] { return reference->voxels(s.points, kVoxelM, voxels[reference->name()]); }});
  for (const auto& [reference, theirs] : downsamplers) {
    const double theirs_ms = theirs_median_ms(theirs);
    report.print("20 mm grid, " + s.name, reference, theirs_ms, "best", median_ms(downsample), note(reference));
  }
}

// We register nothing: the index answers. What it would cost.
void icp(Report& report, const Scene& s, const References& references) {
  Points model;
  for (std::size_t i = 0; i < s.points.position_m.size(); i += 3)
    model.position_m.push_back(s.points.position_m[i] + Vec3f{0.01F, 0.005F, 0.015F});
  for (const auto& reference : references) {
    const double ms = theirs_median_ms([&] { return reference->icp(s.points, model, 0.05, 6); });
    report.print("ICP, 6 iterations, " + s.name, reference->name(), ms, "none", 0,
                 "we have no ICP: the index answers instead");
  }
}

int run(bool full, const char* json_path) {
  References references;
#ifdef IM2FIT_REFERENCES_PCL
  references.push_back(make_pcl());
#endif
#ifdef IM2FIT_REFERENCES_OPEN3D
  references.push_back(make_open3d());
#endif
  Report report;
  for (const Intrinsics& k : {k320, k640}) {
    const Scene scene(k);
    std::printf("%s: %zu points\n", scene.name.c_str(), scene.points.position_m.size());
    normals(report, scene, references);
    device_descriptor(report, scene, references);
    icp(report, scene, references);
    if (full || k.width < 480) exact_fpfh(report, scene, references);
  }
  if (json_path != nullptr && !report.write(json_path)) {
    std::fprintf(stderr, "references_bench: cannot write %s\n", json_path);
    return 1;
  }
  return 0;
}

}  // namespace
}  // namespace im2fit::bench

int main(int argc, char** argv) {
#ifdef IM2FIT_REFERENCES_ICP
  if (argc > 1 && std::strcmp(argv[1], "icp") == 0) return im2fit::bench::icp_references(argc - 1, argv + 1);
#endif
  bool full = false;
  const char* json_path = nullptr;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--full") == 0) {
      full = true;
    } else if (std::strcmp(argv[i], "--json") == 0 && i + 1 < argc) {
      json_path = argv[++i];
    } else {
      std::fprintf(stderr,
                   "usage: references_bench [--full] [--json FILE]\n       references_bench icp --out FILE\n");
      return 2;
    }
  }
  return im2fit::bench::run(full, json_path);
}
