// SPDX-License-Identifier: Apache-2.0
// The C functions of include/im2fit/cameras.h over hal. Nothing of C++ crosses: every function catches.
#include "capi/include/im2fit/cameras.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "capi/status_of.h"
#include "hal/open/open.h"

namespace {

using im2fit::Error;
using im2fit::ErrorCode;
using im2fit::Result;
using im2fit::Status;
namespace hal = im2fit::hal;

// No padding at the end, which callers never set: a field that comes later would be read from it.
static_assert(sizeof(im2fit_cameras_options) == offsetof(im2fit_cameras_options, unit_mm) + sizeof(float));

thread_local std::array<char, 512> last_error{};

int fail(int status, std::string_view text) {
  const std::size_t length = std::min(text.size(), last_error.size() - 1);
  std::memcpy(last_error.data(), text.data(), length);
  last_error[length] = '\0';
  return status;
}
int fail(const Error& error) {
  return fail(im2fit::status_of(error.code), error.message);
}

// Runs `body`, which gives a status, and turns whatever it throws into one.
template <class Body>
int guarded(Body body) noexcept {
  try {
    return body();
  } catch (const std::bad_alloc&) {
    return fail(IM2FIT_ERROR_NO_MEMORY, "out of memory");
  } catch (...) {
    return fail(IM2FIT_ERROR_INTERNAL, "internal error");
  }
}

im2fit_cameras_options defaults() {
  im2fit_cameras_options options{};
  options.struct_size = sizeof options;
  options.rotate_deg = -1;
  options.width = 640;
  options.height = 480;
  options.unit_mm = 1;
  return options;
}

// A struct a newer caller made: what we do not know must be unset.
Result<im2fit_cameras_options> known_options(const im2fit_cameras_options* given) {
  im2fit_cameras_options options = defaults();
  if (given == nullptr) return options;
  const auto* bytes = reinterpret_cast<const char*>(given);
  const std::size_t size = given->struct_size;
  if (size < sizeof options || size > 65536 ||
      !std::all_of(bytes + sizeof options, bytes + size, [](char c) { return c == 0; }))
    return Error{ErrorCode::unsupported,
                 "options.struct_size fits no version of this library: call im2fit_cameras_options_init first"};
  return *given;
}

Result<hal::OpenOptions> opening(const im2fit_cameras_options* given) {
  const auto options = known_options(given);
  if (!options) return options.error();
  if (!(options->unit_mm > 0 && options->unit_mm <= 1000))
    return Error{ErrorCode::invalid_argument,
                 "options.unit_mm is " + std::to_string(options->unit_mm) + ", expected more than 0, up to 1000"};
  for (const int side : {options->width, options->height})
    if (side < 1 || side > im2fit::kImageSideMax)
      return Error{ErrorCode::invalid_argument, "options.width and height are " + std::to_string(options->width) +
                                                    "x" + std::to_string(options->height) + ", expected 1 to " +
                                                    std::to_string(im2fit::kImageSideMax)};
  hal::OpenOptions words;
  if (options->rotate_deg != -1) words.rotate_deg = options->rotate_deg;  // hal says what it may be
  if (options->calibration_path != nullptr) words.camera_yaml_path = options->calibration_path;
  words.unit_mm = options->unit_mm == 1 ? 0 : options->unit_mm;  // 1 is the default: as the folder has it
  words.width = options->width;
  words.height = options->height;
  return words;
}

Result<std::unique_ptr<hal::Source>> open(const char* uri, const im2fit_cameras_options* given) {
  if (uri == nullptr) return Error{ErrorCode::invalid_argument, "the URI is NULL"};
  const auto words = opening(given);
  if (!words) return words.error();
  return hal::open_source(uri, *words);
}

// An attached source, and where down was in its latest frame.
struct Attached {
  std::unique_ptr<hal::Source> source;
  std::optional<im2fit::Vec3f> down;
};

int next_frame(void* user, std::uint16_t* depth_mm, std::int32_t width, std::int32_t height, std::int32_t timeout_ms,
               std::uint64_t* sequence, std::int64_t* time_ns) {
  return guarded([&] {
    auto& attached = *static_cast<Attached*>(user);
    hal::Source& source = *attached.source;
    const im2fit::Intrinsics& k = source.info().intrinsics;
    if (k.width != width || k.height != height)
      return fail(IM2FIT_ERROR_INVALID_ARGUMENT,
                  source.info().uri + ": upright frames are " + std::to_string(k.width) + "x" +
                      std::to_string(k.height) + ", the handle was opened for " + std::to_string(width) + "x" +
                      std::to_string(height) + "; im2fit_cameras_describe fills in the settings");
    const auto frame = source.next({depth_mm, width, height}, timeout_ms);
    if (!frame) return fail(frame.error());
    *sequence = frame->sequence;
    *time_ns = frame->host_ns;
    attached.down = hal::down_of(source, *frame);
    return static_cast<int>(IM2FIT_OK);
  });
}

int down_now(void* user, float down[3]) {
  const auto& known = static_cast<const Attached*>(user)->down;
  if (!known) return 0;
  down[0] = known->x;
  down[1] = known->y;
  down[2] = known->z;
  return 1;
}

void close_source(void* user) {
  const std::unique_ptr<Attached> attached(static_cast<Attached*>(user));
  guarded([&] {
    attached->source->stop();
    return static_cast<int>(IM2FIT_OK);
  });
}

// The opener; `user` is the caller's options or null.
int open_uri(void* user, const char* uri, im2fit_source* place) {
  return guarded([&] {
    auto source = open(uri, static_cast<const im2fit_cameras_options*>(user));
    if (!source) return fail(source.error());
    if (const auto started = (*source)->start(); !started) return fail(started.error());
    *place = {new Attached{std::move(*source), {}}, next_frame, close_source};
    return static_cast<int>(IM2FIT_OK);
  });
}

void describe(const hal::SourceInfo& info, im2fit_settings& settings) {
  const im2fit::Intrinsics& k = info.intrinsics;
  settings.width = k.width;
  settings.height = k.height;
  settings.fx = k.fx;
  settings.fy = k.fy;
  settings.cx = k.cx;
  settings.cy = k.cy;
  settings.sensor = static_cast<std::int32_t>(info.sensor);
  settings.live = info.live ? 1 : 0;
}

}  // namespace

extern "C" {

void im2fit_cameras_options_init(im2fit_cameras_options* options, size_t struct_size) {
  if (options == nullptr) return;
  im2fit_cameras_options known = defaults();
  known.struct_size = struct_size;
  std::memset(options, 0, struct_size);
  std::memcpy(options, &known, std::min(struct_size, sizeof known));
}

int im2fit_cameras_describe(const char* uri, const im2fit_cameras_options* options, im2fit_settings* settings) {
  return guarded([&] {
    if (settings == nullptr) return fail(IM2FIT_ERROR_INVALID_ARGUMENT, "the settings are NULL");
    if (settings->struct_size < offsetof(im2fit_settings, sensor) + sizeof settings->sensor)
      return fail(IM2FIT_ERROR_UNSUPPORTED,
                  "settings.struct_size fits no version of this library: call im2fit_settings_init first");
    const auto source = open(uri, options);
    if (!source) return fail(source.error());
    describe((*source)->info(), *settings);
    return static_cast<int>(IM2FIT_OK);
  });
}

int im2fit_cameras_use(im2fit_handle* handle, const im2fit_cameras_options* options) {
  return guarded([&] {
    // Invalid options are reported here, not by each im2fit_attach.
    if (const auto words = opening(options); !words) return fail(words.error());
    int status = im2fit_set_opener(handle, open_uri, const_cast<im2fit_cameras_options*>(options));
    if (status == IM2FIT_OK) status = im2fit_set_opener_down(handle, down_now);
    return status == IM2FIT_OK ? status : fail(status, im2fit_last_error(nullptr));
  });
}

const char* im2fit_cameras_error(void) {
  return last_error.data();
}

}  // extern "C"
