// SPDX-License-Identifier: Apache-2.0
#include "hal/v4l2/video_device.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "hal/frame_path.h"

namespace im2fit::hal {
namespace {

class KernelDevice final : public VideoDevice {
 public:
  explicit KernelDevice(int descriptor) : descriptor_(descriptor) {}
  KernelDevice(const KernelDevice&) = delete;
  KernelDevice& operator=(const KernelDevice&) = delete;
  ~KernelDevice() override { ::close(descriptor_); }

  int request(unsigned long code, void* argument) override {
    for (;;) {
      // A code has 32 bits, and not every C library takes more.
      if (::ioctl(descriptor_, static_cast<unsigned>(code), argument) == 0) return 0;
      if (errno != EINTR) return errno;
    }
  }

  const std::byte* map(std::size_t size_bytes, std::uint32_t offset) override {
    void* address = ::mmap(nullptr, size_bytes, PROT_READ, MAP_SHARED, descriptor_, static_cast<off_t>(offset));
    return address == MAP_FAILED ? nullptr : static_cast<const std::byte*>(address);
  }

  void unmap(const std::byte* address, std::size_t size_bytes) override {
    ::munmap(const_cast<std::byte*>(address), size_bytes);
  }

  int wait(int timeout_ms, short& events) override {
    const std::int64_t deadline_ns = monotonic_ns() + std::int64_t{timeout_ms} * 1'000'000;
    for (;;) {
      pollfd wanted{descriptor_, POLLIN, 0};
      // Rounded up: a sleep of 0 ms before the deadline would be a spin.
      const std::int64_t left_ms = (deadline_ns - monotonic_ns() + 999'999) / 1'000'000;
      const int count = ::poll(&wanted, 1, static_cast<int>(std::max<std::int64_t>(left_ms, 0)));
      events = count > 0 ? wanted.revents : short{0};
      if (count >= 0) return 0;
      if (errno != EINTR) return errno;
    }
  }

 private:
  int descriptor_;
};

}  // namespace

Result<std::unique_ptr<VideoDevice>> open_video_device(const std::string& path) {
  const int descriptor = ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (descriptor >= 0) return adopt_video_device(descriptor);
  const int error = errno;
  const std::string reason = "v4l2:" + path + ": " + std::strerror(error);
  if (error == ENOENT)
    return Error{ErrorCode::not_found,
                 reason + "; is the camera plugged in? `im2fit devices` lists connected cameras"};
  if (error == ENODEV || error == ENXIO) return Error{ErrorCode::no_device, reason + "; plug the camera in again"};
  if (error == EACCES) return Error{ErrorCode::io, reason + "; the user must be in the group that owns it (video)"};
  if (error == EPERM) return Error{ErrorCode::io, reason + "; the service that runs this allows no such device"};
  return Error{ErrorCode::io, reason + "; is it a V4L2 camera, and free?"};
}

std::unique_ptr<VideoDevice> adopt_video_device(int descriptor) {
  return std::make_unique<KernelDevice>(descriptor);
}

}  // namespace im2fit::hal
