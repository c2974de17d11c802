// SPDX-License-Identifier: Apache-2.0
// An OpenNI2 driver module: the runtime loads it from OpenNI2/Drivers and sees a depth camera.
#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstring>
#include <initializer_list>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

// OniDriverAPI.h expects these of a header that Debian does not ship.
#define XN_NEW(type, ...) new type(__VA_ARGS__)
#define XN_DELETE(pointer) delete (pointer)
#include "Driver/OniDriverAPI.h"
#include "hal/intrinsics.h"
#include "pictures.h"
#include "settings.h"

namespace im2fit::openni2_virtual {
namespace {

// The recorder's codec keeps values below this and below 32768 exactly.
constexpr int kDepthLimit_mm = 32768;
constexpr int kUnitsPer_mm = 10;  // in the 100 um mode

class Driver;

// Copies a property out as OpenNI2 requires: the caller's size must be the property's.
template <class T>
OniStatus copy_out(const T& value, void* data, int* size) {
  if (*size != static_cast<int>(sizeof value)) return ONI_STATUS_BAD_PARAMETER;
  std::memcpy(data, &value, sizeof value);
  return ONI_STATUS_OK;
}

class Stream final : public oni::driver::StreamBase {
 public:
  Stream(std::shared_ptr<Pictures> pictures, const Settings& settings, Driver& driver, std::string uri)
      : pictures_(std::move(pictures)), settings_(settings), driver_(driver), uri_(std::move(uri)) {
    mode_ = {ONI_PIXEL_FORMAT_DEPTH_1_MM, pictures_->camera().width, pictures_->camera().height, settings.fps};
    pixels_.resize(static_cast<std::size_t>(mode_.resolutionX) * static_cast<std::size_t>(mode_.resolutionY));
  }
  ~Stream() override { Stream::stop(); }

  OniStatus start() override;
  void stop() override;

  OniBool isPropertySupported(int id) override {
    for (const int known : kProperties)
      if (id == known) return TRUE;
    return FALSE;
  }
  OniStatus getProperty(int id, void* data, int* size) override;
  OniStatus setProperty(int id, const void* data, int size) override;
  // The recorder writes the properties raised here. Without STRIDE and CROPPING its files play no frame and no error.
  void notifyAllProperties() override;

 private:
  static constexpr int kProperties[] = {ONI_STREAM_PROPERTY_VIDEO_MODE,   ONI_STREAM_PROPERTY_HORIZONTAL_FOV,
                                        ONI_STREAM_PROPERTY_VERTICAL_FOV, ONI_STREAM_PROPERTY_MAX_VALUE,
                                        ONI_STREAM_PROPERTY_MIN_VALUE,    ONI_STREAM_PROPERTY_STRIDE,
                                        ONI_STREAM_PROPERTY_CROPPING,     ONI_STREAM_PROPERTY_MIRRORING};

  void run();
  void send(std::uint64_t index);

  std::shared_ptr<Pictures> pictures_;
  const Settings settings_;
  Driver& driver_;
  const std::string uri_;
  OniVideoMode mode_{};
  std::vector<std::uint16_t> pixels_;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool running_ = false;
  std::thread thread_;
};

class Device final : public oni::driver::DeviceBase {
 public:
  Device(std::shared_ptr<Pictures> pictures, const Settings& settings, Driver& driver, std::string uri)
      : pictures_(std::move(pictures)), settings_(settings), driver_(driver), uri_(std::move(uri)) {
    const Intrinsics& k = pictures_->camera();
    modes_[0] = {ONI_PIXEL_FORMAT_DEPTH_1_MM, k.width, k.height, settings.fps};
    modes_[1] = {ONI_PIXEL_FORMAT_DEPTH_100_UM, k.width, k.height, settings.fps};
    sensor_ = {ONI_SENSOR_DEPTH, 2, modes_};
  }
  OniStatus getSensorInfoList(OniSensorInfo** list, int* count) override {
    *list = &sensor_;
    *count = 1;
    return ONI_STATUS_OK;
  }
  oni::driver::StreamBase* createStream(OniSensorType type) override {
    if (type != ONI_SENSOR_DEPTH || pictures_.use_count() > 1) return nullptr;  // pictures are made for one stream
    return new Stream(pictures_, settings_, driver_, uri_);
  }
  void destroyStream(oni::driver::StreamBase* stream) override { delete stream; }
  OniBool isPropertySupported(int id) override {
    return id == ONI_DEVICE_PROPERTY_SERIAL_NUMBER || id == ONI_DEVICE_PROPERTY_DRIVER_VERSION ||
           id == ONI_DEVICE_PROPERTY_FIRMWARE_VERSION || id == ONI_DEVICE_PROPERTY_HARDWARE_VERSION ||
           id == ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION;
  }
  OniStatus getProperty(int id, void* data, int* size) override {
    switch (id) {
      case ONI_DEVICE_PROPERTY_SERIAL_NUMBER:
      case ONI_DEVICE_PROPERTY_FIRMWARE_VERSION: {
        const std::string text = id == ONI_DEVICE_PROPERTY_SERIAL_NUMBER ? std::to_string(settings_.seed) : "1";
        if (*size < 1) return ONI_STATUS_BAD_PARAMETER;
        std::snprintf(static_cast<char*>(data), static_cast<std::size_t>(*size), "%s", text.c_str());
        return ONI_STATUS_OK;
      }
      case ONI_DEVICE_PROPERTY_DRIVER_VERSION:
        return copy_out(OniVersion{0, 1, 0, 0}, data, size);
      case ONI_DEVICE_PROPERTY_HARDWARE_VERSION:
        return copy_out(1, data, size);
      case ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION:
        return copy_out(ONI_IMAGE_REGISTRATION_OFF, data, size);
      default:
        return ONI_STATUS_NOT_SUPPORTED;
    }
  }
  OniStatus setProperty(int id, const void* data, int size) override {
    if (id != ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION) return ONI_STATUS_NOT_SUPPORTED;
    OniImageRegistrationMode mode{};
    if (size != static_cast<int>(sizeof mode)) return ONI_STATUS_BAD_PARAMETER;
    std::memcpy(&mode, data, sizeof mode);
    return mode == ONI_IMAGE_REGISTRATION_OFF ? ONI_STATUS_OK : ONI_STATUS_NOT_SUPPORTED;
  }

 private:
  std::shared_ptr<Pictures> pictures_;
  const Settings settings_;
  Driver& driver_;
  const std::string uri_;
  OniVideoMode modes_[2];
  OniSensorInfo sensor_{};
};

OniDeviceInfo describe(const std::string& uri) {
  OniDeviceInfo info{};
  std::snprintf(info.uri, sizeof info.uri, "%s", uri.c_str());
  std::snprintf(info.vendor, sizeof info.vendor, "im2fit");
  std::snprintf(info.name, sizeof info.name, "virtual depth camera");
  return info;
}

class Driver final : public oni::driver::DriverBase {
 public:
  explicit Driver(OniDriverServices* services) : DriverBase(services), unplugged_(std::make_shared<Unplugged>()) {}

  // The runtime's current directory is the driver's folder during this call: no path may be opened here.
  OniStatus initialize(oni::driver::DeviceConnectedCallback connected,
                       oni::driver::DeviceDisconnectedCallback disconnected,
                       oni::driver::DeviceStateChangedCallback state_changed, void* cookie) override {
    DriverBase::initialize(connected, disconnected, state_changed, cookie);
    const std::string uri = announced_uri();
    if (!uri.empty()) announce(uri);
    return ONI_STATUS_OK;
  }

  OniStatus tryDevice(const char* uri) override {
    const std::string text = uri;
    if (text.rfind(kScheme, 0) != 0 || text.size() >= ONI_MAX_STR) return ONI_STATUS_ERROR;
    {
      const std::lock_guard lock(unplugged_->mutex);
      if (unplugged_->gone.count(text) != 0) return ONI_STATUS_ERROR;
    }
    announce(text);
    return ONI_STATUS_OK;
  }

  oni::driver::DeviceBase* deviceOpen(const char* uri, const char* /*mode*/) override {
    const auto settings = settings_of(uri);
    if (!settings) return refuse(settings.error());
    auto pictures = settings->folder.empty() ? person_pictures(*settings) : folder_pictures(*settings);
    if (!pictures) return refuse(pictures.error());
    return new Device(std::move(*pictures), *settings, *this, uri);
  }
  void deviceClose(oni::driver::DeviceBase* device) override { delete device; }

  // The runtime holds its lock while it calls this, and telling it of a lost device takes the same lock: so a thread
  // that is just doing so must not be waited for without end.
  void shutdown() override {
    std::unique_lock lock(unplugged_->mutex);
    unplugged_->quit = true;
    unplugged_->idle.notify_all();
    const bool idle =
        unplugged_->idle.wait_for(lock, std::chrono::milliseconds(500), [&] { return unplugged_->calls == 0; });
    lock.unlock();
    for (auto& thread : unplug_threads_) idle ? thread.join() : thread.detach();
    unplug_threads_.clear();
  }

  // As when the cable is pulled, and with `replug_ms` put back so much later: as with USB devices the URI is another
  // then. Returns at once: the runtime may be waiting for the calling thread.
  void unplug(const std::string& uri, int replug_ms) {
    const std::lock_guard lock(unplugged_->mutex);
    if (unplugged_->quit) return;
    ++unplugged_->calls;
    if (replug_ms >= 0) unplugged_->gone.insert(uri);
    unplug_threads_.emplace_back([this, uri, replug_ms, state = unplugged_] {
      const OniDeviceInfo info = describe(uri);
      deviceDisconnected(&info);
      std::unique_lock done(state->mutex);
      if (replug_ms >= 0 &&
          !state->idle.wait_for(done, std::chrono::milliseconds(replug_ms), [&] { return state->quit; })) {
        done.unlock();
        announce(plugged_in_again(uri));
        done.lock();
      }
      --state->calls;
      state->idle.notify_all();
    });
  }

 private:
  struct Unplugged {
    std::mutex mutex;
    std::condition_variable idle;
    std::set<std::string> gone;  // URIs that will not be there again
    int calls = 0;
    bool quit = false;
  };

  void announce(const std::string& uri) {
    const OniDeviceInfo info = describe(uri);
    deviceConnected(&info);
  }
  oni::driver::DeviceBase* refuse(const Error& error) {
    getServices().errorLoggerAppend("%s", error.message.c_str());
    return nullptr;
  }

  std::shared_ptr<Unplugged> unplugged_;
  std::vector<std::thread> unplug_threads_;
};

OniStatus Stream::start() {
  const std::lock_guard lock(mutex_);
  if (running_) return ONI_STATUS_OK;
  if (thread_.joinable()) return ONI_STATUS_ERROR;
  running_ = true;
  thread_ = std::thread([this] { run(); });
  return ONI_STATUS_OK;
}

void Stream::stop() {
  {
    const std::lock_guard lock(mutex_);
    running_ = false;
    wake_.notify_all();
  }
  if (thread_.joinable()) thread_.join();
}

// Picture k is due k/fps after the start. A picture that takes longer to make comes late. None is skipped, so that
// the same settings always give the same recording.
void Stream::run() {
  const auto begin = std::chrono::steady_clock::now();
  auto due = begin;
  for (std::uint64_t index = 0;; ++index) {
    pictures_->make(index, DepthImage(pixels_.data(), mode_.resolutionX, mode_.resolutionY));
    due = std::max(due + std::chrono::microseconds(1'000'000 / mode_.fps),
                   std::chrono::steady_clock::now() - std::chrono::milliseconds(100));
    {
      std::unique_lock lock(mutex_);
      if (wake_.wait_until(lock, due, [&] { return !running_; })) return;
    }
    const auto age = std::chrono::steady_clock::now() - begin;
    if (settings_.unplug_ms >= 0 && age >= std::chrono::milliseconds(settings_.unplug_ms)) {
      driver_.unplug(uri_, settings_.replug_ms);
      return;
    }
    send(index);
  }
}

void Stream::send(std::uint64_t index) {
  OniFrame* frame = getServices().acquireFrame();
  if (frame == nullptr) return;
  frame->frameIndex = static_cast<int>(index + 1);
  frame->timestamp = index * 1'000'000 / static_cast<std::uint64_t>(mode_.fps);
  frame->width = mode_.resolutionX;
  frame->height = mode_.resolutionY;
  frame->stride = mode_.resolutionX * 2;
  frame->cropOriginX = 0;
  frame->cropOriginY = 0;
  frame->croppingEnabled = FALSE;
  frame->sensorType = ONI_SENSOR_DEPTH;
  frame->videoMode = mode_;
  frame->dataSize = static_cast<int>(pixels_.size() * sizeof(std::uint16_t));
  auto* out = static_cast<std::uint16_t*>(frame->data);
  if (mode_.pixelFormat == ONI_PIXEL_FORMAT_DEPTH_100_UM) {
    // 16 bits end at 6.5 m; farther pixels hold no data, as a sensor of that mode reports them.
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
      const int units = pixels_[i] * kUnitsPer_mm;
      out[i] = static_cast<std::uint16_t>(units <= 65535 ? units : 0);
    }
  } else {
    std::memcpy(out, pixels_.data(), static_cast<std::size_t>(frame->dataSize));
  }
  raiseNewFrame(frame);
  getServices().releaseFrame(frame);
}

OniStatus Stream::getProperty(int id, void* data, int* size) {
  const auto view = hal::field_of_view(pictures_->camera());
  const bool fine = mode_.pixelFormat == ONI_PIXEL_FORMAT_DEPTH_100_UM;
  switch (id) {
    case ONI_STREAM_PROPERTY_VIDEO_MODE:
      return copy_out(mode_, data, size);
    case ONI_STREAM_PROPERTY_HORIZONTAL_FOV:
      return copy_out(view.horizontal_rad, data, size);
    case ONI_STREAM_PROPERTY_VERTICAL_FOV:
      return copy_out(view.vertical_rad, data, size);
    case ONI_STREAM_PROPERTY_MAX_VALUE:
      return copy_out(fine ? 65535 : kDepthLimit_mm, data, size);
    case ONI_STREAM_PROPERTY_MIN_VALUE:
      return copy_out(0, data, size);
    case ONI_STREAM_PROPERTY_STRIDE:
      return copy_out(mode_.resolutionX * 2, data, size);
    case ONI_STREAM_PROPERTY_CROPPING:
      return copy_out(OniCropping{}, data, size);
    case ONI_STREAM_PROPERTY_MIRRORING:
      return copy_out(OniBool{FALSE}, data, size);
    default:
      return ONI_STATUS_NOT_SUPPORTED;
  }
}

OniStatus Stream::setProperty(int id, const void* data, int size) {
  if (id == ONI_STREAM_PROPERTY_VIDEO_MODE) {
    OniVideoMode wanted{};
    if (size != static_cast<int>(sizeof wanted)) return ONI_STATUS_BAD_PARAMETER;
    std::memcpy(&wanted, data, sizeof wanted);
    const bool format =
        wanted.pixelFormat == ONI_PIXEL_FORMAT_DEPTH_1_MM || wanted.pixelFormat == ONI_PIXEL_FORMAT_DEPTH_100_UM;
    const std::lock_guard lock(mutex_);
    if (running_ || !format || wanted.resolutionX != mode_.resolutionX || wanted.resolutionY != mode_.resolutionY ||
        wanted.fps != mode_.fps)
      return ONI_STATUS_NOT_SUPPORTED;
    mode_ = wanted;
    raisePropertyChanged(id, &mode_, static_cast<int>(sizeof mode_));
    return ONI_STATUS_OK;
  }
  if (id == ONI_STREAM_PROPERTY_MIRRORING) {
    OniBool mirror = TRUE;
    if (size != static_cast<int>(sizeof mirror)) return ONI_STATUS_BAD_PARAMETER;
    std::memcpy(&mirror, data, sizeof mirror);
    return mirror == FALSE ? ONI_STATUS_OK : ONI_STATUS_NOT_SUPPORTED;
  }
  return ONI_STATUS_NOT_SUPPORTED;
}

void Stream::notifyAllProperties() {
  for (const int id : kProperties) {
    for (const std::size_t wanted : {sizeof(OniVideoMode), sizeof(OniCropping), sizeof(int)}) {
      alignas(8) char value[64];
      int size = static_cast<int>(wanted);
      if (getProperty(id, value, &size) != ONI_STATUS_OK) continue;
      raisePropertyChanged(id, value, size);
      break;
    }
  }
}

}  // namespace
}  // namespace im2fit::openni2_virtual

using im2fit::openni2_virtual::Driver;
ONI_EXPORT_DRIVER(Driver)
