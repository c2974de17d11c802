// SPDX-License-Identifier: Apache-2.0
#include "hal/openni2/oni_reader.h"

#include <OniCAPI.h>
#include <poll.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <thread>
#include <vector>

#include "hal/openni2/oni_protocol.h"
#include "hal/openni2/raw_frame.h"
#include "hal/openni2/runtime.h"

namespace im2fit::hal {
namespace {

// Longer than any machine takes to decode one frame. Not for files whose frame count is known: there the parent's
// watchdog decides. A file that was never closed ends where its frames end.
constexpr int kUnclosedEnd_ms = 1000;

bool write_all(int fd, const void* data, std::size_t size) {
  const auto* at = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t n = ::write(fd, at, size);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    at += n;
    size -= static_cast<std::size_t>(n);
  }
  return true;
}

bool send(int fd, oni::Kind kind, const void* payload, std::size_t size) {
  const oni::Header header{oni::kMagic, kind, static_cast<std::uint32_t>(size), 0};
  return write_all(fd, &header, sizeof header) && write_all(fd, payload, size);
}

int fail(int fd, std::string message) {
  if (message.size() > oni::kFailureBytesMax) message.resize(oni::kFailureBytesMax);
  send(fd, oni::Kind::failure, message.data(), message.size());
  return 1;
}

// Ends the process when no process reads any more, also while the runtime hangs.
void leave_with_the_reader(int fd) {
  std::thread([fd] {
    for (;;) {
      pollfd item{fd, 0, 0};  // POLLERR alone: the pipe's other end was closed
      if (::poll(&item, 1, -1) > 0 && (item.revents & (POLLERR | POLLHUP | POLLNVAL)) != 0) ::_exit(3);
    }
  }).detach();
}

void limit_resources() {
  const rlimit no_core{0, 0};
  ::setrlimit(RLIMIT_CORE, &no_core);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  const rlimit memory{rlim_t{1} << 31, rlim_t{1} << 31};  // a damaged size field must not take the machine's memory
  ::setrlimit(RLIMIT_AS, &memory);
#endif
}

struct Player {
  OniDeviceHandle device = nullptr;
  OniStreamHandle stream = nullptr;
  OniVideoMode mode{};
  bool mirrored = false;
  oni::Hello hello;
};

template <class T>
bool get(OniStreamHandle stream, int property, T& value) {
  int size = sizeof value;
  return oniStreamGetProperty(stream, property, &value, &size) == ONI_STATUS_OK;
}

int unit_um(OniPixelFormat format) {
  return format == ONI_PIXEL_FORMAT_DEPTH_100_UM ? 100 : 1000;
}

// "" or what is wrong.
std::string open(const std::string& path, Player& player) {
  if (oniInitialize(ONI_API_VERSION) != ONI_STATUS_OK)
    return "the OpenNI2 runtime does not start (" + openni2_complaint() + ")";
  if (oniDeviceOpen(path.c_str(), &player.device) != ONI_STATUS_OK)
    return "OpenNI2 does not take it for a recording (" + openni2_complaint() + ")";
  if (oniDeviceGetSensorInfo(player.device, ONI_SENSOR_DEPTH) == nullptr ||
      oniDeviceCreateStream(player.device, ONI_SENSOR_DEPTH, &player.stream) != ONI_STATUS_OK)
    return "it holds no depth stream";
  if (!get(player.stream, ONI_STREAM_PROPERTY_VIDEO_MODE, player.mode)) return "it does not report its picture size";
  const OniPixelFormat format = player.mode.pixelFormat;
  if (format != ONI_PIXEL_FORMAT_DEPTH_1_MM && format != ONI_PIXEL_FORMAT_DEPTH_100_UM)
    return "its depth is in format " + std::to_string(format) + ", expected 1 mm or 100 um";
  oni::Hello& hello = player.hello;
  hello.width = player.mode.resolutionX;
  hello.height = player.mode.resolutionY;
  hello.fps = player.mode.fps;
  if (hello.width < 1 || hello.height < 1 || hello.width > kImageSideMax || hello.height > kImageSideMax)
    return "its pictures are " + std::to_string(hello.width) + "x" + std::to_string(hello.height) + " pixels";
  get(player.stream, ONI_STREAM_PROPERTY_HORIZONTAL_FOV, hello.horizontal_rad);
  get(player.stream, ONI_STREAM_PROPERTY_VERTICAL_FOV, hello.vertical_rad);
  int frames = -1;
  hello.frame_count = get(player.stream, ONI_STREAM_PROPERTY_NUMBER_OF_FRAMES, frames) ? frames : -1;
  OniBool mirror = FALSE;
  player.mirrored = get(player.stream, ONI_STREAM_PROPERTY_MIRRORING, mirror) && mirror != FALSE;
  // Speed -1 makes a frame only when one is requested: none is lost, whatever the reader's pace (0 loses some).
  const float on_demand = -1;
  const OniBool once = FALSE;
  oniDeviceSetProperty(player.device, ONI_DEVICE_PROPERTY_PLAYBACK_SPEED, &on_demand, sizeof on_demand);
  oniDeviceSetProperty(player.device, ONI_DEVICE_PROPERTY_PLAYBACK_REPEAT_ENABLED, &once, sizeof once);
  return "";
}

int play(Player& player, int fd) {
  if (oniStreamStart(player.stream) != ONI_STATUS_OK) return fail(fd, "its depth stream does not start");
  const auto pixels = static_cast<std::size_t>(player.hello.width) * static_cast<std::size_t>(player.hello.height);
  std::vector<std::byte> message(sizeof(oni::Frame) + pixels * sizeof(std::uint16_t));
  auto* depths = reinterpret_cast<std::uint16_t*>(message.data() + sizeof(oni::Frame));
  const bool counted = player.hello.frame_count >= 0;
  // Frames are numbered up to the file's count, and numbers may be missing.
  for (int count = 0, number = 0; !counted || std::max(count, number) < player.hello.frame_count; ++count) {
    // One wait requests one frame. A second wait for the same frame would request another, which would overwrite it:
    // so the timeout here is not short.
    int index = -1;
    if (oniWaitForAnyStream(&player.stream, 1, &index, counted ? ONI_TIMEOUT_FOREVER : kUnclosedEnd_ms) !=
        ONI_STATUS_OK) {
      if (counted) return fail(fd, "frame " + std::to_string(count) + " does not come");
      break;
    }
    OniFrame* frame = nullptr;
    if (oniStreamReadFrame(player.stream, &frame) != ONI_STATUS_OK || frame == nullptr)
      return fail(fd, "frame " + std::to_string(count) + " cannot be read");
    const bool cropped = frame->croppingEnabled != FALSE;
    const RawFrame raw{frame->data,
                       static_cast<std::size_t>(std::max(frame->dataSize, 0)),
                       frame->width,
                       frame->height,
                       frame->stride,
                       cropped ? frame->cropOriginX : 0,
                       cropped ? frame->cropOriginY : 0,
                       unit_um(player.mode.pixelFormat),
                       player.mirrored};
    if (!copy_raw_frame(raw, DepthImage(depths, player.hello.width, player.hello.height)))
      return fail(fd, "frame " + std::to_string(count) + " does not fit the picture size");
    const oni::Frame about{static_cast<std::uint32_t>(frame->frameIndex), frame->timestamp};
    std::memcpy(message.data(), &about, sizeof about);
    number = frame->frameIndex;
    oniFrameRelease(frame);
    if (!send(fd, oni::Kind::frame, message.data(), message.size())) return 3;
  }
  const oni::End end{counted ? 1U : 0U};
  return send(fd, oni::Kind::end, &end, sizeof end) ? 0 : 3;
}

}  // namespace

int serve_oni(const std::string& path, int fd) {
  limit_resources();
  leave_with_the_reader(fd);
  std::error_code code;
  const std::string absolute = std::filesystem::absolute(path, code).string();
  Player player;
  const std::string wrong = open(code ? path : absolute, player);
  if (!wrong.empty()) return fail(fd, wrong);
  if (!send(fd, oni::Kind::hello, &player.hello, sizeof player.hello)) return 3;
  return play(player, fd);
}

}  // namespace im2fit::hal
