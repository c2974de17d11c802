// SPDX-License-Identifier: Apache-2.0
// Packet by packet: packets that make a picture and packets that do not. They are written here byte by byte.
#include <gtest/gtest.h>

#include <vector>

#include "hal/usb/depth_packets.h"
#include "hal/usb/frame_exchange.h"

namespace im2fit::hal {
namespace {

using Outcome = DepthPackets::Outcome;
using Packet = std::vector<std::uint8_t>;

constexpr int kPackets = 242;
constexpr std::size_t kBytes = 422'400;

// The wire: packets of endless pictures, numbered on and on.
class Wire {
 public:
  explicit Wire(int first_number = 0) : number_(first_number) {}
  std::uint64_t picture() const { return picture_; }
  int place() const { return place_; }
  // What the packets of picture n hold, but for 37 n.
  static const std::vector<std::uint8_t>& pattern() {
    static const std::vector<std::uint8_t> bytes = [] {
      std::vector<std::uint8_t> made(kBytes);
      for (std::size_t i = 0; i < kBytes; ++i) made[i] = static_cast<std::uint8_t>(i / 1748 * 5 + i % 251);
      return made;
    }();
    return bytes;
  }
  Packet next() {
    const std::size_t from = static_cast<std::size_t>(place_) * 1748;
    const std::size_t size = place_ == kPackets - 1 ? 1132 : 1748;
    const std::uint32_t ticks = ticks0 + static_cast<std::uint32_t>(picture_) * 2'000'000;
    Packet packet = {0x52, 0x42, 0, 0x72, 0, static_cast<std::uint8_t>(number_), 0, 0};
    if (place_ == 0) packet[3] = 0x71;
    if (place_ == kPackets - 1) packet[3] = 0x75;
    for (int shift = 0; shift < 32; shift += 8) packet.push_back(static_cast<std::uint8_t>(ticks >> shift));
    packet.resize(12 + size);
    const std::uint8_t* own = pattern().data() + from;
    for (std::size_t i = 0; i < size; ++i) packet[12 + i] = static_cast<std::uint8_t>(picture_ * 37 + own[i]);
    skip(1);
    return packet;
  }
  void skip(int packets) {
    number_ += packets;
    place_ += packets;
    picture_ += static_cast<std::uint64_t>(place_ / kPackets);
    place_ %= kPackets;
  }
  std::uint32_t ticks0 = 1000;

 private:
  std::uint64_t picture_ = 0;
  int place_ = 0;
  int number_;
};

struct Reader {
  Reader() : buffer(kBytes) { packets.fill(buffer.data()); }
  Outcome read(const Packet& packet) {
    const Outcome outcome = packets.packet(packet);
    if (outcome == Outcome::frame) ++frames;
    if (outcome == Outcome::damaged) damaged += packets.damaged_frames();
    return outcome;
  }
  // Until the outcome that is not none.
  Outcome read_some(Wire& wire, int count) {
    Outcome last = Outcome::none;
    for (int i = 0; i < count; ++i)
      if (const Outcome outcome = read(wire.next()); outcome != Outcome::none) last = outcome;
    return last;
  }
  bool holds(std::uint64_t picture) const {
    const auto& pattern = Wire::pattern();
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < kBytes; ++i)
      wrong += buffer[i] != static_cast<std::uint8_t>(picture * 37 + pattern[i]);
    return wrong == 0;
  }
  DepthPackets packets;
  std::vector<std::uint8_t> buffer;
  int frames = 0;
  int damaged = 0;
};

TEST(UsbDepthPackets, MakePicturesInOrder) {
  Wire wire(250);
  Reader reader;
  for (std::uint64_t picture = 0; picture < 4; ++picture) {
    EXPECT_EQ(reader.read_some(wire, kPackets - 1), Outcome::none);
    EXPECT_EQ(reader.read_some(wire, 1), Outcome::frame);
    EXPECT_TRUE(reader.holds(picture));
    EXPECT_EQ(reader.packets.ticks(), 1000 + 2'000'000 * picture);
  }
  EXPECT_EQ(reader.packets.stats().packets, 4U * kPackets);
  EXPECT_EQ(reader.packets.stats().lost + reader.packets.stats().repeated + reader.packets.stats().foreign, 0U);
}

TEST(UsbDepthPackets, JoinedInMidPictureWaitForTheNext) {
  Wire wire;
  Reader reader;
  wire.skip(100);
  EXPECT_EQ(reader.read_some(wire, kPackets - 100), Outcome::none);
  EXPECT_EQ(reader.damaged, 0) << "nothing was lost: it was never requested";
  EXPECT_EQ(reader.read_some(wire, kPackets), Outcome::frame);
  EXPECT_TRUE(reader.holds(1));
}

// One packet of each place in turn: that picture is damaged, once, and the next is whole.
TEST(UsbDepthPackets, OneLostAnywhereDamagesItsPictureAndNoOther) {
  for (int place = 0; place < kPackets; place += place < 4 || place > 236 ? 1 : 7) {
    Wire wire(place);
    Reader reader;
    reader.read_some(wire, kPackets);
    reader.read_some(wire, place);
    wire.skip(1);
    reader.read_some(wire, kPackets - place - 1);
    reader.read_some(wire, kPackets);
    EXPECT_EQ(reader.frames, 2) << place;
    EXPECT_EQ(reader.damaged, 1) << place;
    EXPECT_TRUE(reader.holds(2)) << place;
    EXPECT_EQ(reader.packets.stats().lost, 1U) << place;
  }
}

// Up to the length at which 8 bits can no longer tell. What is lost of a picture damages it; one lost whole is either
// counted or left to the clock, but never delivered.
TEST(UsbDepthPackets, AnyStretchLostIsNeverDelivered) {
  for (const int lost : {2, 17, 141, 142, 143, 200, 241, 242, 243, 247, 248, 255, 256, 257, 384, 484, 512, 1000}) {
    for (const int place : {0, 100, 241}) {
      Wire wire;
      Reader reader;
      reader.read_some(wire, kPackets);
      reader.read_some(wire, place);
      wire.skip(lost);
      for (int i = 0; i < 4 * kPackets; ++i) {
        const std::uint64_t picture = wire.picture();
        if (reader.read(wire.next()) == Outcome::frame) {
          ASSERT_TRUE(reader.holds(picture)) << lost << " lost at " << place;
        }
      }
      EXPECT_GE(reader.frames, 3) << lost << " lost at " << place << ": it synchronises again";
    }
  }
}

// 128 pictures are 121 times 256 packets: number, flag and size fit again. The clock does not.
TEST(UsbDepthPackets, ALossThatFitsInAllElseIsSeenByTheClock) {
  Wire wire;
  Reader reader;
  reader.read_some(wire, 100);
  wire.skip(128 * kPackets);
  EXPECT_EQ(reader.read_some(wire, kPackets - 100), Outcome::damaged);
  EXPECT_EQ(reader.frames, 0);
  EXPECT_EQ(reader.read_some(wire, kPackets), Outcome::frame);
  EXPECT_TRUE(reader.holds(129));
}

// 32 bits wrap every 71.6 s, and may meet 0 exactly.
TEST(UsbDepthPackets, TimeZeroIsATimeToo) {
  Wire wire;
  wire.ticks0 = 0U - 2'000'000;
  Reader reader;
  for (const std::uint32_t ticks : {0U - 2'000'000, 0U, 2'000'000U}) {
    EXPECT_EQ(reader.read_some(wire, kPackets), Outcome::frame);
    EXPECT_EQ(reader.packets.ticks(), ticks);
  }
}

TEST(UsbDepthPackets, TwiceOrTooLateAreLeftAlone) {
  Wire wire;
  Reader reader;
  std::vector<Packet> sent;
  for (int i = 0; i < kPackets; ++i) {
    sent.push_back(wire.next());
    reader.read(sent.back());
    if (i % 3 == 0) reader.read(sent.back());
    if (i % 7 == 0 && i > 5) reader.read(sent[static_cast<std::size_t>(i - 5)]);
  }
  EXPECT_EQ(reader.frames, 1);
  EXPECT_TRUE(reader.holds(0));
  EXPECT_EQ(reader.read(sent.back()), Outcome::none) << "the end, twice";
  EXPECT_EQ(reader.damaged, 0);
  EXPECT_EQ(reader.read_some(wire, kPackets), Outcome::frame);
  EXPECT_TRUE(reader.holds(1));
  EXPECT_GT(reader.packets.stats().repeated, 100U);
}

TEST(UsbDepthPackets, SwappedOnesDamageThePicture) {
  Wire wire;
  Reader reader;
  reader.read_some(wire, 50);
  const Packet early = wire.next();
  reader.read(wire.next());
  reader.read(early);
  EXPECT_EQ(reader.read_some(wire, kPackets - 52), Outcome::damaged);
  EXPECT_EQ(reader.read_some(wire, kPackets), Outcome::frame);
}

TEST(UsbDepthPackets, OfTheWrongSizeDamageThePicture) {
  for (const int place : {0, 1, 120, 241}) {
    for (const int change : {-1749, -1748, -1, 1, 159}) {
      Wire wire;
      Reader reader;
      reader.read_some(wire, place);
      Packet packet = wire.next();
      packet.resize(static_cast<std::size_t>(std::max(0, static_cast<int>(packet.size()) + change)), 0xFF);
      reader.read(packet);
      reader.read_some(wire, kPackets - place - 1);
      EXPECT_EQ(reader.frames, 0) << place << " by " << change;
      reader.read_some(wire, kPackets);
      EXPECT_EQ(reader.frames, 1) << place << " by " << change;
      EXPECT_TRUE(reader.holds(1)) << place << " by " << change;
    }
  }
}

TEST(UsbDepthPackets, OfAnotherStreamAreNotTaken) {
  Wire wire;
  Reader reader;
  reader.read_some(wire, 100);
  Packet foreign = wire.next();
  Packet mirror = foreign;
  mirror[0] = 'B';
  EXPECT_EQ(reader.read(mirror), Outcome::none);
  EXPECT_EQ(reader.read({}), Outcome::none);
  EXPECT_EQ(reader.read({'R', 'B', 0}), Outcome::none);
  EXPECT_EQ(reader.packets.stats().foreign, 3U);
  reader.read(foreign);
  EXPECT_EQ(reader.read_some(wire, kPackets - 101), Outcome::frame) << "they stood beside the stream, not in it";
  for (const int flag : {0x00, 0x70, 0x73, 0x81, 0x82, 0x85, 0x71, 0x75}) {
    Reader other;
    Wire again;
    other.read_some(again, 100);
    Packet packet = again.next();
    packet[3] = static_cast<std::uint8_t>(flag);
    other.read(packet);
    other.read_some(again, kPackets - 101);
    EXPECT_EQ(other.frames, 0) << "flag " << flag;
    EXPECT_GE(other.damaged, 1) << "flag " << flag;
    EXPECT_EQ(other.read_some(again, kPackets), Outcome::frame);
  }
}

TEST(UsbDepthPackets, CountEachPictureAGapRunsThrough) {
  Wire wire;
  Reader reader;
  reader.read_some(wire, kPackets);
  reader.read_some(wire, 200);
  wire.skip(100);  // the end of one picture and the start of the next
  EXPECT_EQ(reader.read_some(wire, kPackets - 58), Outcome::damaged);
  EXPECT_EQ(reader.packets.damaged_frames(), 2);
  EXPECT_EQ(reader.packets.packets_received(), 200 + kPackets - 58);
  EXPECT_EQ(reader.read_some(wire, kPackets), Outcome::frame);
}

FrameExchange::Entry entry_of(std::uint64_t number) {
  FrameExchange::Entry entry;
  entry.number = number;
  return entry;
}

TEST(UsbFrameExchange, KeepsTheNewestAndNeverTheOneBeingRead) {
  FrameExchange exchange(16);
  EXPECT_FALSE(exchange.take(0));
  const auto publish = [&](std::uint64_t number) {
    std::fill_n(exchange.filling(), 16, static_cast<std::uint8_t>(number));
    exchange.publish(entry_of(number));
  };
  publish(1);
  const auto reading = exchange.take(0);
  ASSERT_TRUE(reading);
  for (std::uint64_t n = 2; n < 50; ++n) {
    publish(n);
    ASSERT_EQ(reading->bytes[0], 1) << "written to while it is read";
    ASSERT_EQ(reading->bytes[15], 1);
  }
  const auto next = exchange.take(0);
  ASSERT_TRUE(next);
  EXPECT_EQ(next->number, 48U);
  EXPECT_EQ(next->bytes[7], 48);
  EXPECT_EQ(exchange.take(0)->number, 49U);
  EXPECT_FALSE(exchange.take(0));
  EXPECT_EQ(exchange.dropped(), 46U);
}

TEST(UsbFrameExchange, GivesWhatCameBeforeTheEnd) {
  FrameExchange exchange(4);
  exchange.publish(entry_of(7));
  exchange.publish_damaged(entry_of(8));
  exchange.end({ErrorCode::no_device, "gone"});
  exchange.end({ErrorCode::io, "again"});
  EXPECT_EQ(exchange.take(1000)->number, 7U);
  const auto damaged = exchange.take(1000);
  EXPECT_TRUE(damaged->damaged);
  EXPECT_EQ(damaged->bytes, nullptr);
  EXPECT_FALSE(exchange.take(1000));
  EXPECT_EQ(exchange.ended()->message, "gone");
  exchange.reset();
  EXPECT_FALSE(exchange.ended());
  EXPECT_FALSE(exchange.take(0));
}

TEST(UsbFrameExchange, ManyDamagedPushOutGoodOnesAndBothAreCounted) {
  FrameExchange exchange(4);
  exchange.publish(entry_of(0));
  for (std::uint64_t n = 1; n < 20; ++n) exchange.publish_damaged(entry_of(n));
  exchange.publish(entry_of(20));
  std::uint64_t taken = 0;
  for (auto entry = exchange.take(0); entry; entry = exchange.take(0)) ++taken;
  EXPECT_EQ(taken + exchange.dropped() + exchange.dropped_damaged(), 21U);
  EXPECT_EQ(exchange.dropped(), 1U);
}

}  // namespace
}  // namespace im2fit::hal
