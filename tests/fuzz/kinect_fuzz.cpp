// SPDX-License-Identifier: Apache-2.0
// A Kinect's bytes: packets as the fuzzer likes them, and honest streams it loses, repeats, cuts and changes packets
// of. No byte beyond a buffer is touched, and a picture that is delivered is one that was sent.
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <span>
#include <vector>

#include "hal/usb/depth_packets.h"
#include "hal/usb/kinect_commands.h"
#include "kernels/unpack11/shift_table.h"
#include "kernels/unpack11/unpack11.h"
#include "tests/kernels/ref/kernel_refs.h"

namespace {

using namespace im2fit;
using namespace im2fit::hal;

constexpr int kPackets = 242;
constexpr std::size_t kBytes = 422'400;
constexpr std::size_t kRoom = 4096;  // more than any packet

class Input {
 public:
  Input(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}
  bool empty() const { return size_ == 0; }
  int byte() { return size_ == 0 ? 0 : (--size_, *data_++); }
  int word() {
    const int low = byte();
    return low + 256 * byte();
  }
  std::vector<std::uint8_t> bytes(std::size_t count) {
    count = count < size_ ? count : size_;
    std::vector<std::uint8_t> taken(data_, data_ + count);
    data_ += count;
    size_ -= count;
    return taken;
  }

 private:
  const std::uint8_t* data_;
  std::size_t size_;
};

// Byte k of each packet's payload is the same and known, so that a picture can be checked without being kept.
std::uint8_t content(std::uint32_t picture, int place) {
  return static_cast<std::uint8_t>(picture * 31 + static_cast<std::uint32_t>(place) * 7);
}

struct Camera {
  std::uint32_t picture = 0;
  int place = 0;
  std::uint8_t number = 0;
  std::vector<std::uint8_t> next() {
    const std::size_t size = place == kPackets - 1 ? 1132 : 1748;
    std::vector<std::uint8_t> packet(12 + size, content(picture, place));
    const std::uint32_t ticks = (picture + 1) * 2'000'000;
    const std::uint8_t flag = place == 0 ? 0x71 : place == kPackets - 1 ? 0x75 : 0x72;
    const std::uint8_t header[12] = {'R',
                                     'B',
                                     0,
                                     flag,
                                     0,
                                     number,
                                     0,
                                     0,
                                     static_cast<std::uint8_t>(ticks),
                                     static_cast<std::uint8_t>(ticks >> 8),
                                     static_cast<std::uint8_t>(ticks >> 16),
                                     static_cast<std::uint8_t>(ticks >> 24)};
    std::memcpy(packet.data(), header, sizeof header);
    ++number;
    if (++place == kPackets) {
      place = 0;
      ++picture;
    }
    return packet;
  }
};

void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "kinect_fuzz: %s\n", what);
  std::abort();
}

struct Reader {
  // Of its own exact size, so that the sanitizer sees the first byte beyond. Made once: runs are worth more.
  static std::uint8_t* picture_bytes() {
    static const std::unique_ptr<std::uint8_t[]> bytes(new std::uint8_t[kBytes]);
    return bytes.get();
  }
  std::uint8_t* frame = picture_bytes();
  DepthPackets packets;
  Reader() { packets.fill(frame); }

  bool read(const std::vector<std::uint8_t>& bytes) {
    // Against the end of its memory, as a vector may have more of it.
    static const std::unique_ptr<std::uint8_t[]> room(new std::uint8_t[kRoom]);
    std::uint8_t* at = room.get() + kRoom - bytes.size();
    std::copy(bytes.begin(), bytes.end(), at);
    const auto outcome = packets.packet(std::span<const std::uint8_t>(at, bytes.size()));
    require(outcome != DepthPackets::Outcome::damaged || packets.damaged_frames() >= 1, "damage of no picture");
    if (outcome != DepthPackets::Outcome::frame) return false;
    static const ShiftTable table = shift_table({});
    static const std::unique_ptr<std::uint16_t[]> depth(new std::uint16_t[640 * 480]);
    shifts_to_mm(frame, 640 * 480, table, depth.get());
    return true;
  }
  void expect(std::uint32_t picture) {
    for (int place = 0; place < kPackets; ++place) {
      const std::size_t from = static_cast<std::size_t>(place) * 1748;
      const std::size_t size = place == kPackets - 1 ? 1132 : 1748;
      for (std::size_t i : {from, from + size / 2, from + size - 1})
        require(frame[i] == content(picture, place), "a picture that was never sent");
    }
  }
};

// Losses, repetitions and cuts of an honest camera's packets.
void honest_stream(Input& input) {
  Camera camera;
  Reader reader;
  std::vector<std::uint8_t> last;
  int budget = 4 * kPackets;
  while (!input.empty() && budget > 0) {
    const int what = input.byte();
    const int count = 1 + (what / 8 < 31 ? what / 8 : input.byte());
    for (int i = 0; i < count && budget > 0; ++i, --budget) {
      const std::uint32_t picture = camera.picture;
      switch (what % 8) {
        case 0:  // lost
          (void)camera.next();
          break;
        case 1:  // again
          if (!last.empty() && reader.read(last)) reader.expect(picture);
          break;
        case 2:  // cut
          last = camera.next();
          last.resize(static_cast<std::size_t>(input.word()) % last.size());
          require(!reader.read(last), "a picture from a packet that was cut");
          break;
        case 3:  // longer
          last = camera.next();
          last.resize(last.size() + 1 + static_cast<std::size_t>(input.byte()), 0x55);
          require(!reader.read(last), "a picture from a packet with too much");
          break;
        default:
          last = camera.next();
          if (reader.read(last)) reader.expect(picture);
      }
    }
  }
}

// Packets of any bytes, many of them with a header that is nearly right.
void any_packets(Input& input) {
  Reader reader;
  for (int budget = 3000; !input.empty() && budget > 0; --budget) {
    const int what = input.byte();
    if (what < 64) {
      reader.read(input.bytes(static_cast<std::size_t>(input.word()) % 2100));
      continue;
    }
    static constexpr std::uint8_t kFlags[] = {0x71, 0x72, 0x72, 0x75};
    static constexpr std::size_t kSizes[] = {1748, 1748, 1748, 1132, 1747, 0};
    std::vector<std::uint8_t> packet(12 + kSizes[static_cast<std::size_t>(what % 6)],
                                     static_cast<std::uint8_t>(what));
    packet[0] = 'R';
    packet[1] = 'B';
    packet[3] = kFlags[static_cast<std::size_t>(what / 6 % 4)];
    packet[5] = static_cast<std::uint8_t>(input.byte());
    const auto ticks = input.bytes(what % 5 == 0 ? 4 : 0);
    std::copy(ticks.begin(), ticks.end(), packet.begin() + 8);
    reader.read(packet);
  }
}

// A camera that answers commands with whatever it likes; now and then with the right beginning.
class Liar final : public UsbTransport {
 public:
  explicit Liar(Input& input) : input_(input) {}
  Result<std::size_t> control_in(const UsbRequest&, std::span<std::uint8_t> data, int) override {
    const int what = input_.byte();
    if (input_.empty() || what == 0) return Error{ErrorCode::no_device, "gone"};
    auto bytes = input_.bytes(static_cast<std::size_t>(input_.word()) % (data.size() + 1));
    if (what % 4 != 0 && bytes.size() >= 8) {
      bytes[0] = 'R';
      bytes[1] = 'B';
      const std::size_t words = (bytes.size() - 8) / 2;
      bytes.resize(8 + 2 * words);
      bytes[2] = static_cast<std::uint8_t>(words % 256);
      bytes[3] = static_cast<std::uint8_t>(words / 256);
      std::copy(command_.begin() + 4, command_.begin() + 8, bytes.begin() + 4);
      if (bytes.size() > 9 && what % 8 != 1) bytes[8] = bytes[9] = 0;
    }
    std::copy(bytes.begin(), bytes.end(), data.begin());
    return bytes.empty() ? std::size_t{1} : bytes.size();
  }
  Status control_out(const UsbRequest&, std::span<const std::uint8_t> data, int) override {
    command_.assign(data.begin(), data.end());
    return Ok{};
  }
  Status start_stream(const UsbStreamSettings&, UsbPacketSink&) override { return Ok{}; }
  void stop_stream() override {}

 private:
  Input& input_;
  std::vector<std::uint8_t> command_ = std::vector<std::uint8_t>(8);
};

void answers(Input& input) {
  Liar liar(input);
  KinectCommands commands(liar, "the liar");
  const auto plane = commands.zero_plane();
  if (plane && *plane) {
    require(is_plausible(**plane), "a plane no camera has");
    for (const std::uint16_t mm : shift_table(**plane)) require(mm <= 10'000, "a depth beyond the range");
  }
  (void)commands.read_register(kinect::Register::depth_stream);
  (void)commands.start_depth();
}

// Every tier on any bytes, any count.
void unpacking(Input& input) {
  const int count = input.word() % 1400;
  std::vector<std::uint8_t> packed = input.bytes(unpack11_bytes(count));
  packed.resize(unpack11_bytes(count));
  const std::unique_ptr<std::uint8_t[]> exact(new std::uint8_t[packed.size()]);
  std::copy(packed.begin(), packed.end(), exact.get());
  std::vector<std::uint16_t> want(static_cast<std::size_t>(count)), got(want.size());
  unpack11_ref(exact.get(), count, want.data());
  for (const auto& kernel : kUnpack11WithRef) {
    if (!tier_available(kernel.tier)) continue;
    kernel.function(exact.get(), count, got.data());
    require(got == want, "tiers differ");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Input input(data, size);
  switch (input.byte() % 8) {
    case 0:
    case 1:
      any_packets(input);
      break;
    case 2:
      answers(input);
      break;
    case 3:
      unpacking(input);
      break;
    default:
      honest_stream(input);
  }
  return 0;
}
