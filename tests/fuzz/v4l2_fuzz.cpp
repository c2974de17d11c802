// SPDX-License-Identifier: Apache-2.0
// A V4L2 driver with arbitrary answers: sizes, strides, formats, lengths and buffer numbers. No byte beyond a
// buffer is read, and a delivered frame holds the contents of the buffer.
#include <sys/ioctl.h>

#include <cstdio>
#include <cstdlib>

#include "hal/v4l2/v4l2_source.h"
#include "tests/hal/fake_video_device.h"

namespace {

using namespace im2fit;
using namespace im2fit::hal;

constexpr std::uint32_t kBufferMax = 1U << 22;  // a driver with larger ones has no memory for them

class Input {
 public:
  Input(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}
  bool empty() const { return size_ == 0; }
  int byte() { return size_ == 0 ? 0 : (--size_, *data_++); }
  std::uint32_t word() {
    std::uint32_t value = 0;
    for (int i = 0; i < 4; ++i) value = value << 8 | static_cast<std::uint32_t>(byte());
    return value;
  }

 private:
  const std::uint8_t* data_;
  std::size_t size_;
};

void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "v4l2_fuzz: %s\n", what);
  std::abort();
}

// Answers honestly, then changes some of the words of the answer.
class Liar final : public VideoDevice {
 public:
  Liar(FakeVideo& fake, Input& input) : honest_(fake), fake_(fake), input_(input) {}

  int request(unsigned long code, void* argument) override {
    if (fake_.pix.sizeimage > kBufferMax && code == VIDIOC_REQBUFS) return ENOMEM;
    if (input_.byte() >= 250) return input_.byte();
    const int error = honest_.request(code, argument);
    const std::size_t words = _IOC_SIZE(code) / 4;
    for (int lies = input_.byte() % 16 == 0 ? 1 + input_.byte() % 4 : 0; lies > 0 && words > 0; --lies) {
      const std::size_t at = static_cast<std::size_t>(input_.byte()) % words;
      // Near the truth as often as far from it.
      std::uint32_t value = 0;
      std::memcpy(&value, static_cast<char*>(argument) + at * 4, 4);
      value = input_.byte() % 2 == 0 ? input_.word() : value + static_cast<std::uint32_t>(input_.byte()) - 128;
      std::memcpy(static_cast<char*>(argument) + at * 4, &value, 4);
    }
    // Buffers are sized by the format the driver reported.
    if (code == VIDIOC_S_FMT) fake_.pix = static_cast<v4l2_format*>(argument)->fmt.pix;
    return error;
  }
  const std::byte* map(std::size_t size_bytes, std::uint32_t offset) override {
    return honest_.map(size_bytes, offset);
  }
  void unmap(const std::byte* address, std::size_t size_bytes) override { honest_.unmap(address, size_bytes); }
  int wait(int timeout_ms, short& events) override { return honest_.wait(timeout_ms, events); }

 private:
  FakeVideoDevice honest_;
  FakeVideo& fake_;
  Input& input_;
};

void drive(Input& input) {
  static constexpr std::uint32_t kFormats[] = {V4L2_PIX_FMT_Z16, V4L2_PIX_FMT_INZI, V4L2_PIX_FMT_Y16};
  FakeVideo fake;
  fake.formats.clear();
  for (int i = input.byte() % 3; i >= 0; --i)
    fake.formats.push_back({kFormats[input.byte() % 3], {{1 + input.byte() % 96, 1 + input.byte() % 96}}});
  fake.padding_bytes = input.byte() % 4 == 0 ? static_cast<std::uint32_t>(input.byte()) : 0;
  if (input.byte() % 8 == 0) fake.bytes_per_line = input.word();
  if (input.byte() % 8 == 0) fake.size_image = input.word();
  fake.controls = {{5, "Unit", static_cast<int>(input.word())}};
  V4l2Options options;
  options.hfov_deg = 60.0F;
  options.width = 1 + input.byte();
  options.height = 1 + input.byte();
  options.buffer_count = input.byte();
  if (input.byte() % 2 == 0) options.format = static_cast<V4l2Format>(input.byte() % 3);
  if (input.byte() % 2 == 0) options.unit_um = static_cast<int>(input.word() % 100'002);
  if (input.byte() % 8 == 0) options.unit_control = "Unit";
  auto source = V4l2Source::open(std::make_unique<Liar>(fake, input), "the liar", options);
  if (!source) return;
  const Intrinsics& k = (*source)->info().intrinsics;
  std::vector<std::uint16_t> pixels(static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height));
  for (int starts = 0; starts < 2; ++starts) {
    if (!(*source)->start()) continue;
    for (int frames = 0; frames < 16 && !input.empty(); ++frames) {
      FakeVideo::Event event;
      event.bytes.resize(input.byte() % 2 == 0 ? fake.pix.sizeimage : input.word() % (fake.pix.sizeimage + 2));
      std::fill(event.bytes.begin(), event.bytes.end(), static_cast<std::byte>(input.byte()));
      event.flags = input.word();
      event.sequence = input.word();
      event.poll_events = static_cast<short>(input.byte() % 4 == 0 ? input.byte() : POLLIN);
      fake.events.push_back(event);
      (void)(*source)->next({pixels.data(), k.width, k.height}, 0);
    }
    (*source)->stop();
    require(fake.mapped == 0, "a buffer stays mapped");
  }
}

// The copy alone, against its definition.
void copy(Input& input) {
  DepthLayout layout;
  layout.width = input.byte() % 40 - 1;
  layout.height = input.byte() % 40 - 1;
  layout.offset_bytes = input.word() % 5000;
  layout.stride_bytes = input.word() % 200;
  layout.unit_um = static_cast<int>(input.word() % 100'001);
  std::vector<std::byte> buffer(input.word() % 12'000);
  for (std::size_t i = 0; i < buffer.size(); ++i) buffer[i] = static_cast<std::byte>(i * 37 + i / 251);
  const int width = input.byte() % 4 == 0 ? input.byte() % 40 : layout.width;
  std::vector<std::uint16_t> out(static_cast<std::size_t>(std::max(width, 0) * std::max(layout.height, 0)) + 1);
  if (!copy_depth(buffer, layout, {out.data(), std::max(width, 0), std::max(layout.height, 0)})) return;
  for (int v = 0; v < layout.height; ++v) {
    for (int u = 0; u < layout.width; ++u) {
      const std::size_t at =
          layout.offset_bytes + layout.stride_bytes * static_cast<std::size_t>(v) + 2 * static_cast<std::size_t>(u);
      const double raw = static_cast<double>(buffer.at(at)) + 256 * static_cast<double>(buffer.at(at + 1));
      const double mm = static_cast<double>(static_cast<long long>((raw * layout.unit_um + 500) / 1000));
      require(out[static_cast<std::size_t>(v * layout.width + u)] == (mm > 65535 ? 0 : mm), "another depth");
    }
  }
}

void uri(Input& input) {
  std::string text;
  while (!input.empty()) text += static_cast<char>(input.byte());
  const auto options = parse_v4l2_uri(text, {});
  if (!options) return;
  require(options->width >= 1 && options->width <= 2048 && options->fps >= 1, "a size no camera has");
  require(!options->unit_um || (*options->unit_um >= 1 && *options->unit_um <= 100'000), "a unit out of range");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Input input(data, size);
  switch (input.byte() % 8) {
    case 0:
      copy(input);
      break;
    case 1:
      uri(input);
      break;
    default:
      drive(input);
  }
  return 0;
}
