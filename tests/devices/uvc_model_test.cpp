// SPDX-License-Identifier: Apache-2.0
// The model against the specification: a host's reads from it, put together by the rules of UVC 1.0 alone.
#include "tests/devices/uvc_model.h"

#include <gmock/gmock.h>

namespace im2fit::devices {
namespace {

std::vector<std::vector<std::uint16_t>> pictures(int count, int width, int height) {
  std::vector<std::vector<std::uint16_t>> frames;
  Rng rng(7);
  for (int i = 0; i < count; ++i) {
    frames.emplace_back();
    for (int p = 0; p < width * height; ++p) frames.back().push_back(static_cast<std::uint16_t>(rng.index(65536)));
  }
  return frames;
}

UvcSettings small(bool isochronous) {
  UvcSettings settings;
  settings.width = 160;
  settings.height = 120;
  settings.isochronous = isochronous;
  return settings;
}

void start(UvcModel& model, bool isochronous) {
  std::vector<std::uint8_t> block(26);
  ASSERT_TRUE(model.control({0x21, 1, 2 << 8, 1, 26}, block, 0));
  if (isochronous) {
    ASSERT_TRUE(model.control({0x01, 11, 1, 1, 0}, {}, 0));
  }
}

// UVC 1.0 2.4: a frame ends with the end-of-frame bit or where the toggle changes; an error bit spoils it.
struct Received {
  std::vector<std::uint8_t> bytes;
  bool spoilt = false;
  std::int64_t begun_us = 0;
};
std::vector<Received> receive(UvcModel& model, std::int64_t from_us, std::int64_t to_us, std::size_t packet_size) {
  std::vector<Received> frames;
  int toggle = -1;
  bool open = false;
  for (std::int64_t now_us = from_us; now_us < to_us; now_us += 125) {
    const auto packet = model.read_packet(0x81, packet_size, now_us);
    if (packet.empty()) continue;
    EXPECT_EQ(packet[0], 2);
    EXPECT_LE(packet.size(), packet_size);
    if (packet.size() == 2) continue;
    if (!open || (packet[1] & 1) != toggle) frames.push_back({{}, false, now_us});
    toggle = packet[1] & 1;
    open = (packet[1] & 2) == 0;
    frames.back().bytes.insert(frames.back().bytes.end(), packet.begin() + 2, packet.end());
    frames.back().spoilt |= (packet[1] & 0x40) != 0;
  }
  return frames;
}

std::vector<std::uint8_t> little_endian(const std::vector<std::uint16_t>& values) {
  std::vector<std::uint8_t> bytes;
  for (const std::uint16_t value : values) {
    bytes.push_back(static_cast<std::uint8_t>(value & 0xFF));
    bytes.push_back(static_cast<std::uint8_t>(value >> 8));
  }
  return bytes;
}

TEST(UvcModel, DescriptorsTileAndSayDepth) {
  for (const bool isochronous : {false, true}) {
    const UvcModel model(small(isochronous), pictures(1, 160, 120));
    EXPECT_EQ(model.device_descriptor().size(), 18U);
    const auto bytes = model.configuration_descriptor();
    ASSERT_EQ(bytes[2] | bytes[3] << 8, static_cast<int>(bytes.size()));
    std::size_t at = 0;
    int formats = 0;
    int control_bytes = -1;
    int streaming_bytes = -1;
    std::size_t control_from = 0;
    std::size_t streaming_from = 0;
    int interface = -1;
    std::size_t control_past = 0;
    std::size_t streaming_past = 0;
    while (at < bytes.size()) {
      ASSERT_GE(bytes[at], 2);
      ASSERT_LE(at + bytes[at], bytes.size());
      if (bytes[at + 1] == 4) interface = bytes[at + 2];
      if (bytes[at + 1] == 0x24) {
        if (interface == 0 && bytes[at + 2] == 1)
          control_from = at, control_bytes = bytes[at + 5] | bytes[at + 6] << 8;
        if (interface == 1 && bytes[at + 2] == 1)
          streaming_from = at, streaming_bytes = bytes[at + 4] | bytes[at + 5] << 8;
        (interface == 0 ? control_past : streaming_past) = at + bytes[at];
        if (interface == 1 && bytes[at + 2] == 4) {
          ++formats;
          // 5A313620-0000-1000-8000-00AA00389B71 as it goes over the wire.
          const std::vector<std::uint8_t> guid(bytes.begin() + static_cast<long>(at) + 5,
                                               bytes.begin() + static_cast<long>(at) + 21);
          EXPECT_THAT(guid, testing::ElementsAre(0x5A, 0x31, 0x36, 0x20, 0, 0, 0x10, 0, 0x80, 0, 0, 0xAA, 0, 0x38,
                                                 0x9B, 0x71));
        }
      }
      at += bytes[at];
    }
    EXPECT_EQ(at, bytes.size());
    EXPECT_EQ(formats, 1);
    EXPECT_EQ(control_bytes, static_cast<int>(control_past - control_from));
    EXPECT_EQ(streaming_bytes, static_cast<int>(streaming_past - streaming_from));
  }
}

TEST(UvcModel, AnswersProbeAndStallsWhatItHasNot) {
  UvcModel model(small(false), pictures(1, 160, 120));
  const auto block = model.control({0xA1, 0x81, 1 << 8, 1, 26}, {}, 0);
  ASSERT_TRUE(block);
  ASSERT_EQ(block->size(), 26U);
  EXPECT_EQ((*block)[18] | (*block)[19] << 8 | (*block)[20] << 16, 160 * 120 * 2);
  EXPECT_EQ((*block)[4] | (*block)[5] << 8 | (*block)[6] << 16, 333333);
  EXPECT_FALSE(model.control({0xA1, 0x81, 5 << 8, 1, 26}, {}, 0));
  EXPECT_FALSE(model.control({0xA1, 0x81, 1 << 8, 0, 26}, {}, 0));
  EXPECT_FALSE(model.control({0xC0, 1, 0, 0, 4}, {}, 0));
  EXPECT_TRUE(model.read_packet(0x81, 16384, 0).empty()) << "not before the stream is committed";
}

TEST(UvcModel, EveryFrameArrivesWholeInOrderAndOnTime) {
  for (const bool isochronous : {false, true}) {
    const auto frames = pictures(3, 160, 120);
    UvcModel model(small(isochronous), frames);
    start(model, isochronous);
    const auto received = receive(model, 1'000'000, 2'000'000, isochronous ? 3072 : 16384);
    ASSERT_EQ(received.size(), 30U) << "the first at once, the 31st with the second second";
    for (std::size_t i = 0; i + 1 < received.size(); ++i) {
      EXPECT_EQ(received[i].bytes, little_endian(frames[i % 3])) << i;
      EXPECT_NEAR(static_cast<double>(received[i].begun_us), 1e6 + 33333.0 * static_cast<double>(i), 126.0);
    }
    start(model, isochronous);
    const auto again = receive(model, 5'000'000, 5'050'000, isochronous ? 3072 : 16384);
    ASSERT_GE(again.size(), 1U);
    EXPECT_EQ(again[0].bytes, little_endian(frames[0])) << "a new start begins with the first frame";
  }
}

TEST(UvcModel, LossAndDamageSpoilFramesAndAreCounted) {
  auto settings = small(true);
  settings.loss_ppm = 20'000;
  settings.damage_ppm = 20'000;
  const auto frames = pictures(2, 160, 120);
  UvcModel model(settings, frames);
  start(model, true);
  const auto received = receive(model, 0, 3'000'000, 3072);
  EXPECT_GT(model.counts().lost, 5U);
  EXPECT_GT(model.counts().damaged, 5U);
  std::size_t whole = 0;
  for (const auto& frame : received) {
    if (frame.spoilt || frame.bytes.size() != 160 * 120 * 2) continue;
    ++whole;
    EXPECT_TRUE(frame.bytes == little_endian(frames[0]) || frame.bytes == little_endian(frames[1]));
  }
  EXPECT_GT(whole, 10U);
  EXPECT_LT(whole, received.size());
}

}  // namespace
}  // namespace im2fit::devices
