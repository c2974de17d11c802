// SPDX-License-Identifier: Apache-2.0
#include "hal/v4l2/v4l2_source.h"

#include <linux/videodev2.h>
#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <utility>

#include "hal/intrinsics.h"
#include "hal/v4l2/negotiate.h"

namespace im2fit::hal {
namespace {

constexpr int kControlsMax = 1024;
constexpr int kDefaultUnit_um = 1000;

Result<std::uint32_t> find_control(VideoDevice& device, const std::string& name, const std::string& what) {
  std::string others;
  std::uint32_t id = 0;
  for (int i = 0; i < kControlsMax; ++i) {
    v4l2_queryctrl entry{};
    entry.id = id | V4L2_CTRL_FLAG_NEXT_CTRL;
    if (device.request(VIDIOC_QUERYCTRL, &entry) != 0 || entry.id <= id) break;
    id = entry.id;
    if (entry.type == V4L2_CTRL_TYPE_CTRL_CLASS || (entry.flags & V4L2_CTRL_FLAG_DISABLED) != 0) continue;
    const auto* text = reinterpret_cast<const char*>(entry.name);
    const std::string found(text, ::strnlen(text, sizeof entry.name));
    if (found == name) return id;
    if (others.size() < 400) others += (others.empty() ? "'" : ", '") + found + "'";
  }
  return Error{ErrorCode::not_found, what + " has no control '" + name + "'; it has " +
                                         (others.empty() ? std::string("none") : others) +
                                         "; or give the unit itself, ?unit_um=1000"};
}

// Micrometres to a step of the camera's values. V4L2 defines none for Z16 and has no control for it, so: the user's
// value, else the driver's control the user names, else 1000. INZI cameras have units of their own and no default.
// Errors: invalid_argument, not_found (no such control; the error lists those there are), unsupported.
Result<int> depth_unit_um(VideoDevice& device, V4l2Format format, const V4l2Options& options,
                          const std::string& what) {
  if (options.unit_um) {
    if (*options.unit_um >= 1 && *options.unit_um <= 100'000) return *options.unit_um;
    return Error{ErrorCode::invalid_argument, what + ": the depth unit is " + std::to_string(*options.unit_um) +
                                                  " micrometres, expected 1 to 100000"};
  }
  if (options.unit_control.empty()) {
    if (format != V4l2Format::inzi) return kDefaultUnit_um;
    return Error{ErrorCode::invalid_argument,
                 what +
                     " delivers INZI, whose depth unit is the camera's own (0.125 mm is usual); give "
                     "?unit_um=125"};
  }
  const auto id = find_control(device, options.unit_control, what);
  if (!id) return id.error();
  v4l2_control control{*id, 0};
  if (const int error = device.request(VIDIOC_G_CTRL, &control); error != 0)
    return device_error(error, what, "reading control '" + options.unit_control + "'");
  if (control.value >= 1 && control.value <= 100'000) return static_cast<int>(control.value);
  return Error{ErrorCode::unsupported, what + ": control '" + options.unit_control + "' is " +
                                           std::to_string(control.value) +
                                           ", expected 1 to 100000 micrometres; give ?unit_um=1000 instead"};
}

// Announced but not there: a driver may do so once; one that goes on would make us spin.
constexpr int kFalseAlarmsMax = 3;

Result<Calibration> find_calibration(const V4l2Options& options, const DepthLayout& layout, const std::string& what) {
  if (options.calibration) {
    const Intrinsics& k = options.calibration->intrinsics;
    if (k.width == layout.width && k.height == layout.height) return *options.calibration;
    return Error{ErrorCode::invalid_argument, "the calibration is of " + std::to_string(k.width) + "x" +
                                                  std::to_string(k.height) + " pictures, " + what + " delivers " +
                                                  std::to_string(layout.width) + "x" + std::to_string(layout.height) +
                                                  "; give the one of this mode"};
  }
  if (!options.hfov_deg)
    return Error{ErrorCode::invalid_argument,
                 what +
                     ": V4L2 cameras do not report their field of view, and a wrong one falsifies every length; give "
                     "--camera FILE, or the horizontal angle of the data sheet, ?hfov=DEGREES"};
  const double horizontal_rad = static_cast<double>(*options.hfov_deg) * std::numbers::pi / 180;
  const double vertical_rad = 2 * std::atan(std::tan(horizontal_rad / 2) * layout.height / layout.width);
  const auto k = intrinsics_from_field_of_view(layout.width, layout.height, static_cast<float>(horizontal_rad),
                                               static_cast<float>(vertical_rad), what);
  if (!k) return k.error();
  return Calibration{*k, {}, {}, IntrinsicsOrigin::field_of_view};
}

// The driver's time of the frame where it is CLOCK_MONOTONIC's and can be one: within a century of starting.
std::optional<std::int64_t> stamp_ns(const v4l2_buffer& buffer) {
  if ((buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) != V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC) return std::nullopt;
  const auto seconds = std::int64_t{buffer.timestamp.tv_sec};
  const auto micros = std::int64_t{buffer.timestamp.tv_usec};
  if (seconds < 0 || seconds > 3'000'000'000 || micros < 0 || micros >= 1'000'000) return std::nullopt;
  const std::int64_t ns = seconds * 1'000'000'000 + micros * 1000;
  return ns > 0 ? std::optional<std::int64_t>(ns) : std::nullopt;
}

// Which of the system's video nodes is the depth camera.

constexpr const char* kPrefix = "video";

// The numbers behind /dev/video, ascending.
std::vector<int> node_numbers() {
  std::vector<int> numbers;
  std::error_code code;
  for (std::filesystem::directory_iterator i("/dev", code), end; !code && i != end; i.increment(code)) {
    const std::string name = i->path().filename().string();
    if (name.rfind(kPrefix, 0) != 0) continue;
    int number = -1;
    const char* begin = name.data() + 5;
    const char* past = name.data() + name.size();
    if (const auto read = std::from_chars(begin, past, number); read.ec == std::errc() && read.ptr == past)
      numbers.push_back(number);
  }
  std::sort(numbers.begin(), numbers.end());
  return numbers;
}

// The serial number of the USB device behind /dev/videoN, "" when there is none or the kernel does not report it.
std::string v4l2_serial(const std::string& path) {
  // "device" is the USB interface; its parent, the device, has the number.
  const std::string node = std::filesystem::path(path).filename().string();
  std::error_code code;
  const auto device = std::filesystem::canonical("/sys/class/video4linux/" + node + "/device", code);
  if (code) return "";
  std::ifstream file(device.parent_path() / "serial");
  std::string serial;
  std::getline(file, serial);
  return serial;
}

struct Nodes {
  std::vector<V4l2Device> depth;
  std::string closed;  // why the first node that does not open does not
};

Nodes look() {
  Nodes nodes;
  for (const int number : node_numbers()) {
    const std::string path = std::string("/dev/") + kPrefix + std::to_string(number);
    const auto device = open_video_device(path);
    if (!device) {
      if (nodes.closed.empty()) nodes.closed = device.error().message;
      continue;
    }
    const auto camera = describe_camera(**device, path);
    if (camera && camera->is_depth()) nodes.depth.push_back({path, camera->name, v4l2_serial(path)});
  }
  return nodes;
}

// The node `path`, or when "" the first depth camera; with `serial` not "" the one with that number: nodes are
// numbered anew with every plugging in. Error: no_device, listing what is there.
Result<std::string> find_v4l2_node(const std::string& path, const std::string& serial) {
  const Nodes nodes = look();
  std::string there;
  // The first: one camera may have several depth nodes, and twins may share a number.
  for (const V4l2Device& device : nodes.depth) {
    if ((path.empty() || device.path == path) && (serial.empty() || device.serial == serial)) return device.path;
    there += (there.empty() ? "" : ", ") + device.path + (device.serial.empty() ? "" : " (" + device.serial + ")");
  }
  return Error{ErrorCode::no_device,
               "no V4L2 depth camera" + (serial.empty() ? std::string() : " with serial " + serial) +
                   (path.empty() ? std::string() : " at " + path) + "; there " +
                   (there.empty() ? std::string("is none that offers Z16 or INZI") : "is " + there) +
                   (nodes.closed.empty() ? "" : " (" + nodes.closed + ")")};
}

}  // namespace

Result<std::unique_ptr<V4l2Source>> V4l2Source::open(const V4l2Options& options) {
  V4l2Options named = options;
  if (options.path.empty() || !options.serial.empty()) {
    const auto path = find_v4l2_node(options.path, options.serial);
    if (!path) return path.error();
    named.path = *path;
  }
  auto device = open_video_device(named.path);
  if (!device) return device.error();
  auto source = open(std::move(*device), named.path, named);
  if (!source) return source.error();
  // Nodes are numbered anew when the camera comes back; its number stays, where no twin has the same.
  named.serial = (*source)->info_.serial = v4l2_serial(named.path);
  const auto found = named.serial.empty() ? Result<std::string>(std::string()) : find_v4l2_node("", named.serial);
  if (!found || *found != named.path) named.serial.clear();
  (*source)->info_.uri = v4l2_uri(named);
  return source;
}

Result<std::unique_ptr<V4l2Source>> V4l2Source::open(std::unique_ptr<VideoDevice> device, const std::string& name,
                                                     const V4l2Options& options) {
  if (!is_rotation(options.rotate_deg))
    return Error{ErrorCode::invalid_argument,
                 "rotation is " + std::to_string(options.rotate_deg) + ", expected 0, 90, 180 or 270 degrees"};
  std::unique_ptr<V4l2Source> source(new V4l2Source);
  source->device_ = std::move(device);
  source->options_ = options;
  source->options_.buffer_count = std::clamp(options.buffer_count, 2, 32);
  const auto camera = describe_camera(*source->device_, name);
  if (!camera) return camera.error();
  auto mode = negotiate(*source->device_, *camera, options, name);
  if (!mode) return mode.error();
  const auto unit_um = depth_unit_um(*source->device_, mode->format, options, name);
  if (!unit_um) return unit_um.error();
  mode->layout.unit_um = *unit_um;
  const auto calibration = find_calibration(options, mode->layout, name);
  if (!calibration) return calibration.error();
  auto upright = UprightPath::make(*calibration, options.rotate_deg, "the calibration of " + name);
  if (!upright) return upright.error();
  source->mode_ = *mode;
  source->path_ = std::move(*upright);
  SourceInfo& info = source->info_;
  V4l2Options words = options;
  words.path = name;
  words.serial.clear();
  info.uri = v4l2_uri(words);
  info.name = camera->name;
  info.intrinsics = source->path_.upright();
  info.intrinsics_origin = calibration->origin;
  info.rotate_deg = options.rotate_deg;
  info.live = true;
  return source;
}

V4l2Source::~V4l2Source() {
  stop();
}

Error V4l2Source::fail(int error, const std::string& doing) {
  Error failure = device_error(error, info_.name + " (" + info_.uri + ")", doing);
  lost_ = failure.code == ErrorCode::no_device;
  return failure;
}

Status V4l2Source::map_buffers() {
  v4l2_requestbuffers request{};
  request.count = static_cast<__u32>(options_.buffer_count);
  request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  request.memory = V4L2_MEMORY_MMAP;
  if (const int error = device_->request(VIDIOC_REQBUFS, &request); error != 0)
    return fail(error, "requesting buffers");
  // A driver may give fewer than requested, or more; two are the least with which frames flow.
  const auto count = std::min(request.count, static_cast<__u32>(options_.buffer_count));
  if (count < 2)
    return Error{ErrorCode::io, info_.name + " provides " + std::to_string(count) + " buffers, expected at least 2"};
  for (std::uint32_t i = 0; i < count; ++i) {
    v4l2_buffer about{};
    about.index = i;
    about.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    about.memory = V4L2_MEMORY_MMAP;
    if (const int error = device_->request(VIDIOC_QUERYBUF, &about); error != 0)
      return fail(error, "querying a buffer");
    if (about.length < mode_.layout.size_bytes())
      return Error{ErrorCode::io, info_.name + " provides buffers of " + std::to_string(about.length) +
                                      " bytes for pictures of " + std::to_string(mode_.layout.size_bytes())};
    const std::byte* address = device_->map(about.length, about.m.offset);
    if (address == nullptr) return Error{ErrorCode::io, info_.name + ": its buffers cannot be mapped"};
    buffers_.push_back({address, about.length});
    if (auto ok = queue(i); !ok) return ok;
  }
  return Ok{};
}

Status V4l2Source::queue(std::uint32_t index) {
  v4l2_buffer buffer{};
  buffer.index = index;
  buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  buffer.memory = V4L2_MEMORY_MMAP;
  if (const int error = device_->request(VIDIOC_QBUF, &buffer); error != 0)
    return fail(error, "handing back a buffer");
  return Ok{};
}

Status V4l2Source::start() {
  if (lost_) return fail(ENODEV, "starting");
  if (started_) return Ok{};
  book_.reset();
  counted_ = false;
  started_ = true;  // from here on there is something for stop() to undo
  auto ok = map_buffers();
  if (ok) {
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (const int error = device_->request(VIDIOC_STREAMON, &type); error != 0) ok = fail(error, "starting");
  }
  if (!ok) stop();
  return ok;
}

void V4l2Source::stop() {
  if (!started_) return;
  started_ = false;
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  device_->request(VIDIOC_STREAMOFF, &type);
  for (const Buffer& buffer : buffers_) device_->unmap(buffer.address, buffer.size_bytes);
  buffers_.clear();
  v4l2_requestbuffers none{};
  none.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  none.memory = V4L2_MEMORY_MMAP;
  device_->request(VIDIOC_REQBUFS, &none);
}

// The driver's number has 32 bits and wraps after 4.5 years, or when a driver begins near the end.
std::uint64_t V4l2Source::whole_sequence(std::uint32_t sequence) {
  if (!counted_) {
    counted_ = true;
    sequence_ = sequence;
  } else {
    const auto step = static_cast<std::int32_t>(sequence - static_cast<std::uint32_t>(sequence_));
    // Never below the first turn: a driver that starts over counts as a repeat.
    if (step >= 0 || static_cast<std::uint64_t>(-std::int64_t{step}) <= sequence_)
      sequence_ += static_cast<std::uint64_t>(std::int64_t{step});
    else
      sequence_ = sequence;
  }
  return sequence_;
}

Result<V4l2Source::Filled> V4l2Source::take_filled(int timeout_ms) {
  const std::int64_t deadline_ns = monotonic_ns() + std::int64_t{timeout_ms} * 1'000'000;
  for (int false_alarms = 0; false_alarms < kFalseAlarmsMax; ++false_alarms) {
    short events = 0;
    const std::int64_t left_ms = (deadline_ns - monotonic_ns() + 999'999) / 1'000'000;
    const int wait_ms = static_cast<int>(std::clamp<std::int64_t>(left_ms, 0, std::max(timeout_ms, 0)));
    if (const int error = device_->wait(wait_ms, events); error != 0) return fail(error, "waiting for a frame");
    if (events == 0)
      return Error{ErrorCode::timeout, info_.name + ": no frame within " + std::to_string(timeout_ms) + " ms"};
    if ((events & POLLIN) == 0) return fail(ENODEV, "waiting for a frame");
    v4l2_buffer buffer{};
    buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    buffer.memory = V4L2_MEMORY_MMAP;
    const int error = device_->request(VIDIOC_DQBUF, &buffer);
    if (error == EAGAIN) continue;
    if (error != 0) return fail(error, "taking a frame");
    if (buffer.index >= buffers_.size())
      return Error{ErrorCode::io, info_.name + " hands over buffer " + std::to_string(buffer.index) + " of " +
                                      std::to_string(buffers_.size())};
    Filled filled;
    filled.index = buffer.index;
    filled.used_bytes = std::min<std::size_t>(buffer.bytesused, buffers_[buffer.index].size_bytes);
    filled.faulty = (buffer.flags & V4L2_BUF_FLAG_ERROR) != 0;
    filled.info.sequence = whole_sequence(buffer.sequence);
    filled.info.host_ns = stamp_ns(buffer).value_or(monotonic_ns());
    return filled;
  }
  return Error{ErrorCode::io, info_.name + " announces frames it does not have"};
}

Result<FrameInfo> V4l2Source::next(DepthImage depth, int timeout_ms) {
  if (auto ok = path_.check(depth, info_.name); !ok) return ok.error();
  if (!started_) return Error{ErrorCode::invalid_argument, info_.name + " is not started; call start() first"};
  if (lost_) return fail(ENODEV, "waiting for a frame");
  const auto filled = take_filled(timeout_ms);
  if (!filled) return filled.error();
  const bool good = !filled->faulty && copy_depth({buffers_[filled->index].address, filled->used_bytes}, mode_.layout,
                                                  path_.camera_image());
  const auto queued = queue(filled->index);
  if (!good) {
    book_.damaged();
    return Error{ErrorCode::corrupt,
                 info_.name + ": frame " + std::to_string(filled->info.sequence) +
                     (filled->faulty ? " came damaged"
                                     : " has " + std::to_string(filled->used_bytes) + " bytes of " +
                                           std::to_string(mode_.layout.size_bytes())) +
                     "; it is skipped"};
  }
  // The frame is whole even when its buffer could not be handed back; the next call reports the loss.
  if (!queued && !lost_) return queued.error();
  path_.deliver(depth);
  book_.saw(filled->info.sequence);
  return filled->info;
}

std::vector<V4l2Device> list_v4l2_devices() {
  return look().depth;
}

}  // namespace im2fit::hal
