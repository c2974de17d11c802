// SPDX-License-Identifier: Apache-2.0
// A Kinect in software with its motor, opened as a real one is, and what each of its pixels must become.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hal/usb/kinect_open.h"
#include "hal/usb/usb_transport.h"
#include "tests/devices/kinect_model.h"
#include "tests/devices/usb_device.h"
#include "tests/hal/support.h"

namespace im2fit::hal {

// A USB bus in the process, with device models on it. Its time stands still but in run(). One device at one port.
// The mutex is the wire: one thing at a time.
struct ModelPort {
  std::mutex mutex;
  devices::UsbDevice* device = nullptr;  // null: unplugged
  int generation = 0;                    // an opened device stays gone when another is plugged in
  std::int64_t now_us = 0;
  std::int64_t until_us = 0;  // a rest of less than a microframe is kept from one run() to the next
  bool claimed = false;
  int interface_setting = 0;
  UsbPacketSink* sink = nullptr;
  std::uint8_t endpoint = 0;
  std::size_t packet_bytes = 0;
};

class ModelTransport final : public UsbTransport {
 public:
  explicit ModelTransport(std::shared_ptr<ModelPort> port) : port_(std::move(port)), generation_(port_->generation) {
    port_->claimed = true;
  }
  ~ModelTransport() override {
    stop_stream();
    const std::lock_guard lock(port_->mutex);
    if (here()) port_->claimed = false;
  }

  Result<std::size_t> control_in(const UsbRequest& request, std::span<std::uint8_t> data, int) override {
    const std::lock_guard lock(port_->mutex);
    if (!here()) return gone();
    const auto answer = port_->device->control(setup(request, data.size()), {}, port_->now_us);
    if (!answer) return stalled();
    std::copy(answer->begin(), answer->end(), data.begin());
    return answer->size();
  }

  Status control_out(const UsbRequest& request, std::span<const std::uint8_t> data, int) override {
    const std::lock_guard lock(port_->mutex);
    if (!here()) return gone();
    if (!port_->device->control(setup(request, data.size()), data, port_->now_us)) return stalled();
    return Ok{};
  }

  Status start_stream(const UsbStreamSettings& settings, UsbPacketSink& sink) override {
    const std::lock_guard lock(port_->mutex);
    if (!here()) return gone();
    const auto bytes = port_->device->configuration_descriptor();
    int setting = -1;
    for (std::size_t i = 0; i + 1 < bytes.size() && bytes[i] > 0; i += bytes[i]) {
      if (bytes[i + 1] == 4) setting = bytes[i + 3];
      if (bytes[i + 1] != 5 || bytes[i + 2] != settings.endpoint || bytes[i + 3] != 1) continue;
      const int size = bytes[i + 4] + 256 * (bytes[i + 5] % 8), times = 1 + bytes[i + 5] / 8 % 4;
      if (size * times < settings.packet_bytes_min) continue;
      port_->endpoint = settings.endpoint;
      port_->packet_bytes = static_cast<std::size_t>(size * times);
      port_->interface_setting = setting;
      port_->sink = &sink;
      return Ok{};
    }
    return Error{ErrorCode::unsupported, "no such endpoint"};
  }

  void stop_stream() override {
    const std::lock_guard lock(port_->mutex);
    if (port_->generation == generation_) port_->sink = nullptr;
  }

 private:
  bool here() const { return port_->device != nullptr && port_->generation == generation_; }
  static Error gone() { return {ErrorCode::no_device, "it was pulled out"}; }
  static Error stalled() { return {ErrorCode::unsupported, "it stalls"}; }
  static devices::SetupPacket setup(const UsbRequest& r, std::size_t length) {
    return {r.type, r.request, r.value, r.index, static_cast<std::uint16_t>(length)};
  }

  std::shared_ptr<ModelPort> port_;
  int generation_;
};

class ModelBus final : public UsbBus {
 public:
  void plug(const std::string& name, devices::UsbDevice& device) {
    auto& port = ports_[name];
    if (!port) port = std::make_shared<ModelPort>();
    const std::lock_guard lock(port->mutex);
    port->device = &device;
    port->claimed = false;
    ++port->generation;
  }

  void unplug(const std::string& name) {
    ModelPort& port = *ports_.at(name);
    const std::lock_guard lock(port.mutex);
    port.device = nullptr;
    if (port.sink != nullptr) port.sink->ended({ErrorCode::no_device, "it was pulled out"});
    port.sink = nullptr;
  }

  // Microframe by microframe, a packet each.
  void run(const std::string& name, std::int64_t us) {
    ModelPort& port = *ports_.at(name);
    for (port.until_us += us; port.now_us + 125 <= port.until_us;) {
      const std::lock_guard lock(port.mutex);
      port.now_us += 125;
      if (port.device == nullptr || port.sink == nullptr) continue;
      const auto packet = port.device->read_packet(port.endpoint, port.packet_bytes, port.now_us);
      if (!packet.empty()) port.sink->packet(packet);
    }
  }

  // The host is busy elsewhere: time goes by and no packets are fetched.
  void idle(const std::string& name, std::int64_t us) {
    ports_.at(name)->now_us += us;
    ports_.at(name)->until_us += us;
  }
  const ModelPort& port(const std::string& name) const { return *ports_.at(name); }

  Result<std::vector<UsbDeviceEntry>> list(std::uint16_t vendor) override {
    std::vector<UsbDeviceEntry> entries;
    for (const auto& [name, port] : ports_) {
      if (port->device == nullptr) continue;
      const auto d = port->device->device_descriptor();
      const auto text = d.at(16) == 0 ? std::vector<std::uint8_t>{} : port->device->string_descriptor(d.at(16));
      UsbDeviceEntry entry{word(d, 8), word(d, 10), name, ""};
      for (std::size_t i = 2; i < text.size(); i += 2) entry.serial += static_cast<char>(text[i]);
      if (entry.vendor == vendor) entries.push_back(entry);
    }
    return entries;
  }

  Result<std::unique_ptr<UsbTransport>> open(const UsbDeviceEntry& device) override {
    const auto found = ports_.find(device.port);
    if (found == ports_.end() || found->second->device == nullptr)
      return Error{ErrorCode::no_device, "it is no longer there"};
    if (found->second->claimed) return Error{ErrorCode::io, "another program has it"};
    return std::unique_ptr<UsbTransport>(new ModelTransport(found->second));
  }

 private:
  static std::uint16_t word(const std::vector<std::uint8_t>& d, std::size_t i) {
    return static_cast<std::uint16_t>(d.at(i) + 256 * d.at(i + 1));
  }
  std::map<std::string, std::shared_ptr<ModelPort>> ports_;
};

using devices::KinectCameraModel;
using devices::KinectMotorModel;
using devices::KinectSettings;

constexpr int kWidth = 640;  // other rigs have others
constexpr int kHeight = 480;
inline constexpr std::int64_t kFrame_us = 33'500;  // a little more than one

// Any value at any place, another in each frame.
inline std::uint16_t raw_at(std::uint64_t number, std::size_t i) {
  const std::uint64_t z = (number * 307'201 + i + 1) * 0x9E3779B97F4A7C15ULL;
  return static_cast<std::uint16_t>((z >> 40) % 2048);
}
inline void picture(std::uint64_t number, std::span<std::uint16_t> raw) {
  for (std::size_t i = 0; i < raw.size(); ++i) raw[i] = raw_at(number, i);
}

// What the camera means, in millimetres.
inline std::vector<std::uint16_t> millimetres(const KinectSettings& settings) {
  std::vector<std::uint16_t> table(2048);
  for (int raw = 0; raw < 2048; ++raw)
    table[static_cast<std::size_t>(raw)] = devices::mm_of_shift(settings, static_cast<std::uint16_t>(raw));
  return table;
}

struct Rig {
  explicit Rig(const KinectSettings& s = {}, bool with_motor = true)
      : settings(s), camera(s, picture), table(millimetres(s)), out(kWidth, kHeight) {
    bus.plug("1-1.1", camera);
    if (with_motor) bus.plug("1-1.2", motor);
  }
  Status open(const KinectOptions& options = {}, const std::string& id = "") {
    source.reset();
    auto opened = open_kinect(bus, id, options);
    if (!opened) return opened.error();
    source = std::move(*opened);
    return Ok{};
  }
  void run(std::int64_t us) { bus.run("1-1.1", us); }
  // Whether `out` is frame `number` of the model to the last pixel.
  bool is_frame(std::uint64_t number) const {
    for (std::size_t i = 0; i < out.pixels.size(); ++i)
      if (out.pixels[i] != table[raw_at(number, i)]) return false;
    return true;
  }

  KinectSettings settings;
  KinectCameraModel camera;
  KinectMotorModel motor;
  ModelBus bus;
  std::vector<std::uint16_t> table;
  std::unique_ptr<KinectSource> source;
  Picture out;
};

inline void expect_ok(const Status& status) {
  EXPECT_TRUE(status) << status.error().message;
}

inline void expect_direction(const std::optional<Vec3f>& got, float x, float y, float z) {
  ASSERT_TRUE(got);
  EXPECT_NEAR(got->x, x, 0.002);
  EXPECT_NEAR(got->y, y, 0.002);
  EXPECT_NEAR(got->z, z, 0.002);
}

}  // namespace im2fit::hal
