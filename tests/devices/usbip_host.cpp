// SPDX-License-Identifier: Apache-2.0
#include "tests/devices/usbip_host.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <sstream>

namespace im2fit::devices {
namespace {

// Documentation/usb/usbip_protocol.rst: 48 bytes of big-endian words (the setup packet as it is).
constexpr std::size_t kHeaderWords = 12;
constexpr std::uint32_t kSubmit = 1;
constexpr std::uint32_t kUnlink = 2;
constexpr std::uint32_t kSubmitReply = 3;
constexpr std::uint32_t kUnlinkReply = 4;
constexpr std::uint32_t kTransferMax = 1U << 20;
constexpr std::uint32_t kPacketsMax = 1024;

constexpr std::int64_t kBulkRetry_us = 500;
constexpr std::int64_t kIdle_us = 100'000;
constexpr std::int64_t kLate_us = 500'000;  // beyond this the packets' clock starts over

constexpr std::uint8_t kGetStatus = 0x00;
constexpr std::uint8_t kGetDescriptor = 0x06;

constexpr const char* kController = "/sys/devices/platform/vhci_hcd.0/";

std::int64_t now_us() {
  return std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

Error failed(const std::string& doing) {
  return {ErrorCode::io, "usbip: " + doing + ": " + std::strerror(errno)};
}

}  // namespace

UsbipHost::UsbipHost(UsbDevice& device, int socket) : device_(device), socket_(socket) {
  read_endpoints();
}

void UsbipHost::read_endpoints() {
  const auto bytes = device_.configuration_descriptor();
  for (std::size_t at = 0; at + 2 <= bytes.size() && bytes[at] >= 2; at += bytes[at]) {
    if (bytes[at + 1] != 5 || at + 7 > bytes.size() || (bytes[at + 2] & 0x80) == 0) continue;
    Endpoint& endpoint = endpoints_[bytes[at + 2]];
    endpoint.isochronous = (bytes[at + 3] & 3) == 1;
    // High speed: 2^(bInterval - 1) microframes of 125 us (USB 2.0 9.6.6).
    endpoint.interval_us = std::int64_t{125} << std::clamp(bytes[at + 6] - 1, 0, 15);
  }
}

bool UsbipHost::read_exactly(void* to, std::size_t count) {
  auto* bytes = static_cast<char*>(to);
  while (count > 0) {
    const ssize_t n = ::recv(socket_, bytes, count, 0);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    bytes += n;
    count -= static_cast<std::size_t>(n);
  }
  return true;
}

bool UsbipHost::write_exactly(const void* from, std::size_t count) {
  const auto* bytes = static_cast<const char*>(from);
  while (count > 0) {
    const ssize_t n = ::send(socket_, bytes, count, MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    bytes += n;
    count -= static_cast<std::size_t>(n);
  }
  return true;
}

Status UsbipHost::run() {
  while (!stopped_ && !unplugged_) {
    const auto pause_us = serve(now_us());
    if (!pause_us) return pause_us.error();
    pollfd wanted{socket_, POLLIN, 0};
    const timespec pause{static_cast<time_t>(*pause_us / 1'000'000), static_cast<long>(*pause_us % 1'000'000 * 1000)};
    const int count = ::ppoll(&wanted, 1, &pause, nullptr);
    if (count < 0 && errno != EINTR) return failed("waiting");
    if (count <= 0) continue;
    if (auto ok = receive(); !ok) return ok;
  }
  return Ok{};
}

Status UsbipHost::receive() {
  std::array<std::uint32_t, kHeaderWords> words{};
  if (!read_exactly(words.data(), sizeof words)) {
    unplugged_ = true;
    return Ok{};
  }
  for (std::size_t i = 0; i < 10; ++i) words[i] = ntohl(words[i]);
  if (words[0] == kSubmit) return submit(words.data());
  if (words[0] == kUnlink) return unlink(words.data());
  return Error{ErrorCode::io, "usbip: the kernel sent command " + std::to_string(words[0]) + ", expected 1 or 2"};
}

// Words: command, number, device, direction, endpoint, flags, length, start frame, packets, interval, setup.
Status UsbipHost::submit(const std::uint32_t* words) {
  ++counts_.submitted;
  const std::uint32_t number = words[1];
  const bool in = words[3] == 1;
  const std::uint32_t length = words[6];
  const std::uint32_t packet_count = words[8] == 0xFFFFFFFFU ? 0 : words[8];  // -1: not isochronous
  if (length > kTransferMax || packet_count > kPacketsMax)
    return Error{ErrorCode::io, "usbip: a request of " + std::to_string(length) + " bytes is beyond reason"};
  std::vector<std::uint8_t> out(in ? 0 : length);
  if (!read_exactly(out.data(), out.size())) return failed("reading");
  Urb urb{number, length, {}};
  std::vector<std::uint32_t> packets(packet_count * 4);
  if (!read_exactly(packets.data(), packets.size() * 4)) return failed("reading");
  for (std::size_t i = 0; i < packet_count; ++i) urb.packet_lengths.push_back(ntohl(packets[4 * i + 1]));
  if (words[4] == 0) {
    const auto* setup = reinterpret_cast<const std::uint8_t*>(words + 10);
    const auto word = [&](int at) { return static_cast<std::uint16_t>(setup[at] | setup[at + 1] << 8); };
    return answer_control(number, in, {setup[0], setup[1], word(2), word(4), word(6)}, out);
  }
  const auto endpoint = endpoints_.find(static_cast<std::uint8_t>(words[4] | 0x80));
  if (!in || endpoint == endpoints_.end()) return reply(number, -EPIPE, {}, 0, {}, 0);
  if (endpoint->second.waiting.empty() && endpoint->second.clock_us < now_us()) endpoint->second.clock_us = now_us();
  endpoint->second.waiting.push_back(std::move(urb));
  return Ok{};
}

// One thread answers and takes back, so a request is either still waiting here or was answered before: no answer ever
// follows its unlinking, at which the kernel would drop the device.
Status UsbipHost::unlink(const std::uint32_t* words) {
  const std::uint32_t wanted = words[5];
  int status = 0;
  for (auto& [address, endpoint] : endpoints_) {
    const auto found = std::find_if(endpoint.waiting.begin(), endpoint.waiting.end(),
                                    [&](const Urb& urb) { return urb.number == wanted; });
    if (found == endpoint.waiting.end()) continue;
    endpoint.waiting.erase(found);
    status = -ECONNRESET;
    ++counts_.unlinked;
    break;
  }
  std::array<std::uint32_t, kHeaderWords> answer{htonl(kUnlinkReply), htonl(words[1])};
  answer[5] = htonl(static_cast<std::uint32_t>(status));
  if (!write_exactly(answer.data(), sizeof answer)) unplugged_ = true;
  return Ok{};
}

std::optional<std::vector<std::uint8_t>> UsbipHost::standard_request(const SetupPacket& setup) const {
  if (setup.request_type == 0x80 && setup.request == kGetDescriptor) {
    std::vector<std::uint8_t> bytes;
    if (setup.value >> 8 == 1) bytes = device_.device_descriptor();
    if (setup.value >> 8 == 2) bytes = device_.configuration_descriptor();
    if (setup.value >> 8 == 3) bytes = device_.string_descriptor(static_cast<std::uint8_t>(setup.value & 0xFF));
    if (bytes.empty()) return std::nullopt;
    return bytes;
  }
  if ((setup.request_type & 0xE0) == 0x80 && setup.request == kGetStatus) return std::vector<std::uint8_t>{0, 0};
  return std::nullopt;
}

Status UsbipHost::answer_control(std::uint32_t number, bool in, const SetupPacket& setup,
                                 std::span<const std::uint8_t> out) {
  auto answer = standard_request(setup);
  if (!answer) answer = device_.control(setup, out, now_us());
  if (!answer) return reply(number, -EPIPE, {}, 0, {}, 0);
  if (!in) return reply(number, 0, {}, static_cast<std::uint32_t>(out.size()), {}, 0);
  const std::size_t count = std::min<std::size_t>(answer->size(), setup.length);
  return reply(number, 0, std::span(*answer).first(count), static_cast<std::uint32_t>(count), {}, 0);
}

Result<std::int64_t> UsbipHost::serve(std::int64_t now) {
  std::int64_t pause_us = kIdle_us;
  for (auto& [address, endpoint] : endpoints_) {
    while (!endpoint.waiting.empty()) {
      const Urb& urb = endpoint.waiting.front();
      if (endpoint.isochronous) {
        const std::int64_t due_us =
            endpoint.clock_us + endpoint.interval_us * static_cast<std::int64_t>(urb.packet_lengths.size());
        if (due_us > now) {
          pause_us = std::min(pause_us, due_us - now);
          break;
        }
        if (now - due_us > kLate_us) endpoint.clock_us = now - (due_us - endpoint.clock_us);
        if (auto ok = complete_isochronous(address, endpoint); !ok) return ok.error();
        continue;
      }
      const auto data = device_.read_packet(address, urb.length, now);
      if (data.empty()) {
        pause_us = std::min(pause_us, kBulkRetry_us);
        break;
      }
      if (auto ok = reply(urb.number, 0, data, static_cast<std::uint32_t>(data.size()), {}, 0); !ok)
        return ok.error();
      endpoint.waiting.pop_front();
    }
  }
  return pause_us;
}

// The packets' data follow one another without gaps; then a descriptor each, offsets as the kernel gave them
// (it restores them itself).
Status UsbipHost::complete_isochronous(std::uint8_t address, Endpoint& endpoint) {
  const Urb urb = std::move(endpoint.waiting.front());
  endpoint.waiting.pop_front();
  std::vector<std::uint8_t> data;
  data.reserve(urb.length);
  std::vector<std::uint32_t> words;
  std::uint32_t offset = 0;
  const std::uint32_t start_frame = frame_number_;
  for (const std::uint32_t length : urb.packet_lengths) {
    auto packet = device_.read_packet(address, length, endpoint.clock_us);
    packet.resize(std::min<std::size_t>(packet.size(), length));
    data.insert(data.end(), packet.begin(), packet.end());
    for (const std::uint32_t word : {offset, length, static_cast<std::uint32_t>(packet.size()), 0U})
      words.push_back(htonl(word));
    offset += length;
    endpoint.clock_us += endpoint.interval_us;
    ++frame_number_;
    ++counts_.packets;
  }
  return reply(urb.number, 0, data, static_cast<std::uint32_t>(data.size()), words, start_frame);
}

Status UsbipHost::reply(std::uint32_t number, int status, std::span<const std::uint8_t> data, std::uint32_t actual,
                        const std::vector<std::uint32_t>& packet_words, std::uint32_t start_frame) {
  std::array<std::uint32_t, kHeaderWords> header{htonl(kSubmitReply), htonl(number)};
  header[5] = htonl(static_cast<std::uint32_t>(status));
  header[6] = htonl(actual);
  header[7] = htonl(start_frame);
  header[8] = htonl(static_cast<std::uint32_t>(packet_words.size() / 4));
  std::vector<std::uint8_t> message(sizeof header + data.size() + packet_words.size() * 4);
  std::memcpy(message.data(), header.data(), sizeof header);
  std::copy(data.begin(), data.end(), message.begin() + sizeof header);
  if (!packet_words.empty())
    std::memcpy(message.data() + sizeof header + data.size(), packet_words.data(), packet_words.size() * 4);
  if (!write_exactly(message.data(), message.size())) unplugged_ = true;
  return Ok{};
}

Result<Attachment> attach_to_vhci() {
  std::ifstream status(std::string(kController) + "status");
  if (!status) return Error{ErrorCode::not_found, "no vhci_hcd here: modprobe vhci_hcd, as root"};
  Attachment made;
  std::string line;
  while (made.port < 0 && std::getline(status, line)) {
    std::istringstream columns(line);
    std::string hub, port, state;
    columns >> hub >> port >> state;
    if (hub == "hs" && state == "004") made.port = std::stoi(port);
  }
  if (made.port < 0) return Error{ErrorCode::io, "all high-speed ports of vhci_hcd are taken"};
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) return failed("making a socket pair");
  made.socket = ends[0];
  // Speed 3: high. The kernel takes a reference of its own to the socket.
  const std::string words = std::to_string(made.port) + " " + std::to_string(ends[1]) + " 65537 3";
  const int file = ::open((std::string(kController) + "attach").c_str(), O_WRONLY | O_CLOEXEC);
  const bool written = file >= 0 && ::write(file, words.data(), words.size()) == static_cast<ssize_t>(words.size());
  const Error error = failed("attaching to port " + std::to_string(made.port));
  if (file >= 0) ::close(file);
  ::close(ends[1]);
  if (written) return made;
  ::close(made.socket);
  return error;
}

Status detach_from_vhci(int port) {
  const std::string words = std::to_string(port);
  const int file = ::open((std::string(kController) + "detach").c_str(), O_WRONLY | O_CLOEXEC);
  const bool written = file >= 0 && ::write(file, words.data(), words.size()) == static_cast<ssize_t>(words.size());
  const Error error = failed("detaching port " + words);
  if (file >= 0) ::close(file);
  if (written) return Ok{};
  return error;
}

}  // namespace im2fit::devices
