// SPDX-License-Identifier: Apache-2.0
#include "hal/v4l2/negotiate.h"

#include <linux/videodev2.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstdlib>
#include <cstring>

namespace im2fit::hal {
namespace {

constexpr int kEntriesMax = 256;  // of any list: a broken driver must not keep us here

std::string fourcc_text(std::uint32_t fourcc) {
  std::string text;
  for (int shift = 0; shift < 32; shift += 8) {
    const char c = static_cast<char>(fourcc >> shift & 0x7F);
    if (c > ' ') text += c;
  }
  return text;
}

template <std::size_t n>
std::string text_of(const __u8 (&field)[n]) {
  const auto* begin = reinterpret_cast<const char*>(field);
  return {begin, ::strnlen(begin, n)};
}

std::string size_text(long width, long height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

struct Size {
  int width = 0;
  int height = 0;
};

int nearest_step(int wanted, std::uint32_t min, std::uint32_t max, std::uint32_t step) {
  if (step == 0) step = 1;
  if (max < min) max = min;
  const auto w = static_cast<std::uint32_t>(std::max(wanted, 0));
  if (w <= min) return static_cast<int>(std::min<std::uint32_t>(min, kImageSideMax + 1));
  const std::uint32_t clamped = std::min(w, max);
  std::uint32_t value = min + (clamped - min + step / 2) / step * step;
  if (value > max) value -= step;
  return static_cast<int>(std::min<std::uint32_t>(value, kImageSideMax + 1));
}

// The wanted size itself where the driver does not list its sizes.
Size nearest_size(VideoDevice& device, std::uint32_t fourcc, const V4l2Options& wanted) {
  Size best;
  long best_cost = -1;
  for (int i = 0; i < kEntriesMax; ++i) {
    v4l2_frmsizeenum entry{};
    entry.index = static_cast<__u32>(i);
    entry.pixel_format = fourcc;
    if (device.request(VIDIOC_ENUM_FRAMESIZES, &entry) != 0) break;
    if (entry.type != V4L2_FRMSIZE_TYPE_DISCRETE) {
      const auto& range = entry.stepwise;
      return {nearest_step(wanted.width, range.min_width, range.max_width, range.step_width),
              nearest_step(wanted.height, range.min_height, range.max_height, range.step_height)};
    }
    if (entry.discrete.width > kImageSideMax || entry.discrete.height > kImageSideMax) continue;
    const Size size{static_cast<int>(entry.discrete.width), static_cast<int>(entry.discrete.height)};
    const long cost = std::labs(static_cast<long>(size.width) - wanted.width) +
                      std::labs(static_cast<long>(size.height) - wanted.height);
    if (best_cost < 0 || cost < best_cost) {
      best = size;
      best_cost = cost;
    }
  }
  return best_cost < 0 ? Size{wanted.width, wanted.height} : best;
}

Result<V4l2Format> choose_format(const V4l2Camera& camera, const V4l2Options& options, const std::string& what) {
  std::string offered;
  for (const std::uint32_t fourcc : camera.formats) offered += (offered.empty() ? "" : ", ") + fourcc_text(fourcc);
  if (options.format) {
    if (camera.offers(*options.format)) return *options.format;
    return Error{ErrorCode::unsupported, what + " does not offer " + fourcc_text(fourcc_of(*options.format)) +
                                             "; it offers " + (offered.empty() ? "nothing" : offered)};
  }
  if (camera.offers(V4l2Format::z16)) return V4l2Format::z16;
  if (camera.offers(V4l2Format::inzi)) return V4l2Format::inzi;
  return Error{ErrorCode::unsupported,
               what + " is not a depth camera: it offers " + (offered.empty() ? "nothing" : offered) +
                   ", expected Z16 or INZI" +
                   (camera.offers(V4l2Format::y16) ? "; if its Y16 is depth, give ?format=Y16" : "")};
}

Result<DepthLayout> layout_of(V4l2Format format, const v4l2_pix_format& pix, const std::string& what) {
  if (pix.width < 1 || pix.height < 1 || pix.width > kImageSideMax || pix.height > kImageSideMax)
    return Error{ErrorCode::unsupported, what + " delivers " + size_text(pix.width, pix.height) +
                                             " pictures, expected 1 to 2048 pixels a side; give another ?size=WxH"};
  if (pix.field != V4L2_FIELD_NONE && pix.field != V4L2_FIELD_ANY)
    return Error{ErrorCode::unsupported, what + " delivers interlaced pictures, expected whole ones"};
  DepthLayout layout;
  layout.width = static_cast<int>(pix.width);
  layout.height = static_cast<int>(pix.height);
  const std::size_t row_bytes = std::size_t{2} * pix.width;
  if (format == V4l2Format::inzi) {
    // Two planes without padding, whatever bytesperline says: drivers count both planes into it (kernel
    // documentation, pixfmt-inzi).
    layout.stride_bytes = row_bytes;
    layout.offset_bytes = row_bytes * pix.height;
  } else {
    layout.stride_bytes = pix.bytesperline == 0 ? row_bytes : pix.bytesperline;
  }
  if (layout.stride_bytes < row_bytes || pix.bytesperline > 64 * kImageSideMax || pix.sizeimage < layout.size_bytes())
    return Error{ErrorCode::unsupported, what + " reports for a " + size_text(pix.width, pix.height) + " picture " +
                                             std::to_string(pix.bytesperline) + " bytes a line and " +
                                             std::to_string(pix.sizeimage) + " in all, which is impossible"};
  return layout;
}

// Best effort: many drivers have one rate only and no such call.
float set_rate(VideoDevice& device, int fps) {
  v4l2_streamparm parameters{};
  parameters.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (device.request(VIDIOC_G_PARM, &parameters) != 0) return 0;
  if ((parameters.parm.capture.capability & V4L2_CAP_TIMEPERFRAME) != 0) {
    parameters.parm.capture.timeperframe = {1, static_cast<__u32>(fps)};
    if (device.request(VIDIOC_S_PARM, &parameters) != 0) return 0;
  }
  const auto& period = parameters.parm.capture.timeperframe;
  return period.numerator == 0 ? 0.0F : static_cast<float>(period.denominator) / static_cast<float>(period.numerator);
}

}  // namespace

std::uint32_t fourcc_of(V4l2Format format) {
  switch (format) {
    case V4l2Format::z16:
      return V4L2_PIX_FMT_Z16;
    case V4l2Format::inzi:
      return V4L2_PIX_FMT_INZI;
    case V4l2Format::y16:
      return V4L2_PIX_FMT_Y16;
  }
  return 0;
}

bool V4l2Camera::offers(V4l2Format format) const {
  return std::find(formats.begin(), formats.end(), fourcc_of(format)) != formats.end();
}

Error device_error(int error, const std::string& what, const std::string& doing) {
  if (error == ENODEV || error == ENXIO || error == EIO)
    return {ErrorCode::no_device,
            what + " was disconnected (" + doing + ": " + std::strerror(error) + "); plug it in and open it again"};
  if (error == EBUSY)
    return {ErrorCode::io, what + " is used by another program (" + doing + "); end that one first"};
  return {ErrorCode::io, what + ": " + doing + " failed (" + std::strerror(error) + ")"};
}

Result<V4l2Camera> describe_camera(VideoDevice& device, const std::string& what) {
  v4l2_capability about{};
  if (const int error = device.request(VIDIOC_QUERYCAP, &about); error != 0) {
    if (error == ENODEV || error == ENXIO || error == EIO)
      return device_error(error, what, "querying its capabilities");
    return Error{ErrorCode::unsupported, what + " is not a V4L2 device (" + std::strerror(error) + ")"};
  }
  const std::uint32_t able =
      (about.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? about.device_caps : about.capabilities;
  if ((able & V4L2_CAP_VIDEO_CAPTURE) == 0 || (able & V4L2_CAP_STREAMING) == 0)
    return Error{ErrorCode::unsupported,
                 what + " (" + text_of(about.card) + ") does not stream pictures of one plane"};
  V4l2Camera camera{text_of(about.card), text_of(about.bus_info), {}};
  for (int i = 0; i < kEntriesMax; ++i) {
    v4l2_fmtdesc entry{};
    entry.index = static_cast<__u32>(i);
    entry.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (device.request(VIDIOC_ENUM_FMT, &entry) != 0) break;
    camera.formats.push_back(entry.pixelformat);
  }
  return camera;
}

Result<V4l2Mode> negotiate(VideoDevice& device, const V4l2Camera& camera, const V4l2Options& options,
                           const std::string& what) {
  const auto format = choose_format(camera, options, what);
  if (!format) return format.error();
  const Size size = nearest_size(device, fourcc_of(*format), options);
  v4l2_format wanted{};
  wanted.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  wanted.fmt.pix.width = static_cast<__u32>(size.width);
  wanted.fmt.pix.height = static_cast<__u32>(size.height);
  wanted.fmt.pix.pixelformat = fourcc_of(*format);
  wanted.fmt.pix.field = V4L2_FIELD_NONE;  // bytesperline stays 0: some drivers keep an older mode's
  if (const int error = device.request(VIDIOC_S_FMT, &wanted); error != 0)
    return device_error(error, what, "setting " + size_text(size.width, size.height));
  if (wanted.fmt.pix.pixelformat != fourcc_of(*format))
    return Error{ErrorCode::unsupported, what + " offers " + fourcc_text(fourcc_of(*format)) + " but delivers " +
                                             fourcc_text(wanted.fmt.pix.pixelformat)};
  const auto layout = layout_of(*format, wanted.fmt.pix, what);
  if (!layout) return layout.error();
  V4l2Mode mode{*format, *layout, wanted.fmt.pix.sizeimage, 0};
  mode.fps = set_rate(device, options.fps);
  return mode;
}

static_assert(std::endian::native == std::endian::little, "Z16 and Y16 are copied as they are");

std::size_t DepthLayout::size_bytes() const {
  if (width < 1 || height < 1) return 0;
  return offset_bytes + stride_bytes * static_cast<std::size_t>(height - 1) + static_cast<std::size_t>(width) * 2;
}

bool copy_depth(std::span<const std::byte> buffer, const DepthLayout& layout, DepthImage out) {
  if (layout.width < 1 || layout.height < 1 || layout.width != out.width || layout.height != out.height) return false;
  const std::size_t row_bytes = static_cast<std::size_t>(layout.width) * 2;
  if (layout.stride_bytes < row_bytes || layout.unit_um < 1 || buffer.size() < layout.size_bytes()) return false;
  const std::byte* from = buffer.data() + layout.offset_bytes;
  const auto unit_um = static_cast<std::uint64_t>(layout.unit_um);
  for (int v = 0; v < out.height; ++v, from += layout.stride_bytes) {
    std::uint16_t* row = out.row(v);
    std::memcpy(row, from, row_bytes);
    if (unit_um == 1000) continue;
    for (int u = 0; u < out.width; ++u) {
      const std::uint64_t mm = (row[u] * unit_um + 500) / 1000;
      row[u] = mm <= 65535 ? static_cast<std::uint16_t>(mm) : std::uint16_t{0};
    }
  }
  return true;
}

}  // namespace im2fit::hal
