// SPDX-License-Identifier: Apache-2.0
// A Kinect for Xbox 360 in software: camera and motor, as two USB devices. Written from the OpenKinect project's
// public description of the wire. It shares no code with the reader under test: an error made twice must be made in
// two ways.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "core/rng.h"
#include "tests/devices/usb_device.h"

namespace im2fit::devices {

// What goes wrong, and how often: millionths of the packets sent.
struct KinectFaults {
  int lost_ppm = 0;
  int duplicated_ppm = 0;
  int truncated_ppm = 0;
  std::uint64_t seed = 1;
  std::optional<std::uint16_t> stalled_opcode;    // the control transfer stalls
  std::optional<std::uint16_t> refused_opcode;    // answered with an error code
  std::optional<std::uint16_t> refused_register;  // so are writes to this register
  int polls_until_answer = 0;                     // fetches that find nothing before the answer is there
  bool mute = false;                              // commands are never answered
  bool silent = false;                            // nothing comes down the stream
  bool stale_answers = false;                     // before each answer comes the one before
};

struct KinectSettings {
  std::string serial = "A00364A13385040A";
  bool for_windows = false;  // product 02bf, endpoints in alternate setting 1, longer fixed parameters
  float emitter_cm = 7.5F;
  float reference_cm = 120.0F;
  float pixel_cm = 0.1042F;
  std::uint16_t constant_shift = 200;
  std::uint32_t first_ticks = 0;   // 60 MHz clock at the first frame
  std::uint8_t first_number = 0;   // of the first packet
  bool start_without_time = true;  // the first packet of a frame says time 0, as some do
  KinectFaults faults;
};

// Writes raw shifts (0 to 2047, 2047 no data), 640 x 480 row by row, of frame `number`, counted from 0 at each start
// of the stream.
using KinectPicture = std::function<void(std::uint64_t number, std::span<std::uint16_t> raw)>;

// The distance of a raw shift for this camera, by the published formula, in millimetres to the nearest one; 0: none,
// or beyond 10 m. And the shift whose distance is nearest to `mm`; 2047 for 0. For pictures made from distances, and
// for the expected results.
std::uint16_t mm_of_shift(const KinectSettings& settings, std::uint16_t raw);
std::uint16_t shift_of_mm(const KinectSettings& settings, std::uint16_t mm);

class KinectCameraModel final : public UsbDevice {
 public:
  KinectCameraModel(const KinectSettings& settings, KinectPicture picture);

  std::vector<std::uint8_t> device_descriptor() const override;
  std::vector<std::uint8_t> configuration_descriptor() const override;
  std::vector<std::uint8_t> string_descriptor(std::uint8_t number) const override;
  std::optional<std::vector<std::uint8_t>> control(const SetupPacket& setup, std::span<const std::uint8_t> out,
                                                   std::int64_t now_us) override;
  // A packet in each microframe of 125 us while a frame lasts (242 of them), frames 1/30 s apart. What is not fetched
  // within 50 ms is lost with the rest of its frame, as in a camera.
  std::vector<std::uint8_t> read_packet(std::uint8_t endpoint, std::size_t size_max, std::int64_t now_us) override;

  KinectFaults& faults() { return settings_.faults; }
  bool streaming() const;  // all registers are as they must be for packed 11-bit depth
  // Since the stream's start: frames whose last packet's turn is over; those of them with a packet lost or cut; those
  // nothing was fetched of.
  std::uint64_t frames_ended() const { return frames_ended_; }
  const std::set<std::uint64_t>& spoiled() const { return spoiled_; }
  const std::set<std::uint64_t>& unsent() const { return unsent_; }
  std::uint16_t register_value(std::uint16_t which) const;
  std::uint64_t commands() const { return commands_; }

 private:
  std::vector<std::uint8_t> answer(std::span<const std::uint8_t> command, std::int64_t now_us);
  std::vector<std::uint8_t> fixed_parameters() const;
  void begin_stream(std::int64_t now_us);
  void begin_frame();
  std::int64_t frame_start_us(std::uint64_t number) const;
  void step();
  void catch_up(std::int64_t now_us);
  bool chance(int ppm);

  KinectSettings settings_;
  KinectPicture picture_;
  Rng rng_;
  std::map<std::uint16_t, std::uint16_t> registers_;
  std::vector<std::vector<std::uint8_t>> answers_;  // oldest first
  std::vector<std::uint8_t> last_answer_;
  int polls_ = 0;
  std::uint64_t commands_ = 0;

  std::int64_t stream_start_us_ = 0;
  std::uint64_t frame_ = 0;
  int packet_ = 0;  // next of the frame
  std::uint8_t number_ = 0;
  std::vector<std::uint16_t> raw_;
  std::vector<std::uint8_t> packed_;
  std::vector<std::uint8_t> again_;  // a packet to be sent a second time
  std::uint64_t frames_ended_ = 0;
  std::set<std::uint64_t> spoiled_;
  std::set<std::uint64_t> unsent_;
};

class KinectMotorModel final : public UsbDevice {
 public:
  std::vector<std::uint8_t> device_descriptor() const override;
  std::vector<std::uint8_t> configuration_descriptor() const override;
  std::vector<std::uint8_t> string_descriptor(std::uint8_t number) const override;
  std::optional<std::vector<std::uint8_t>> control(const SetupPacket& setup, std::span<const std::uint8_t> out,
                                                   std::int64_t now_us) override;
  std::vector<std::uint8_t> read_packet(std::uint8_t, std::size_t, std::int64_t) override { return {}; }

  // What the accelerometer shows, 819 counts to a g; at rest and level 0, 819, 0 (x left, y up, z forward).
  void set_acceleration(int x, int y, int z) { acceleration_[0] = x, acceleration_[1] = y, acceleration_[2] = z; }
  int target_half_deg() const { return target_half_deg_; }
  bool stalls = false;

 private:
  int acceleration_[3] = {0, 819, 0};
  int target_half_deg_ = 0;
  std::int64_t arrives_us_ = 0;
};

}  // namespace im2fit::devices
