// SPDX-License-Identifier: Apache-2.0
// Plugs an emulated USB camera into this machine's kernel and plays a depth folder through it. As root, with vhci_hcd
// loaded; made for the guest of scripts/firmware-test.
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <memory>
#include <thread>

#include "hal/folder/depth_folder.h"
#include "tests/devices/kinect_model.h"
#include "tests/devices/usbip_host.h"
#include "tests/devices/uvc_model.h"
#include "tests/devices/words.h"

namespace im2fit::devices {
namespace {

constexpr const char* kUsage =
    "usage: im2fit-usb-emulator uvc|kinect DEPTH_FOLDER [--key number]...\n"
    "       im2fit-usb-emulator motor [--key number]...   a Kinect's foot\n"
    "       im2fit-usb-emulator shifts DEPTH_FOLDER OUT   the folder as a Kinect can carry it: plugs in nothing\n"
    "       im2fit-usb-emulator small DEPTH_FOLDER OUT    a quarter as wide and high: likewise\n"
    "  --fps 30 --iso 0                 of the uvc camera's stream\n"
    "  --number 1                       ends the serial\n"
    "  --accel-x 0 --accel-y 819 --accel-z 0   what the foot's accelerometer feels: left, up, forward, 819 to a g\n"
    "  --loss-ppm 0 --damage-ppm 0 --seed 1\n"
    "  --for-ms 0                       end after so long (0: on SIGTERM)\n"
    "  --times 0 --unplug-after-ms 1500 --replug-after-ms 500 --first-after-ms 1500\n"
    "                                   pull the cable and plug it in again so often; the first time later or sooner";

struct Clip {
  int width = 0;
  int height = 0;
  std::vector<std::vector<std::uint16_t>> frames;
};

// The raw value of every distance, of the camera all Kinects here are.
std::vector<std::uint16_t> shifts_of_mm() {
  std::vector<std::uint16_t> shifts(65536);
  for (std::size_t mm = 0; mm < shifts.size(); ++mm) shifts[mm] = shift_of_mm({}, static_cast<std::uint16_t>(mm));
  return shifts;
}

// As the camera sees them: not turned upright.
Result<Clip> load_clip(const std::string& path) {
  auto folder = hal::FolderSource::open(path, {0, ""});
  if (!folder) return folder.error();
  Clip clip{(*folder)->info().intrinsics.width, (*folder)->info().intrinsics.height, {}};
  if (auto ok = (*folder)->start(); !ok) return ok.error();
  for (;;) {
    std::vector<std::uint16_t> pixels(static_cast<std::size_t>(clip.width) * static_cast<std::size_t>(clip.height));
    const auto frame = (*folder)->next({pixels.data(), clip.width, clip.height}, 0);
    if (!frame && frame.error().code == ErrorCode::end_of_stream) break;
    if (!frame) return frame.error();
    clip.frames.push_back(std::move(pixels));
  }
  if (clip.frames.empty()) return Error{ErrorCode::corrupt, path + " holds no frames"};
  return clip;
}

std::unique_ptr<UsbDevice> make_motor(const Words& words) {
  auto motor = std::make_unique<KinectMotorModel>();
  motor->set_acceleration(words.whole("accel-x"), words.whole("accel-y"), words.whole("accel-z"));
  return motor;
}

Result<std::unique_ptr<UsbDevice>> make_camera(const std::string& kind, Clip clip, const Words& words) {
  if (kind == "uvc") {
    UvcSettings settings;
    settings.width = clip.width;
    settings.height = clip.height;
    settings.fps = words.whole("fps");
    settings.isochronous = words["iso"] != 0;
    settings.serial = "Z16-000" + std::to_string(words["number"]);
    settings.loss_ppm = words.whole("loss-ppm");
    settings.damage_ppm = words.whole("damage-ppm");
    settings.seed = static_cast<std::uint64_t>(words["seed"]);
    return std::unique_ptr<UsbDevice>(new UvcModel(settings, std::move(clip.frames)));
  }
  if (kind == "kinect") {
    if (clip.width != 640 || clip.height != 480)
      return Error{ErrorCode::invalid_argument, "a Kinect's pictures have 640x480 pixels"};
    KinectSettings settings;
    settings.serial = "A0000000000000" + std::to_string(words["number"]) + "A";
    settings.faults.lost_ppm = words.whole("loss-ppm");
    settings.faults.truncated_ppm = words.whole("damage-ppm");
    settings.faults.seed = static_cast<std::uint64_t>(words["seed"]);
    const auto shifts = shifts_of_mm();
    for (auto& frame : clip.frames)
      for (auto& pixel : frame) pixel = shifts[pixel];
    const auto picture = [frames = std::move(clip.frames)](std::uint64_t number, std::span<std::uint16_t> raw) {
      const auto& frame = frames[static_cast<std::size_t>(number % frames.size())];
      std::copy(frame.begin(), frame.end(), raw.begin());
    };
    return std::unique_ptr<UsbDevice>(new KinectCameraModel(settings, picture));
  }
  return Error{ErrorCode::invalid_argument, "no device '" + kind + "'\n" + kUsage};
}

Result<std::unique_ptr<UsbDevice>> make_device(const Words& words) {
  if (words.words() == std::vector<std::string>{"motor"}) return make_motor(words);
  if (words.words().size() != 2) return Error{ErrorCode::invalid_argument, kUsage};
  auto clip = load_clip(words.words()[1]);
  if (!clip) return clip.error();
  return make_camera(words.words()[0], std::move(*clip), words);
}

// Another folder of the same frames, each as `change` leaves it, every `step`th pixel of every `step`th line.
Status rewrite(const std::string& from, const std::string& to, int step,
               const std::function<std::uint16_t(std::uint16_t)>& change) {
  auto folder = hal::FolderSource::open(from);
  if (!folder) return folder.error();
  hal::FolderWriter::Options options;
  options.rotate_deg = (*folder)->info().rotate_deg;
  folder = hal::FolderSource::open(from, {0, ""});
  if (!folder) return folder.error();
  const Intrinsics& k = (*folder)->info().intrinsics;
  const auto per_step = 1.0F / static_cast<float>(step);
  const Intrinsics small{k.width / step,  k.height / step, k.fx * per_step,
                         k.fy * per_step, k.cx * per_step, k.cy * per_step};
  auto writer = hal::FolderWriter::create(to, small, options);
  if (!writer) return writer.error();
  if (auto ok = (*folder)->start(); !ok) return ok;
  std::vector<std::uint16_t> pixels(static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height));
  const DepthImage whole(pixels.data(), k.width, k.height);
  for (;;) {
    const auto frame = (*folder)->next(whole, 0);
    if (!frame && frame.error().code == ErrorCode::end_of_stream) return (*writer)->finish();
    if (!frame) return frame.error();
    std::vector<std::uint16_t> kept;
    for (int v = 0; v < small.height; ++v)
      for (int u = 0; u < small.width; ++u) kept.push_back(change(whole.at(u * step, v * step)));
    if (auto ok = (*writer)->write({kept.data(), small.width, small.height}, *frame); !ok) return ok;
  }
}

// Sleeps; true when the program is to end.
bool pause_ms(long long duration_ms) {
  sigset_t ending;
  sigemptyset(&ending);
  sigaddset(&ending, SIGTERM);
  sigaddset(&ending, SIGINT);
  const timespec duration{static_cast<time_t>(duration_ms / 1000), static_cast<long>(duration_ms % 1000 * 1'000'000)};
  return ::sigtimedwait(&ending, nullptr, duration_ms > 0 ? &duration : nullptr) > 0;
}

void say(const char* what) {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  std::printf("emulator %s at_ms=%lld\n", what,
              static_cast<long long>(std::chrono::duration_cast<std::chrono::milliseconds>(now).count()));
  std::fflush(stdout);
}

// Plugged in for `duration_ms` (0: until a signal). True when the program is to end.
Result<bool> plug_in(UsbDevice& device, long long duration_ms) {
  const auto attached = attach_to_vhci();
  if (!attached) return attached.error();
  UsbipHost host(device, attached->socket);
  Status served = Ok{};
  std::thread thread([&] { served = host.run(); });
  say("plugged");
  const bool end = pause_ms(duration_ms);
  const auto detached = detach_from_vhci(attached->port);
  say("unplugged");
  host.stop();
  thread.join();
  ::close(attached->socket);
  std::printf("emulator submitted=%llu unlinked=%llu packets=%llu\n",
              static_cast<unsigned long long>(host.counts().submitted),
              static_cast<unsigned long long>(host.counts().unlinked),
              static_cast<unsigned long long>(host.counts().packets));
  if (!served) return served.error();
  if (!detached) return detached.error();
  return end;
}

Status play(const Words& words) {
  if (words.words().size() == 3 && words.words()[0] == "shifts") {
    // Every depth becomes the nearest one a Kinect has a raw value for.
    return rewrite(words.words()[1], words.words()[2], 1,
                   [shifts = shifts_of_mm()](std::uint16_t mm) { return mm_of_shift({}, shifts[mm]); });
  }
  if (words.words().size() == 3 && words.words()[0] == "small")
    return rewrite(words.words()[1], words.words()[2], 4, [](std::uint16_t mm) { return mm; });
  auto device = make_device(words);
  if (!device) return device.error();
  for (long long i = 0; i < words["times"]; ++i) {
    const auto end = plug_in(**device, words[i == 0 ? "first-after-ms" : "unplug-after-ms"]);
    if (!end) return end.error();
    if (*end || pause_ms(words["replug-after-ms"])) return Ok{};
  }
  const auto end = plug_in(**device, words["for-ms"]);
  if (!end) return end.error();
  return Ok{};
}

}  // namespace
}  // namespace im2fit::devices

int main(int argc, char** argv) {
  using namespace im2fit::devices;
  // Blocked in every thread: pause_ms() takes them.
  sigset_t ending;
  sigemptyset(&ending);
  sigaddset(&ending, SIGTERM);
  sigaddset(&ending, SIGINT);
  sigprocmask(SIG_BLOCK, &ending, nullptr);
  const Words words(argc, argv,
                    {{"fps", 30},
                     {"iso", 0},
                     {"number", 1},
                     {"accel-x", 0},
                     {"accel-y", 819},
                     {"accel-z", 0},
                     {"loss-ppm", 0},
                     {"damage-ppm", 0},
                     {"seed", 1},
                     {"for-ms", 0},
                     {"times", 0},
                     {"unplug-after-ms", 1500},
                     {"replug-after-ms", 500},
                     {"first-after-ms", 1500}},
                    kUsage);
  if (const auto played = play(words); !played) {
    std::fprintf(stderr, "im2fit-usb-emulator: %s\n", played.error().message.c_str());
    return 1;
  }
  return 0;
}
