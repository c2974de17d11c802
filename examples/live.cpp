// SPDX-License-Identifier: Apache-2.0
// Measures one person after the other before a live camera, with guidance. Standard input has the depth: raw 16-bit
// frames, mm.
//   v4l2-ctl -d /dev/video2 --stream-mmap --stream-to=- | live TRACKER.i2t INDEX.i2f 640 480 FX FY CX CY
#include <im2fit/im2fit.h>

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

namespace {
using Handle = std::unique_ptr<im2fit_handle, decltype(&im2fit_close)>;

// Prints state and guidance for the person when they change.
void guide(const im2fit_result& result, std::string& shown) {
  std::string text = im2fit_state_name(result.state);
  for (int bit = 0; bit < IM2FIT_GUIDANCE_COUNT; ++bit)
    if ((result.guidance >> bit & 1U) != 0) text += std::string(" ") + im2fit_guidance_name(bit);
  if (text != shown) std::cerr << text << '\n';
  shown = text;
}

void print(const im2fit_result& result) {
  std::cout << "person " << result.session + 1 << '\n';
  for (int i = 0; i < IM2FIT_MEASUREMENT_COUNT; ++i) {
    const auto& m = result.measurements[i];
    std::printf("  %-17s %7.1f %s  [%.1f, %.1f]\n", im2fit_measurement_name(i), static_cast<double>(m.value),
                im2fit_measurement_unit(i), static_cast<double>(m.low), static_cast<double>(m.high));
  }
  std::fflush(stdout);
}

int fail(const im2fit_handle* handle) {
  std::cerr << "live: " << im2fit_last_error(handle) << '\n';
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 9) return std::cerr << "usage: live TRACKER INDEX WIDTH HEIGHT FX FY CX CY\n", 2;
  im2fit_settings settings;
  im2fit_settings_init(&settings, sizeof settings);
  settings.tracker_path = argv[1];
  settings.index_path = argv[2];
  settings.width = std::atoi(argv[3]), settings.height = std::atoi(argv[4]);
  settings.fx = std::strtof(argv[5], nullptr), settings.fy = std::strtof(argv[6], nullptr);
  settings.cx = std::strtof(argv[7], nullptr), settings.cy = std::strtof(argv[8], nullptr);
  settings.frames_wanted = 6;
  const bool recording = std::getenv("LIVE_RECORDING") != nullptr;  // of standard input: no frame is dropped
  settings.live = recording ? 0 : 1;
  settings.single_thread = recording ? 1 : 0;
  im2fit_handle* opened = nullptr;
  if (im2fit_open(&settings, &opened) != IM2FIT_OK) return fail(nullptr);
  const Handle handle(opened, im2fit_close);

  std::vector<std::uint16_t> depth(static_cast<std::size_t>(settings.width) *
                                   static_cast<std::size_t>(settings.height));
  im2fit_result result{};
  std::string shown;
  for (std::uint64_t sequence = 0; std::fread(depth.data(), 2, depth.size(), stdin) == depth.size(); ++sequence) {
    const auto now = std::chrono::steady_clock::now().time_since_epoch();
    const std::int64_t time_ns = std::chrono::duration_cast<std::chrono::nanoseconds>(now).count();
    if (im2fit_push(handle.get(), depth.data(), settings.width, settings.height, 0, sequence, time_ns) != IM2FIT_OK ||
        im2fit_poll(handle.get(), &result, sizeof result) != IM2FIT_OK)
      return fail(handle.get());
    guide(result, shown);
    if (result.state != IM2FIT_STATE_MEASURED) continue;
    print(result);
    if (im2fit_next(handle.get()) != IM2FIT_OK) return fail(handle.get());  // begins when this one has left
  }
  if (im2fit_finish(handle.get()) != IM2FIT_OK || im2fit_poll(handle.get(), &result, sizeof result) != IM2FIT_OK)
    return fail(handle.get());
  if (result.state == IM2FIT_STATE_MEASURED) print(result);  // with the frames before the end
  return 0;
}
