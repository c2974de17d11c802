// SPDX-License-Identifier: Apache-2.0
#include "hal/openni2/runtime.h"

#include <OniCAPI.h>

#include <mutex>

namespace im2fit::hal {
namespace {
std::mutex runtime_mutex;
std::weak_ptr<OpenNi2Runtime> runtime_in_use;
}  // namespace

Result<std::shared_ptr<OpenNi2Runtime>> OpenNi2Runtime::get() {
  const std::lock_guard lock(runtime_mutex);
  if (auto runtime = runtime_in_use.lock()) return runtime;
  if (oniInitialize(ONI_API_VERSION) != ONI_STATUS_OK) {
    Error error{ErrorCode::unsupported, "the OpenNI2 runtime does not start (" + openni2_complaint() +
                                            "); is libopenni2-0 installed with its drivers?"};
    oniShutdown();
    return error;
  }
  std::shared_ptr<OpenNi2Runtime> runtime(new OpenNi2Runtime);
  runtime_in_use = runtime;
  return runtime;
}

OpenNi2Runtime::~OpenNi2Runtime() {
  const std::lock_guard lock(runtime_mutex);
  oniShutdown();
}

std::string openni2_complaint() {
  std::string text = oniGetExtendedError();
  for (char& c : text)
    if (c == '\n' || c == '\t' || c == '\r') c = ' ';
  const auto begin = text.find_first_not_of(' ');
  if (begin == std::string::npos) return "it gives no reason";
  return text.substr(begin, text.find_last_not_of(' ') + 1 - begin);
}

Result<std::vector<OpenNi2Device>> list_openni2_devices() {
  auto runtime = OpenNi2Runtime::get();
  if (!runtime) return runtime.error();
  OniDeviceInfo* list = nullptr;
  int count = 0;
  if (oniGetDeviceList(&list, &count) != ONI_STATUS_OK)
    return Error{ErrorCode::io, "OpenNI2 cannot list its cameras (" + openni2_complaint() + ")"};
  std::vector<OpenNi2Device> devices;
  for (int i = 0; i < count; ++i) devices.push_back({list[i].uri, std::string(list[i].vendor) + " " + list[i].name});
  oniReleaseDeviceList(list);
  return devices;
}

}  // namespace im2fit::hal
