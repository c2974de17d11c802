// SPDX-License-Identifier: Apache-2.0
#include "tests/devices/uvc_model.h"

#include <algorithm>
#include <cstring>
#include <initializer_list>

namespace im2fit::devices {
namespace {

using Bytes = std::vector<std::uint8_t>;

// USB 2.0 table 9-4 and UVC 1.0 table A-8.
constexpr std::uint8_t kClearFeature = 0x01;
constexpr std::uint8_t kSetConfiguration = 0x09;
constexpr std::uint8_t kSetInterface = 0x0B;
constexpr std::uint8_t kSetCur = 0x01;
constexpr std::uint8_t kGetLen = 0x85;
constexpr std::uint8_t kGetInfo = 0x86;
constexpr std::uint8_t kProbe = 1;
constexpr std::uint8_t kCommit = 2;
constexpr std::uint8_t kStreamingInterface = 1;

// UVC 1.0 2.4.3.3: the flags of a payload's header.
constexpr std::uint8_t kFrameToggle = 0x01;
constexpr std::uint8_t kEndOfFrame = 0x02;
constexpr std::uint8_t kError = 0x40;
constexpr std::uint8_t kEndOfHeader = 0x80;

void put(Bytes& bytes, std::initializer_list<int> values) {
  for (const int value : values) bytes.push_back(static_cast<std::uint8_t>(value));
}
void put16(Bytes& bytes, int value) {
  put(bytes, {value & 0xFF, value >> 8 & 0xFF});
}
void put32(Bytes& bytes, std::uint32_t value) {
  for (int shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<std::uint8_t>(value >> shift & 0xFF));
}

}  // namespace

UvcModel::UvcModel(const UvcSettings& settings, std::vector<std::vector<std::uint16_t>> frames)
    : settings_(settings), frames_(std::move(frames)), rng_(settings.seed) {}

Bytes UvcModel::device_descriptor() const {
  // A miscellaneous device with interface associations, as UVC requires; Intel's number, a product that does not
  // exist.
  Bytes d;
  put(d, {18, 1, 0x00, 0x02, 0xEF, 2, 1, 64, 0x86, 0x80, 0x01, 0x0A, 0x00, 0x01, 2, 1, 3, 1});
  return d;
}

Bytes UvcModel::configuration_descriptor() const {
  const int endpoint_size = settings_.isochronous ? 0x1400 : 512;  // 1,024 bytes, two more a microframe
  Bytes d;
  put(d, {9, 2, 0, 0, 2, 1, 0, 0x80, 50});
  put(d, {8, 0x0B, 0, 2, 0x0E, 3, 0, 0});                                           // association of both interfaces
  put(d, {9, 4, 0, 0, 0, 0x0E, 1, 0, 0});                                           // video control
  put(d, {13, 0x24, 1, 0x00, 0x01, 13 + 18 + 9, 0, 0x00, 0x6C, 0xDC, 0x02, 1, 1});  // its header
  put(d, {18, 0x24, 2, 1, 0x01, 0x02, 0, 0, 0, 0, 0, 0, 0, 0, 3, 0, 0, 0});         // camera terminal
  put(d, {9, 0x24, 3, 2, 0x01, 0x01, 0, 1, 0});                                     // output terminal
  put(d, {9, 4, 1, 0, settings_.isochronous ? 0 : 1, 0x0E, 2, 0, 0});               // video streaming
  put(d, {14, 0x24, 1, 1, 14 + 27 + 30, 0, kEndpoint, 0, 2, 0, 0, 0, 1, 0});        // its header
  // Uncompressed, with the GUID of depth: 5A313620-..., which begins with "Z16 ".
  put(d, {27, 0x24, 4, 1, 1, 'Z', '1', '6', ' ', 0, 0, 0x10, 0, 0x80, 0, 0, 0xAA, 0, 0x38, 0x9B, 0x71});
  put(d, {16, 1, 0, 0, 0, 0});
  put(d, {30, 0x24, 5, 1, 0});
  put16(d, settings_.width);
  put16(d, settings_.height);
  const auto bits_per_s = static_cast<std::uint32_t>(frame_bytes() * 8 * static_cast<std::size_t>(settings_.fps));
  put32(d, bits_per_s);
  put32(d, bits_per_s);
  put32(d, static_cast<std::uint32_t>(frame_bytes()));
  put32(d, static_cast<std::uint32_t>(10'000'000 / settings_.fps));
  put(d, {1});
  put32(d, static_cast<std::uint32_t>(10'000'000 / settings_.fps));
  if (settings_.isochronous) put(d, {9, 4, 1, 1, 1, 0x0E, 2, 0, 0});
  put(d, {7, 5, kEndpoint, settings_.isochronous ? 5 : 2, endpoint_size & 0xFF, endpoint_size >> 8,
          settings_.isochronous ? 1 : 0});
  d[2] = static_cast<std::uint8_t>(d.size() & 0xFF);
  d[3] = static_cast<std::uint8_t>(d.size() >> 8);
  return d;
}

Bytes UvcModel::string_descriptor(std::uint8_t number) const {
  if (number == 0) return {4, 3, 0x09, 0x04};
  const std::string texts[] = {"im2fit depth model", "im2fit tests", settings_.serial};
  if (number > std::size(texts)) return {};
  const std::string& text = texts[number - 1];
  Bytes d{static_cast<std::uint8_t>(2 + 2 * text.size()), 3};
  for (const char c : text) put(d, {c, 0});
  return d;
}

// UVC 1.0 table 4-47, the 26 bytes of the first version.
Bytes UvcModel::probe_block() const {
  Bytes block;
  put(block, {1, 0, 1, 1});
  put32(block, static_cast<std::uint32_t>(10'000'000 / settings_.fps));
  block.resize(18);
  put32(block, static_cast<std::uint32_t>(frame_bytes()));
  put32(block, settings_.isochronous ? kIsoPayload : kBulkPayload);
  return block;
}

std::optional<Bytes> UvcModel::streaming_control(const SetupPacket& setup) {
  const int selector = setup.value >> 8;
  if ((setup.index & 0xFF) != kStreamingInterface || (selector != kProbe && selector != kCommit)) return std::nullopt;
  if (setup.request == kSetCur) {
    // There is one mode only: whatever is proposed, the answer is that one. A bulk stream begins here.
    if (selector == kCommit && !settings_.isochronous) restart();
    return Bytes{};
  }
  if (setup.request == kGetLen) return Bytes{26, 0};
  if (setup.request == kGetInfo) return Bytes{3};
  return probe_block();
}

void UvcModel::restart() {
  streaming_ = true;
  begun_ = false;
  index_ = 0;
  sent_ = 0;
  ++counts_.starts;
}

std::optional<Bytes> UvcModel::control(const SetupPacket& setup, std::span<const std::uint8_t>, std::int64_t) {
  switch (setup.request_type) {
    case 0x00:
      if (setup.request != kSetConfiguration) return std::nullopt;
      streaming_ = false;
      return Bytes{};
    case 0x01:
      if (setup.request != kSetInterface) return std::nullopt;
      if (settings_.isochronous && setup.index == kStreamingInterface) {
        if (setup.value == 1)
          restart();
        else
          streaming_ = false;
      }
      return Bytes{};
    case 0x02:
      // How uvcvideo ends a bulk stream.
      if (setup.request != kClearFeature) return std::nullopt;
      streaming_ = false;
      return Bytes{};
    case 0x21:
    case 0xA1:
      return streaming_control(setup);
    default:
      return std::nullopt;
  }
}

Bytes UvcModel::read_packet(std::uint8_t endpoint, std::size_t size_max, std::int64_t now_us) {
  if (endpoint != kEndpoint || !streaming_ || size_max <= kHeader) return {};
  if (!begun_) {
    begun_ = true;
    due_us_ = now_us;
  }
  const auto flags = static_cast<std::uint8_t>(kEndOfHeader | (index_ % 2 == 1 ? kFrameToggle : 0));
  if (sent_ == 0) {
    if (now_us < due_us_) return settings_.isochronous ? Bytes{kHeader, flags} : Bytes{};
    // Late by more than a frame: the clock starts over instead of running after the time.
    due_us_ = std::max(due_us_ + period_us(), now_us);
  }
  const std::size_t payload_max = settings_.isochronous ? kIsoPayload : kBulkPayload;
  const std::size_t count = std::min({size_max, payload_max, frame_bytes() - sent_ + kHeader}) - kHeader;
  Bytes packet(kHeader + count);
  packet[0] = kHeader;
  packet[1] = flags;
  const auto& frame = frames_[static_cast<std::size_t>(index_ % frames_.size())];
  std::memcpy(packet.data() + kHeader, reinterpret_cast<const std::uint8_t*>(frame.data()) + sent_, count);
  sent_ += count;
  if (sent_ == frame_bytes()) {
    packet[1] |= kEndOfFrame;
    ++counts_.frames;
    ++index_;
    sent_ = 0;
  }
  if (hit(settings_.damage_ppm)) {
    ++counts_.damaged;
    packet[1] |= kError;
    std::fill(packet.begin() + kHeader, packet.end(), std::uint8_t{0xA5});
  }
  if (hit(settings_.loss_ppm)) {
    ++counts_.lost;
    // Of a bulk pipe nothing is lost without the host noticing; a camera that overruns sends a payload without data.
    if (!settings_.isochronous) return {kHeader, flags};
    return {};
  }
  return packet;
}

}  // namespace im2fit::devices
