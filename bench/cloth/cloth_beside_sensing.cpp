// SPDX-License-Identifier: Apache-2.0
// What clothes on the page cost the camera's path: a person is guided at 30 Hz, alone and while a page shows trousers
// and a T-shirt that move all the time, in turns. A frame's latency is from its push until every stage is done with
// it.
//   device_bench clothes [SECONDS=10] > beside.json          of each of two turns
//   taskset -c 0 device_bench clothes                        where the clothes' thread has no core of its own
// Files: IM2FIT_BODY, IM2FIT_TRACKER, IM2FIT_INDEX, else the cache's.
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "apps/kiosk/live_cloth.h"
#include "bench/frame/room.h"
#include "garment/drape/dressing_pose.h"
#include "garment/drape/moving_clothes.h"
#include "person/measuring_data.h"
#include "train/dressed/dressed_people.h"

namespace im2fit::bench {
namespace {

using Clock = std::chrono::steady_clock;
constexpr auto kPeriod = std::chrono::nanoseconds(33'333'333);
constexpr int kPictures = 8;

struct Turn {
  std::vector<double> latencies_ms;
  int told = 0;      // messages to the page
  double cpu_s = 0;  // of the process
  double seconds = 0;
};

double cpu_s() {
  rusage u{};
  getrusage(RUSAGE_SELF, &u);
  return static_cast<double>(u.ru_utime.tv_sec + u.ru_stime.tv_sec) +
         1e-6 * static_cast<double>(u.ru_utime.tv_usec + u.ru_stime.tv_usec);
}

double quantile(std::vector<double> values, double share) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

class Beside {
 public:
  Beside(const body::BodyModel& model, const MeasuringData& data)
      : data_(data), person_(lab::example_people(model)[1]), poses_(lab::dressed_poses(model, person_)) {
    auto outfit = std::make_unique<body::Outfit>(model, lab::pieces_for(person_, {"trousers", "t_shirt"}, 0, true));
    outfit->dress(person_.rest, person_.skeleton, poses_[0].pose);
    clothes_ = std::make_shared<body::MovingClothes>(model, std::move(outfit), person_.skeleton);
    for (int i = 0; i < kPictures; ++i)
      pictures_.push_back(picture(test::standing_figure(0, kDistanceMm), 7 + static_cast<std::uint64_t>(i)));
  }

  // False: the engine cannot be made; the reason has been printed.
  bool take(int seconds, bool dressed, Turn& turn) {
    EngineSettings settings;
    settings.intrinsics = kCamera;
    settings.width = kCamera.width;
    settings.height = kCamera.height;
    settings.frames_wanted = 1000;  // guided to the end: a measured person costs less
    auto engine = make_engine(settings, data_, "");
    if (!engine) {
      std::fprintf(stderr, "device_bench: %s\n", engine.error().message.c_str());
      return false;
    }
    std::atomic<int> told{0};
    apps::LiveCloth cloth([&](std::uint32_t) { ++told; });
    if (dressed) cloth.wear("clothes", clothes_);
    const double before = cpu_s();
    const auto began = Clock::now();
    auto due = began;
    for (int i = 0; i < 30 * seconds; ++i) {
      std::this_thread::sleep_until(due += kPeriod);
      if (dressed) {
        (void)cloth.ask("clothes");
        // Arms go up and down in two seconds, legs stride.
        const int t = i % 60;
        cloth.follow(body::between(poses_[0].pose, poses_[i / 60 % 2 == 0 ? 2 : 6].pose,
                                   static_cast<float>(t < 30 ? t : 60 - t) / 30));
      }
      const auto pushed = Clock::now();
      hal::FrameInfo info;
      info.sequence = static_cast<std::uint64_t>(i) + 1;
      info.host_ns = static_cast<std::int64_t>(i + 1) * kPeriod.count();
      if (!(*engine)->push({pictures_[static_cast<std::size_t>(i % kPictures)].data(), kCamera.width, kCamera.height},
                           info))
        std::fprintf(stderr, "device_bench: a frame was refused\n");
      (*engine)->wait_idle(-1);
      if (i >= 30)  // the first second finds room and person
        turn.latencies_ms.push_back(std::chrono::duration<double, std::milli>(Clock::now() - pushed).count());
    }
    turn.seconds += std::chrono::duration<double>(Clock::now() - began).count();
    turn.cpu_s += cpu_s() - before;
    turn.told += told;
    return true;
  }

 private:
  const MeasuringData& data_;
  lab::DressedPerson person_;
  std::vector<lab::NamedPose> poses_;
  std::shared_ptr<body::MovingClothes> clothes_;
  std::vector<std::vector<std::uint16_t>> pictures_;
};

void print(const char* name, const Turn& t, const char* after) {
  std::printf(
      " \"%s\": {\"median_ms\": %.2f, \"p99_ms\": %.2f, \"most_ms\": %.2f, \"late_frames\": %td, \"frames\": %zu, "
      "\"told_hz\": %.1f, \"cores\": %.2f}%s\n",
      name, quantile(t.latencies_ms, 0.5), quantile(t.latencies_ms, 0.99), quantile(t.latencies_ms, 1),
      std::count_if(t.latencies_ms.begin(), t.latencies_ms.end(), [](double ms) { return ms > 33.3; }),
      t.latencies_ms.size(), t.told / t.seconds, t.cpu_s / t.seconds, after);
}

}  // namespace

int clothes_beside_sensing(int seconds) {
  const std::string body_path = file_of("IM2FIT_BODY", "body.i2b", "");
  const auto data = load_measuring_data(
      {file_of("IM2FIT_TRACKER", "tracker.i2t"), file_of("IM2FIT_INDEX", "index.i2f"), body_path, {}});
  if (!data) {
    std::fprintf(stderr, "device_bench: %s\n", data.error().message.c_str());
    return 1;
  }
  const auto model = body::BodyModel::load(body_path);
  if (!model) {
    std::fprintf(stderr, "device_bench: %s\n", model.error().message.c_str());
    return 1;
  }
  Beside beside(*model, *data);
  std::array<Turn, 2> turns;
  for (int round = 0; round < 2; ++round)
    for (const bool dressed : {false, true})
      if (!beside.take(seconds, dressed, turns[dressed ? 1 : 0])) return 1;
  std::printf("{\n");
  print("alone", turns[0], ",");
  print("beside clothes", turns[1], "");
  std::printf("}\n");
  return 0;
}

}  // namespace im2fit::bench
