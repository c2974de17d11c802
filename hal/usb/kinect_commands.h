// SPDX-License-Identifier: Apache-2.0
// Commands to a Kinect camera and queries of it, over control transfers.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/status.h"
#include "hal/usb/kinect_protocol.h"
#include "hal/usb/usb_transport.h"
#include "kernels/unpack11/shift_table.h"

namespace im2fit::hal {

class KinectCommands {
 public:
  // `what` names the camera in errors. The transport must outlive this.
  KinectCommands(UsbTransport& transport, std::string what) : transport_(transport), what_(std::move(what)) {}

  // The answer without its header and its status word. Errors: no_device, timeout (no answer within a second), io
  // (an answer to something else, or refused), unsupported (stalled).
  Result<std::vector<std::uint8_t>> command(kinect::Opcode opcode, std::span<const std::uint16_t> words);
  Status write_register(kinect::Register which, std::uint16_t value);
  Result<std::uint16_t> read_register(kinect::Register which);

  // What the camera was calibrated with in the factory. None: it does not report it, or reports what no camera has.
  Result<std::optional<ZeroPlane>> zero_plane();

  // 640 x 480 at 11 bits and 30 frames a second, not mirrored, projector steadily on. Packets follow at once.
  Status start_depth();
  Status stop_depth();

 private:
  Error error(ErrorCode code, kinect::Opcode opcode, const std::string& why) const;

  UsbTransport& transport_;
  std::string what_;
  std::uint16_t tag_ = 0;
};

}  // namespace im2fit::hal
