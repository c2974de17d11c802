// SPDX-License-Identifier: Apache-2.0
#include "hal/usb/kinect_source.h"

#include <utility>

namespace im2fit::hal {

using namespace kinect;

KinectSource::KinectSource(std::unique_ptr<UsbTransport> camera, std::unique_ptr<UsbTransport> motor,
                           const KinectIdentity& identity)
    : camera_(std::move(camera)), commands_(*camera_, identity.name + " (" + identity.uri + ")") {
  if (motor) motor_ = std::make_unique<KinectMotor>(std::move(motor), identity.name + " (" + identity.uri + ")");
  info_.uri = identity.uri;
  info_.name = identity.name;
  info_.serial = identity.serial;
  info_.sensor = SensorKind::structured_light;
  info_.live = true;
}

Status KinectSource::set_up(const KinectOptions& options) {
  const auto reported = commands_.zero_plane();
  if (!reported) return reported.error();
  if (*reported) plane_ = **reported;
  table_ = shift_table(plane_);
  const float focal_px = focal_length_px(plane_);
  Calibration camera;
  camera.intrinsics = {kWidth, kHeight, focal_px, focal_px, 0.5F * (kWidth - 1), 0.5F * (kHeight - 1)};
  camera.origin = *reported ? IntrinsicsOrigin::device : IntrinsicsOrigin::field_of_view;
  if (options.calibration) {
    const Intrinsics& k = options.calibration->intrinsics;
    if (k.width != kWidth || k.height != kHeight)
      return Error{ErrorCode::invalid_argument, "the calibration is of " + std::to_string(k.width) + "x" +
                                                    std::to_string(k.height) + " pictures, " + info_.name +
                                                    " delivers 640x480; give the one of this size"};
    camera = *options.calibration;
  }
  auto upright = UprightPath::make(camera, options.rotate_deg, "the calibration of " + info_.name);
  if (!upright) return upright.error();
  path_ = std::move(*upright);
  info_.intrinsics = path_.upright();
  info_.intrinsics_origin = camera.origin;
  info_.rotate_deg = options.rotate_deg;
  return Ok{};
}

Result<std::unique_ptr<KinectSource>> KinectSource::create(std::unique_ptr<UsbTransport> camera,
                                                           std::unique_ptr<UsbTransport> motor,
                                                           const KinectIdentity& identity,
                                                           const KinectOptions& options) {
  if (!is_rotation(options.rotate_deg))
    return Error{ErrorCode::invalid_argument,
                 "rotation is " + std::to_string(options.rotate_deg) + ", expected 0, 90, 180 or 270 degrees"};
  std::unique_ptr<KinectSource> source(new KinectSource(std::move(camera), std::move(motor), identity));
  if (auto ok = source->set_up(options); !ok) return ok.error();
  return source;
}

KinectSource::~KinectSource() {
  stop();
}

Status KinectSource::start() {
  if (started_) return Ok{};
  // A program that was killed leaves the camera streaming: its last frame is not ours.
  if (auto ok = commands_.stop_depth(); !ok) return ok.error();
  receiver_.reset();
  delivered_ = damaged_ = 0;
  UsbStreamSettings settings;
  settings.endpoint = kDepthEndpoint;
  settings.packet_bytes_min = static_cast<int>(kPacketBytesMax);
  // The host listens before the camera speaks, or the first frames would be cut.
  if (auto ok = camera_->start_stream(settings, receiver_); !ok)
    return Error{ok.error().code, info_.name + " (" + info_.uri + ") does not stream: " + ok.error().message};
  if (auto ok = commands_.start_depth(); !ok) {
    camera_->stop_stream();
    return ok.error();
  }
  started_ = true;
  return Ok{};
}

Result<FrameInfo> KinectSource::next(DepthImage depth, int timeout_ms) {
  if (auto ok = path_.check(depth, info_.name); !ok) return ok.error();
  if (!started_) return Error{ErrorCode::invalid_argument, info_.name + " is not started; call start() first"};
  const auto entry = receiver_.exchange().take(timeout_ms);
  if (!entry) {
    if (const auto ended = receiver_.exchange().ended())
      return Error{ended->code,
                   info_.name + " (" + info_.uri + ") stopped: " + ended->message + "; plug it in and open it again"};
    return Error{ErrorCode::timeout, info_.name + ": no frame within " + std::to_string(timeout_ms) + " ms"};
  }
  if (entry->damaged) {
    ++damaged_;
    return Error{ErrorCode::corrupt, info_.name + ": frame " + std::to_string(entry->number) + " is damaged (" +
                                         std::to_string(entry->packets_received) + " of " +
                                         std::to_string(kPacketsPerFrame) + " packets came); it is skipped"};
  }
  shifts_to_mm(entry->bytes, kWidth * kHeight, table_, path_.camera_image().pixels);
  path_.deliver(depth);
  ++delivered_;
  return FrameInfo{entry->number, entry->host_ns, entry->device_us};
}

void KinectSource::stop() {
  if (!started_) return;
  started_ = false;
  if (!receiver_.exchange().ended())
    (void)commands_.stop_depth();  // a camera that does not obey is cut off all the same
  camera_->stop_stream();
}

SourceStats KinectSource::stats() const {
  SourceStats stats;
  stats.delivered = delivered_;
  stats.gaps = receiver_.missed() + receiver_.exchange().dropped();
  stats.damaged = damaged_ + receiver_.exchange().dropped_damaged();
  return stats;
}

std::optional<Vec3f> KinectSource::down() const {
  if (!motor_) return std::nullopt;
  const auto camera = motor_->down();
  if (!camera) return std::nullopt;
  return rotate_upright(*camera, info_.rotate_deg);
}

}  // namespace im2fit::hal
