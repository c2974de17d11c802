// SPDX-License-Identifier: Apache-2.0
// Our cloth beside Jolt Physics: the same mesh, masses, stiffnesses, body and beginning, one thread, in turns.
//   cloth_references BODY.i2b [--picture FILE.png] [--runs 5]
// A T-shirt begins kAwayMm off a median man's skin and falls onto it for kFrames frames of 1/30 s; the man stands.
// Jolt's soft bodies take a frame in substeps as ours do, so that equal numbers of them do equal work.

// clang-format off
#include <Jolt/Jolt.h>  // before all other files of Jolt
// clang-format on
#include <Jolt/Core/Factory.h>
#include <Jolt/Core/JobSystemSingleThreaded.h>
#include <Jolt/Core/TempAllocator.h>
#include <Jolt/Physics/Body/BodyCreationSettings.h>
#include <Jolt/Physics/Collision/Shape/MeshShape.h>
#include <Jolt/Physics/PhysicsSystem.h>
#include <Jolt/Physics/SoftBody/SoftBodyCreationSettings.h>
#include <Jolt/Physics/SoftBody/SoftBodyMotionProperties.h>
#include <Jolt/RegisterTypes.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "core/file.h"
#include "evaluation/garment/drape_quality.h"
#include "garment/drape/outfit.h"
#include "report/dressed_picture.h"
#include "train/common/stopwatch.h"
#include "train/dressed/dressed_people.h"

namespace im2fit::bench {
namespace {

constexpr int kFrames = 60;
constexpr float kAwayMm = 15;
constexpr float kMetre = 1000;                                 // mm
constexpr std::array<int, 4> kJoltSubsteps = {5, 16, 32, 64};  // 5: Jolt's own default, 16: ours

struct Scene {
  const body::Outfit& outfit;
  const body::Fabric& fabric;
  std::vector<Vec3f> begin;

  const body::Cloth& cloth() const { return outfit.cloth(0); }
  const body::GarmentMesh& mesh() const { return cloth().mesh(); }
};

struct Fallen {
  std::string who;
  int substeps = 0;
  std::vector<double> frame_ms;  // of each run, the mean of its frames
  std::vector<Vec3f> places;     // in the end
};

struct Judged {
  double strain_mean = 0, strain_p95 = 0, strain_peak = 0;
  lab::Inside inside;
};
Judged judge(const Scene& scene, const std::vector<Vec3f>& places) {
  const auto& constraints = scene.cloth().constraints();
  std::vector<double> strain;
  for (std::size_t i = 0; i < constraints.edges.size(); ++i) {
    const auto [a, b] = constraints.edges[i];
    const Vec3f edge = places[static_cast<std::size_t>(b)] - places[static_cast<std::size_t>(a)];
    strain.push_back(std::max(0.0, std::sqrt(static_cast<double>(dot(edge, edge))) / constraints.edge_mm[i] - 1));
  }
  std::sort(strain.begin(), strain.end());
  Judged out;
  for (const double s : strain) out.strain_mean += s / static_cast<double>(strain.size());
  out.strain_p95 = strain[strain.size() * 95 / 100];
  out.strain_peak = strain.back();
  out.inside = lab::judge_inside(scene.outfit.skin(), scene.cloth(), places);
  return out;
}

double run_ours(const Scene& scene, std::vector<Vec3f>& places) {
  body::Cloth cloth(scene.mesh(), scene.fabric);
  cloth.place(scene.begin);
  lab::Stopwatch watch;
  for (int i = 0; i < kFrames; ++i) cloth.run(scene.outfit.skin(), {});
  const double ms = 1e3 * watch.lap() / kFrames;
  places = lab::positions_of(cloth);
  return ms;
}

// --- Jolt ----------------------------------------------------------------------------------------------------------

constexpr JPH::ObjectLayer kBodyLayer = 0, kClothLayer = 1;

class Layers final : public JPH::BroadPhaseLayerInterface {
 public:
  JPH::uint GetNumBroadPhaseLayers() const override { return 2; }
  JPH::BroadPhaseLayer GetBroadPhaseLayer(JPH::ObjectLayer layer) const override {
    return JPH::BroadPhaseLayer(static_cast<JPH::BroadPhaseLayer::Type>(layer));
  }
#if defined(JPH_EXTERNAL_PROFILE) || defined(JPH_PROFILE_ENABLED)
  const char* GetBroadPhaseLayerName(JPH::BroadPhaseLayer) const override {
    return "layer";
  }
#endif
};
class WithBroadPhase final : public JPH::ObjectVsBroadPhaseLayerFilter {
 public:
  bool ShouldCollide(JPH::ObjectLayer, JPH::BroadPhaseLayer) const override { return true; }
};
class WithEachOther final : public JPH::ObjectLayerPairFilter {
 public:
  bool ShouldCollide(JPH::ObjectLayer a, JPH::ObjectLayer b) const override { return a != b; }
};

JPH::Float3 metres(Vec3f p) {
  return {p.x / kMetre, p.y / kMetre, p.z / kMetre};
}

JPH::ShapeRefC shape_of(const body::BodySurface& skin) {
  JPH::VertexList vertices;
  for (const Vec3f& p : skin.position(true)) vertices.push_back(metres(p));
  JPH::IndexedTriangleList triangles;
  for (const auto& t : skin.triangles())
    triangles.push_back(JPH::IndexedTriangle(static_cast<JPH::uint32>(t[0]), static_cast<JPH::uint32>(t[1]),
                                             static_cast<JPH::uint32>(t[2])));
  const auto made = JPH::MeshShapeSettings(std::move(vertices), std::move(triangles)).Create();
  if (made.HasError()) {
    std::fprintf(stderr, "cloth_references: %s\n", made.GetError().c_str());
    return nullptr;
  }
  return made.Get();
}

// Lengths, masses, stretching along warp and weft and bending are those of our own constraints
// (cloth_constraints.cpp), without what sewing adds to hems, bands and seams.
JPH::Ref<JPH::SoftBodySharedSettings> shared_settings(const Scene& scene) {
  const body::GarmentMesh& mesh = scene.mesh();
  const body::Fabric& fabric = scene.fabric;
  const auto length = [&](std::int32_t a, std::int32_t b) {
    return mesh.length_mm(static_cast<std::size_t>(a), static_cast<std::size_t>(b)) / kMetre;
  };
  const auto area = [&](std::int32_t a, std::int32_t b, std::int32_t c) {
    const float x = length(a, b), y = length(b, c), z = length(c, a), half = (x + y + z) / 2;
    return std::sqrt(std::max(0.0F, half * (half - x) * (half - y) * (half - z)));
  };
  std::vector<float> mass_kg(mesh.vertex_count(), 0);
  for (const auto& t : mesh.triangles)
    for (const std::int32_t v : t)
      mass_kg[static_cast<std::size_t>(v)] += fabric.weight_g_m2 * 1e-3F * area(t[0], t[1], t[2]) / 3;

  JPH::Ref<JPH::SoftBodySharedSettings> settings = new JPH::SoftBodySharedSettings;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
    settings->mVertices.push_back(
        JPH::SoftBodySharedSettings::Vertex(metres(scene.begin[v]), JPH::Float3(0, 0, 0), 1 / mass_kg[v]));
  std::vector<std::array<std::int32_t, 3>> sides;  // low, high, opposite
  for (const auto& t : mesh.triangles) {
    settings->AddFace(JPH::SoftBodySharedSettings::Face(
        static_cast<JPH::uint32>(t[0]), static_cast<JPH::uint32>(t[1]), static_cast<JPH::uint32>(t[2])));
    for (std::size_t k = 0; k < 3; ++k)
      sides.push_back({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3]), t[(k + 2) % 3]});
  }
  for (const auto& [a, b] : scene.cloth().constraints().edges) {
    const body::Flat from = mesh.flat[static_cast<std::size_t>(a)], to = mesh.flat[static_cast<std::size_t>(b)];
    const float dx = to.x - from.x, dy = to.y - from.y, drawn = dx * dx + dy * dy;
    const float warp = drawn > 0 ? dy * dy / drawn : 0;
    const float stiffness_n_m = warp * fabric.stretch_warp_n_m + (1 - warp) * fabric.stretch_weft_n_m;
    JPH::SoftBodySharedSettings::Edge edge(static_cast<JPH::uint32>(a), static_cast<JPH::uint32>(b),
                                           1 / stiffness_n_m);
    edge.mRestLength = length(a, b);
    settings->mEdgeConstraints.push_back(edge);
  }
  // A hinge's energy is 3 B e² angle² / (A + A') / 2 (Grinspun et al. 2003).
  std::sort(sides.begin(), sides.end());
  for (std::size_t i = 0; i + 1 < sides.size(); ++i) {
    const auto &one = sides[i], &other = sides[i + 1];
    if (one[0] != other[0] || one[1] != other[1]) continue;
    const float e = length(one[0], one[1]);
    const float areas = area(one[0], one[1], one[2]) + area(other[0], other[1], other[2]);
    const float stiffness = 3 * body::kWeightShare * fabric.bending_un_m * 1e-6F * e * e / areas;
    settings->mDihedralBendConstraints.push_back(JPH::SoftBodySharedSettings::DihedralBend(
        static_cast<JPH::uint32>(one[0]), static_cast<JPH::uint32>(one[1]), static_cast<JPH::uint32>(one[2]),
        static_cast<JPH::uint32>(other[2]), 1 / stiffness));
  }
  settings->Optimize();  // mInitialAngle stays 0: cloth is flat at rest
  return settings;
}

double run_jolt(const Scene& scene, const JPH::ShapeRefC& skin, const JPH::SoftBodySharedSettings* settings,
                int substeps, std::vector<Vec3f>& places) {
  Layers layers;
  WithBroadPhase with_broad_phase;
  WithEachOther with_each_other;
  JPH::PhysicsSystem system;
  system.Init(2, 0, 16, 16, layers, with_broad_phase, with_each_other);
  JPH::TempAllocatorImpl memory(64 << 20);
  JPH::JobSystemSingleThreaded jobs(JPH::cMaxPhysicsJobs);
  JPH::BodyInterface& bodies = system.GetBodyInterface();
  bodies.CreateAndAddBody(JPH::BodyCreationSettings(skin, JPH::RVec3::sZero(), JPH::Quat::sIdentity(),
                                                    JPH::EMotionType::Static, kBodyLayer),
                          JPH::EActivation::DontActivate);
  JPH::SoftBodyCreationSettings soft(settings, JPH::RVec3::sZero(), JPH::Quat::sIdentity(), kClothLayer);
  soft.mNumIterations = static_cast<JPH::uint32>(substeps);
  soft.mLinearDamping = body::ClothFrame{}.damping_per_s;
  soft.mFriction = scene.fabric.friction;
  soft.mGravityFactor = body::kWeightShare;
  soft.mVertexRadius = body::Cloth::kSkinMm / kMetre;
  soft.mUpdatePosition = false;
  soft.mAllowSleeping = false;
  const JPH::BodyID cloth = bodies.CreateAndAddSoftBody(soft, JPH::EActivation::Activate);
  system.OptimizeBroadPhase();
  lab::Stopwatch watch;
  for (int i = 0; i < kFrames; ++i) system.Update(1.0F / 30, 1, &memory, &jobs);
  const double ms = 1e3 * watch.lap() / kFrames;
  const JPH::BodyLockRead lock(system.GetBodyLockInterface(), cloth);
  const auto* motion = static_cast<const JPH::SoftBodyMotionProperties*>(lock.GetBody().GetMotionProperties());
  places.clear();
  for (const auto& v : motion->GetVertices())
    places.push_back({v.mPosition.GetX() * kMetre, v.mPosition.GetY() * kMetre, v.mPosition.GetZ() * kMetre});
  return ms;
}

// --- Both ----------------------------------------------------------------------------------------------------------

std::vector<Vec3f> normals_of(const body::GarmentMesh& mesh, const std::vector<Vec3f>& places) {
  std::vector<Vec3f> out(places.size());
  for (const auto& t : mesh.triangles) {
    const auto a = static_cast<std::size_t>(t[0]), b = static_cast<std::size_t>(t[1]),
               c = static_cast<std::size_t>(t[2]);
    const Vec3f n = cross(places[b] - places[a], places[c] - places[a]);
    for (const std::size_t v : {a, b, c}) out[v] = out[v] + n;
  }
  for (Vec3f& n : out) n = normalized(n);
  return out;
}

bool draw(const Scene& scene, const std::vector<Fallen>& all, const std::string& path) {
  constexpr std::array<PictureView, 2> kViews = {kFrontView, kBackView};
  constexpr float kMarginMm = 80;
  const auto [low, high] = std::minmax_element(scene.begin.begin(), scene.begin.end(),
                                               [](const Vec3f& a, const Vec3f& b) { return a.y < b.y; });
  PictureFrame frame;
  frame.width = 240;
  frame.height = 290;
  frame.low_mm = low->y - kMarginMm;
  frame.high_mm = high->y + kMarginMm;
  frame.middle_z_mm = scene.outfit.body()[0].z;
  const body::BodySurface& skin = scene.outfit.skin();
  Canvas sheet(frame.width * static_cast<int>(all.size()), 2 * frame.height);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto normals = normals_of(scene.mesh(), all[i].places);
    const std::array<PictureMesh, 2> meshes = {
        PictureMesh{skin.position(true), skin.normal(true), skin.triangles(), {0.60F, 0.40F, 0.30F}, {}, {}},
        PictureMesh{all[i].places, normals, scene.mesh().triangles, {0.15F, 0.30F, 0.55F}, {}, {}, true}};
    const Canvas views = draw_meshes(meshes, kViews, frame);
    const int left = static_cast<int>(i) * frame.width;
    for (int y = 0; y < sheet.height(); ++y)
      for (int x = 0; x < frame.width; ++x)
        sheet.set(left + x, y, views.at(y < frame.height ? x : frame.width + x, y % frame.height));
  }
  const auto png = sheet.png();
  return png && write_file_atomically(path, *png);
}

int compare(const std::string& body_path, const std::string& picture, int runs) {
  const auto model = body::BodyModel::load(body_path);
  if (!model) {
    std::fprintf(stderr, "cloth_references: %s\n", model.error().message.c_str());
    return 1;
  }
  const auto people = lab::example_people(*model);
  const auto man = std::find_if(people.begin(), people.end(),
                                [](const lab::DressedPerson& person) { return person.name == "median-man"; });
  body::Outfit outfit(*model, lab::pieces_for(*man, {"t_shirt"}));
  const body::Pose pose = lab::dressed_poses(*model, *man)[0].pose;
  outfit.dress(man->rest, man->skeleton, pose);
  for (int i = 0; i < 2; ++i) outfit.frame(pose);  // the skin stands
  const Wardrobe& wardrobe = builtin_wardrobe();
  Scene scene{outfit, *wardrobe.fabric(wardrobe.garment("t_shirt")->fabric), {}};
  const auto normals = normals_of(scene.mesh(), lab::positions_of(scene.cloth()));
  for (std::size_t v = 0; v < normals.size(); ++v)
    scene.begin.push_back(scene.cloth().position(v) + normals[v] * kAwayMm);

  JPH::RegisterDefaultAllocator();
  const auto factory = std::make_unique<JPH::Factory>();
  JPH::Factory::sInstance = factory.get();
  JPH::RegisterTypes();
  const JPH::ShapeRefC skin = shape_of(outfit.skin());
  if (skin == nullptr) return 1;
  const auto settings = shared_settings(scene);

  std::vector<Fallen> all = {{"ours", body::Cloth::kSubsteps, {}, {}}};
  for (const int substeps : kJoltSubsteps) all.push_back({"Jolt", substeps, {}, {}});
  for (int run = 0; run < runs; ++run)
    for (Fallen& one : all)
      one.frame_ms.push_back(one.who == "ours" ? run_ours(scene, one.places)
                                               : run_jolt(scene, skin, settings, one.substeps, one.places));
  std::printf("%zu vertices, %d frames, %d runs in turns, one thread, processor time\n", scene.mesh().vertex_count(),
              kFrames, runs);
  std::printf("| | substeps | ms a frame | of ours | strain mean | p95 | peak | inside, deepest |\n");
  std::printf("|---|---:|---:|---:|---:|---:|---:|---:|\n");
  for (const Fallen& one : all) {
    std::vector<double> ratio;
    for (std::size_t run = 0; run < one.frame_ms.size(); ++run)
      ratio.push_back(one.frame_ms[run] / all[0].frame_ms[run]);
    const auto [least, most] = std::minmax_element(ratio.begin(), ratio.end());
    const auto [fast, slow] = std::minmax_element(one.frame_ms.begin(), one.frame_ms.end());
    const Judged q = judge(scene, one.places);
    std::printf("| %s | %d | %.1f to %.1f | %.2f to %.2f | %.2f %% | %.1f %% | %.0f %% | %.2f %%, %.1f mm |\n",
                one.who.c_str(), one.substeps, *fast, *slow, *least, *most, 100 * q.strain_mean, 100 * q.strain_p95,
                100 * q.strain_peak, 100.0 * q.inside.share, q.inside.deepest_mm);
  }
  JPH::UnregisterTypes();
  JPH::Factory::sInstance = nullptr;
  if (!picture.empty() && !draw(scene, all, picture)) {
    std::fprintf(stderr, "cloth_references: %s cannot be written\n", picture.c_str());
    return 1;
  }
  return 0;
}

}  // namespace
}  // namespace im2fit::bench

int main(int argc, char** argv) {
  CLI::App app("A falling T-shirt, ours beside Jolt Physics");
  std::string body, picture;
  int runs = 5;
  app.add_option("body", body, "body file (.i2b)")->required();
  app.add_option("--picture", picture, "what each came to, a column each, front and back, as PNG");
  app.add_option("--runs", runs, "of each, in turns")->check(CLI::Range(1, 100));
  CLI11_PARSE(app, argc, argv);
  return im2fit::bench::compare(body, picture, runs);
}
