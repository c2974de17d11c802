// SPDX-License-Identifier: Apache-2.0
#include "train/tracker/tracker_images.h"

#include <algorithm>

#include "core/rng.h"
#include "hal/source.h"
#include "perception/joints/side.h"
#include "perception/segment/segment.h"
#include "train/common/parallel.h"

namespace im2fit::lab {
namespace {

constexpr std::uint64_t kImageStream = 0x7452414B;
constexpr double kTruthMaskShare = 0.25;

std::size_t index_of(int u, int v, int width) {
  return static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(u);
}

// Turns a sensor frame upright (train/camera/virtual_camera.h, "Mounting").
template <class T>
void turn_upright(const std::vector<T>& in, int width, int height, int rotate_deg, std::vector<T>& out) {
  const int out_width = rotate_deg % 180 == 0 ? width : height;
  const int out_height = rotate_deg % 180 == 0 ? height : width;
  out.resize(in.size());
  for (int v = 0; v < out_height; ++v) {
    for (int u = 0; u < out_width; ++u) {
      int from_u = u;
      int from_v = v;
      if (rotate_deg == 90) {
        from_u = v;
        from_v = height - 1 - u;
      } else if (rotate_deg == 180) {
        from_u = width - 1 - u;
        from_v = height - 1 - v;
      } else if (rotate_deg == 270) {
        from_u = width - 1 - v;
        from_v = u;
      }
      out[index_of(u, v, out_width)] = in[index_of(from_u, from_v, width)];
    }
  }
}

Person box_of(const std::vector<std::uint8_t>& mask, int width, int height) {
  Person person;
  person.u_min = width;
  person.v_min = height;
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      if (mask[index_of(u, v, width)] == 0) continue;
      person.found = true;
      person.u_min = std::min(person.u_min, u);
      person.u_max = std::max(person.u_max, u);
      person.v_min = std::min(person.v_min, v);
      person.v_max = std::max(person.v_max, v);
    }
  }
  return person;
}

TrackerImage make_image(Studio& studio, const Subject& subject, std::span<const Vec3f> rest, std::uint64_t seed,
                        std::uint64_t index) {
  Rng rng = Rng::for_item(seed, kImageStream, index);
  const UprightFrame frame = studio.render(subject, rest, draw_tracker_scene(training_mix(), rng));
  const Intrinsics& k = frame.intrinsics;
  std::vector<std::uint8_t> mask = frame.truth_mask;
  if (rng.uniform() >= kTruthMaskShare) {
    Segmenter segmenter(k.width, k.height);
    PersonTracker people;
    std::vector<std::uint8_t> own(mask.size());
    segmenter.run(DepthView(frame.depth.data(), k.width, k.height), k, people,
                  MaskImage(own.data(), k.width, k.height));
    if (overlap(own, frame.truth_mask)) mask.swap(own);
  }
  const Person person = box_of(mask, k.width, k.height);
  TrackerImage image;
  joints::downsample(DepthView(frame.depth.data(), k.width, k.height), MaskView(mask.data(), k.width, k.height), k,
                     person, image.view);
  JointSet truth = frame.joints;
  image.back = truth[Joint::LS].x + truth[Joint::LH].x < truth[Joint::RS].x + truth[Joint::RH].x;
  if (image.back) joints::swap_sides(truth);
  image.truth = truth.position_mm;
  return image;
}

}  // namespace

UprightFrame Studio::render(const Subject& subject, std::span<const Vec3f> rest, const TrackerScene& drawn) {
  const int width = drawn.intrinsics.width, height = drawn.intrinsics.height;
  const auto of_size = [&](const auto& s) {
    return s->intrinsics().width == width && s->intrinsics().height == height;
  };
  auto found = std::find_if(scenes_.begin(), scenes_.end(), of_size);
  if (found == scenes_.end()) {
    scenes_.push_back(
        std::make_unique<VirtualScene>(model_, subject, drawn.scene, drawn.sensor, drawn.intrinsics, drawn.seed));
    found = scenes_.end() - 1;
  } else {
    (*found)->restage(subject, drawn.scene, drawn.sensor, drawn.seed, rest);
  }
  VirtualScene& scene = **found;
  std::vector<std::uint16_t> depth(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  std::vector<std::uint8_t> mask(depth.size());
  scene.render(0, DepthImage(depth.data(), width, height));
  scene.person_mask(MaskImage(mask.data(), width, height));
  UprightFrame frame;
  frame.intrinsics = hal::rotate_upright(drawn.intrinsics, drawn.rotate_deg);
  turn_upright(depth, width, height, drawn.rotate_deg, frame.depth);
  turn_upright(mask, width, height, drawn.rotate_deg, frame.truth_mask);
  frame.joints = scene.joints(0);
  return frame;
}

bool overlap(const std::vector<std::uint8_t>& mask, const std::vector<std::uint8_t>& truth) {
  int both = 0;
  int either = 0;
  for (std::size_t i = 0; i < mask.size(); ++i) {
    both += mask[i] != 0 && truth[i] != 0 ? 1 : 0;
    either += mask[i] != 0 || truth[i] != 0 ? 1 : 0;
  }
  return both * 2 > either;
}

std::vector<TrackerImage> render_tracker_images(const body::BodyModel& model, int image_count, int images_per_subject,
                                                std::uint64_t seed, int thread_count,
                                                const std::function<void(double)>& progress) {
  std::vector<TrackerImage> images(static_cast<std::size_t>(image_count));
  const int subject_count = (image_count + images_per_subject - 1) / images_per_subject;
  const auto make_worker = [&] {
    return [&, studio = Studio(model), rest = std::vector<Vec3f>()](int s) mutable {
      const Subject subject = draw_subject(model, Family::training, seed, static_cast<std::uint64_t>(s), rest);
      const int last = std::min(image_count, (s + 1) * images_per_subject);
      for (int i = s * images_per_subject; i < last; ++i)
        images[static_cast<std::size_t>(i)] = make_image(studio, subject, rest, seed, static_cast<std::uint64_t>(i));
    };
  };
  for_each_item_by_worker(subject_count, thread_count, make_worker, [&](std::uint64_t done) {
    if (progress) progress(static_cast<double>(done) / subject_count);
  });
  return images;
}

TrackerImage mirrored(const TrackerImage& image) {
  TrackerImage out = image;
  joints::mirror(image.view, out.view);
  JointSet joints;
  joints.position_mm = image.truth;
  for (Vec3f& p : joints.position_mm) p.x = -p.x;
  joints::swap_sides(joints);
  out.truth = joints.position_mm;
  return out;
}

}  // namespace im2fit::lab
