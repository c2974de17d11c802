// SPDX-License-Identifier: Apache-2.0
// The host against the protocol's description (Documentation/usb/usbip_protocol.rst), with this test as the kernel.
#include "tests/devices/usbip_host.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <thread>

namespace im2fit::devices {
namespace {

// Bulk endpoint 0x81 never has anything; isochronous endpoint 0x82 (interval 4 ms, so that requests stay a while)
// sends packets of 1, 2, 3, ... bytes, each its own length.
class CountingDevice final : public UsbDevice {
 public:
  std::vector<std::uint8_t> device_descriptor() const override { return {18, 1, 0, 2}; }
  std::vector<std::uint8_t> configuration_descriptor() const override {
    return {9, 2, 32, 0, 1,    1, 0, 0x80, 50, 9, 4, 0,    0, 2,  0xFF, 0,
            0, 0, 7,  5, 0x81, 2, 0, 2,    0,  7, 5, 0x82, 1, 64, 0,    6};
  }
  std::vector<std::uint8_t> string_descriptor(std::uint8_t) const override { return {}; }
  std::optional<std::vector<std::uint8_t>> control(const SetupPacket& setup, std::span<const std::uint8_t> out,
                                                   std::int64_t) override {
    if (setup.request == 0x77) return std::nullopt;
    received.assign(out.begin(), out.end());
    return std::vector<std::uint8_t>{9, 8, 7, 6};
  }
  std::vector<std::uint8_t> read_packet(std::uint8_t endpoint, std::size_t, std::int64_t now_us) override {
    if (endpoint != 0x82) return {};
    times.push_back(now_us);
    ++sent;
    return std::vector<std::uint8_t>(static_cast<std::size_t>(sent), static_cast<std::uint8_t>(sent));
  }
  int sent = 0;
  std::vector<std::int64_t> times;
  std::vector<std::uint8_t> received;
};

class Kernel {
 public:
  Kernel() {
    EXPECT_EQ(::socketpair(AF_UNIX, SOCK_STREAM, 0, ends_), 0);
    host_ = std::make_unique<UsbipHost>(device, ends_[1]);
    thread_ = std::thread([this] { EXPECT_TRUE(host_->run()); });
  }
  ~Kernel() {
    ::close(ends_[0]);  // unplugged
    thread_.join();
    ::close(ends_[1]);
  }
  // `setup`: eight bytes, or none.
  void submit(std::uint32_t number, bool in, std::uint32_t endpoint, std::uint32_t length,
              const std::vector<std::uint32_t>& packets, const std::array<std::uint8_t, 8>& setup,
              const std::vector<std::uint8_t>& out = {}) {
    const auto count = packets.empty() ? 0xFFFFFFFFU : static_cast<std::uint32_t>(packets.size());
    std::uint32_t words[12] = {1, number, 65537, in ? 1U : 0U, endpoint, 0, length, 0, count, 0};
    for (auto& word : words) word = htonl(word);
    std::memcpy(words + 10, setup.data(), 8);
    send(words, sizeof words);
    send(out.data(), out.size());
    std::uint32_t offset = 0;
    for (const std::uint32_t size : packets) {
      const std::uint32_t about[4] = {htonl(offset), htonl(size), 0, 0};
      send(about, sizeof about);
      offset += size;
    }
  }
  void unlink(std::uint32_t number, std::uint32_t wanted) {
    std::uint32_t words[12] = {2, number, 65537, 0, 0, wanted};
    for (auto& word : words) word = htonl(word);
    send(words, sizeof words);
  }
  std::array<std::int32_t, 12> answer() {
    std::array<std::int32_t, 12> words{};
    receive(words.data(), sizeof words);
    for (auto& word : words) word = static_cast<std::int32_t>(ntohl(static_cast<std::uint32_t>(word)));
    return words;
  }
  std::vector<std::uint8_t> bytes(std::size_t count) {
    std::vector<std::uint8_t> read(count);
    receive(read.data(), count);
    return read;
  }
  CountingDevice device;

 private:
  void send(const void* from, std::size_t count) {
    ASSERT_EQ(::send(ends_[0], from, count, MSG_NOSIGNAL), static_cast<ssize_t>(count));
  }
  void receive(void* to, std::size_t count) {
    ASSERT_EQ(::recv(ends_[0], to, count, MSG_WAITALL), static_cast<ssize_t>(count));
  }
  int ends_[2] = {-1, -1};
  std::unique_ptr<UsbipHost> host_;
  std::thread thread_;
};

TEST(UsbipHost, AnswersControlRequestsAndStalls) {
  Kernel kernel;
  kernel.submit(5, true, 0, 64, {}, {0x80, 6, 0, 1, 0, 0, 18, 0});
  EXPECT_THAT(kernel.answer(), testing::ElementsAre(3, 5, 0, 0, 0, 0, 4, 0, 0, 0, 0, 0));
  EXPECT_THAT(kernel.bytes(4), testing::ElementsAre(18, 1, 0, 2));
  kernel.submit(6, true, 0, 3, {}, {0xC0, 1, 0, 0, 0, 0, 3, 0});
  EXPECT_EQ(kernel.answer()[6], 3) << "no more than was requested";
  EXPECT_THAT(kernel.bytes(3), testing::ElementsAre(9, 8, 7));
  kernel.submit(7, false, 0, 2, {}, {0x40, 1, 0, 0, 0, 0, 2, 0}, {0xAB, 0xCD});
  EXPECT_THAT(kernel.answer(), testing::ElementsAre(3, 7, 0, 0, 0, 0, 2, 0, 0, 0, 0, 0));
  EXPECT_THAT(kernel.device.received, testing::ElementsAre(0xAB, 0xCD));
  kernel.submit(8, true, 0, 4, {}, {0xC0, 0x77, 0, 0, 0, 0, 4, 0});
  EXPECT_EQ(kernel.answer()[5], -EPIPE);
}

TEST(UsbipHost, PacksIsochronousDataWithoutGaps) {
  Kernel kernel;
  kernel.submit(9, true, 2, 30, {10, 10, 10}, {});
  kernel.submit(10, true, 2, 20, {10, 10}, {});
  EXPECT_THAT(kernel.answer(), testing::ElementsAre(3, 9, 0, 0, 0, 0, 6, 0, 3, 0, 0, 0));
  EXPECT_THAT(kernel.bytes(6), testing::ElementsAre(1, 2, 2, 3, 3, 3));
  for (std::uint8_t i = 0; i < 3; ++i)
    EXPECT_THAT(kernel.bytes(16), testing::ElementsAre(0, 0, 0, i * 10, 0, 0, 0, 10, 0, 0, 0, i + 1, 0, 0, 0, 0));
  EXPECT_EQ(kernel.answer()[6], 9);
  EXPECT_EQ(kernel.bytes(9 + 32).size(), 41U);
  ASSERT_EQ(kernel.device.times.size(), 5U);
  for (const std::size_t i : {1, 2, 4}) EXPECT_EQ(kernel.device.times[i] - kernel.device.times[i - 1], 4000);
}

TEST(UsbipHost, WhatIsTakenBackIsNeverAnswered) {
  Kernel kernel;
  kernel.submit(20, true, 1, 512, {}, {});  // bulk: waits for ever
  kernel.unlink(21, 20);
  EXPECT_THAT(kernel.answer(), testing::ElementsAre(4, 21, 0, 0, 0, -ECONNRESET, 0, 0, 0, 0, 0, 0));
  kernel.unlink(22, 20);
  EXPECT_EQ(kernel.answer()[5], 0) << "not known any more";
  kernel.submit(23, true, 0, 4, {}, {0xC0, 1, 0, 0, 0, 0, 4, 0});
  EXPECT_EQ(kernel.answer()[1], 23) << "and nothing came between";
  EXPECT_EQ(kernel.bytes(4).size(), 4U);
}

}  // namespace
}  // namespace im2fit::devices
