// SPDX-License-Identifier: Apache-2.0
// im2fit-lab make cut-regression BODY.i2b > data/garments/bodies.yaml
// The body a size is cut for: each measure as a straight line over the chest girth, least squares over training
// people of each sex.
#include <array>
#include <cmath>
#include <cstdio>
#include <string_view>
#include <vector>

#include "apps/im2fit-lab/make/make.h"
#include "body/model_data.h"
#include "body/tape.h"
#include "garment/drape/dressing_pose.h"
#include "garment/pattern.h"
#include "person/builtin_tape.h"
#include "train/population/drawn_people.h"

namespace {

using namespace im2fit;
using namespace im2fit::body;

constexpr std::uint64_t kSeed = 0x6761;
constexpr int kPeople = 400;  // half of them women

// Of the tape, in CutMeasure's order; the rest is measured here.
constexpr std::array<const char*, 14> kTapeIds = {"chest_girth", "waist_girth", "high_hip_girth",   "hip_girth",
                                                  "thigh_girth", "knee_girth",  "calf_girth",       "upper_arm_girth",
                                                  "wrist_girth", "neck_girth",  "shoulder_breadth", "sleeve_length",
                                                  "inside_leg",  "stature"};

struct Fit {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  void add(double a, double b) {
    n += 1;
    x += a;
    y += b;
    xx += a * a;
    xy += a * b;
  }
  double slope() const { return (n * xy - x * y) / (n * xx - x * x); }
  double start() const { return (y - slope() * x) / n; }
};

// Highest skin of trunk and arms at a distance from the middle, in the dressing pose.
float top_at(const BodyModel& model, std::span<const Vec3f> posed, float x, float below) {
  float top = -1e9F;
  for (std::size_t v = 0; v < static_cast<std::size_t>(model.body_vertex_count()); ++v)
    if (std::fabs(std::fabs(posed[v].x) - x) < 10 && posed[v].y < below) top = std::max(top, posed[v].y);
  return top;
}

int run(const char* path) {
  const auto model = BodyModel::load(path);
  if (!model) {
    std::fprintf(stderr, "im2fit-lab make cut-regression: %s\n", model.error().message.c_str());
    return 1;
  }
  const Tape& tape = builtin_tape();
  TapeMeasurer measurer(*model);
  std::vector<float> values(tape.definitions.size());
  std::array<std::array<Fit, kCutMeasureCount>, 2> fits;
  std::vector<Vec3f> rest(static_cast<std::size_t>(model->vertex_count())), posed(rest.size());
  for (int i = 0; i < kPeople; ++i) {
    const Drawn person = draw_person(*model, Family::training, kSeed, static_cast<std::uint64_t>(i));
    measurer.measure(tape, person.params, values);
    CutBody own{};
    for (std::size_t k = 0; k < kTapeIds.size(); ++k)
      own[k] = values[static_cast<std::size_t>(definition_index(tape, kTapeIds[k]))];
    model->morph(person.params, rest);
    const Skeleton skeleton = rest_skeleton(*model, rest);
    const Pose pose = dressing_pose(skeleton);
    skin(*model, rest, skeleton, pose, posed);
    const PosedSkeleton bones = pose_skeleton(skeleton, pose);
    const auto head = [&](Segment s) { return bones.head[static_cast<std::size_t>(s)]; };
    const Vec3f shoulder = head(Segment::left_upper_arm), hip = head(Segment::left_upper_leg);
    const auto set = [&](CutMeasure m, float value) { own[static_cast<std::size_t>(m)] = value; };
    const float neck_half = 0.16F * own[static_cast<std::size_t>(CutMeasure::neck)] + 20;
    set(CutMeasure::shoulder_x, shoulder.x);
    set(CutMeasure::shoulder_to_neck, top_at(*model, posed, neck_half, head(Segment::neck).y + 60) - shoulder.y);
    set(CutMeasure::shoulder_top, top_at(*model, posed, shoulder.x, 1e9F) - shoulder.y);
    set(CutMeasure::hip_x, hip.x);
    const Vec3f crotch = rest[static_cast<std::size_t>(model->data().landmark(Landmark::crotch))];
    const float hip_to_crotch = skeleton.head[static_cast<std::size_t>(Segment::left_upper_leg)].y - crotch.y;
    set(CutMeasure::hip_to_crotch, hip_to_crotch);
    set(CutMeasure::hip_to_high_hip, values[static_cast<std::size_t>(definition_index(tape, "high_hip_height"))] -
                                         own[static_cast<std::size_t>(CutMeasure::inside_leg)] - hip_to_crotch);
    bool whole = true;
    for (const float v : own) whole = whole && std::isfinite(v);
    if (!whole) continue;
    for (std::size_t k = 1; k < kCutMeasureCount; ++k)
      fits[person.woman ? 1 : 0][k].add(static_cast<double>(own[0]), static_cast<double>(own[k]));
  }
  std::printf(
      "# SPDX-License-Identifier: Apache-2.0\n"
      "# The body a size is cut for, mm: each measure is `mm` and `chest` times the chest girth. docs/garments.md.\n"
      "# Made by im2fit-lab make cut-regression of %d training people.\n"
      "schema: im2fit.bodies/1\n",
      kPeople);
  for (const std::size_t sex : {0U, 1U}) {
    std::printf("%s:\n", sex == 0 ? "men" : "women");
    for (std::size_t k = 1; k < kCutMeasureCount; ++k)
      std::printf("  %s: {mm: %.1f, chest: %.4f}\n", std::string(kCutMeasureNames[k]).c_str(), fits[sex][k].start(),
                  fits[sex][k].slope());
  }
  return 0;
}

}  // namespace

namespace im2fit::apps {

int make_cut_regression(int argc, char** argv) {
  if (argc != 2 || std::string_view(argv[1]) == "--help") {
    std::fprintf(stderr, "im2fit-lab make cut-regression BODY.i2b > data/garments/bodies.yaml\n");
    return 2;
  }
  return run(argv[1]);
}

}  // namespace im2fit::apps
