// SPDX-License-Identifier: Apache-2.0
#include "hal/usb/libusb_stream.h"

#include <sys/time.h>

#include <chrono>
#include <optional>
#include <span>
#include <string>
#include <system_error>
#include <utility>

namespace im2fit::hal {
namespace {

constexpr int kFailuresMax = 500;  // transfers of some milliseconds each: longer than a passing disturbance

}  // namespace

Result<std::unique_ptr<LibusbStream>> LibusbStream::start(LibusbContext context, libusb_device_handle* handle,
                                                          const UsbStreamSettings& settings, int packet_bytes,
                                                          UsbPacketSink& sink) {
  std::unique_ptr<LibusbStream> stream(new LibusbStream(std::move(context), sink));
  if (auto ok = stream->submit(handle, settings, packet_bytes); !ok) return ok.error();
  return stream;
}

Status LibusbStream::submit(libusb_device_handle* handle, const UsbStreamSettings& settings, int packet_bytes) {
  const int transfer_bytes = settings.packets_per_transfer * packet_bytes;
  buffer_.resize(static_cast<std::size_t>(settings.transfers) * static_cast<std::size_t>(transfer_bytes));
  transfers_.reserve(static_cast<std::size_t>(settings.transfers));  // one allocated is never lost
  std::optional<Error> failed;
  {
    const std::lock_guard lock(mutex_);
    for (int i = 0; i < settings.transfers && !failed; ++i) {
      libusb_transfer* transfer = libusb_alloc_transfer(settings.packets_per_transfer);
      if (transfer == nullptr) {
        failed = Error{ErrorCode::io, "no memory for USB transfers"};
        break;
      }
      transfers_.push_back(transfer);
      libusb_fill_iso_transfer(transfer, handle, settings.endpoint,
                               buffer_.data() + static_cast<std::ptrdiff_t>(i) * transfer_bytes, transfer_bytes,
                               settings.packets_per_transfer, on_done, this, 0);
      libusb_set_iso_packet_lengths(transfer, static_cast<unsigned>(packet_bytes));
      if (const int code = libusb_submit_transfer(transfer); code < 0)
        failed = libusb_error(
            code, "transfer " + std::to_string(i + 1) + " of " + std::to_string(settings.transfers) + " is refused");
      else
        ++in_flight_;
    }
  }
  if (failed) return *failed;
  try {
    events_ = std::thread([this] { handle_events(); });
  } catch (const std::system_error& error) {
    return Error{ErrorCode::io, std::string("no thread can be started for its transfers (") + error.what() +
                                    "); end other programs or raise the limit on processes (ulimit -u)"};
  }
  return Ok{};
}

LibusbStream::~LibusbStream() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  // No transfer is submitted from here on. Cancelling a completed transfer fails harmlessly (not found).
  for (libusb_transfer* transfer : transfers_) libusb_cancel_transfer(transfer);
  libusb_interrupt_event_handler(context_.get());
  // Without an event thread (start() failed) the destroying thread handles the cancelled transfers: libusb must not
  // own a transfer when it is freed.
  if (events_.joinable())
    events_.join();
  else
    handle_events();
  for (libusb_transfer* transfer : transfers_) libusb_free_transfer(transfer);
}

bool LibusbStream::drained() {
  const std::lock_guard lock(mutex_);
  return in_flight_ == 0;
}

void LibusbStream::handle_events() {
  // Nothing in flight means stopped or over: completed transfers go back into flight before they are left.
  while (!drained()) {
    timeval limit{0, 100'000};
    const int code = libusb_handle_events_timeout_completed(context_.get(), &limit, nullptr);
    if (code < 0 && code != LIBUSB_ERROR_INTERRUPTED) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

void LIBUSB_CALL LibusbStream::on_done(libusb_transfer* transfer) {
  static_cast<LibusbStream*>(transfer->user_data)->done(transfer);
}

void LibusbStream::deliver(libusb_transfer* transfer) {
  const std::uint8_t* at = transfer->buffer;
  for (int i = 0; i < transfer->num_iso_packets; ++i) {
    const libusb_iso_packet_descriptor& packet = transfer->iso_packet_desc[i];
    if (packet.status == LIBUSB_TRANSFER_COMPLETED && packet.actual_length > 0 &&
        packet.actual_length <= packet.length)
      sink_.packet(std::span(at, packet.actual_length));
    at += packet.length;
  }
}

void LibusbStream::done(libusb_transfer* transfer) {
  std::optional<Error> why;
  {
    const std::lock_guard lock(mutex_);
    if (stopping_ || over_) {
      --in_flight_;
      return;
    }
  }
  if (transfer->status == LIBUSB_TRANSFER_COMPLETED) deliver(transfer);
  {
    const std::lock_guard lock(mutex_);
    failures_ = transfer->status == LIBUSB_TRANSFER_COMPLETED ? 0 : failures_ + 1;
    if (!stopping_) {
      // Unplugging shows as NO_DEVICE, or as a cancellation that was not requested.
      if (transfer->status == LIBUSB_TRANSFER_NO_DEVICE || transfer->status == LIBUSB_TRANSFER_CANCELLED)
        why = Error{ErrorCode::no_device, "the device was unplugged"};
      else if (failures_ > kFailuresMax)
        why = Error{ErrorCode::io,
                    "transfers fail one after the other (libusb status " + std::to_string(transfer->status) + ")"};
      else if (const int code = libusb_submit_transfer(transfer); code < 0)
        why = libusb_error(code, "a transfer is refused");
      else
        return;
    }
    over_ = over_ || why;
    // Reported below, while this transfer still keeps the stream from being taken apart.
    if (!why) {
      --in_flight_;
      return;
    }
  }
  sink_.ended(*why);
  const std::lock_guard lock(mutex_);
  --in_flight_;
}

}  // namespace im2fit::hal
