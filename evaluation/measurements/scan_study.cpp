// SPDX-License-Identifier: Apache-2.0
#include "evaluation/measurements/scan_study.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>
#include <utility>

#include "body/measure.h"
#include "body/model_data.h"
#include "core/file.h"
#include "core/rng.h"
#include "engine/engine.h"
#include "evaluation/measurements/error_statistics.h"
#include "evaluation/population/other_tape.h"
#include "hal/scan/scan_source.h"
#include "person/person_measurement.h"
#include "train/camera/virtual_camera.h"
#include "train/common/parallel.h"

namespace im2fit::lab {
namespace {

constexpr std::uint64_t kScanStream = 0x5CA9;

constexpr Measurement kLevels[] = {Measurement::chest_girth, Measurement::waist_girth, Measurement::hip_girth};

using Surface = VirtualScene::Surface;

struct ScanUnit {
  const char* name;
  double mm;
};
constexpr ScanUnit kScanUnits[] = {{"mm", 1}, {"cm", 10}, {"m", 1000}, {"inch", 25.4}};
// How y up, z front is written, from right-handed axes to such.
struct ScanUp {
  const char* name;
  Vec3f (*turned)(Vec3f);
};
constexpr ScanUp kScanUps[] = {{"y", [](Vec3f p) { return p; }},
                               {"z",
                                [](Vec3f p) {
                                  return Vec3f{p.x, -p.z, p.y};
                                }},
                               {"x", [](Vec3f p) {
                                  return Vec3f{p.y, -p.x, p.z};
                                }}};

// In mm, y up, the lowest point at 0.
Surface standing_surface(const body::BodyModel& model, const HeldOutPerson& person) {
  SceneOptions options = person.capture.scene;
  options.pitch_deg = 0;
  options.rotate_deg = 0;
  options.sway = false;
  const VirtualScene scene(model, person.subject, options, person.capture.sensor, person.capture.intrinsics,
                           person.capture.seed);
  Surface surface = scene.person_surface(0);
  float low = std::numeric_limits<float>::max();
  for (Vec3f& p : surface.vertices) {
    p = {p.x, -p.y, -p.z};
    low = std::min(low, p.y);
  }
  for (Vec3f& p : surface.vertices) p.y -= low;
  return surface;
}

void add_noise(Surface& surface, float sd_mm, Rng& rng) {
  std::vector<Vec3f> normals(surface.vertices.size());
  for (const Triangle& t : surface.triangles) {
    std::array<std::size_t, 3> corner{};
    for (std::size_t i = 0; i < 3; ++i) corner[i] = static_cast<std::size_t>(t[i]);
    const Vec3f a = surface.vertices[corner[0]];
    const Vec3f normal = cross(surface.vertices[corner[1]] - a, surface.vertices[corner[2]] - a);
    for (const std::size_t v : corner) normals[v] = normals[v] + normal;
  }
  for (std::size_t v = 0; v < normals.size(); ++v)
    surface.vertices[v] = surface.vertices[v] + normalized(normals[v]) * (sd_mm * static_cast<float>(rng.normal()));
}

void cut_holes(Surface& surface, int count, Rng& rng) {
  for (int i = 0; i < count; ++i) {
    const auto vertices = static_cast<double>(surface.vertices.size());
    const Vec3f middle = surface.vertices[static_cast<std::size_t>(rng.uniform(0, 0.999999) * vertices)];
    const auto radius = static_cast<float>(rng.uniform(25, 50));
    std::erase_if(surface.triangles, [&](const Triangle& t) {
      return norm(surface.vertices[static_cast<std::size_t>(t[0])] - middle) < radius;
    });
  }
}

void put_number(std::string& out, std::uint32_t bits) {
  for (int shift = 0; shift < 32; shift += 8) out += static_cast<char>(bits >> shift & 0xFFU);
}

std::string ply_text(const Surface& surface) {
  std::string out = fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float "
      "z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
      surface.vertices.size(), surface.triangles.size());
  for (const Vec3f p : surface.vertices)
    for (const float value : {p.x, p.y, p.z}) put_number(out, std::bit_cast<std::uint32_t>(value));
  for (const Triangle& t : surface.triangles) {
    out += '\3';
    for (std::size_t i = 0; i < 3; ++i) put_number(out, static_cast<std::uint32_t>(t[i]));
  }
  return out;
}

std::string obj_text(const Surface& surface) {
  std::string out = "o scan\n";
  for (const Vec3f p : surface.vertices) out += fmt::format("v {:.6g} {:.6g} {:.6g}\n", p.x, p.y, p.z);
  for (const Triangle& t : surface.triangles) out += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  return out;
}

class ScanStudy {
 public:
  ScanStudy(const body::BodyModel& model, const JointModel& joint_model, const index::Index& index,
            const ScanStudyOptions& options, std::string folder)
      : model_(model), joint_model_(joint_model), index_(index), options_(options), folder_(std::move(folder)) {}

  Result<ScanOutcome> run(std::uint64_t index) const {
    const HeldOutPerson person = draw_person(model_, options_.people, index);
    ScanOutcome outcome;
    outcome.truth = person.subject.truth;
    for (auto* values : {&outcome.values, &outcome.low, &outcome.high})
      values->fill(std::numeric_limits<float>::quiet_NaN());
    outcome.at_true_level_mm.fill(std::numeric_limits<float>::quiet_NaN());
    outcome.of_scan_mm.fill(std::numeric_limits<float>::quiet_NaN());
    const Levels levels = true_levels(person);
    if (auto ok = write(person, index, levels, outcome); !ok) return ok.error();
    if (auto ok = measure(levels, outcome); !ok) outcome.problem = ok.error().message;
    return outcome;
  }

 private:
  using Levels = std::array<float, 3>;  // of chest, waist and hip, above the floor, mm

  Status write(const HeldOutPerson& person, std::uint64_t index, const Levels& levels, ScanOutcome& outcome) const {
    Rng rng = Rng::for_item(options_.people.seed, kScanStream, index);
    Surface surface = standing_surface(model_, person);
    compare_scan(surface, person.subject.actor != nullptr, levels, outcome);
    add_noise(surface, options_.noise_mm, rng);
    cut_holes(surface, options_.holes, rng);
    // Every unit and axis comes with every other within twelve people.
    const ScanUnit& unit = kScanUnits[index % std::size(kScanUnits)];
    const ScanUp& up = kScanUps[index % std::size(kScanUps)];
    const double yaw = rng.uniform(0, 2 * std::numbers::pi);
    const auto s = static_cast<float>(std::sin(yaw)), c = static_cast<float>(std::cos(yaw));
    for (Vec3f& p : surface.vertices)
      p = up.turned({c * p.x + s * p.z, p.y, c * p.z - s * p.x}) * static_cast<float>(1 / unit.mm);
    const bool ply = index / 2 % 2 == 0;
    outcome.unit = unit.name;
    outcome.up = up.name;
    outcome.file = fmt::format("{}/scan_{:03}.{}", folder_, index, ply ? "ply" : "obj");
    return write_file_atomically(outcome.file, ply ? ply_text(surface) : obj_text(surface));
  }

  // Without the arms: those of the body model's mesh are known; those of an actor are far from waist and hip.
  void compare_scan(const Surface& surface, bool actor, const Levels& levels, ScanOutcome& outcome) const {
    constexpr float kBetweenArmsMm = 300;
    double middle = 0;
    for (const Vec3f p : surface.vertices) middle += static_cast<double>(p.x);
    const auto axis = static_cast<float>(middle / static_cast<double>(surface.vertices.size()));
    const auto& is_arm = model_.data().triangle_is_arm;
    std::vector<std::uint8_t> trunk;
    for (std::size_t i = 0; i < surface.triangles.size(); ++i) {
      const Vec3f corner = surface.vertices[static_cast<std::size_t>(surface.triangles[i][0])];
      const bool arm = actor ? std::fabs(corner.x - axis) >= kBetweenArmsMm : i < is_arm.size() && is_arm[i] != 0;
      trunk.push_back(arm ? 0 : 1);
    }
    for (std::size_t l = 1; l < levels.size(); ++l) {
      const double girth = tape_round(surface.vertices, surface.triangles, trunk, {0, levels[l], 0}, {0, 1, 0});
      if (girth > 0)
        outcome.of_scan_mm[l - 1] = static_cast<float>(girth) - outcome.truth[measurement_index(kLevels[l])];
    }
  }

  Status measure(const Levels& levels, ScanOutcome& outcome) const {
    auto source = hal::open_scan(outcome.file);
    if (!source) return source.error();
    outcome.found = (*source)->info().name.substr(outcome.file.size());
    EngineSettings settings;
    settings.intrinsics = (*source)->info().intrinsics;
    settings.width = settings.intrinsics.width;
    settings.height = settings.intrinsics.height;
    settings.turn = Turn::walk;
    settings.clothing = ClothingGiven::bare;
    settings.body = &model_;
    settings.shape_space = &model_.shape_space();
    settings.single_thread = true;
    auto engine = Engine::create(settings, joint_model_, index_);
    if (!engine) return engine.error();
    if (auto ok = im2fit::run(**engine, **source, true); !ok) return ok;
    const auto result = measurement_of(**engine, {&index_, &model_}, (*source)->info());
    if (!result) return result.error();
    outcome.measured = result->result.measured;
    outcome.around = result->result.views == AnswerViews::around;
    outcome.turned_deg = result->result.turned_deg;
    if (!outcome.measured) return Error{ErrorCode::not_found, "no person was measured"};
    for (std::size_t m = 0; m < kMeasurementCount; ++m) {
      const index::IntervalEstimate& estimate = result->result.answer.measurements[m];
      outcome.values[m] = estimate.value;
      outcome.low[m] = estimate.low;
      outcome.high[m] = estimate.high;
    }
    if (result->body) compare_levels(levels, result->body->params, outcome);
    return Ok{};
  }

  static float height_above(float low, const body::Measurer& measurer, Measurement id) {
    for (const body::Section& section : measurer.sections())
      if (section.id == id && !section.hull.empty()) return section.hull.front().y - low;
    return std::numeric_limits<float>::quiet_NaN();
  }
  float floor_of(const body::Measurer& measurer) const {
    const auto vertices = measurer.posed().first(static_cast<std::size_t>(model_.body_vertex_count()));
    return std::min_element(vertices.begin(), vertices.end(), [](Vec3f a, Vec3f b) { return a.y < b.y; })->y;
  }

  Levels true_levels(const HeldOutPerson& person) const {
    if (person.subject.actor != nullptr) {
      const ActorLevels levels = levels_of(*person.subject.actor, options_.people.other->rig().parts);
      return {levels.chest, levels.waist, levels.hip};
    }
    body::Measurer measurer(model_);
    std::vector<Vec3f> rest(static_cast<std::size_t>(model_.vertex_count()));
    morph_subject(model_, person.subject, rest);
    measurer.measure_rest_mesh(rest, person.subject.params.gender);
    Levels levels{};
    for (std::size_t l = 0; l < levels.size(); ++l)
      levels[l] = height_above(floor_of(measurer), measurer, kLevels[l]);
    return levels;
  }

  void compare_levels(const Levels& heights, const body::Params& answered, ScanOutcome& outcome) const {
    body::Measurer measurer(model_);
    measurer.measure(answered);
    std::vector<std::uint8_t> trunk;
    for (const std::uint8_t arm : model_.data().triangle_is_arm) trunk.push_back(arm == 0 ? 1 : 0);
    for (std::size_t l = 0; l < heights.size(); ++l) {
      const double girth = tape_round(measurer.posed(), model_.body_triangles(), trunk,
                                      {0, floor_of(measurer) + heights[l], 0}, {0, 1, 0});
      if (girth > 0)
        outcome.at_true_level_mm[l] = static_cast<float>(girth) - outcome.truth[measurement_index(kLevels[l])];
    }
  }

  const body::BodyModel& model_;
  const JointModel& joint_model_;
  const index::Index& index_;
  const ScanStudyOptions& options_;
  std::string folder_;
};

}  // namespace

Result<std::vector<ScanOutcome>> study_scans(const body::BodyModel& model, const JointModel& joint_model,
                                             const index::Index& index, const ScanStudyOptions& options) {
  const bool keeps = !options.keep_folder.empty();
  const std::string folder =
      keeps ? options.keep_folder
            : (std::filesystem::temp_directory_path() / ("im2fit-scans-" + std::to_string(::getpid()))).string();
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  if (failed) return Error{ErrorCode::io, "cannot make " + folder + ": " + failed.message()};
  const auto count = static_cast<std::uint64_t>(options.people.subjects);
  std::vector<Result<ScanOutcome>> results(count, Result<ScanOutcome>(ScanOutcome{}));
  const ScanStudy study(model, joint_model, index, options, folder);
  for_each_item(
      count, options.people.threads, [&](std::uint64_t i) { results[i] = study.run(i); },
      begin_progress(options.people.progress, "scans", count));
  if (!keeps) std::filesystem::remove_all(folder, failed);
  std::vector<ScanOutcome> outcomes;
  for (auto& result : results) {
    if (!result) return result.error();
    outcomes.push_back(std::move(*result));
  }
  return outcomes;
}

std::string text_of(const std::vector<ScanOutcome>& outcomes) {
  std::string text;
  int measured = 0, around = 0;
  for (const ScanOutcome& o : outcomes) {
    measured += o.measured ? 1 : 0;
    around += o.around ? 1 : 0;
    text += fmt::format("{} ({}, {} up):{}{}", std::filesystem::path(o.file).filename().string(), o.unit, o.up,
                        o.found, o.problem.empty() ? "" : " " + o.problem);
    if (o.measured && !o.around) text += fmt::format(", from the front alone: followed {:.0f} degrees", o.turned_deg);
    for (const Measurement m : kLevels)
      if (o.measured) text += fmt::format(" {:+.0f}", o.values[measurement_index(m)] - o.truth[measurement_index(m)]);
    text += "\n";
  }
  text += fmt::format("{} scans, {} measured, {} of them all round\n", outcomes.size(), measured, around);
  text += "measurement                  scans    bias     MAE     max  in interval\n";
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    std::vector<double> errors;
    int held = 0;
    for (const ScanOutcome& o : outcomes) {
      if (!o.measured || !std::isfinite(o.truth[m])) continue;
      errors.push_back(static_cast<double>(o.values[m] - o.truth[m]));
      held += o.truth[m] >= o.low[m] && o.truth[m] <= o.high[m] ? 1 : 0;
    }
    const ErrorStatistics s = error_statistics(errors);
    if (s.count > 0)
      text += fmt::format("{:<27} {:>6} {:>7.1f} {:>7.1f} {:>7.1f}  {} of {}\n", kMeasurementTable[m].id, s.count,
                          s.bias, s.mae, s.max, held, s.count);
  }
  constexpr const char* kLevelNames[] = {"chest", "waist", "hip"};
  const auto add = [&](const std::string& what, const auto& error_of) {
    std::vector<double> errors;
    for (const ScanOutcome& o : outcomes) errors.push_back(static_cast<double>(error_of(o)));
    const ErrorStatistics s = error_statistics(errors);
    text += fmt::format("{:<27} {:>6} {:>7.1f} {:>7.1f} {:>7.1f}\n", what, s.count, s.bias, s.mae, s.max);
  };
  for (std::size_t l = 0; l < 3; ++l)
    add(fmt::format("{} at true height", kLevelNames[l]),
        [&](const ScanOutcome& o) { return o.at_true_level_mm[l]; });
  for (std::size_t l = 0; l < 2; ++l)
    add(fmt::format("{} of the scan itself", kLevelNames[l + 1]),
        [&](const ScanOutcome& o) { return o.of_scan_mm[l]; });
  return text;
}

}  // namespace im2fit::lab
