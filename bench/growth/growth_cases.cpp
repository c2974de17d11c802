// SPDX-License-Identifier: Apache-2.0
// What a guided frame costs as pictures, company and distance grow: growth/AXIS/VALUE, one run a frame, the sensor
// and the fuser of bench/frame. One axis is moved at a time; the others stay at 640x480, one person, 2.3 m.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bench/frame/room.h"
#include "bench/kernels/cases.h"
#include "core/file.h"
#include "perception/observe/observe.h"

namespace im2fit::bench {
namespace {

constexpr int kWarmUp = 12;       // frames until floor and tracker have converged
constexpr int kAccumulated = 15;  // frames of a session
constexpr int kPeopleMax = 6;
constexpr double kBehindMm = 1600;  // distance of the wall behind the measured person

struct Setting {
  std::string name;
  int width = 480, height = 640;  // upright
  int people = 1;
  float distance_mm = kDistanceMm;
};

std::vector<Setting> settings() {
  std::vector<Setting> all;
  for (const int scale : {1, 2, 3, 4, 6, 8}) {  // of 160x120
    Setting s;
    s.width = 120 * scale;
    s.height = 160 * scale;
    s.name = "pixels/" + std::to_string(s.height) + "x" + std::to_string(s.width);
    all.push_back(s);
  }
  for (int people = 0; people <= kPeopleMax; ++people) {
    Setting s;
    s.people = people;
    // Six abreast fit at 4.5 m.
    s.distance_mm = 4500;
    s.width = 640;
    s.height = 480;
    s.name = "people/" + std::to_string(people);
    all.push_back(s);
  }
  for (const int distance_mm : {1800, 2000, 2300, 2600, 3000, 3500, 4000}) {
    Setting s;
    s.distance_mm = static_cast<float>(distance_mm);
    s.name = "distance/" + std::to_string(distance_mm);
    all.push_back(s);
  }
  return all;
}

// Whom the session is about in the middle, the others beside him, first to the right.
std::vector<test::Figure> figures(const Setting& s) {
  constexpr float kApartMm = 800;
  std::vector<test::Figure> all;
  for (int i = 0; i < s.people; ++i) {
    const auto steps = static_cast<float>((i + 1) / 2);
    all.push_back(test::standing_figure((i % 2 == 0 ? -1.0F : 1.0F) * steps * kApartMm, s.distance_mm));
  }
  return all;
}

struct Scene {
  explicit Scene(const Setting& s, const JointModel& model)
      : k{s.width, s.height, 0, 0, 0, 0},
        sensor(s.width, s.height, model),
        fuser(s.width, s.height),
        mask(static_cast<std::size_t>(s.width) * static_cast<std::size_t>(s.height)) {
    const float scale = static_cast<float>(std::max(s.width, s.height)) / 640;
    k.fx = k.fy = kCamera.fx * scale;
    k.cx = 0.5F * static_cast<float>(s.width - 1);
    k.cy = 0.5F * static_cast<float>(s.height - 1);
    const auto standing = figures(s);
    for (std::size_t i = 0; i < depth.size(); ++i)
      depth[i] = picture(standing, k, static_cast<double>(s.distance_mm) + kBehindMm, 7 + i);
    for (int i = 0; i < kWarmUp; ++i) frame();
    if (found != (s.people > 0) || users != s.people)
      std::fprintf(stderr, "growth/%s: %d people are followed\n", s.name.c_str(), users);
  }
  void frame() {
    next = (next + 1) % depth.size();
    const DepthView view(depth[next].data(), k.width, k.height);
    const MaskImage out(mask.data(), k.width, k.height);
    const Detection detection = sensor.sense(view, k, out);
    found = detection.person.found;
    users = detection.user_count;
    if (fuser.frame_count() >= kAccumulated) fuser.reset();
    if (found) fuser.add(view, out, k, detection);
  }
  Intrinsics k;
  PersonDetector sensor;
  Fuser fuser;
  std::array<std::vector<std::uint16_t>, 2> depth;
  std::vector<std::uint8_t> mask;
  std::size_t next = 0;
  bool found = false;
  int users = 0;
};

}  // namespace

Cases growth_cases(std::string_view) {
  Cases cases;
  const std::string path = file_of("IM2FIT_TRACKER", "tracker.i2t");
  auto file = MappedFile::open(path);
  if (!file) {
    std::fprintf(stderr, "growth: no tracker in %s\n", path.c_str());
    return cases;
  }
  const auto mapped = std::make_shared<MappedFile>(std::move(*file));
  auto parsed = JointModel::parse(mapped->bytes(), path);
  if (!parsed) {
    std::fprintf(stderr, "growth: %s\n", parsed.error().message.c_str());
    return cases;
  }
  const auto model = std::make_shared<JointModel>(std::move(*parsed));
  const Tier tier = tier_available(Tier::avx2)   ? Tier::avx2
                    : tier_available(Tier::neon) ? Tier::neon
                                                 : Tier::portable;
  for (const Setting& s : settings()) {
    // Made when it is run, so that one is in memory at a time.
    const auto scene = std::make_shared<std::optional<Scene>>();
    Case one;
    one.kernel = "growth/" + s.name;
    one.variant = "best";
    one.tier = tier;
    one.items = 1;
    one.item = "frame";
    one.run = [s, scene, model, mapped] {
      if (!*scene) scene->emplace(s, *model);
      (*scene)->frame();
    };
    cases.push_back(std::move(one));
  }
  return cases;
}

}  // namespace im2fit::bench
