// SPDX-License-Identifier: Apache-2.0
// The system calls a V4L2 camera is driven with, and nothing else: tests put a scripted device in their place.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "core/status.h"

namespace im2fit::hal {

// One thread at a time. Errors are errno values, 0 when all went well; no call is cut short by signals.
class VideoDevice {
 public:
  virtual ~VideoDevice() = default;
  // ioctl(2). `code` is one of <linux/videodev2.h>, `argument` its struct.
  virtual int request(unsigned long code, void* argument) = 0;
  // mmap(2) for reading, nullptr when refused; what is mapped stays readable after the device is gone.
  virtual const std::byte* map(std::size_t size_bytes, std::uint32_t offset) = 0;
  virtual void unmap(const std::byte* address, std::size_t size_bytes) = 0;
  // poll(2) for a filled buffer: `events` becomes POLLIN, POLLERR and the like, or 0 after `timeout_ms`. Sleeps,
  // never spins.
  virtual int wait(int timeout_ms, short& events) = 0;
};

// Errors: not_found, io (permission; in use), no_device.
Result<std::unique_ptr<VideoDevice>> open_video_device(const std::string& path);
// A descriptor that another process or an Android service opened (O_RDWR | O_NONBLOCK); closed with the device.
std::unique_ptr<VideoDevice> adopt_video_device(int descriptor);

}  // namespace im2fit::hal
