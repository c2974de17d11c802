// SPDX-License-Identifier: Apache-2.0
// The C functions of include/im2fit/im2fit.h over the C++ engine. Nothing of C++ crosses: every function catches.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <new>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "body/skeleton.h"
#include "capi/person.h"
#include "core/measurement.h"

namespace {

using im2fit::c::fail;
using im2fit::c::guarded;
using im2fit::c::no_body;
using im2fit::c::not_measured;
using im2fit::c::with_person;

static_assert(IM2FIT_MEASUREMENT_COUNT == im2fit::kMeasurementCount);
static_assert(IM2FIT_JOINT_COUNT == im2fit::kJointCount);
static_assert(IM2FIT_GUIDANCE_COUNT == im2fit::kGuidanceCount);
static_assert(IM2FIT_WEIGHT == static_cast<int>(im2fit::Measurement::weight));
static_assert(IM2FIT_HIP_GIRTH == static_cast<int>(im2fit::Measurement::hip_girth));
static_assert(IM2FIT_STATE_MEASURED == static_cast<int>(im2fit::SessionState::measured));
static_assert(IM2FIT_STATE_LOST == static_cast<int>(im2fit::SessionState::lost));
static_assert(IM2FIT_STATE_TURNING == static_cast<int>(im2fit::SessionState::turning));
static_assert(IM2FIT_VIEWS_AROUND == static_cast<int>(im2fit::AnswerViews::around));
static_assert(IM2FIT_SENSOR_UNKNOWN == static_cast<int>(im2fit::SensorKind::unknown));
static_assert(IM2FIT_SENSOR_TIME_OF_FLIGHT == static_cast<int>(im2fit::SensorKind::time_of_flight));
static_assert(IM2FIT_SENSOR_STEREO == static_cast<int>(im2fit::SensorKind::stereo));
static_assert(IM2FIT_USER_COUNT_MAX == im2fit::kUserCountMax);
static_assert(IM2FIT_VIEW_UNKNOWN == static_cast<int>(im2fit::ViewSide::unknown));
static_assert(IM2FIT_VIEW_SIDE == static_cast<int>(im2fit::ViewSide::side));
static_assert(IM2FIT_GUIDANCE_MOVING == static_cast<int>(im2fit::Guidance::moving));
static_assert(IM2FIT_GUIDANCE_CALIBRATION_POSE == static_cast<int>(im2fit::Guidance::calibration_pose));
static_assert(IM2FIT_GUIDANCE_TURN_ROUND == static_cast<int>(im2fit::Guidance::turn_round));
static_assert(IM2FIT_GUIDANCE_CLOTHED == static_cast<int>(im2fit::Guidance::clothed));
static_assert(IM2FIT_GUIDANCE_WALK_ROUND == static_cast<int>(im2fit::Guidance::walk_round));
static_assert(IM2FIT_GUIDANCE_HEAD_UNSEEN == static_cast<int>(im2fit::Guidance::head_unseen));
static_assert(IM2FIT_GUIDANCE_STEP_TO_THE_MIDDLE == static_cast<int>(im2fit::Guidance::step_to_the_middle));
static_assert(IM2FIT_GUIDANCE_DEPTH_MISSING == static_cast<int>(im2fit::Guidance::depth_missing));
static_assert(IM2FIT_TURN_WALK == static_cast<int>(im2fit::Turn::walk));
static_assert(IM2FIT_CLOTHING_DRESSED == static_cast<int>(im2fit::ClothingGiven::dressed));
// No padding at the end, which callers never set: a field that comes later would be read from it.
static_assert(sizeof(im2fit_settings) == offsetof(im2fit_settings, pack_data) + sizeof(im2fit_data));

#define IM2FIT_TEXT_OF(x) #x
#define IM2FIT_TEXT(x) IM2FIT_TEXT_OF(x)
constexpr const char* kVersion =
    IM2FIT_TEXT(IM2FIT_VERSION_MAJOR) "." IM2FIT_TEXT(IM2FIT_VERSION_MINOR) "." IM2FIT_TEXT(IM2FIT_VERSION_PATCH);

// Up to `log_user`: what every caller has. Fields past the caller's size are 0.
constexpr std::size_t kSettingsSizeMin = offsetof(im2fit_settings, user_id);

// A struct a newer caller made: what we do not know must be unset.
bool copy_settings(const im2fit_settings& from, im2fit_settings& to) {
  const std::size_t size = from.struct_size;
  if (size < kSettingsSizeMin || size > 65536) return false;
  to = {};
  std::memcpy(&to, &from, std::min(size, sizeof to));
  if (size <= sizeof to) return true;
  const std::span<const char> bytes(reinterpret_cast<const char*>(&from), size);
  return std::all_of(bytes.begin() + sizeof to, bytes.end(), [](char c) { return c == 0; });
}

int open_guarded(const im2fit_settings* settings, im2fit_handle** handle) {
  im2fit_settings known;
  if (!copy_settings(*settings, known))
    return fail(nullptr, IM2FIT_ERROR_UNSUPPORTED,
                "settings.struct_size fits no version of this library: call im2fit_settings_init first");
  auto opened = im2fit::open_c_handle(known, nullptr);
  if (opened) {
    *handle = opened->release();
    return IM2FIT_OK;
  }
  const int status = fail(nullptr, opened.error());
  if (known.log != nullptr) known.log(known.log_user, status, im2fit::c::last_error_of_thread());
  return status;
}

im2fit_joint to_c(im2fit::Vec3f position, float confidence) {
  return {position.x, position.y, position.z, confidence};
}

im2fit_result to_c(const im2fit::EngineResult& r) {
  im2fit_result out{};
  out.state = static_cast<std::int32_t>(r.state);
  out.guidance = r.guidance;
  out.guidance_seen = r.guidance_seen;
  out.has_joints = r.has_joints || r.measured ? 1 : 0;
  out.frames_seen = r.frames_seen;
  out.frames_used = r.frames_used;
  out.frames_dropped = r.frames_dropped;
  out.sequence_gaps = r.sequence_gaps;
  out.sequence_repeats = r.sequence_repeats;
  out.time_reversals = r.time_reversals;
  const im2fit::JointSet& joints = r.measured ? r.measured_joints : r.joints;
  for (std::size_t i = 0; i < im2fit::kJointCount; ++i)
    out.joints[i] = to_c(joints.position_mm[i], joints.confidence[i]);
  out.measured = r.measured ? 1 : 0;
  out.front_measured = r.front_measured ? 1 : 0;
  out.views = static_cast<std::int32_t>(r.views);
  out.arms_close = r.arms_close;
  out.clothing_probability = r.answer.clothing.probability;
  out.clothing_ease_mm = r.answer.clothing.ease_mm;
  out.known_used = r.known_outcome.used;
  out.known_doubted = r.known_outcome.doubted;
  out.frames_back = static_cast<std::uint32_t>(r.frames_back);
  out.turned_deg = r.turned_deg;
  out.female = r.answer.female;
  out.age = {r.age.years.value, r.age.years.low, r.age.years.high};
  std::copy(r.age.bands.begin(), r.age.bands.end(), out.age_bands);
  for (std::size_t i = 0; i < im2fit::kMeasurementCount; ++i) {
    const im2fit::index::IntervalEstimate& e = r.answer.measurements[i];
    out.measurements[i] = {e.value, e.low, e.high};
    out.paper[i] = r.paper[i];
  }
  out.index_entry = r.answer.nearest;
  out.index_distance = r.answer.nearest_distance;
  out.user_id = r.user;
  out.view = static_cast<std::int32_t>(r.view);
  out.session = r.session;
  out.user_count = r.user_count;
  for (std::size_t i = 0; i < static_cast<std::size_t>(r.user_count); ++i) {
    const im2fit::User& u = r.users[i];
    out.users[i] = {u.id, u.u_min, u.v_min, u.u_max, u.v_max, u.centroid_mm.x, u.centroid_mm.y, u.centroid_mm.z};
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(r.user_count); ++i) {
    if (!r.users[i].confirmed) continue;
    out.users_outside |= r.users[i].left_out == im2fit::LeftOut::outside ? 1U << i : 0;
    out.users_still |= r.users[i].left_out == im2fit::LeftOut::still ? 1U << i : 0;
  }
  if (!r.has_joints) return out;
  out.joints_inferred = r.joints_inferred;
  for (std::size_t i = 0; i < im2fit::kJointCount; ++i)
    out.display_joints[i] = to_c(r.display_joints.position_mm[i], r.display_joints.confidence[i]);
  return out;
}

// Posed body vertices, the lowest at y = 0.
std::vector<im2fit::Vec3f> posed_mesh(const im2fit::body::BodyModel& model, const im2fit::AnsweredBody& body) {
  std::vector<im2fit::Vec3f> rest(static_cast<std::size_t>(model.vertex_count()));
  model.morph(body.params, rest);
  std::vector<im2fit::Vec3f> posed(rest.size());
  im2fit::body::skin(model, rest, im2fit::body::rest_skeleton(model, rest), body.pose, posed);
  posed.resize(static_cast<std::size_t>(model.body_vertex_count()));
  float sole = posed.front().y;
  for (const im2fit::Vec3f& v : posed) sole = std::min(sole, v.y);
  for (im2fit::Vec3f& v : posed) v.y -= sole;
  return posed;
}

template <std::size_t N>
const char* name_at(const std::array<std::string_view, N>& names, int index) {
  // The tables hold literals, which end in a zero byte.
  return index >= 0 && static_cast<std::size_t>(index) < N ? names[static_cast<std::size_t>(index)].data() : nullptr;
}

}  // namespace

extern "C" {

const char* im2fit_version(void) {
  return kVersion;
}

const char* im2fit_status_name(int status) {
  constexpr std::array<std::string_view, 14> kNames = {
      "ok",      "invalid_argument", "not_found", "io",           "corrupt",   "unsupported", "no_device",
      "timeout", "end_of_stream",    "no_memory", "not_measured", "too_small", "internal",    "forked"};
  const char* name = status <= 0 && status > -100 ? name_at(kNames, -status) : nullptr;
  return name != nullptr ? name : "unknown";
}

const char* im2fit_last_error(const im2fit_handle* handle) {
  return handle != nullptr ? handle->error.data() : im2fit::c::last_error_of_thread();
}

void im2fit_settings_init(im2fit_settings* settings, size_t struct_size) {
  if (settings == nullptr) return;
  im2fit_settings defaults{};
  defaults.struct_size = struct_size;
  defaults.frames_wanted = im2fit::kFramesWantedDefault;
  defaults.frames_min = 5;
  defaults.pool_frames = 8;
  std::memset(settings, 0, struct_size);
  std::memcpy(settings, &defaults, std::min(struct_size, sizeof defaults));
}

int im2fit_open(const im2fit_settings* settings, im2fit_handle** handle) {
  if (handle == nullptr) return fail(nullptr, IM2FIT_ERROR_INVALID_ARGUMENT, "the place for the handle is NULL");
  *handle = nullptr;
  if (settings == nullptr) return fail(nullptr, IM2FIT_ERROR_INVALID_ARGUMENT, "the settings are NULL");
  try {
    return open_guarded(settings, handle);
  } catch (const std::bad_alloc&) {
    return fail(nullptr, IM2FIT_ERROR_NO_MEMORY, "out of memory");
  } catch (...) {
    return fail(nullptr, IM2FIT_ERROR_INTERNAL, "internal error");
  }
}

void im2fit_close(im2fit_handle* handle) {
  if (handle != nullptr && !im2fit::c::opened_here(*handle)) handle->leave_to_parent();
  delete handle;
}

int im2fit_push(im2fit_handle* handle, const uint16_t* depth_mm, int32_t width, int32_t height, size_t stride,
                uint64_t sequence, int64_t time_ns) {
  return guarded(handle, [&](im2fit_handle& h) {
    if (depth_mm == nullptr) return fail(&h, IM2FIT_ERROR_INVALID_ARGUMENT, "the frame is NULL");
    if (stride != 0 && (width < 0 || stride < static_cast<std::size_t>(width) || stride > 1U << 24))
      return fail(&h, IM2FIT_ERROR_INVALID_ARGUMENT,
                  "the stride is less than the width (it counts values, not bytes)");
    const im2fit::DepthView depth(depth_mm, width, height, stride == 0 ? width : static_cast<int>(stride));
    im2fit::hal::FrameInfo info;
    info.sequence = sequence;
    info.host_ns = time_ns;
    const auto pushed = h.engine->push(depth, info);
    return pushed ? static_cast<int>(IM2FIT_OK) : fail(&h, pushed.error());
  });
}

int im2fit_finish(im2fit_handle* handle) {
  return guarded(handle, [](im2fit_handle& h) {
    h.engine->finish();
    const auto sound = h.engine->fault();
    return sound ? static_cast<int>(IM2FIT_OK) : fail(&h, sound.error());
  });
}

int im2fit_reset(im2fit_handle* handle) {
  return guarded(handle, [](im2fit_handle& h) {
    h.engine->reset();
    h.next_after.reset();
    h.forget_person();
    h.frames.forget();
    h.mask->forget();
    return static_cast<int>(IM2FIT_OK);
  });
}

int im2fit_next(im2fit_handle* handle) {
  return guarded(handle, [](im2fit_handle& h) {
    h.engine->next_person();
    // Read afterwards: a frame in the pipeline may have measured the person. Before MEASURED the new session has
    // begun.
    const im2fit::EngineResult now = h.engine->result();
    if (now.measured) h.next_after = now.session;
    return static_cast<int>(IM2FIT_OK);
  });
}

int im2fit_select_user(im2fit_handle* handle, int32_t user_id) {
  return guarded(handle, [&](im2fit_handle& h) {
    if (user_id < 0)
      return fail(&h, IM2FIT_ERROR_INVALID_ARGUMENT,
                  "user id " + std::to_string(user_id) + ": ids are 1 and up, 0 means any person");
    h.engine->select_user(user_id);
    return static_cast<int>(IM2FIT_OK);
  });
}

int im2fit_set_region(im2fit_handle* handle, float x0_mm, float z0_mm, float x1_mm, float z1_mm) {
  return guarded(handle, [&](im2fit_handle& h) {
    const bool everywhere = x0_mm == 0 && z0_mm == 0 && x1_mm == 0 && z1_mm == 0;
    const im2fit::FloorRegion region{x0_mm, z0_mm, x1_mm, z1_mm};
    const auto set = h.engine->set_region(everywhere ? std::nullopt : std::optional(region));
    return set ? static_cast<int>(IM2FIT_OK) : fail(&h, IM2FIT_ERROR_INVALID_ARGUMENT, set.error().message);
  });
}

int im2fit_set_opener(im2fit_handle* handle, im2fit_opener_fn opener, void* opener_user) {
  return guarded(handle, [&](im2fit_handle& h) {
    h.opener = opener;
    h.opener_user = opener_user;
    return static_cast<int>(IM2FIT_OK);
  });
}

int im2fit_set_opener_down(im2fit_handle* handle, im2fit_down_fn down) {
  return guarded(handle, [&](im2fit_handle& h) {
    h.opener_down = down;
    return static_cast<int>(IM2FIT_OK);
  });
}

int im2fit_attach(im2fit_handle* handle, const char* uri) {
  return guarded(handle, [&](im2fit_handle& h) {
    if (uri == nullptr) return fail(&h, IM2FIT_ERROR_INVALID_ARGUMENT, "the URI is NULL");
    if (h.opener == nullptr)
      return fail(&h, IM2FIT_ERROR_UNSUPPORTED,
                  std::string("no opener for ") + uri +
                      ": call im2fit_set_opener (im2fit_cameras_use) first, or push frames");
    h.source.reset();
    im2fit_source source{};
    const int status = h.opener(h.opener_user, uri, &source);
    if (status != IM2FIT_OK)
      return fail(&h, im2fit::c::known_status(status),
                  std::string("cannot open ") + uri + ": the opener returned " + std::to_string(status) + " (" +
                      im2fit_status_name(status) + ")");
    if (source.next == nullptr)
      return fail(&h, IM2FIT_ERROR_INVALID_ARGUMENT, std::string("the opener set no next() for ") + uri);
    h.source = std::make_unique<OpenedSource>(source, h.opener_down, h.origin);
    return static_cast<int>(IM2FIT_OK);
  });
}

int im2fit_pump(im2fit_handle* handle, int32_t timeout_ms) {
  return guarded(handle, [&](im2fit_handle& h) {
    if (h.source == nullptr)
      return fail(&h, IM2FIT_ERROR_INVALID_ARGUMENT, "no source is attached: call im2fit_attach first");
    h.source->forget_status();
    const auto pumped = im2fit::pump(*h.source, *h.engine, timeout_ms);
    if (pumped && *pumped == im2fit::Pumped::frame) return static_cast<int>(IM2FIT_OK);
    // TIMEOUT and END_OF_STREAM are not failures, so they are not logged.
    if (pumped && *pumped == im2fit::Pumped::waiting) return static_cast<int>(IM2FIT_ERROR_TIMEOUT);
    if (pumped && *pumped == im2fit::Pumped::end) return static_cast<int>(IM2FIT_ERROR_END_OF_STREAM);
    const int status = h.source->status();
    if (status != IM2FIT_OK)
      return fail(&h, im2fit::c::known_status(status),
                  "the attached source gave no frame: its next() returned " + std::to_string(status) + " (" +
                      im2fit_status_name(status) + ")");
    return fail(&h, pumped.error());
  });
}

int im2fit_detach(im2fit_handle* handle) {
  return guarded(handle, [](im2fit_handle& h) {
    h.source.reset();
    return static_cast<int>(IM2FIT_OK);
  });
}

int im2fit_poll(const im2fit_handle* handle, im2fit_result* result, size_t struct_size) {
  // From any thread: it may not touch the handle's error text, only the calling thread's.
  if (handle == nullptr || result == nullptr)
    return fail(nullptr, IM2FIT_ERROR_INVALID_ARGUMENT,
                handle == nullptr ? "the handle is NULL" : "the place for the result is NULL");
  if (!im2fit::c::opened_here(*handle)) return im2fit::c::fail_forked();
  im2fit_result full = to_c(handle->engine->result());
  full.frames_wanted = handle->frames_wanted;
  std::memcpy(result, &full, std::min(struct_size, sizeof full));
  if (struct_size > sizeof full)
    std::memset(reinterpret_cast<char*>(result) + sizeof full, 0, struct_size - sizeof full);
  return IM2FIT_OK;
}

int im2fit_sizes(im2fit_handle* handle, im2fit_size* sizes, size_t capacity, size_t* count, size_t* best) {
  return guarded(handle, [&](im2fit_handle& h) {
    if (count == nullptr || (sizes == nullptr && capacity > 0))
      return fail(&h, IM2FIT_ERROR_INVALID_ARGUMENT, "count is NULL, or sizes is NULL with a capacity");
    *count = 0;
    return with_person(h, [&](const im2fit::PersonMeasurement& person) {
      const im2fit::SizeAnswer& answer = *person.size;
      *count = answer.entries.size();
      if (capacity < *count)
        return fail(&h, IM2FIT_ERROR_TOO_SMALL, "there are " + std::to_string(*count) + " sizes");
      for (std::size_t i = 0; i < *count; ++i) {
        const im2fit::SizeAnswer::Entry& entry = answer.entries[i];
        sizes[i] = {};
        entry.size.copy(sizes[i].name, sizeof sizes[i].name - 1);
        sizes[i].probability = static_cast<float>(entry.probability);
        if (best != nullptr && entry.size == answer.best) *best = i;
      }
      return static_cast<int>(IM2FIT_OK);
    });
  });
}

int im2fit_body_mesh(im2fit_handle* handle, float* vertices, size_t vertex_capacity, size_t* vertex_count,
                     int32_t* triangles, size_t triangle_capacity, size_t* triangle_count) {
  return guarded(handle, [&](im2fit_handle& h) {
    if (vertex_count == nullptr || triangle_count == nullptr)
      return fail(&h, IM2FIT_ERROR_INVALID_ARGUMENT, "vertex_count or triangle_count is NULL");
    *vertex_count = *triangle_count = 0;
    if (h.data.body_model == nullptr) return no_body(h);
    const im2fit::body::BodyModel& model = *h.data.body_model;
    const auto faces = model.body_triangles();
    *vertex_count = static_cast<std::size_t>(model.body_vertex_count());
    *triangle_count = faces.size();
    if (!h.engine->result().measured) return not_measured(h);
    if ((vertices != nullptr && vertex_capacity < *vertex_count) ||
        (triangles != nullptr && triangle_capacity < *triangle_count))
      return fail(&h, IM2FIT_ERROR_TOO_SMALL,
                  "the body has " + std::to_string(*vertex_count) + " vertices and " +
                      std::to_string(*triangle_count) + " triangles");
    if (triangles != nullptr) std::memcpy(triangles, faces.data(), faces.size_bytes());
    if (vertices == nullptr) return static_cast<int>(IM2FIT_OK);
    return with_person(h, [&](const im2fit::PersonMeasurement& person) {
      const auto mesh = posed_mesh(model, *person.body);
      for (std::size_t i = 0; i < *vertex_count; ++i) {
        vertices[3 * i] = mesh[i].x;
        vertices[3 * i + 1] = mesh[i].y;
        vertices[3 * i + 2] = mesh[i].z;
      }
      return static_cast<int>(IM2FIT_OK);
    });
  });
}

int im2fit_body_residual(im2fit_handle* handle, float residual[IM2FIT_MEASUREMENT_COUNT]) {
  return guarded(handle, [&](im2fit_handle& h) {
    if (residual == nullptr) return fail(&h, IM2FIT_ERROR_INVALID_ARGUMENT, "the place for the residual is NULL");
    if (h.data.body_model == nullptr) return no_body(h);
    return with_person(h, [&](const im2fit::PersonMeasurement& person) {
      std::copy(person.body->fit.residual.begin(), person.body->fit.residual.end(), residual);
      return static_cast<int>(IM2FIT_OK);
    });
  });
}

const char* im2fit_state_name(int state) {
  constexpr std::array<std::string_view, 7> kNames = {"SEARCHING", "USER_FOUND", "CALIBRATING", "TRACKING",
                                                      "MEASURED",  "LOST",       "TURNING"};
  return name_at(kNames, state);
}

const char* im2fit_guidance_name(int bit) {
  return name_at(im2fit::kGuidanceNames, bit);
}

const char* im2fit_measurement_name(int id) {
  return id >= 0 && id < IM2FIT_MEASUREMENT_COUNT ? im2fit::kMeasurementTable[static_cast<std::size_t>(id)].id.data()
                                                  : nullptr;
}

const char* im2fit_measurement_unit(int id) {
  return id >= 0 && id < IM2FIT_MEASUREMENT_COUNT
             ? im2fit::kMeasurementTable[static_cast<std::size_t>(id)].unit.data()
             : nullptr;
}

const char* im2fit_joint_name(int joint) {
  return name_at(im2fit::kJointNames, joint);
}

const char* im2fit_view_name(int view) {
  constexpr std::array<std::string_view, 4> kNames = {"unknown", "front", "back", "side"};
  return name_at(kNames, view);
}

}  // extern "C"
