// SPDX-License-Identifier: Apache-2.0
#include "hal/openni2/runtime.h"

#include <OniCAPI.h>

#include <algorithm>
#include <mutex>

#ifdef __clang__
#pragma clang diagnostic ignored "-Wreserved-identifier"  // the sanitizers' own names
#endif

#if defined(__SANITIZE_ADDRESS__)
// The runtime forgets buffers of its own (of its recorder on a full disk, of its driver list).
extern "C" const char* __lsan_default_options() {
  return "print_suppressions=0";
}
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libOpenNI2\nleak:libOniFile\nleak:libPS1080\nleak:libPSLink\n";
}
#elif defined(__SANITIZE_THREAD__)
// The runtime is not built for this sanitizer, and takes and frees locks in ways of its own.
extern "C" const char* __tsan_default_suppressions() {
  return "mutex:libOpenNI2\ndeadlock:libOpenNI2\nrace:libOpenNI2\nrace:libOniFile\nrace:libPS1080\nrace:libPSLink\n";
}
#endif

namespace im2fit::hal {
namespace {

std::mutex runtime_mutex;
std::weak_ptr<OpenNi2Runtime> runtime_in_use;

Result<std::shared_ptr<OpenNi2Runtime>> begin() {
  if (oniInitialize(ONI_API_VERSION) == ONI_STATUS_OK) return std::make_shared<OpenNi2Runtime>();
  Error error{ErrorCode::unsupported, "the OpenNI2 runtime does not start (" + openni2_complaint() +
                                          "); is libopenni2-0 installed with its drivers?"};
  oniShutdown();
  return error;
}

}  // namespace

// Not kept for the process in a static: that would end it after the drivers' own statics are gone.
Result<std::shared_ptr<OpenNi2Runtime>> OpenNi2Runtime::get() {
  const std::lock_guard lock(runtime_mutex);
  if (auto runtime = runtime_in_use.lock()) return runtime;
  auto begun = begin();
  if (!begun) return begun;
  runtime_in_use = *begun;
#if defined(__SANITIZE_ADDRESS__)
  // Drivers that are unloaded before the leak checker looks cannot be named in its suppressions: they stay loaded.
  static std::shared_ptr<OpenNi2Runtime>* volatile kept = nullptr;
  kept = new std::shared_ptr<OpenNi2Runtime>(*begun);
  (void)kept;  // volatile: read, so that the pointer is a root the checker sees
#endif
  return begun;
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
  if (begin == std::string::npos) return "it reports no reason";
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
  devices.reserve(static_cast<std::size_t>(std::max(count, 0)));
  for (int i = 0; i < count; ++i) devices.push_back({list[i].uri, std::string(list[i].vendor) + " " + list[i].name});
  oniReleaseDeviceList(list);
  return devices;
}

}  // namespace im2fit::hal
