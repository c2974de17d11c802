// SPDX-License-Identifier: Apache-2.0
// A USB Video Class 1.0 depth camera: one Z16 format, one size, bulk or isochronous. From the class's public
// specification and the requests of the kernel's uvcvideo.
#pragma once

#include <string>

#include "core/rng.h"
#include "tests/devices/usb_device.h"

namespace im2fit::devices {

struct UvcSettings {
  int width = 640;
  int height = 480;
  int fps = 30;
  bool isochronous = false;
  std::string serial = "Z16-0001";
  // Of payloads, parts in a million: lost in transit, or marked by the camera as damaged (and then filled with
  // nonsense).
  int loss_ppm = 0;
  int damage_ppm = 0;
  std::uint64_t seed = 1;
};

// Plays its frames round and round from the first one, anew with every start of the stream, and never faster than
// `fps`. A host that reads late gets every frame late; none is left out.
class UvcModel final : public UsbDevice {
 public:
  static constexpr std::uint8_t kEndpoint = 0x81;
  static constexpr int kBulkPayload = 16384;
  static constexpr int kIsoPayload = 3072;  // three packets of 1,024 bytes in a microframe
  static constexpr int kHeader = 2;         // length and flags: no clocks of the camera's own

  // `frames`: at least one, each of width * height depths.
  UvcModel(const UvcSettings& settings, std::vector<std::vector<std::uint16_t>> frames);

  std::vector<std::uint8_t> device_descriptor() const override;
  std::vector<std::uint8_t> configuration_descriptor() const override;
  std::vector<std::uint8_t> string_descriptor(std::uint8_t number) const override;
  std::optional<std::vector<std::uint8_t>> control(const SetupPacket& setup, std::span<const std::uint8_t> out,
                                                   std::int64_t now_us) override;
  // One payload a call: of a bulk endpoint the whole transfer that carries it.
  std::vector<std::uint8_t> read_packet(std::uint8_t endpoint, std::size_t size_max, std::int64_t now_us) override;

  struct Counts {
    std::uint64_t starts = 0;
    std::uint64_t frames = 0;   // sent to the last byte
    std::uint64_t lost = 0;     // payloads
    std::uint64_t damaged = 0;  // payloads
  };
  const Counts& counts() const { return counts_; }

 private:
  std::vector<std::uint8_t> probe_block() const;
  std::optional<std::vector<std::uint8_t>> streaming_control(const SetupPacket& setup);
  void restart();
  bool hit(int ppm) { return ppm > 0 && rng_.index(1'000'000) < ppm; }
  std::size_t frame_bytes() const { return frames_.front().size() * 2; }
  std::int64_t period_us() const { return 1'000'000 / settings_.fps; }

  UvcSettings settings_;
  std::vector<std::vector<std::uint16_t>> frames_;
  Rng rng_;
  Counts counts_;
  bool streaming_ = false;
  bool begun_ = false;       // the clock of the stream runs from the first packet requested
  std::uint64_t index_ = 0;  // of the frame being sent
  std::size_t sent_ = 0;     // its bytes
  std::int64_t due_us_ = 0;  // when it may begin
};

}  // namespace im2fit::devices
