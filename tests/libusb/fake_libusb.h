// SPDX-License-Identifier: Apache-2.0
// libusb's functions over device models, as far as hal/usb calls them and as its documentation says they behave: a
// transfer given is called back exactly once, by whichever thread handles events; cancelling is a request; a device
// that goes takes its transfers back with NO_DEVICE.
#pragma once

#include <cstdint>
#include <string>

#include "tests/devices/usb_device.h"

namespace im2fit::fake {

struct Port {
  std::string name;  // "1-1.2"
  devices::UsbDevice* device = nullptr;
  bool kernel_driver = true;  // has the interface while it is not claimed
  bool forbidden = false;     // may not be opened
  bool busy = false;          // another program has claimed it
  int refuse_submits_after = -1;
  int fail_transfers = 0;  // that many come back with an error
  int alternate_setting = 0;
  int times_detached = 0;
  std::int64_t now_us = 0;  // goes on with the transfers
};

// What is plugged in, one test at a time.
void reset();
Port& plug(const std::string& name, devices::UsbDevice& device);  // to be changed before it is opened
void unplug(const std::string& name);
Port port(const std::string& name);  // as it is now
void fail_transfers(const std::string& name, int count);
void refuse_submits_after(const std::string& name, int count);  // -1: never
void no_usb(bool none);                                         // libusb_init fails, as on a machine without USB
// A descriptor by which libusb_wrap_sys_device finds the device there.
void give_descriptor(int descriptor, const std::string& name);

// What libusb's caller still owes.
struct Debts {
  int contexts = 0;
  int handles = 0;
  int claims = 0;
  int transfers = 0;
  int in_flight = 0;
  int lists = 0;
  bool none() const { return contexts + handles + claims + transfers + in_flight + lists == 0; }
};
Debts debts();
int most_in_flight();
bool discovery_was_off();  // in the last context made

}  // namespace im2fit::fake
