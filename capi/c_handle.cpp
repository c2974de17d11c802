// SPDX-License-Identifier: Apache-2.0
#include "capi/c_handle.h"

#include <sys/types.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "capi/include/im2fit/im2fit.h"
#include "core/camera.h"
#include "core/file.h"
#include "core/status.h"
#include "engine/engine.h"
#include "formats/model_pack.h"
#include "hal/source.h"

namespace im2fit {
namespace {

// The largest file of ours is a body of 12 MB; this catches a size that was not set or is an address.
constexpr std::size_t kDataSizeMax = std::size_t{1} << 30;

Error wrong(const std::string& name, const std::string& what) {
  return {ErrorCode::invalid_argument, name + what};
}

Result<std::vector<std::byte>> read_at(const im2fit_data& data, const std::string& name) {
  std::vector<std::byte> bytes(data.size);
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t n = ::pread(data.fd, bytes.data() + done, bytes.size() - done,
                              static_cast<off_t>(data.offset) + static_cast<off_t>(done));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return Error{ErrorCode::io, "cannot read " + name + ": " + std::strerror(errno)};
    if (n == 0)
      return Error{ErrorCode::corrupt,
                   name + " ends after " + std::to_string(done) + " bytes, expected " + std::to_string(data.size)};
    done += static_cast<std::size_t>(n);
  }
  return bytes;
}

// `field` of the settings names it in errors: "settings.index_data". Errors: invalid_argument for a kind, address,
// size or offset that cannot be; io when the descriptor cannot be read; corrupt when it ends before.
Result<std::vector<std::byte>> bytes_of(const im2fit_data& data, const char* field) {
  const std::string name = std::string("settings.") + field;
  if (data.kind != IM2FIT_DATA_MEMORY && data.kind != IM2FIT_DATA_FD)
    return wrong(name, ".kind is " + std::to_string(data.kind) + ", expected one of IM2FIT_DATA_...");
  if (data.size == 0 || data.size > kDataSizeMax)
    return wrong(name, ".size is " + std::to_string(data.size) + ", expected 1 to " + std::to_string(kDataSizeMax));
  if (data.kind == IM2FIT_DATA_MEMORY) {
    if (data.bytes == nullptr) return wrong(name, ".bytes is NULL");
    const auto* first = static_cast<const std::byte*>(data.bytes);
    return std::vector<std::byte>(first, first + data.size);
  }
  // A 32-bit machine's off_t may have 32 bits.
  if (data.offset < 0 || data.offset > std::numeric_limits<off_t>::max() - static_cast<off_t>(kDataSizeMax))
    return wrong(name, ".offset is " + std::to_string(data.offset));
  return read_at(data, name);
}

struct Field {
  const char* name;
  std::int32_t value, low, high;
};

// Errors: invalid_argument, "settings.FIELD is FOUND, expected ...".
Status check_settings(const im2fit_settings& s) {
  const Field fields[] = {
      {"width", s.width, 1, kImageSideMax},
      {"height", s.height, 1, kImageSideMax},
      {"frames_wanted", s.frames_wanted, 1, kFramesWantedMax},
      {"frames_min", s.frames_min, 1, s.frames_wanted},
      {"calibration_psi", s.calibration_psi, 0, 1},
      {"live", s.live, 0, 1},
      {"single_thread", s.single_thread, 0, 1},
      {"pool_frames", s.pool_frames, kPoolFramesMin, kPoolFramesMax},
      {"user_id", s.user_id, 0, std::numeric_limits<std::int32_t>::max()},
      {"turn", s.turn, IM2FIT_TURN_NONE, IM2FIT_TURN_WALK},
      {"clothing", s.clothing, IM2FIT_CLOTHING_UNKNOWN, IM2FIT_CLOTHING_DRESSED},
      {"sensor", s.sensor, IM2FIT_SENSOR_UNKNOWN, IM2FIT_SENSOR_STEREO},
  };
  for (const Field& field : fields)
    if (field.value < field.low || field.value > field.high)
      return Error{ErrorCode::invalid_argument, std::string("settings.") + field.name + " is " +
                                                    std::to_string(field.value) + ", expected " +
                                                    std::to_string(field.low) + " to " + std::to_string(field.high)};
  return hal::check_intrinsics({s.width, s.height, s.fx, s.fy, s.cx, s.cy}, "settings");
}

Error missing(const char* field) {
  return {ErrorCode::invalid_argument, std::string("settings.") + field + " is not set"};
}

EngineSettings engine_settings(const im2fit_settings& s) {
  EngineSettings settings;
  settings.width = s.width;
  settings.height = s.height;
  settings.intrinsics = {s.width, s.height, s.fx, s.fy, s.cx, s.cy};
  settings.frames_wanted = s.frames_wanted;
  settings.frames_min = s.frames_min;
  settings.user = s.user_id;
  settings.calibration_psi = s.calibration_psi != 0;
  settings.turn = static_cast<Turn>(s.turn);
  settings.clothing = static_cast<ClothingGiven>(s.clothing);
  settings.sensor = static_cast<SensorKind>(s.sensor);
  settings.live = s.live != 0;
  settings.single_thread = s.single_thread != 0;
  settings.pool_frames = s.pool_frames;
  return settings;
}

Result<std::vector<std::string>> size_charts(const im2fit_settings& settings) {
  if (settings.men_chart_path == nullptr && settings.women_chart_path == nullptr) return std::vector<std::string>{};
  if (settings.men_chart_path == nullptr) return missing("men_chart_path");
  if (settings.women_chart_path == nullptr) return missing("women_chart_path");
  return std::vector<std::string>{settings.men_chart_path, settings.women_chart_path};
}

// A file by its path, or its bytes from where the settings say; `name` is what messages call it.
Status take_file(const im2fit_data& data, const char* path, const char* field, std::string& name,
                 std::optional<std::vector<std::byte>>& bytes) {
  if (data.kind == IM2FIT_DATA_PATH) {
    if (path != nullptr) name = path;
    return Ok{};
  }
  name = std::string("settings.") + field;
  auto read = bytes_of(data, field);
  if (!read) return read.error();
  bytes = std::move(*read);
  return Ok{};
}

// Fills in the models that have no file of their own.
Status take_pack(const im2fit_settings& s, MeasuringFiles& files, MeasuringBytes& bytes) {
  std::string name;
  std::optional<std::vector<std::byte>> pack;
  if (auto ok = take_file(s.pack_data, s.pack_path, "pack_data", name, pack); !ok) return ok;
  if (name.empty()) return Ok{};
  for (std::string* file : {&files.tracker, &files.index, &files.body})
    if (file->empty()) *file = name;
  if (pack) return take_models(*pack, name, files, bytes);
  if (is_model_pack(name)) return Ok{};  // load_measuring_data reads it
  std::vector<std::byte> first;
  if (auto ok = read_file_into(name, SIZE_MAX, sizeof(std::uint64_t), first); !ok) return ok;
  return ModelPack::parse(first, name, false).error();
}

Result<MeasuringData> load_data(const im2fit_settings& s, std::vector<std::string> charts) {
  MeasuringFiles files;
  MeasuringBytes bytes;
  files.size_charts = std::move(charts);
  if (auto ok = take_file(s.tracker_data, s.tracker_path, "tracker_data", files.tracker, bytes.tracker); !ok)
    return ok.error();
  if (auto ok = take_file(s.index_data, s.index_path, "index_data", files.index, bytes.index); !ok) return ok.error();
  if (auto ok = take_file(s.body_data, s.body_path, "body_data", files.body, bytes.body); !ok) return ok.error();
  if (auto ok = take_file(s.calibration_site_data, s.calibration_site_path, "calibration_site_data", files.site,
                          bytes.site);
      !ok)
    return ok.error();
  if (auto ok = take_pack(s, files, bytes); !ok) return ok.error();
  if (files.tracker.empty()) return missing("tracker_path");
  if (files.index.empty()) return missing("index_path");
  return load_measuring_data(files, std::move(bytes));
}

}  // namespace

}  // namespace im2fit

im2fit::Result<im2fit::hal::FrameInfo> OpenedSource::next(im2fit::DepthImage depth, int timeout_ms) {
  using im2fit::ErrorCode;
  im2fit::hal::FrameInfo frame;
  status_ = opened_.next(opened_.user, depth.pixels, depth.width, depth.height, timeout_ms, &frame.sequence,
                         &frame.host_ns);
  if (status_ == IM2FIT_OK) {
    float down[3] = {};
    if (down_ != nullptr && down_(opened_.user, down) == 1) {
      const im2fit::Vec3f said{down[0], down[1], down[2]};
      if (const float length = norm(said); length > 0 && std::isfinite(length)) frame.down = normalized(said);
    }
    return frame;
  }
  const ErrorCode code = status_ == IM2FIT_ERROR_TIMEOUT         ? ErrorCode::timeout
                         : status_ == IM2FIT_ERROR_END_OF_STREAM ? ErrorCode::end_of_stream
                         : status_ == IM2FIT_ERROR_CORRUPT       ? ErrorCode::corrupt
                                                                 : ErrorCode::no_device;
  return im2fit::Error{code, "the attached source gave no frame"};
}

namespace im2fit {

Result<std::unique_ptr<im2fit_handle>> open_c_handle(const im2fit_settings& settings,
                                                     std::unique_ptr<FrameStages> stages) {
  if (auto ok = check_settings(settings); !ok) return ok.error();
  auto handle = std::make_unique<im2fit_handle>();
  handle->process = ::getpid();
  handle->log = settings.log;
  handle->log_user = settings.log_user;
  EngineSettings words = engine_settings(settings);
  words.watch = [keeper = handle->mask.get()](const FrameSeen& frame) { keeper->keep(frame); };
  handle->mask->prepare(words.width, words.height);
  handle->frames_wanted = settings.frames_wanted;
  handle->frames.prepare(words.intrinsics);
  handle->origin.uri = handle->origin.name = "im2fit.h";
  handle->origin.intrinsics = words.intrinsics;
  handle->origin.intrinsics_origin = hal::IntrinsicsOrigin::caller;
  auto charts = size_charts(settings);
  if (!charts) return charts.error();
  if (stages != nullptr) {
    auto sizes = load_size_charts(*charts);
    if (!sizes) return sizes.error();
    handle->data.charts = std::move(*sizes);
    auto engine = create_engine(words, std::move(stages));
    if (!engine) return engine.error();
    handle->engine = std::move(*engine);
    return handle;
  }
  auto data = load_data(settings, std::move(*charts));
  if (!data) return data.error();
  handle->data = std::move(*data);
  auto engine = make_engine(words, handle->data, "");
  if (!engine) return engine.error();
  handle->engine = std::move(*engine);
  return handle;
}

}  // namespace im2fit
