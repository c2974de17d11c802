// SPDX-License-Identifier: Apache-2.0
// A depth camera behind a V4L2 driver of the kernel (UVC depth cameras, sensors on CSI): no library, mapped buffers.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "hal/frame_path.h"
#include "hal/v4l2/negotiate.h"

namespace im2fit::hal {

class V4l2Source final : public Source {
 public:
  // V4L2 reports neither lens nor field of view: `options` holds a calibration or an angle, or opening is refused.
  // Errors: invalid_argument, not_found, unsupported (no depth, by agreement or otherwise), no_device, io.
  static Result<std::unique_ptr<V4l2Source>> open(const V4l2Options& options);
  // With a device opened elsewhere; `name` stands in the messages and the uri.
  static Result<std::unique_ptr<V4l2Source>> open(std::unique_ptr<VideoDevice> device, const std::string& name,
                                                  const V4l2Options& options);
  ~V4l2Source() override;

  const SourceInfo& info() const override { return info_; }
  Status start() override;
  // host_ns is the buffer's own time where the driver stamps CLOCK_MONOTONIC, else that of its arrival. A frame the
  // driver calls faulty, or that is too short, is `corrupt`; a device that fails (ENODEV, EIO, POLLERR) is gone:
  // `no_device`, on every call from then on.
  Result<FrameInfo> next(DepthImage depth, int timeout_ms) override;
  void stop() override;
  SourceStats stats() const override { return book_.stats(); }

  const V4l2Mode& mode() const { return mode_; }

 private:
  struct Buffer {
    const std::byte* address = nullptr;
    std::size_t size_bytes = 0;
  };
  struct Filled {
    std::uint32_t index = 0;
    std::size_t used_bytes = 0;
    bool faulty = false;
    FrameInfo info;
  };
  V4l2Source() = default;
  Status map_buffers();
  Status queue(std::uint32_t index);
  Result<Filled> take_filled(int timeout_ms);
  Error fail(int error, const std::string& doing);  // remembers that the device is gone
  std::uint64_t whole_sequence(std::uint32_t sequence);

  std::unique_ptr<VideoDevice> device_;
  V4l2Options options_;
  SourceInfo info_;
  V4l2Mode mode_;
  UprightPath path_;
  SequenceBook book_;
  std::vector<Buffer> buffers_;
  bool started_ = false;
  bool lost_ = false;
  bool counted_ = false;  // sequence_ holds a frame's number
  std::uint64_t sequence_ = 0;
};

struct V4l2Device {
  std::string path;    // /dev/videoN
  std::string name;    // card
  std::string serial;  // as its USB device reports it; "": none
};
// The cameras that offer Z16 or INZI, by number. Devices that cannot be opened are left out.
std::vector<V4l2Device> list_v4l2_devices();

}  // namespace im2fit::hal
