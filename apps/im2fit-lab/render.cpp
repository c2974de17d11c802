// SPDX-License-Identifier: Apache-2.0
// A depth folder of one synthetic person, with the truth beside it.
#include <fmt/core.h>

#include "apps/common/paths.h"
#include "apps/common/progress.h"
#include "apps/im2fit-lab/commands.h"
#include "body/export/export.h"
#include "core/file.h"
#include "hal/folder/depth_folder.h"
#include "person/data_files.h"
#include "train/camera/synthetic_person.h"

namespace im2fit::apps {
namespace {

struct RenderOptions {
  std::string out;
  PersonOptions person;
  std::string family = "held_out";
  std::string condition = "noise";
  std::string pose = "relaxed";
  std::string size = "640x480";
  int frames = 30;
  int turn_after = 0, step_round_after = 0, walk_round_after = 0;  // 0: never
  bool clothed = false;
  bool paper_files = false;
  bool truth_only = false;
  std::string body = made_body_path();
};

// Camera axes (x right, y down, z forward) to a body mesh's (y up, +z out of the face).
JointSet mesh_axes(JointSet joints) {
  for (auto& p : joints.position_mm) p = {p.x, -p.y, -p.z};
  return joints;
}

// The paper's four files per sample, posed as in frame 0.
Status write_paper_files(const body::BodyModel& model, SyntheticPerson& person, const std::string& directory) {
  const auto& subject = person.subject();
  std::vector<Vec3f> rest(static_cast<std::size_t>(model.vertex_count()));
  lab::morph_subject(model, subject, rest);
  const auto skeleton = body::rest_skeleton(model, rest);
  const body::Avatar avatar{&model, subject.params,
                            body::pose_from_joints(skeleton, mesh_axes(person.scene().joints(0)))};
  using Writer = Status (*)(const body::Avatar&, const std::string&);
  const std::pair<Writer, const char*> files[] = {{body::write_obj, "sample.obj"},
                                                  {body::write_skel, "sample.skel"},
                                                  {body::write_bvh, "sample.bvh"},
                                                  {body::write_attributes, "sample.txt"}};
  for (const auto& [write, name] : files)
    if (const auto written = write(avatar, directory + "/" + name); !written) return written.error();
  return Ok{};
}

Status write_frames(SyntheticPerson& person, const RenderOptions& options, int rotate_deg) {
  const Intrinsics k = person.scene().intrinsics();
  hal::FolderWriter::Options writing;
  writing.camera_name = "im2fit virtual Kinect (synthetic)";
  writing.rotate_deg = rotate_deg;
  auto writer = hal::FolderWriter::create(options.out, k, writing);
  if (!writer) return writer.error();
  std::vector<std::uint16_t> pixels(static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height));
  const DepthImage image(pixels.data(), k.width, k.height);
  Progress progress("frames", static_cast<std::uint64_t>(options.frames));
  for (int i = 0; i < options.frames; ++i) {
    person.scene().render(static_cast<std::uint64_t>(i), image);
    hal::FrameInfo info;
    info.sequence = static_cast<std::uint64_t>(i);
    info.host_ns = i * 33'333'333LL;
    info.device_us = i * 33'333LL;
    // Of the upright picture; the frames are stored as the sensor delivers them.
    if (options.walk_round_after > 0)
      info.pose = hal::rotate_upright(person.scene().camera_pose(info.sequence), (360 - rotate_deg) % 360);
    if (const auto written = (*writer)->write(image, info); !written) return written.error();
    progress.update(static_cast<std::uint64_t>(i) + 1);
  }
  return (*writer)->finish();
}

Result<int> run_render(const RenderOptions& options) {
  const auto model = load_body(options.body);
  if (!model) return model.error();
  const auto family = family_of(options.family);
  if (!family) return family.error();
  const auto pose = pose_of(options.pose);
  if (!pose) return pose.error();
  PersonOptions wanted = options.person;
  wanted.family = *family;
  wanted.scene.pose = *pose;
  wanted.scene.turn = turn_after(options.turn_after);
  if (options.step_round_after > 0) wanted.scene.step_round = step_round_after(options.step_round_after);
  if (options.walk_round_after > 0) wanted.scene.step_round = walk_round_after(options.walk_round_after);
  if (options.clothed) dress(wanted.scene);
  wanted.noise = options.condition == "noise";
  if (!wanted.noise) wanted.scene.furniture_count = 0;
  if (options.size == "320x240") wanted.width = 320, wanted.height = 240;
  SyntheticPerson person(*model, wanted);
  const Truth truth = person.truth(options.truth_only ? 0 : options.frames);
  if (options.truth_only) {
    if (const auto written = write_truth(truth, options.out); !written) return written.error();
    return kExitOk;
  }
  if (const auto written = write_frames(person, options, wanted.scene.rotate_deg); !written) return written.error();
  if (const auto written = write_truth(truth, options.out + "/truth.json"); !written) return written.error();
  if (options.paper_files)
    if (const auto written = write_paper_files(*model, person, options.out); !written) return written.error();
  fmt::print("{}: {} frames of a synthetic {}, {:.0f} mm tall\n", options.out, options.frames,
             truth.woman ? "woman" : "man", truth.values[measurement_index(Measurement::stature)]);
  return kExitOk;
}

}  // namespace

void add_render(cli::App& app, Command& chosen) {
  auto options = std::make_shared<RenderOptions>();
  options->person.scene = furnished_room();
  auto* sub = add_command<RenderOptions>(
      app, chosen, "render", "Render a synthetic person to a depth folder with truth.json",
      "  im2fit-lab render --out person7 --seed 7\n"
      "  im2fit-lab render --out bare --condition bare --pose psi --rotate 0 --paper-files\n"
      "  im2fit-lab render --out both --seed 7 --frames 150 --turn-after 40\n"
      "  im2fit-lab render --out walked --seed 7 --frames 570 --walk-round-after 60",
      options, run_render);
  auto& person = options->person;
  sub->add_option("--out", options->out, "Folder to make (a file with --truth-only)")->required()->type_name("DIR");
  sub->add_option("--seed", person.seed, "Seed of the person, the room and the noise")->capture_default_str();
  sub->add_option("--subject", person.subject, "Number of the person within the seed")->capture_default_str();
  sub->add_option("--family", options->family, "Population")
      ->one_of({"paper", "training", "held_out"})
      ->capture_default_str();
  sub->add_option("--frames", options->frames, "Frames")->range(1, 100000)->capture_default_str();
  sub->add_option("--rotate", person.scene.rotate_deg, "Mounting of the camera, degrees")
      ->one_of({0, 90, 180, 270})
      ->capture_default_str();
  sub->add_option("--condition", options->condition, "noise: a Kinect in a furnished room; bare: a perfect sensor")
      ->one_of({"noise", "bare"})
      ->capture_default_str();
  sub->add_option("--pose", options->pose, "Pose of the person")
      ->one_of({"relaxed", "arms_out", "a_pose", "psi", "free", "bowed", "squat", "bent_knees", "arm_raised"})
      ->capture_default_str();
  sub->add_option("--distance", person.scene.distance_mm,
                  "Distance from camera to person, mm; 0: the whole person fits into the picture")
      ->range(0, 8000)
      ->capture_default_str();
  sub->add_option("--furniture", person.scene.furniture_count, "Pieces of furniture")
      ->range(0, 20)
      ->capture_default_str();
  sub->add_option("--size", options->size, "Picture size of the sensor")
      ->one_of({"640x480", "320x240"})
      ->capture_default_str();
  sub->add_flag("--back", person.scene.back_view, "Seen from behind");
  auto* turn = sub->add_option("--turn-after", options->turn_after, "The person turns round after N frames; 0: never")
                   ->range(0, 100000)
                   ->capture_default_str();
  auto* step = sub->add_option("--step-round-after", options->step_round_after,
                               "The person makes one full turn, in 9 s, after N frames; 0: never")
                   ->range(0, 100000)
                   ->capture_default_str()
                   ->excludes(turn);
  sub->add_option("--walk-round-after", options->walk_round_after,
                  "The camera is carried round the person once, in 15 s, after N frames; 0: never. poses.csv has the "
                  "true poses")
      ->range(0, 100000)
      ->capture_default_str()
      ->excludes(turn)
      ->excludes(step);
  sub->add_flag("--clothed", options->clothed, "With clothes, shoes and hair; the true values are those of the body");
  sub->add_flag("--paper-files", options->paper_files,
                "Also write sample.obj, .skel, .bvh and .txt in the paper's formats");
  sub->add_flag("--truth-only", options->truth_only, "Write only the true values, into the file --out");
  sub->add_option("--body", options->body, "Body file")->type_name("FILE")->capture_default_str();
}

}  // namespace im2fit::apps
