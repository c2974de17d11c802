// SPDX-License-Identifier: Apache-2.0
// A V4L2 device as its documentation describes one, kept to the calls a camera is driven with, whose every answer a
// test can set.
#pragma once

#include <linux/videodev2.h>
#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "hal/v4l2/video_device.h"

namespace im2fit::hal {

struct FakeVideo {
  struct Format {
    std::uint32_t fourcc = V4L2_PIX_FMT_Z16;
    std::vector<std::pair<int, int>> sizes{{640, 480}};  // empty: the driver does not list them
  };
  struct Event {
    std::vector<std::byte> bytes;
    std::uint32_t sequence = 0;
    std::uint32_t flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
    std::int64_t time_us = 1;
    int dequeue_error = 0;
    short poll_events = POLLIN;
    int poll_error = 0;
    std::uint32_t index_added = 0;  // a buffer number that does not exist
  };
  struct Control {
    std::uint32_t id;
    std::string name;
    int value;
  };
  std::uint32_t capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  std::vector<Format> formats{{}};
  std::uint32_t padding_bytes = 0;   // at the end of each line
  std::uint32_t bytes_per_line = 0;  // instead of the value from size and padding
  std::uint32_t size_image = 0;      // likewise
  std::uint32_t other_fourcc = 0;    // what S_FMT gives instead
  std::uint32_t field = V4L2_FIELD_NONE;
  std::uint32_t buffers_given = 32;
  std::vector<Control> controls;
  std::map<unsigned long, int> errors;  // request -> errno
  std::deque<Event> events;

  // What the source did.
  v4l2_pix_format pix{};
  v4l2_fract period{1, 30};
  std::vector<std::vector<std::byte>> memory;
  std::deque<std::uint32_t> queued;
  int mapped = 0;
  int calls_of_wait = 0;
  bool streaming = false;
  bool closed = false;
};

class FakeVideoDevice final : public VideoDevice {
 public:
  explicit FakeVideoDevice(FakeVideo& fake) : fake_(fake) {}
  ~FakeVideoDevice() override { fake_.closed = true; }

  int request(unsigned long code, void* argument) override {
    if (const auto error = fake_.errors.find(code); error != fake_.errors.end()) return error->second;
    switch (code) {
      case VIDIOC_QUERYCAP:
        return capabilities(*static_cast<v4l2_capability*>(argument));
      case VIDIOC_ENUM_FMT:
        return format(*static_cast<v4l2_fmtdesc*>(argument));
      case VIDIOC_ENUM_FRAMESIZES:
        return size(*static_cast<v4l2_frmsizeenum*>(argument));
      case VIDIOC_S_FMT:
        return set_format(*static_cast<v4l2_format*>(argument));
      case VIDIOC_G_PARM:
      case VIDIOC_S_PARM:
        return parameters(code, *static_cast<v4l2_streamparm*>(argument));
      case VIDIOC_QUERYCTRL:
        return query_control(*static_cast<v4l2_queryctrl*>(argument));
      case VIDIOC_G_CTRL:
        return get_control(*static_cast<v4l2_control*>(argument));
      case VIDIOC_REQBUFS:
        return make_buffers(*static_cast<v4l2_requestbuffers*>(argument));
      case VIDIOC_QUERYBUF:
      case VIDIOC_QBUF:
      case VIDIOC_DQBUF:
        return buffer(code, *static_cast<v4l2_buffer*>(argument));
      case VIDIOC_STREAMON:
        fake_.streaming = true;
        return 0;
      case VIDIOC_STREAMOFF:
        fake_.streaming = false;
        fake_.queued.clear();
        return 0;
      default:
        return ENOTTY;
    }
  }

  const std::byte* map(std::size_t size_bytes, std::uint32_t offset) override {
    if (offset >= fake_.memory.size() || fake_.memory[offset].size() < size_bytes) return nullptr;
    ++fake_.mapped;
    return fake_.memory[offset].data();
  }
  void unmap(const std::byte*, std::size_t) override { --fake_.mapped; }

  int wait(int, short& events) override {
    ++fake_.calls_of_wait;
    events = fake_.events.empty() ? short{0} : fake_.events.front().poll_events;
    const int error = fake_.events.empty() ? 0 : fake_.events.front().poll_error;
    return error;
  }

 private:
  int capabilities(v4l2_capability& out) const {
    std::snprintf(reinterpret_cast<char*>(out.card), sizeof out.card, "Fake depth");
    std::snprintf(reinterpret_cast<char*>(out.bus_info), sizeof out.bus_info, "fake-1");
    out.capabilities = fake_.capabilities | V4L2_CAP_DEVICE_CAPS;
    out.device_caps = fake_.capabilities;
    return 0;
  }
  int format(v4l2_fmtdesc& out) const {
    if (out.index >= fake_.formats.size()) return EINVAL;
    out.pixelformat = fake_.formats[out.index].fourcc;
    return 0;
  }
  int size(v4l2_frmsizeenum& out) const {
    for (const auto& f : fake_.formats) {
      if (f.fourcc != out.pixel_format || out.index >= f.sizes.size()) continue;
      out.type = V4L2_FRMSIZE_TYPE_DISCRETE;
      out.discrete.width = static_cast<__u32>(f.sizes[out.index].first);
      out.discrete.height = static_cast<__u32>(f.sizes[out.index].second);
      return 0;
    }
    return EINVAL;
  }
  int set_format(v4l2_format& out) const {
    v4l2_pix_format& pix = out.fmt.pix;
    if (fake_.other_fourcc != 0) pix.pixelformat = fake_.other_fourcc;
    const __u32 bytes = pix.pixelformat == V4L2_PIX_FMT_INZI ? 4 : 2;  // as uvcvideo counts INZI
    pix.bytesperline = pix.width * bytes + fake_.padding_bytes;
    if (fake_.bytes_per_line != 0) pix.bytesperline = fake_.bytes_per_line;
    pix.sizeimage = fake_.size_image != 0 ? fake_.size_image : pix.bytesperline * pix.height;
    pix.field = fake_.field;
    fake_.pix = pix;
    return 0;
  }
  int parameters(unsigned long code, v4l2_streamparm& out) const {
    if (code == VIDIOC_S_PARM) fake_.period = out.parm.capture.timeperframe;
    out.parm.capture.capability = V4L2_CAP_TIMEPERFRAME;
    out.parm.capture.timeperframe = fake_.period;
    return 0;
  }
  int query_control(v4l2_queryctrl& out) const {
    const std::uint32_t after = out.id & ~static_cast<__u32>(V4L2_CTRL_FLAG_NEXT_CTRL);
    for (const auto& control : fake_.controls) {
      if (control.id <= after) continue;
      out.id = control.id;
      out.type = V4L2_CTRL_TYPE_INTEGER;
      std::strncpy(reinterpret_cast<char*>(out.name), control.name.c_str(), sizeof out.name - 1);
      return 0;
    }
    return EINVAL;
  }
  int get_control(v4l2_control& out) const {
    for (const auto& control : fake_.controls) {
      if (control.id == out.id) return out.value = control.value, 0;
    }
    return EINVAL;
  }
  int make_buffers(v4l2_requestbuffers& out) const {
    out.count = std::min<__u32>(out.count, fake_.buffers_given);
    fake_.queued.clear();
    fake_.memory.assign(out.count, std::vector<std::byte>(fake_.pix.sizeimage));
    return 0;
  }
  int buffer(unsigned long code, v4l2_buffer& out) const {
    if (code == VIDIOC_DQBUF) return dequeue(out);
    if (out.index >= fake_.memory.size()) return EINVAL;
    if (code == VIDIOC_QBUF) {
      if (std::find(fake_.queued.begin(), fake_.queued.end(), out.index) != fake_.queued.end()) return EINVAL;
      fake_.queued.push_back(out.index);
      return 0;
    }
    out.length = static_cast<__u32>(fake_.memory[out.index].size());
    out.m.offset = out.index;
    return 0;
  }
  int dequeue(v4l2_buffer& out) const {
    if (fake_.events.empty() || fake_.queued.empty()) return EAGAIN;
    const FakeVideo::Event event = fake_.events.front();
    fake_.events.pop_front();
    if (event.dequeue_error != 0) return event.dequeue_error;
    out.index = fake_.queued.front();
    fake_.queued.pop_front();
    std::copy_n(event.bytes.begin(), std::min(event.bytes.size(), fake_.memory[out.index].size()),
                fake_.memory[out.index].begin());
    out.index += event.index_added;
    out.bytesused = static_cast<__u32>(event.bytes.size());
    out.flags = event.flags;
    out.sequence = event.sequence;
    out.timestamp.tv_sec = static_cast<decltype(out.timestamp.tv_sec)>(event.time_us / 1'000'000);
    out.timestamp.tv_usec = static_cast<decltype(out.timestamp.tv_usec)>(event.time_us % 1'000'000);
    return 0;
  }

  FakeVideo& fake_;
};

}  // namespace im2fit::hal
