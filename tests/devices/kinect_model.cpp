// SPDX-License-Identifier: Apache-2.0
#include "tests/devices/kinect_model.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <utility>

namespace im2fit::devices {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::size_t kPixels = 640 * 480;
constexpr std::size_t kPacked = kPixels / 8 * 11;
constexpr std::size_t kPayload = 1760 - 12;
constexpr int kPackets = 242;  // 241 full ones and one of 1132 bytes
constexpr std::int64_t kMicroframe_us = 125;
constexpr std::int64_t kPatience_us = 50'000;

Bytes text_descriptor(const std::string& text) {
  Bytes bytes = {static_cast<std::uint8_t>(2 + 2 * text.size()), 3};
  for (const char c : text) {
    bytes.push_back(static_cast<std::uint8_t>(c));
    bytes.push_back(0);
  }
  return bytes;
}

Bytes device_descriptor_of(std::uint16_t product) {
  return {18,
          1,
          0x00,
          0x02,
          0,
          0,
          0,
          64,
          0x5E,
          0x04,
          static_cast<std::uint8_t>(product & 0xFF),
          static_cast<std::uint8_t>(product >> 8),
          0x0B,
          0x01,
          2,
          1,
          3,
          1};
}

void append(Bytes& to, std::initializer_list<int> bytes) {
  for (const int byte : bytes) to.push_back(static_cast<std::uint8_t>(byte));
}

void append_float(Bytes& to, float value) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, &value, 4);
  for (int i = 0; i < 4; ++i, bits /= 256) to.push_back(static_cast<std::uint8_t>(bits % 256));
}

int word(std::span<const std::uint8_t> bytes, std::size_t index) {
  return bytes[2 * index] + 256 * bytes[2 * index + 1];
}

// What every device does when its host sets it up.
bool is_housekeeping(const SetupPacket& setup) {
  const bool standard_out = setup.request_type <= 0x02;
  return standard_out && (setup.request == 1 || setup.request == 3 || setup.request == 9 || setup.request == 11);
}

// The bits of the picture in a row, each value's highest first.
void pack(const std::vector<std::uint16_t>& raw, Bytes& packed) {
  std::fill(packed.begin(), packed.end(), std::uint8_t{0});
  std::size_t bit = 0;
  for (const std::uint16_t value : raw) {
    // At its place in a window of 24 bits that begins with the byte the value begins in.
    const unsigned window = static_cast<unsigned>(value & 2047) << (24 - 11 - bit % 8);
    std::uint8_t* at = &packed[bit / 8];
    at[0] = static_cast<std::uint8_t>(at[0] | (window >> 16));
    if (const unsigned second = (window >> 8) & 255; second != 0) at[1] = static_cast<std::uint8_t>(at[1] | second);
    if (const unsigned third = window & 255; third != 0) at[2] = static_cast<std::uint8_t>(at[2] | third);
    bit += 11;
  }
}

}  // namespace

std::uint16_t mm_of_shift(const KinectSettings& s, std::uint16_t raw) {
  if (raw >= 2047) return 0;
  const double m = ((raw - 4.0 * s.constant_shift) / 4.0 - 0.375) * static_cast<double>(s.pixel_cm);
  const double emitter = static_cast<double>(s.emitter_cm), reference = static_cast<double>(s.reference_cm);
  const double z = 10.0 * (m * reference / (emitter - m) + reference);
  return z > 0 && z < 10'000.5 ? static_cast<std::uint16_t>(std::floor(z + 0.5)) : std::uint16_t{0};
}

std::uint16_t shift_of_mm(const KinectSettings& s, std::uint16_t mm) {
  if (mm == 0) return 2047;
  const double emitter = static_cast<double>(s.emitter_cm), reference = static_cast<double>(s.reference_cm);
  const double m = emitter - 10.0 * emitter * reference / mm;
  const double raw = 4.0 * (m / static_cast<double>(s.pixel_cm) + 0.375) + 4.0 * s.constant_shift;
  const int guess = static_cast<int>(std::clamp(raw, 0.0, 2046.0));
  int best = guess;
  for (int near = std::max(0, guess - 1); near <= std::min(2046, guess + 2); ++near) {
    const auto off = [&](int shift) {
      const int z = mm_of_shift(s, static_cast<std::uint16_t>(shift));
      return z == 0 ? 100'000 : std::abs(z - mm);
    };
    if (off(near) < off(best)) best = near;
  }
  return static_cast<std::uint16_t>(best);
}

KinectCameraModel::KinectCameraModel(const KinectSettings& settings, KinectPicture picture)
    : settings_(settings),
      picture_(std::move(picture)),
      rng_(settings.faults.seed),
      registers_{{0x105, 1}, {0x06, 0}, {0x12, 0}, {0x13, 0}, {0x14, 0}, {0x17, 1}},
      number_(settings.first_number),
      raw_(kPixels),
      packed_(kPacked) {}

Bytes KinectCameraModel::device_descriptor() const {
  return device_descriptor_of(settings_.for_windows ? 0x02BF : 0x02AE);
}

Bytes KinectCameraModel::configuration_descriptor() const {
  Bytes bytes = {9, 2, 0, 0, 1, 1, 0, 0xC0, 8};
  if (settings_.for_windows) append(bytes, {9, 4, 0, 0, 0, 0xFF, 0xFF, 0xFF, 0});
  append(bytes, {9, 4, 0, settings_.for_windows ? 1 : 0, 2, 0xFF, 0xFF, 0xFF, 0});
  for (const int endpoint : {0x81, 0x82}) append(bytes, {7, 5, endpoint, 1, 0xC0, 0x0B, 1});  // 2 x 960 bytes
  bytes[2] = static_cast<std::uint8_t>(bytes.size());
  return bytes;
}

Bytes KinectCameraModel::string_descriptor(std::uint8_t number) const {
  switch (number) {
    case 0:
      return {4, 3, 0x09, 0x04};
    case 1:
      return text_descriptor("Xbox NUI Camera");
    case 2:
      return text_descriptor("Microsoft");
    case 3:
      return text_descriptor(settings_.serial);
    default:
      return {};
  }
}

std::uint16_t KinectCameraModel::register_value(std::uint16_t which) const {
  const auto found = registers_.find(which);
  return found == registers_.end() ? std::uint16_t{0} : found->second;
}

bool KinectCameraModel::streaming() const {
  return register_value(0x06) == 2 && register_value(0x12) == 3 && register_value(0x13) == 1 &&
         register_value(0x14) == 30;
}

// 322 bytes (334 of the later camera), of which only the zero plane is known.
Bytes KinectCameraModel::fixed_parameters() const {
  Bytes bytes(94, 0xEE);
  bytes[0] = bytes[1] = 0;
  append_float(bytes, settings_.emitter_cm);
  append_float(bytes, 2.3F);
  append_float(bytes, settings_.reference_cm);
  append_float(bytes, settings_.pixel_cm);
  bytes.resize(settings_.for_windows ? 334 : 322, 0xEE);
  return bytes;
}

Bytes KinectCameraModel::answer(std::span<const std::uint8_t> command, std::int64_t now_us) {
  const int opcode = word(command, 2);
  const auto data = command.subspan(8);
  const auto& faults = settings_.faults;
  Bytes body = {0, 0};
  if (faults.refused_opcode == opcode) {
    body = {5, 0};
  } else if (opcode == 0x02 && data.size() >= 2) {
    const std::uint16_t value = register_value(static_cast<std::uint16_t>(word(data, 0)));
    append(body, {value % 256, value / 256});
  } else if (opcode == 0x03 && data.size() >= 4) {
    const auto which = static_cast<std::uint16_t>(word(data, 0));
    if (faults.refused_register == which) {
      body = {6, 0};
    } else {
      const bool before = streaming();
      registers_[which] = static_cast<std::uint16_t>(word(data, 1));
      if (!before && streaming()) begin_stream(now_us);
    }
  } else if (opcode == 0x04) {
    body = fixed_parameters();
  } else if (opcode == 0x16 && data.size() >= 10 && word(data, 0) == 0) {
    append(body, {settings_.constant_shift % 256, settings_.constant_shift / 256});
  } else {
    body = {2, 0};
  }
  Bytes bytes = {'R', 'B'};
  append(bytes, {static_cast<int>(body.size() / 2) % 256, static_cast<int>(body.size() / 2) / 256, command[4],
                 command[5], command[6], command[7]});
  bytes.insert(bytes.end(), body.begin(), body.end());
  return bytes;
}

std::optional<Bytes> KinectCameraModel::control(const SetupPacket& setup, std::span<const std::uint8_t> out,
                                                std::int64_t now_us) {
  if (is_housekeeping(setup)) return Bytes{};
  if (setup.request_type == 0x80 && setup.request == 0) return Bytes{1, 0};
  if (setup.request_type == 0x40 && setup.request == 0) {
    if (out.size() < 8 || out[0] != 0x47 || out[1] != 0x4D ||
        out.size() != 8 + 2 * static_cast<std::size_t>(word(out, 1)))
      return std::nullopt;
    ++commands_;
    if (settings_.faults.stalled_opcode == word(out, 2)) return std::nullopt;
    if (settings_.faults.stale_answers && !last_answer_.empty()) answers_.push_back(last_answer_);
    last_answer_ = answer(out, now_us);
    if (!settings_.faults.mute) answers_.push_back(last_answer_);
    polls_ = settings_.faults.polls_until_answer;
    return Bytes{};
  }
  if (setup.request_type == 0xC0 && setup.request == 0) {
    if (answers_.empty() || polls_-- > 0) return Bytes{};
    Bytes bytes = answers_.front();
    answers_.erase(answers_.begin());
    if (bytes.size() > setup.length) bytes.resize(setup.length);
    return bytes;
  }
  return std::nullopt;
}

bool KinectCameraModel::chance(int ppm) {
  return ppm > 0 && rng_.index(1'000'000) < ppm;
}

std::int64_t KinectCameraModel::frame_start_us(std::uint64_t number) const {
  return stream_start_us_ + static_cast<std::int64_t>(number) * 100'000 / 3;
}

void KinectCameraModel::begin_stream(std::int64_t now_us) {
  stream_start_us_ = now_us;
  frame_ = 0;
  packet_ = 0;
  frames_ended_ = 0;
  spoiled_.clear();
  unsent_.clear();
  again_.clear();
}

void KinectCameraModel::begin_frame() {
  picture_(frame_, raw_);
  pack(raw_, packed_);
}

void KinectCameraModel::step() {
  ++number_;
  if (++packet_ < kPackets) return;
  packet_ = 0;
  ++frame_;
  ++frames_ended_;
}

// What is not fetched in time is gone, the numbers of its packets with it.
void KinectCameraModel::catch_up(std::int64_t now_us) {
  while (now_us - (frame_start_us(frame_) + packet_ * kMicroframe_us) > kPatience_us) {
    (packet_ == 0 ? unsent_ : spoiled_).insert(frame_);
    number_ = static_cast<std::uint8_t>(number_ + kPackets - packet_);
    packet_ = 0;
    ++frame_;
    ++frames_ended_;
  }
}

Bytes KinectCameraModel::read_packet(std::uint8_t endpoint, std::size_t size_max, std::int64_t now_us) {
  if (endpoint != 0x82 || !streaming() || settings_.faults.silent) return {};
  if (!again_.empty()) return std::exchange(again_, {});
  catch_up(now_us);
  if (now_us < frame_start_us(frame_) + packet_ * kMicroframe_us) return {};
  if (packet_ == 0) begin_frame();

  const std::size_t from = static_cast<std::size_t>(packet_) * kPayload;
  const std::size_t size = std::min(kPayload, kPacked - from);
  const int flag = packet_ == 0 ? 0x71 : packet_ == kPackets - 1 ? 0x75 : 0x72;
  const auto ticks = static_cast<std::uint32_t>(settings_.first_ticks + frame_ * 2'000'000);  // 60 MHz / 30
  const std::uint32_t shown = packet_ == 0 && settings_.start_without_time ? 0 : ticks;
  Bytes bytes;
  bytes.reserve(12 + size);
  append(bytes,
         {'R', 'B', 0, flag, 0, number_, static_cast<int>((12 + size) / 256), static_cast<int>((12 + size) % 256),
          static_cast<int>(shown & 255), static_cast<int>((shown >> 8) & 255), static_cast<int>((shown >> 16) & 255),
          static_cast<int>(shown >> 24)});
  bytes.insert(bytes.end(), packed_.begin() + static_cast<std::ptrdiff_t>(from),
               packed_.begin() + static_cast<std::ptrdiff_t>(from + size));
  if (chance(settings_.faults.truncated_ppm)) {
    bytes.resize(static_cast<std::size_t>(rng_.index(static_cast<int>(bytes.size()))));
    spoiled_.insert(frame_);
  }
  if (chance(settings_.faults.lost_ppm) || bytes.size() > size_max) {
    bytes.clear();
    spoiled_.insert(frame_);
  }
  if (chance(settings_.faults.duplicated_ppm)) again_ = bytes;
  step();
  return bytes;
}

Bytes KinectMotorModel::device_descriptor() const {
  return device_descriptor_of(0x02B0);
}

Bytes KinectMotorModel::configuration_descriptor() const {
  return {9, 2, 18, 0, 1, 1, 0, 0xC0, 50, 9, 4, 0, 0, 0, 0xFF, 0, 0, 0};
}

Bytes KinectMotorModel::string_descriptor(std::uint8_t number) const {
  if (number == 0) return {4, 3, 0x09, 0x04};
  if (number == 1) return text_descriptor("Xbox NUI Motor");
  if (number == 2) return text_descriptor("Microsoft");
  return {};
}

std::optional<Bytes> KinectMotorModel::control(const SetupPacket& setup, std::span<const std::uint8_t>,
                                               std::int64_t now_us) {
  if (is_housekeeping(setup)) return Bytes{};
  if (setup.request_type == 0x80 && setup.request == 0) return Bytes{1, 0};
  if (stalls) return std::nullopt;
  if (setup.request_type == 0xC0 && setup.request == 0x10) return Bytes{0x22};
  if (setup.request_type == 0x40 && setup.request == 0x06) return Bytes{};
  if (setup.request_type == 0x40 && setup.request == 0x31) {
    const int target = setup.value < 0x8000 ? setup.value : setup.value - 0x10000;
    arrives_us_ = now_us + 50'000 * std::abs(target - target_half_deg_) / 2;  // 20 degrees a second
    target_half_deg_ = target;
    return Bytes{};
  }
  if (setup.request_type == 0xC0 && setup.request == 0x32) {
    const bool moving = now_us < arrives_us_;
    Bytes bytes = {0, 0};
    for (const int counts : acceleration_) {
      const int unsigned_counts = counts < 0 ? counts + 65536 : counts;
      append(bytes, {unsigned_counts / 256, unsigned_counts % 256});
    }
    const int tilt = moving ? -128 : target_half_deg_;
    append(bytes, {tilt < 0 ? tilt + 256 : tilt, moving ? 4 : std::abs(target_half_deg_) >= 62 ? 1 : 0});
    if (bytes.size() > setup.length) bytes.resize(setup.length);
    return bytes;
  }
  return std::nullopt;
}

}  // namespace im2fit::devices
