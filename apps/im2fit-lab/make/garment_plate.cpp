// SPDX-License-Identifier: Apache-2.0
// im2fit-lab make garment-plate BODY.i2b OUT.png
// The paper's plate for six people: mean depth of 16 frames of a Kinect for Xbox 360, its normals, the body, and the
// body in trousers and a T-shirt of the sizes that fit, from the front, the left and the back. Simulated people and
// camera; the body is the person's own, not an answer.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>
#include <vector>

#include "apps/im2fit-lab/make/make.h"
#include "core/file.h"
#include "hal/source.h"
#include "kernels/normals/normals.h"
#include "report/dressed_picture.h"
#include "train/camera/virtual_camera.h"
#include "train/dressed/dressed_people.h"

namespace {

using namespace im2fit;
using namespace im2fit::lab;

constexpr int kPeople = 6, kFrames = 16;
constexpr std::uint64_t kSeed = 33;
constexpr int kCellWidth = 170, kCellHeight = 330;

struct Seen {
  Intrinsics k;              // of the upright picture
  std::vector<float> depth;  // mm, upright; 0 where the person is not
};

Seen look_at(const body::BodyModel& model, const Subject& subject) {
  SceneOptions scene_options;
  scene_options.rotate_deg = 90;
  scene_options.yaw_deg = 0;
  scene_options.sway = false;
  const Intrinsics sensor = kinect_intrinsics(640, 480);
  VirtualScene scene(model, subject, scene_options, kinect_sensor(), sensor, kSeed);
  const auto width = static_cast<std::size_t>(sensor.width), height = static_cast<std::size_t>(sensor.height);
  std::vector<std::uint16_t> frame(width * height);
  std::vector<std::uint8_t> mask(width * height);
  std::vector<float> sum(width * height), count(width * height);
  for (std::uint64_t i = 0; i < kFrames; ++i) {
    scene.render(i, {frame.data(), sensor.width, sensor.height});
    scene.person_mask({mask.data(), sensor.width, sensor.height});
    for (std::size_t p = 0; p < frame.size(); ++p) {
      if (mask[p] == 0 || frame[p] == 0) continue;
      sum[p] += static_cast<float>(frame[p]);
      count[p] += 1;
    }
  }
  Seen seen;
  seen.k = hal::rotate_upright(sensor, scene_options.rotate_deg);
  seen.depth.resize(frame.size());
  for (std::size_t v = 0; v < width; ++v)
    for (std::size_t u = 0; u < height; ++u) {
      const std::size_t p = (height - 1 - u) * width + v;  // virtual_camera.h: mounted turned by 90 degrees
      seen.depth[v * height + u] = count[p] > 0.5F * kFrames ? sum[p] / count[p] : 0;
    }
  return seen;
}

struct Normals {
  std::vector<float> x, y, z;
};

Normals normals_of(const Seen& seen) {
  constexpr int kRadiusPx = 3;
  constexpr float kStepMm = 60;
  const float none = std::numeric_limits<float>::quiet_NaN();
  const std::size_t count = seen.depth.size();
  std::vector<float> x(count, none), y(count, none), z(count, none);
  for (std::size_t p = 0; p < count; ++p) {
    if (!(seen.depth[p] > 0)) continue;
    const auto width = static_cast<std::size_t>(seen.k.width);
    const std::size_t column = p % width, row = p / width;
    const auto u = static_cast<float>(column), v = static_cast<float>(row);
    z[p] = seen.depth[p];
    x[p] = (u - seen.k.cx) / seen.k.fx * z[p];
    y[p] = (v - seen.k.cy) / seen.k.fy * z[p];
  }
  Normals out{std::vector<float>(count), std::vector<float>(count), std::vector<float>(count)};
  normals(seen.k, x.data(), y.data(), z.data(), kRadiusPx, kStepMm, out.x.data(), out.y.data(), out.z.data());
  return out;
}

std::uint8_t byte_of(float share) {
  return static_cast<std::uint8_t>(std::lround(255 * std::clamp(share, 0.0F, 1.0F)));
}

// The person's box of the picture, in a cell; `colour` of a pixel of it.
template <class F>
void paste_box(const Seen& seen, Canvas& to, int left, int top, F colour) {
  int u0 = seen.k.width, u1 = 0, v0 = seen.k.height, v1 = 0;
  for (int v = 0; v < seen.k.height; ++v)
    for (int u = 0; u < seen.k.width; ++u) {
      if (!(seen.depth[static_cast<std::size_t>(v * seen.k.width + u)] > 0)) continue;
      u0 = std::min(u0, u);
      u1 = std::max(u1, u);
      v0 = std::min(v0, v);
      v1 = std::max(v1, v);
    }
  const float scale = static_cast<float>(v1 - v0 + 1) / (kCellHeight - 20);
  const float middle = static_cast<float>(u0 + u1) / 2;
  for (int y = 0; y < kCellHeight; ++y)
    for (int x = 0; x < kCellWidth; ++x) {
      const int u = static_cast<int>(middle + (static_cast<float>(x) + 0.5F - kCellWidth / 2.0F) * scale);
      const int v = v0 + static_cast<int>((static_cast<float>(y) - 10) * scale);
      if (u < 0 || v < 0 || u >= seen.k.width || v >= seen.k.height) continue;
      const auto p = static_cast<std::size_t>(v * seen.k.width + u);
      if (seen.depth[p] > 0) to.set(left + x, top + y, colour(p));
    }
}

void paste(const Canvas& from, Canvas& to, int left, int top) {
  for (int y = 0; y < from.height(); ++y)
    for (int x = 0; x < from.width(); ++x) to.set(left + x, top + y, from.at(x, y));
}

void draw_row(const body::BodyModel& model, std::uint64_t number, Canvas& plate) {
  const Subject subject = draw_subject(model, Family::held_out, kSeed, number);
  const int top = static_cast<int>(number) * kCellHeight;
  const Seen seen = look_at(model, subject);
  float near = 1e9F, far = 0;
  for (const float d : seen.depth) {
    if (!(d > 0)) continue;
    near = std::min(near, d);
    far = std::max(far, d);
  }
  paste_box(seen, plate, 0, top, [&](std::size_t p) {
    const std::uint8_t grey = byte_of(0.95F - 0.75F * (seen.depth[p] - near) / (far - near));
    return Rgb{grey, grey, grey};
  });
  const Normals n = normals_of(seen);
  paste_box(seen, plate, kCellWidth, top, [&](std::size_t p) {
    if (!(n.z[p] <= 1)) return Rgb{200, 200, 200};
    return Rgb{byte_of(0.5F + n.x[p] / 2), byte_of(0.5F - n.y[p] / 2), byte_of(0.5F - n.z[p] / 2)};
  });
  const DressedPerson person = dressed_person(model, "person", subject.woman, subject.params);
  const body::Pose pose = dressed_poses(model, person)[0].pose;
  const std::vector<std::string> garments = {"trousers", "t_shirt"};
  std::vector<LinearColour> colours;
  colours.reserve(garments.size());
  for (const std::string& id : garments) colours.push_back(builtin_wardrobe().garment(id)->colour);
  body::Outfit bare(model, {}), dressed(model, pieces_for(person, garments));
  bare.dress(person.rest, person.skeleton, pose);
  dressed.dress(person.rest, person.skeleton, pose);
  float low = 1e9F, high = -1e9F;
  for (const Vec3f& v : bare.body().first(static_cast<std::size_t>(model.body_vertex_count()))) {
    low = std::min(low, v.y);
    high = std::max(high, v.y);
  }
  PictureFrame frame;
  frame.width = kCellWidth;
  frame.height = kCellHeight;
  frame.middle_z_mm = person.skeleton.head[0].z;
  const float margin = 10 * (high - low) / (kCellHeight - 20);
  frame.low_mm = low - margin;
  frame.high_mm = high + margin;
  constexpr PictureView kViews[] = {kFrontView, kLeftView, kBackView};
  const auto whose = subject.woman ? body::LookOf::woman : body::LookOf::man;
  paste(draw_outfit(model, bare, whose, {}, std::span(kViews).first(1), frame), plate, 2 * kCellWidth, top);
  paste(draw_outfit(model, dressed, whose, colours, kViews, frame), plate, 3 * kCellWidth, top);
}

}  // namespace

namespace im2fit::apps {

int make_garment_plate(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "im2fit-lab make garment-plate BODY.i2b OUT.png\n");
    return 2;
  }
  const auto model = body::BodyModel::load(argv[1]);
  if (!model) {
    std::fprintf(stderr, "im2fit-lab make garment-plate: %s\n", model.error().message.c_str());
    return 1;
  }
  Canvas plate(6 * kCellWidth, kPeople * kCellHeight);
  plate.rectangle(0, 0, plate.width(), plate.height(), {242, 242, 245});
  for (std::uint64_t i = 0; i < kPeople; ++i) draw_row(*model, i, plate);
  const auto png = plate.png();
  const Status written = png ? write_file_atomically(argv[2], *png) : Status(png.error());
  if (written) return 0;
  std::fprintf(stderr, "im2fit-lab make garment-plate: %s\n", written.error().message.c_str());
  return 1;
}

}  // namespace im2fit::apps
