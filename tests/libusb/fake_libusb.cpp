// SPDX-License-Identifier: Apache-2.0
#include "tests/libusb/fake_libusb.h"

#include <libusb.h>
#include <sys/time.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdarg>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

using im2fit::devices::SetupPacket;
using im2fit::devices::UsbDevice;
using im2fit::fake::Debts;
using im2fit::fake::Port;

namespace {

using Bytes = std::vector<std::uint8_t>;

struct Flight {
  libusb_transfer* transfer;
  libusb_context* context;
  bool cancelled = false;
};

}  // namespace

struct libusb_device {
  std::string port;
  int generation;
  UsbDevice* model;
  libusb_context* context;
};
struct libusb_device_handle {
  libusb_device device;
  bool detach = false;
  bool claimed = false;
  bool detached = false;
};
struct libusb_context {
  bool discovers = true;
  bool interrupted = false;
};

namespace {

struct World {
  std::mutex mutex;  // of everything here
  std::condition_variable changed;
  std::map<std::string, Port> ports;
  std::map<std::string, int> generations;
  std::map<int, std::string> descriptors;
  std::deque<Flight> flights;
  bool none = false;
  bool discovery_off = false;
  bool last_off = false;
  Debts debts;
  int most = 0;
  std::mutex events;  // libusb's event lock
};

World& world() {
  static World w;
  return w;
}

bool here(const libusb_device& device) {
  const auto found = world().ports.find(device.port);
  return found != world().ports.end() && found->second.device != nullptr &&
         world().generations[device.port] == device.generation;
}

std::uint16_t word(const Bytes& bytes, std::size_t i) {
  return static_cast<std::uint16_t>(bytes.at(i) + 256 * bytes.at(i + 1));
}

// Completes the oldest transfer of this context. Returns false without one. The world is unlocked while the owner is
// called.
bool complete_one(libusb_context* context) {
  std::unique_lock lock(world().mutex);
  auto& flights = world().flights;
  // A cancelled one first, then in order.
  auto at = std::find_if(flights.begin(), flights.end(),
                         [&](const Flight& f) { return f.context == context && f.cancelled; });
  if (at == flights.end())
    at = std::find_if(flights.begin(), flights.end(), [&](const Flight& f) { return f.context == context; });
  if (at == flights.end()) return false;
  const Flight flight = *at;
  flights.erase(at);
  libusb_transfer* t = flight.transfer;
  const libusb_device& device = t->dev_handle->device;
  t->status = LIBUSB_TRANSFER_COMPLETED;
  if (flight.cancelled) {
    t->status = LIBUSB_TRANSFER_CANCELLED;
  } else if (!here(device)) {
    t->status = LIBUSB_TRANSFER_NO_DEVICE;
  } else if (Port& port = world().ports.at(device.port); port.fail_transfers > 0) {
    --port.fail_transfers;
    t->status = LIBUSB_TRANSFER_ERROR;
  } else {
    std::uint8_t* buffer = t->buffer;
    for (int i = 0; i < t->num_iso_packets; ++i) {
      auto& packet = t->iso_packet_desc[i];
      port.now_us += 125;
      const Bytes bytes = port.device->read_packet(t->endpoint, packet.length, port.now_us);
      std::copy(bytes.begin(), bytes.end(), buffer);
      packet.actual_length = static_cast<unsigned>(bytes.size());
      packet.status = LIBUSB_TRANSFER_COMPLETED;
      buffer += packet.length;
    }
  }
  --world().debts.in_flight;
  lock.unlock();
  t->callback(t);
  return true;
}

}  // namespace

namespace im2fit::fake {

void reset() {
  const std::lock_guard lock(world().mutex);
  world().ports.clear();
  world().descriptors.clear();
  world().flights.clear();
  world().none = world().discovery_off = world().last_off = false;
  world().debts = {};
  world().most = 0;
}

Port& plug(const std::string& name, UsbDevice& device) {
  const std::lock_guard lock(world().mutex);
  Port& port = world().ports[name];
  port = Port{};
  port.name = name;
  port.device = &device;
  ++world().generations[name];
  return port;
}

void unplug(const std::string& name) {
  const std::lock_guard lock(world().mutex);
  world().ports.at(name).device = nullptr;
}

Port port(const std::string& name) {
  const std::lock_guard lock(world().mutex);
  return world().ports.at(name);
}

void fail_transfers(const std::string& name, int count) {
  const std::lock_guard lock(world().mutex);
  world().ports.at(name).fail_transfers = count;
}

void refuse_submits_after(const std::string& name, int count) {
  const std::lock_guard lock(world().mutex);
  world().ports.at(name).refuse_submits_after = count;
}

void no_usb(bool none) {
  world().none = none;
}

void give_descriptor(int descriptor, const std::string& name) {
  world().descriptors[descriptor] = name;
}

Debts debts() {
  const std::lock_guard lock(world().mutex);
  return world().debts;
}

int most_in_flight() {
  const std::lock_guard lock(world().mutex);
  return world().most;
}

bool discovery_was_off() {
  return world().last_off;
}

}  // namespace im2fit::fake

extern "C" {

int LIBUSB_CALL libusb_init(libusb_context** context) {
  const std::lock_guard lock(world().mutex);
  if (world().none && !world().discovery_off) return LIBUSB_ERROR_OTHER;
  *context = new libusb_context;
  (*context)->discovers = !world().discovery_off;
  world().last_off = world().discovery_off;
  ++world().debts.contexts;
  return 0;
}

void LIBUSB_CALL libusb_exit(libusb_context* context) {
  const std::lock_guard lock(world().mutex);
  --world().debts.contexts;
  delete context;
}

int LIBUSB_CALL libusb_set_option(libusb_context*, enum libusb_option option, ...) {
  const std::lock_guard lock(world().mutex);
  if (option == LIBUSB_OPTION_NO_DEVICE_DISCOVERY) world().discovery_off = true;
  return 0;
}

const char* LIBUSB_CALL libusb_strerror(int code) {
  switch (code) {
    case LIBUSB_ERROR_NO_DEVICE:
      return "No such device";
    case LIBUSB_ERROR_ACCESS:
      return "Access denied";
    case LIBUSB_ERROR_BUSY:
      return "Resource busy";
    default:
      return "Other error";
  }
}

ssize_t LIBUSB_CALL libusb_get_device_list(libusb_context* context, libusb_device*** list) {
  const std::lock_guard lock(world().mutex);
  std::vector<libusb_device*> devices;
  for (const auto& [name, port] : world().ports)
    if (port.device != nullptr && context->discovers)
      devices.push_back(new libusb_device{name, world().generations[name], port.device, context});
  *list = static_cast<libusb_device**>(std::calloc(devices.size() + 1, sizeof(libusb_device*)));
  std::copy(devices.begin(), devices.end(), *list);
  ++world().debts.lists;
  return static_cast<ssize_t>(devices.size());
}

void LIBUSB_CALL libusb_free_device_list(libusb_device** list, int) {
  const std::lock_guard lock(world().mutex);
  for (libusb_device** at = list; *at != nullptr; ++at) delete *at;
  std::free(list);
  --world().debts.lists;
}

int LIBUSB_CALL libusb_get_device_descriptor(libusb_device* device, struct libusb_device_descriptor* out) {
  const Bytes d = device->model->device_descriptor();
  *out = {};
  out->idVendor = word(d, 8);
  out->idProduct = word(d, 10);
  out->iSerialNumber = d.at(16);
  return 0;
}

std::uint8_t LIBUSB_CALL libusb_get_bus_number(libusb_device* device) {
  return static_cast<std::uint8_t>(std::atoi(device->port.c_str()));
}

int LIBUSB_CALL libusb_get_port_numbers(libusb_device* device, std::uint8_t* numbers, int) {
  int depth = 0;
  for (std::size_t at = device->port.find('-'); at != std::string::npos; at = device->port.find('.', at + 1))
    numbers[depth++] = static_cast<std::uint8_t>(std::atoi(device->port.c_str() + at + 1));
  return depth;
}

int LIBUSB_CALL libusb_open(libusb_device* device, libusb_device_handle** handle) {
  const std::lock_guard lock(world().mutex);
  if (!here(*device)) return LIBUSB_ERROR_NO_DEVICE;
  if (world().ports.at(device->port).forbidden) return LIBUSB_ERROR_ACCESS;
  *handle = new libusb_device_handle{*device};
  ++world().debts.handles;
  return 0;
}

int LIBUSB_CALL libusb_wrap_sys_device(libusb_context* context, intptr_t descriptor, libusb_device_handle** handle) {
  const std::lock_guard lock(world().mutex);
  const auto found = world().descriptors.find(static_cast<int>(descriptor));
  if (found == world().descriptors.end()) return LIBUSB_ERROR_OTHER;
  const Port& port = world().ports.at(found->second);
  if (port.device == nullptr) return LIBUSB_ERROR_NO_DEVICE;
  *handle = new libusb_device_handle{{port.name, world().generations[port.name], port.device, context}};
  ++world().debts.handles;
  return 0;
}

void LIBUSB_CALL libusb_close(libusb_device_handle* handle) {
  const std::lock_guard lock(world().mutex);
  --world().debts.handles;
  delete handle;
}

libusb_device* LIBUSB_CALL libusb_get_device(libusb_device_handle* handle) {
  return &handle->device;
}

int LIBUSB_CALL libusb_get_string_descriptor_ascii(libusb_device_handle* handle, std::uint8_t number,
                                                   unsigned char* data, int length) {
  const Bytes text = handle->device.model->string_descriptor(number);
  int count = 0;
  for (std::size_t i = 2; i < text.size() && count < length; i += 2) data[count++] = text[i];
  return count > 0 ? count : LIBUSB_ERROR_INVALID_PARAM;
}

int LIBUSB_CALL libusb_set_auto_detach_kernel_driver(libusb_device_handle* handle, int enable) {
  handle->detach = enable != 0;
  return 0;
}

int LIBUSB_CALL libusb_claim_interface(libusb_device_handle* handle, int) {
  const std::lock_guard lock(world().mutex);
  if (!here(handle->device)) return LIBUSB_ERROR_NO_DEVICE;
  Port& port = world().ports.at(handle->device.port);
  if (port.busy || (port.kernel_driver && !handle->detach)) return LIBUSB_ERROR_BUSY;
  handle->detached = port.kernel_driver;
  port.times_detached += port.kernel_driver ? 1 : 0;
  port.kernel_driver = false;
  port.busy = true;
  handle->claimed = true;
  ++world().debts.claims;
  return 0;
}

int LIBUSB_CALL libusb_release_interface(libusb_device_handle* handle, int) {
  const std::lock_guard lock(world().mutex);
  if (!handle->claimed) return LIBUSB_ERROR_NOT_FOUND;
  handle->claimed = false;
  --world().debts.claims;
  if (!here(handle->device)) return LIBUSB_ERROR_NO_DEVICE;
  Port& port = world().ports.at(handle->device.port);
  port.busy = false;
  port.kernel_driver = handle->detached;
  return 0;
}

int LIBUSB_CALL libusb_set_interface_alt_setting(libusb_device_handle* handle, int, int setting) {
  const std::lock_guard lock(world().mutex);
  if (!here(handle->device)) return LIBUSB_ERROR_NO_DEVICE;
  world().ports.at(handle->device.port).alternate_setting = setting;
  return 0;
}

int LIBUSB_CALL libusb_get_active_config_descriptor(libusb_device* device,
                                                    struct libusb_config_descriptor** configuration) {
  const std::lock_guard lock(world().mutex);
  if (!here(*device)) return LIBUSB_ERROR_NO_DEVICE;
  const Bytes bytes = device->model->configuration_descriptor();
  auto* c = new libusb_config_descriptor{};
  auto* interface = new libusb_interface[1];
  auto* settings = new libusb_interface_descriptor[8]{};
  int count = 0;
  for (std::size_t i = 0; i + 1 < bytes.size(); i += bytes[i]) {
    if (bytes[i + 1] == LIBUSB_DT_INTERFACE) {
      settings[count].bAlternateSetting = bytes[i + 3];
      settings[count].endpoint = new libusb_endpoint_descriptor[8]{};
      ++count;
    } else if (bytes[i + 1] == LIBUSB_DT_ENDPOINT) {
      libusb_interface_descriptor& setting = settings[count - 1];
      auto& endpoint = const_cast<libusb_endpoint_descriptor&>(setting.endpoint[setting.bNumEndpoints++]);
      endpoint.bEndpointAddress = bytes[i + 2];
      endpoint.bmAttributes = bytes[i + 3];
      endpoint.wMaxPacketSize = word(bytes, i + 4);
    }
  }
  interface[0] = {settings, count};
  c->bNumInterfaces = 1;
  c->interface = interface;
  *configuration = c;
  return 0;
}

void LIBUSB_CALL libusb_free_config_descriptor(struct libusb_config_descriptor* c) {
  for (int i = 0; i < c->interface[0].num_altsetting; ++i) delete[] c->interface[0].altsetting[i].endpoint;
  delete[] c->interface[0].altsetting;
  delete[] c->interface;
  delete c;
}

int LIBUSB_CALL libusb_control_transfer(libusb_device_handle* handle, std::uint8_t type, std::uint8_t request,
                                        std::uint16_t value, std::uint16_t index, unsigned char* data,
                                        std::uint16_t length, unsigned) {
  // A thread that waits for libusb handles events meanwhile, when no other does.
  if (std::unique_lock events(world().events, std::try_to_lock); events.owns_lock())
    complete_one(handle->device.context);
  const std::lock_guard lock(world().mutex);
  if (!here(handle->device)) return LIBUSB_ERROR_NO_DEVICE;
  const bool in = (type & 0x80) != 0;
  const auto answer = handle->device.model->control(
      SetupPacket{type, request, value, index, length},
      in ? std::span<const std::uint8_t>() : std::span<const std::uint8_t>(data, length),
      world().ports.at(handle->device.port).now_us);
  if (!answer) return LIBUSB_ERROR_PIPE;
  if (!in) return length;
  std::copy(answer->begin(), answer->end(), data);
  return static_cast<int>(answer->size());
}

struct libusb_transfer* LIBUSB_CALL libusb_alloc_transfer(int packets) {
  const std::lock_guard lock(world().mutex);
  ++world().debts.transfers;
  return static_cast<libusb_transfer*>(std::calloc(
      1, sizeof(libusb_transfer) + static_cast<std::size_t>(packets) * sizeof(libusb_iso_packet_descriptor)));
}

void LIBUSB_CALL libusb_free_transfer(struct libusb_transfer* transfer) {
  const std::lock_guard lock(world().mutex);
  for (const Flight& flight : world().flights)
    if (flight.transfer == transfer) std::abort();  // freed while in flight: the kernel would write into it
  --world().debts.transfers;
  std::free(transfer);
}

int LIBUSB_CALL libusb_submit_transfer(struct libusb_transfer* transfer) {
  {
    const std::lock_guard lock(world().mutex);
    const libusb_device& device = transfer->dev_handle->device;
    if (!here(device)) return LIBUSB_ERROR_NO_DEVICE;
    Port& port = world().ports.at(device.port);
    if (port.refuse_submits_after == 0) return LIBUSB_ERROR_NO_MEM;
    if (port.refuse_submits_after > 0) --port.refuse_submits_after;
    for (const Flight& flight : world().flights)
      if (flight.transfer == transfer) return LIBUSB_ERROR_BUSY;
    world().flights.push_back({transfer, device.context});
    world().most = std::max(world().most, ++world().debts.in_flight);
  }
  world().changed.notify_all();
  return 0;
}

int LIBUSB_CALL libusb_cancel_transfer(struct libusb_transfer* transfer) {
  const std::lock_guard lock(world().mutex);
  for (Flight& flight : world().flights) {
    if (flight.transfer != transfer) continue;
    flight.cancelled = true;
    return 0;
  }
  return LIBUSB_ERROR_NOT_FOUND;
}

void LIBUSB_CALL libusb_interrupt_event_handler(libusb_context* context) {
  {
    const std::lock_guard lock(world().mutex);
    context->interrupted = true;
  }
  world().changed.notify_all();
}

int LIBUSB_CALL libusb_handle_events_timeout_completed(libusb_context* context, struct timeval* limit, int*) {
  const std::lock_guard events(world().events);
  {
    std::unique_lock lock(world().mutex);
    world().changed.wait_for(lock, std::chrono::microseconds(limit->tv_sec * 1'000'000 + limit->tv_usec), [&] {
      const auto& flights = world().flights;
      return context->interrupted ||
             std::any_of(flights.begin(), flights.end(), [&](const Flight& f) { return f.context == context; });
    });
    context->interrupted = false;
  }
  complete_one(context);
  return 0;
}

}  // extern "C"
