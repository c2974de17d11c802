// SPDX-License-Identifier: Apache-2.0
#include "hal/openni2/openni2_source.h"

#include <OniCAPI.h>

#include <atomic>
#include <cstdlib>
#include <cstring>

#include "hal/frame_path.h"
#include "hal/intrinsics.h"
#include "hal/known_sensors.h"
#include "hal/openni2/raw_frame.h"

namespace im2fit::hal {
namespace {

constexpr int kWaitSlice_ms = 50;  // how late a lost device may be noticed

int unit_um(OniPixelFormat format) {
  if (format == ONI_PIXEL_FORMAT_DEPTH_1_MM) return 1000;
  if (format == ONI_PIXEL_FORMAT_DEPTH_100_UM) return 100;
  return 0;
}

// Smaller is better: size first, then unit, then rate.
long mode_cost(const OniVideoMode& mode, const OpenNi2Options& wanted) {
  const long size = std::labs(static_cast<long>(mode.resolutionX) - wanted.width) +
                    std::labs(static_cast<long>(mode.resolutionY) - wanted.height);
  const bool unit_off = (unit_um(mode.pixelFormat) == 100) != wanted.fine_units;
  return size * 10'000 + (unit_off ? 1'000 : 0) + std::labs(static_cast<long>(mode.fps) - wanted.fps);
}

template <class T>
bool get(OniStreamHandle stream, int property, T& value) {
  int size = sizeof value;
  return oniStreamGetProperty(stream, property, &value, &size) == ONI_STATUS_OK &&
         size == static_cast<int>(sizeof value);
}

}  // namespace

struct OpenNi2Source::Impl {
  std::shared_ptr<OpenNi2Runtime> runtime;
  OniCallbackHandle callbacks = nullptr;
  OniDeviceHandle device = nullptr;
  OniStreamHandle stream = nullptr;
  OniDeviceInfo device_info{};
  OniVideoMode mode{};
  bool mirrored = false;
  bool started = false;
  std::atomic<bool> lost{false};
  SourceInfo info;
  UprightPath path;
  SequenceBook book;

  ~Impl();
  Status open_device(const std::string& uri, const OpenNi2Options& options);
  Status choose_mode(const OpenNi2Options& options);
  Result<Calibration> find_calibration(const OpenNi2Options& options);
  Error no_device() const {
    return {ErrorCode::no_device, info.name + " (" + info.uri + ") was disconnected; plug it in and open it again"};
  }
  static void on_disconnected(const OniDeviceInfo* gone, void* cookie);
};

void OpenNi2Source::Impl::on_disconnected(const OniDeviceInfo* gone, void* cookie) {
  auto* self = static_cast<Impl*>(cookie);
  if (std::strcmp(gone->uri, self->device_info.uri) == 0) self->lost = true;
}

OpenNi2Source::Impl::~Impl() {
  if (callbacks != nullptr) oniUnregisterDeviceCallbacks(callbacks);
  if (stream != nullptr) {
    oniStreamStop(stream);
    oniStreamDestroy(stream);
  }
  if (device != nullptr) oniDeviceClose(device);
}

Status OpenNi2Source::Impl::open_device(const std::string& uri, const OpenNi2Options& options) {
  const std::string what = uri.empty() ? "the first OpenNI2 camera" : uri;
  oniGetExtendedError();
  if (oniDeviceOpen(uri.empty() ? nullptr : uri.c_str(), &device) != ONI_STATUS_OK) {
    device = nullptr;
    return Error{ErrorCode::no_device, "cannot open " + what + " (" + openni2_complaint() +
                                           "); is it plugged in? `im2fit devices` lists connected cameras"};
  }
  oniDeviceGetInfo(device, &device_info);
  info.uri = std::string("openni2:") + device_info.uri;
  info.name = std::string(device_info.vendor) + " " + device_info.name;
  info.sensor = sensor_of_usb(device_info.usbVendorId, device_info.usbProductId);
  info.live = true;
  info.rotate_deg = options.rotate_deg;
  char serial[128] = "";
  int size = sizeof serial;
  if (oniDeviceGetProperty(device, ONI_DEVICE_PROPERTY_SERIAL_NUMBER, serial, &size) == ONI_STATUS_OK) {
    serial[sizeof serial - 1] = '\0';
    info.serial = serial;
  }
  OniDeviceCallbacks wanted{};
  wanted.deviceDisconnected = on_disconnected;
  if (oniRegisterDeviceCallbacks(&wanted, this, &callbacks) != ONI_STATUS_OK) callbacks = nullptr;
  if (oniDeviceCreateStream(device, ONI_SENSOR_DEPTH, &stream) != ONI_STATUS_OK) {
    stream = nullptr;
    return Error{ErrorCode::unsupported, info.name + " has no depth stream (" + openni2_complaint() + ")"};
  }
  return Ok{};
}

Status OpenNi2Source::Impl::choose_mode(const OpenNi2Options& options) {
  const OniSensorInfo* sensor = oniDeviceGetSensorInfo(device, ONI_SENSOR_DEPTH);
  const OniVideoMode* best = nullptr;
  for (int i = 0; sensor != nullptr && i < sensor->numSupportedVideoModes; ++i) {
    const OniVideoMode& candidate = sensor->pSupportedVideoModes[i];
    if (unit_um(candidate.pixelFormat) == 0 || candidate.resolutionX < 1 || candidate.resolutionY < 1 ||
        candidate.resolutionX > kImageSideMax || candidate.resolutionY > kImageSideMax)
      continue;
    if (best == nullptr || mode_cost(candidate, options) < mode_cost(*best, options)) best = &candidate;
  }
  if (best == nullptr)
    return Error{ErrorCode::unsupported, info.name + " offers no depth mode in 1 mm or 100 um up to " +
                                             std::to_string(kImageSideMax) + " pixels a side"};
  mode = *best;
  if (oniStreamSetProperty(stream, ONI_STREAM_PROPERTY_VIDEO_MODE, &mode, sizeof mode) != ONI_STATUS_OK)
    return Error{ErrorCode::io, info.name + " refuses its own mode " + std::to_string(mode.resolutionX) + "x" +
                                    std::to_string(mode.resolutionY) + " at " + std::to_string(mode.fps) + " fps (" +
                                    openni2_complaint() + ")"};
  // The depth camera's own view: neither mirrored nor moved onto the colour camera, whose intrinsics are others. A
  // device that keeps its mirror on is turned back here.
  const OniImageRegistrationMode off = ONI_IMAGE_REGISTRATION_OFF;
  oniDeviceSetProperty(device, ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION, &off, sizeof off);
  const OniBool plain = FALSE;
  oniStreamSetProperty(stream, ONI_STREAM_PROPERTY_MIRRORING, &plain, sizeof plain);
  OniBool mirror = FALSE;
  mirrored = get(stream, ONI_STREAM_PROPERTY_MIRRORING, mirror) && mirror != FALSE;
  return Ok{};
}

Result<Calibration> OpenNi2Source::Impl::find_calibration(const OpenNi2Options& options) {
  if (options.calibration) {
    const Intrinsics& k = options.calibration->intrinsics;
    if (k.width == mode.resolutionX && k.height == mode.resolutionY) return *options.calibration;
    return Error{ErrorCode::invalid_argument, "the calibration is of " + std::to_string(k.width) + "x" +
                                                  std::to_string(k.height) + " pictures, " + info.name +
                                                  " delivers " + std::to_string(mode.resolutionX) + "x" +
                                                  std::to_string(mode.resolutionY) + "; give the one of this mode"};
  }
  float horizontal_rad = 0;
  float vertical_rad = 0;
  if (!get(stream, ONI_STREAM_PROPERTY_HORIZONTAL_FOV, horizontal_rad) ||
      !get(stream, ONI_STREAM_PROPERTY_VERTICAL_FOV, vertical_rad))
    return Error{ErrorCode::unsupported, info.name + " does not report its field of view; give --camera FILE"};
  const auto k =
      intrinsics_from_field_of_view(mode.resolutionX, mode.resolutionY, horizontal_rad, vertical_rad, info.name);
  if (!k) return k.error();
  return Calibration{*k, {}, {}, IntrinsicsOrigin::field_of_view};
}

OpenNi2Source::OpenNi2Source(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
OpenNi2Source::~OpenNi2Source() = default;
const SourceInfo& OpenNi2Source::info() const {
  return impl_->info;
}
SourceStats OpenNi2Source::stats() const {
  return impl_->book.stats();
}

Result<std::unique_ptr<OpenNi2Source>> OpenNi2Source::open(const std::string& uri, const OpenNi2Options& options) {
  if (!is_rotation(options.rotate_deg))
    return Error{ErrorCode::invalid_argument,
                 "rotation is " + std::to_string(options.rotate_deg) + ", expected 0, 90, 180 or 270 degrees"};
  auto runtime = OpenNi2Runtime::get();
  if (!runtime) return runtime.error();
  auto impl = std::make_unique<Impl>();
  impl->runtime = *runtime;
  if (auto ok = impl->open_device(uri, options); !ok) return ok.error();
  if (auto ok = impl->choose_mode(options); !ok) return ok.error();
  const auto camera = impl->find_calibration(options);
  if (!camera) return camera.error();
  auto upright = UprightPath::make(*camera, options.rotate_deg, "the calibration of " + impl->info.name);
  if (!upright) return upright.error();
  impl->path = std::move(*upright);
  impl->info.intrinsics_origin = camera->origin;
  impl->info.intrinsics = impl->path.upright();
  return std::unique_ptr<OpenNi2Source>(new OpenNi2Source(std::move(impl)));
}

Status OpenNi2Source::start() {
  Impl& d = *impl_;
  if (d.lost) return d.no_device();
  if (d.started) return Ok{};
  d.book.reset();
  if (oniStreamStart(d.stream) != ONI_STATUS_OK)
    return Error{ErrorCode::io,
                 d.info.name + " does not start (" + openni2_complaint() + "); is another program using it?"};
  d.started = true;
  return Ok{};
}

Result<FrameInfo> OpenNi2Source::next(DepthImage depth, int timeout_ms) {
  Impl& d = *impl_;
  if (auto ok = d.path.check(depth, d.info.name); !ok) return ok.error();
  if (!d.started) return Error{ErrorCode::invalid_argument, d.info.name + " is not started; call start() first"};
  for (int waited_ms = 0;;) {
    if (d.lost) return d.no_device();
    const int slice_ms = timeout_ms - waited_ms < kWaitSlice_ms ? timeout_ms - waited_ms : kWaitSlice_ms;
    int index = -1;
    const OniStatus status = oniWaitForAnyStream(&d.stream, 1, &index, slice_ms > 0 ? slice_ms : 0);
    if (status == ONI_STATUS_OK) break;
    if (status != ONI_STATUS_TIME_OUT)
      return Error{ErrorCode::io, d.info.name + ": waiting for a frame failed (" + openni2_complaint() + ")"};
    waited_ms += slice_ms > 0 ? slice_ms : 0;
    if (waited_ms >= timeout_ms)
      return d.lost
                 ? d.no_device()
                 : Error{ErrorCode::timeout, d.info.name + ": no frame within " + std::to_string(timeout_ms) + " ms"};
  }
  OniFrame* frame = nullptr;
  if (oniStreamReadFrame(d.stream, &frame) != ONI_STATUS_OK || frame == nullptr)
    return d.lost ? d.no_device()
                  : Error{ErrorCode::io, d.info.name + ": reading a frame failed (" + openni2_complaint() + ")"};
  const std::int64_t now_ns = monotonic_ns();
  RawFrame raw{frame->data,
               static_cast<std::size_t>(frame->dataSize > 0 ? frame->dataSize : 0),
               frame->width,
               frame->height,
               frame->stride,
               frame->croppingEnabled != FALSE ? frame->cropOriginX : 0,
               frame->croppingEnabled != FALSE ? frame->cropOriginY : 0,
               unit_um(frame->videoMode.pixelFormat),
               d.mirrored};
  const FrameInfo result{static_cast<std::uint64_t>(static_cast<std::uint32_t>(frame->frameIndex)), now_ns,
                         static_cast<std::int64_t>(frame->timestamp)};
  const bool good = copy_raw_frame(raw, d.path.camera_image());
  oniFrameRelease(frame);
  if (!good) {
    d.book.damaged();
    return Error{ErrorCode::corrupt, d.info.name + ": a frame's size does not fit its mode; it is skipped"};
  }
  d.path.deliver(depth);
  d.book.saw(result.sequence);
  return result;
}

void OpenNi2Source::stop() {
  if (impl_->started) oniStreamStop(impl_->stream);
  impl_->started = false;
}

}  // namespace im2fit::hal
