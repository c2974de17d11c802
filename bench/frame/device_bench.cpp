// SPDX-License-Identifier: Apache-2.0
// What the library keeps in memory and how often it wakes a processor: an engine with body, tracker and index of
// their files, fed at 30 Hz for as many seconds as the argument says (default 5) while a person stands in the
// picture, and again while the room is empty and the engine rests.
//   device_bench [SECONDS] > device.json
//   device_bench clothes [SECONDS] > beside.json   what clothes on the page cost
//   (bench/cloth/cloth_beside_sensing.cpp)
#include <malloc.h>
#include <sys/resource.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <memory>
#include <string>
#include <thread>

#include "bench/frame/room.h"
#include "person/measuring_data.h"

namespace im2fit::bench {

int clothes_beside_sensing(int seconds);  // cloth/cloth_beside_sensing.cpp; an exit code

namespace {

constexpr std::int64_t kPeriodNs = 33333333;

// Of this process, MB: its own memory, and memory mapped from files (programs, libraries, body, tracker, index).
struct Resident {
  double own_mb = 0, mapped_mb = 0;
};
Resident resident() {
  Resident now;
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    const auto mb = [&](const char* key) {
      const std::string start = std::string(key) + ":";
      return line.starts_with(start) ? std::strtod(line.c_str() + start.size(), nullptr) / 1024 : 0.0;
    };
    now.own_mb += mb("RssAnon");
    now.mapped_mb += mb("RssFile");
  }
  return now;
}

// All that is allocated, used so far or not: describing a person uses memory that guiding one does not.
double allocated_mb() {
  const struct mallinfo2 heap = mallinfo2();
  return static_cast<double>(heap.uordblks + heap.hblkhd) / (1 << 20);
}

// All threads' so far: each is a thread that slept and was woken.
long wakeups() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_nvcsw;
}

class Camera {
 public:
  explicit Camera(const test::Figure& figure) {
    for (std::size_t i = 0; i < pixels_.size(); ++i) pixels_[i] = picture(figure, 7 + i);
  }
  // At the camera's rate; the times of the frames are exact.
  void feed(Engine& engine, int seconds) {
    auto due = std::chrono::steady_clock::now();
    for (int i = 0; i < 30 * seconds; ++i) {
      std::this_thread::sleep_until(due += std::chrono::nanoseconds(kPeriodNs));
      push(engine);
    }
    engine.wait_idle(-1);
  }
  // As fast as they are taken.
  void hurry(Engine& engine, int frames) {
    for (int i = 0; i < frames; ++i) push(engine);
    engine.wait_idle(-1);
  }
  double own_mb() const { return static_cast<double>(2 * 2 * pixels_[0].size()) / (1 << 20); }

 private:
  void push(Engine& engine) {
    hal::FrameInfo info;
    info.sequence = sequence++;
    info.host_ns = static_cast<std::int64_t>(sequence) * kPeriodNs;
    if (!engine.push({pixels_[sequence % 2].data(), kCamera.width, kCamera.height}, info))
      std::fprintf(stderr, "device_bench: a frame was refused\n");
  }
  static inline std::uint64_t sequence = 0;
  std::array<std::vector<std::uint16_t>, 2> pixels_;
};

int run(int seconds) {
  const auto data = load_measuring_data({file_of("IM2FIT_TRACKER", "tracker.i2t"),
                                         file_of("IM2FIT_INDEX", "index.i2f"),
                                         file_of("IM2FIT_BODY", "body.i2b", ""),
                                         {}});
  if (!data) {
    std::fprintf(stderr, "device_bench: %s\n", data.error().message.c_str());
    return 1;
  }
  Camera person(test::standing_figure(0, kDistanceMm));
  Camera empty(test::standing_figure(0, 100 * kDistanceMm));
  EngineSettings settings;
  settings.intrinsics = kCamera;
  settings.width = kCamera.width;
  settings.height = kCamera.height;
  settings.one_after_another = settings.rest = true;
  auto engine = make_engine(settings, *data, "");
  if (!engine) {
    std::fprintf(stderr, "device_bench: %s\n", engine.error().message.c_str());
    return 1;
  }
  person.hurry(**engine, 60);
  // Who was there leaves; a person is guided again at the camera's rate.
  empty.hurry(**engine, 40);
  const long live_from = wakeups();
  person.feed(**engine, 1);
  const long live_to = wakeups();
  empty.hurry(**engine, 90);
  const long rest_from = wakeups();
  empty.feed(**engine, seconds);
  const long rest_to = wakeups();
  const Resident now = resident();
  std::printf(
      "{\"allocated_mb\": %.1f, \"own_mb\": %.1f, \"of_which_pictures_mb\": %.1f, \"mapped_mb\": %.1f, "
      "\"wakeups_live_per_s\": %.1f, \"wakeups_rest_per_s\": %.1f}\n",
      allocated_mb(), now.own_mb, person.own_mb() + empty.own_mb(), now.mapped_mb,
      static_cast<double>(live_to - live_from), static_cast<double>(rest_to - rest_from) / seconds);
  return 0;
}

}  // namespace
}  // namespace im2fit::bench

int main(int argc, char** argv) {
  const bool clothes = argc > 1 && std::strcmp(argv[1], "clothes") == 0;
  const char* seconds_text = argc > 1 + clothes ? argv[1 + clothes] : clothes ? "10" : "5";
  char* end = nullptr;
  const long seconds = std::strtol(seconds_text, &end, 10);
  if (*end != '\0' || argc > 2 + clothes || seconds < 2 || seconds > 60) {
    std::fprintf(stderr, "usage: device_bench [clothes] [SECONDS, 2 to 60]\n");
    return 2;
  }
  if (!clothes) return im2fit::bench::run(static_cast<int>(seconds));
#ifdef IM2FIT_BENCH_PAGE
  return im2fit::bench::clothes_beside_sensing(static_cast<int>(seconds));
#else
  std::fprintf(stderr, "device_bench: built without the page or without the workstation's judges of garments\n");
  return 1;
#endif
}
