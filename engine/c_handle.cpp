// SPDX-License-Identifier: Apache-2.0
#include "engine/c_handle.h"

#include <unistd.h>

#include <utility>

#include "engine/c_api/data.h"
#include "engine/c_api/settings.h"

namespace im2fit {
namespace {

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
  settings.turn = s.turn != 0 ? Turn::asked : Turn::none;
  settings.clothing = static_cast<ClothingGiven>(s.clothing);
  settings.sensor = static_cast<SensorKind>(s.sensor);
  settings.live = s.live != 0;
  settings.single_thread = s.single_thread != 0;
  settings.pool_frames = s.pool_frames;
  return settings;
}

Status load_sizes(const im2fit_settings& settings, im2fit_handle& handle) {
  if (settings.men_chart_path == nullptr && settings.women_chart_path == nullptr) {
    handle.sizes = builtin_size_system();
    return Ok{};
  }
  if (settings.men_chart_path == nullptr) return missing("men_chart_path");
  if (settings.women_chart_path == nullptr) return missing("women_chart_path");
  auto men = load_size_chart(settings.men_chart_path);
  if (!men) return men.error();
  auto women = load_size_chart(settings.women_chart_path);
  if (!women) return women.error();
  auto sizes = make_size_system({std::move(*men), std::move(*women)});
  if (!sizes) return sizes.error();
  handle.sizes = std::move(*sizes);
  return Ok{};
}

Status load_models(const im2fit_settings& settings, im2fit_handle& handle) {
  const bool tracker_by_path = settings.tracker_data.kind == IM2FIT_DATA_PATH;
  const bool index_by_path = settings.index_data.kind == IM2FIT_DATA_PATH;
  if (tracker_by_path && settings.tracker_path == nullptr) return missing("tracker_path");
  if (index_by_path && settings.index_path == nullptr) return missing("index_path");
  if (tracker_by_path) {
    auto file = MappedFile::open(settings.tracker_path);
    if (!file) return file.error();
    handle.tracker_file = std::move(*file);
  } else {
    auto bytes = c::bytes_of(settings.tracker_data, "tracker_data");
    if (!bytes) return bytes.error();
    handle.tracker_bytes = std::move(*bytes);
  }
  auto tracker = tracker_by_path ? JointModel::parse(handle.tracker_file.bytes(), settings.tracker_path)
                                 : JointModel::parse(handle.tracker_bytes, "settings.tracker_data");
  if (!tracker) return tracker.error();
  handle.tracker.emplace(std::move(*tracker));
  auto index = index_by_path ? index::Index::open(settings.index_path)
                             : c::parsed<index::Index>(settings.index_data, "index_data");
  if (!index) return index.error();
  handle.index.emplace(std::move(*index));
  return Ok{};
}

}  // namespace

int status_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::invalid_argument:
      return IM2FIT_ERROR_INVALID_ARGUMENT;
    case ErrorCode::not_found:
      return IM2FIT_ERROR_NOT_FOUND;
    case ErrorCode::io:
      return IM2FIT_ERROR_IO;
    case ErrorCode::corrupt:
      return IM2FIT_ERROR_CORRUPT;
    case ErrorCode::unsupported:
      return IM2FIT_ERROR_UNSUPPORTED;
    case ErrorCode::no_device:
      return IM2FIT_ERROR_NO_DEVICE;
    case ErrorCode::timeout:
      return IM2FIT_ERROR_TIMEOUT;
    case ErrorCode::end_of_stream:
      break;
  }
  return IM2FIT_ERROR_END_OF_STREAM;
}

Result<std::unique_ptr<im2fit_handle>> open_c_handle(const im2fit_settings& settings,
                                                     std::unique_ptr<FrameStages> stages) {
  if (auto ok = c::check_settings(settings); !ok) return ok.error();
  auto handle = std::make_unique<im2fit_handle>();
  handle->process = ::getpid();
  handle->log = settings.log;
  handle->log_user = settings.log_user;
  handle->width = settings.width;
  handle->height = settings.height;
  if (auto loaded = load_sizes(settings, *handle); !loaded) return loaded.error();
  if (settings.body_path != nullptr || settings.body_data.kind != IM2FIT_DATA_PATH) {
    auto body = settings.body_data.kind == IM2FIT_DATA_PATH
                    ? body::BodyModel::load(settings.body_path)
                    : c::parsed<body::BodyModel>(settings.body_data, "body_data");
    if (!body) return body.error();
    handle->body.emplace(std::move(*body));
  }
  if (stages == nullptr) {
    if (auto loaded = load_models(settings, *handle); !loaded) return loaded.error();
  }
  EngineSettings engine_words = engine_settings(settings);
  if (handle->body) engine_words.shape_space = &handle->body->shape_space();
  auto engine = stages == nullptr ? Engine::create(engine_words, *handle->tracker, *handle->index)
                                  : create_engine(engine_words, std::move(stages));
  if (!engine && handle->index)
    return Error{engine.error().code, c::name_of(settings.index_data, settings.index_path, "index_data") + " with " +
                                          c::name_of(settings.tracker_data, settings.tracker_path, "tracker_data") +
                                          ": " + engine.error().message};
  if (!engine) return engine.error();
  handle->engine = std::move(*engine);
  handle->frames.prepare(engine_words.intrinsics);
  return handle;
}

}  // namespace im2fit
