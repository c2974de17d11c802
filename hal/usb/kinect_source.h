// SPDX-License-Identifier: Apache-2.0
// The Kinect for Xbox 360, over USB and with no driver of anyone else.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "hal/frame_path.h"
#include "hal/intrinsics.h"
#include "hal/source.h"
#include "hal/usb/kinect_commands.h"
#include "hal/usb/kinect_motor.h"
#include "hal/usb/kinect_receiver.h"
#include "hal/usb/usb_transport.h"

namespace im2fit::hal {

struct KinectOptions {
  int rotate_deg = 0;
  std::optional<Calibration> calibration;  // replaces the camera's own; 640 x 480. Its rotate_deg is ignored
};

struct KinectIdentity {
  std::string uri;
  std::string name;
  std::string serial;
};

// 640 x 480 at 30 frames a second, millimetres by the camera's own calibration of its reference plane, or by the
// usual one if it reports none. A camera's own focal length is origin `device`, the usual one `field_of_view`. The
// camera does not report a principal point: it is the picture's centre.
class KinectSource final : public Source {
 public:
  // `motor` may be null. Asks the camera for its calibration. Errors: no_device, timeout, invalid_argument (options).
  static Result<std::unique_ptr<KinectSource>> create(std::unique_ptr<UsbTransport> camera,
                                                      std::unique_ptr<UsbTransport> motor,
                                                      const KinectIdentity& identity, const KinectOptions& options);
  ~KinectSource() override;

  const SourceInfo& info() const override { return info_; }
  Status start() override;
  // `corrupt`: packets of this frame were lost; it is counted and skipped. Frames not taken yet are held: three,
  // then the oldest goes and is counted as a gap.
  Result<FrameInfo> next(DepthImage depth, int timeout_ms) override;
  void stop() override;
  // delivered + gaps + damaged are the frames the camera sent between the first and the last known.
  SourceStats stats() const override;
  // Asks the accelerometer: a control transfer of about a millisecond. From the thread that calls next().
  std::optional<Vec3f> down() const override;

  KinectMotor* motor() { return motor_.get(); }  // null: none
  const ZeroPlane& zero_plane() const { return plane_; }
  PacketStats packet_stats() const { return receiver_.packet_stats(); }

 private:
  KinectSource(std::unique_ptr<UsbTransport> camera, std::unique_ptr<UsbTransport> motor,
               const KinectIdentity& identity);
  Status set_up(const KinectOptions& options);

  SourceInfo info_;
  KinectReceiver receiver_;  // outlives the transports that call it
  std::unique_ptr<UsbTransport> camera_;
  std::unique_ptr<KinectMotor> motor_;
  KinectCommands commands_;
  ZeroPlane plane_;
  ShiftTable table_{};
  UprightPath path_;
  bool started_ = false;
  std::uint64_t delivered_ = 0;
  std::uint64_t damaged_ = 0;
};

}  // namespace im2fit::hal
