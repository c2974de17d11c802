// SPDX-License-Identifier: Apache-2.0
#include "hal/open/open.h"

#include <filesystem>
#include <string_view>

#include "hal/folder/camera_yaml.h"
#include "hal/folder/depth_folder.h"
#include "hal/folder/other_recordings.h"
#include "hal/folder/scanner_3d_app.h"
#include "hal/folder/stray_scanner.h"
#include "hal/folder/tum_folder.h"
#include "hal/recording/bag_recording.h"
#include "hal/recording/kinect_recording.h"
#include "hal/recording/zip_folder.h"
#if IM2FIT_HAVE_OPENNI2
#include "hal/openni2/finder.h"
#include "hal/openni2/oni_source.h"
#include "hal/openni2/oni_writer.h"
#include "hal/openni2/openni2_source.h"
#endif
#if IM2FIT_HAVE_SCANS
#include "hal/scan/scan_source.h"
#endif
#if IM2FIT_HAVE_V4L2
#include "hal/v4l2/v4l2_source.h"
#endif
#if IM2FIT_HAVE_USB
#include "hal/usb/libusb_cameras.h"
#endif

namespace im2fit::hal {
namespace {

bool starts_with(const std::string& text, const std::string& head) {
  return text.rfind(head, 0) == 0;
}

// "openni2:URI" -> URI, "openni2" -> "", anything else -> none.
std::optional<std::string> after_scheme(const std::string& uri, const std::string& scheme) {
  if (uri == scheme) return "";
  if (starts_with(uri, scheme + ":")) return uri.substr(scheme.size() + 1);
  return std::nullopt;
}

// `ending` in lower case.
bool has_ending(const std::string& uri, std::string_view ending) {
  if (uri.size() <= ending.size()) return false;
  for (std::size_t i = 0; i < ending.size(); ++i) {
    const char c = uri[uri.size() - ending.size() + i];
    if ((c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c) != ending[i]) return false;
  }
  return true;
}

Result<std::unique_ptr<Source>> open_folder(const std::string& path, const OpenOptions& options) {
  FolderOptions wanted;
  wanted.rotate_deg = options.rotate_deg;
  wanted.camera_yaml_path = options.camera_yaml_path;
  wanted.unit_mm = options.unit_mm;
  constexpr std::pair<bool (*)(const std::string&), decltype(&open_stray_scanner)> kRecorders[] = {
      {is_stray_scanner, open_stray_scanner},
      {is_scanner_3d_app, open_scanner_3d_app},
      {is_tum_folder, open_tum_folder}};
  for (const auto& [is_theirs, open] : kRecorders) {
    if (!is_theirs(path)) continue;
    auto source = open(path, wanted);
    if (!source) return source.error();
    return std::unique_ptr<Source>(std::move(*source));
  }
  auto source = FolderSource::open(path, wanted);
  if (!source && source.error().code == ErrorCode::not_found)
    if (auto other = other_folder(path)) return *other;
  if (!source) return source.error();
  return std::unique_ptr<Source>(std::move(*source));
}

[[maybe_unused]] Result<std::optional<CameraFile>> calibration(const std::string& path, bool must_exist,
                                                               PictureSize pictures = {}) {
  std::error_code code;
  if (path.empty() || (!must_exist && !std::filesystem::exists(path, code))) return std::optional<CameraFile>{};
  auto file = load_camera_yaml(path, pictures);
  if (!file) return file.error();
  return std::optional<CameraFile>{*file};
}

// Calibration and mounting of a camera or recording; the caller's word for the mounting wins over the file's.
template <class Wanted>
void take_calibration(const std::optional<CameraFile>& file, const OpenOptions& options, Wanted& wanted) {
  if (file) {
    wanted.calibration = *file;
    wanted.rotate_deg = file->rotate_deg.value_or(0);
  }
  wanted.rotate_deg = options.rotate_deg.value_or(wanted.rotate_deg);
}

#if IM2FIT_HAVE_USB
Result<std::unique_ptr<Source>> open_usb(const std::string& device, const OpenOptions& options) {
  const auto file = calibration(options.camera_yaml_path, true, {options.width, options.height});
  if (!file) return file.error();
  KinectOptions wanted;
  take_calibration(*file, options, wanted);
  auto source = open_usb_camera(device, wanted);
  if (!source) return source.error();
  return std::unique_ptr<Source>(std::move(*source));
}
Result<std::vector<DeviceEntry>> list_usb() {
  const auto found = list_usb_cameras();
  if (!found) return found.error();
  std::vector<DeviceEntry> devices;
  for (const auto& camera : *found) devices.push_back({"usb:" + camera.id, camera.name});
  return devices;
}
#else
Result<std::unique_ptr<Source>> open_usb(const std::string&, const OpenOptions&) {
  return Error{
      ErrorCode::unsupported,
      "usb needs libusb, which is not in this build; install libusb-1.0-0-dev and build with usb in IM2FIT_SOURCES"};
}
Result<std::vector<DeviceEntry>> list_usb() {
  return std::vector<DeviceEntry>{};
}
#endif

#if IM2FIT_HAVE_OPENNI2
Result<OpenNi2Options> camera_options(const OpenOptions& options) {
  const auto file = calibration(options.camera_yaml_path, true, {options.width, options.height});
  if (!file) return file.error();
  OpenNi2Options wanted;
  wanted.width = options.width;
  wanted.height = options.height;
  take_calibration(*file, options, wanted);
  return wanted;
}

Result<std::unique_ptr<Source>> open_camera(const std::string& device, const OpenOptions& options) {
  const auto wanted = camera_options(options);
  if (!wanted) return wanted.error();
  auto source = OpenNi2Source::open(device, *wanted);
  if (!source) return source.error();
  return std::unique_ptr<Source>(std::move(*source));
}

Result<std::vector<DeviceEntry>> list_openni2() {
  auto found = list_openni2_devices();
  if (!found) return found.error();
  std::vector<DeviceEntry> devices;
  for (const auto& device : *found) devices.push_back({"openni2:" + device.uri, device.name});
  return devices;
}

ReconnectingSource::Opener openni2_opener(const std::string& device, const OpenOptions& options) {
  return [device, options,
          finder = std::make_shared<OpenNi2Finder>()](const SourceInfo* lost) -> Result<std::unique_ptr<Source>> {
    const auto wanted = camera_options(options);
    if (!wanted) return wanted.error();
    auto source = lost == nullptr ? finder->open(device, *wanted) : finder->find(*lost, *wanted);
    if (!source) return source.error();
    return std::unique_ptr<Source>(std::move(*source));
  };
}

// The format has no checksum: a changed byte gives wrong depths and no error. Our own recordings are known by theirs.
Status check_crc(const std::string& path, const CameraFile& beside) {
  if (!beside.oni_crc32c) return Ok{};
  const auto crc = oni_crc32c(path);
  if (!crc) return crc.error();
  if (*crc == *beside.oni_crc32c) return Ok{};
  return Error{ErrorCode::corrupt, path +
                                       " is not as it was recorded (its checksum differs from the one in its .yaml); "
                                       "copy or record it again"};
}

Result<std::unique_ptr<Source>> open_recording(const std::string& path, const OpenOptions& options) {
  const bool given = !options.camera_yaml_path.empty();
  const auto file = calibration(given ? options.camera_yaml_path : oni_sidecar_path(path), given);
  if (!file) return file.error();
  OniOptions wanted;
  wanted.stall_ms = options.stall_ms;
  if (*file)
    if (auto ok = check_crc(path, **file); !ok) return ok.error();
  take_calibration(*file, options, wanted);
  auto source = OniSource::open(path, wanted);
  if (!source) return source.error();
  return std::unique_ptr<Source>(std::move(*source));
}
#else
Error no_openni2(const std::string& what) {
  return {ErrorCode::unsupported, what +
                                      " needs OpenNI2, which is not in this build; install libopenni2-dev and build "
                                      "with openni2 in IM2FIT_SOURCES"};
}
Result<std::unique_ptr<Source>> open_camera(const std::string&, const OpenOptions&) {
  return no_openni2("openni2");
}
Result<std::unique_ptr<Source>> open_recording(const std::string& path, const OpenOptions&) {
  return no_openni2(path);
}
Result<std::vector<DeviceEntry>> list_openni2() {
  return std::vector<DeviceEntry>{};
}
#endif

#if IM2FIT_HAVE_V4L2
Result<std::unique_ptr<Source>> open_v4l2(const std::string& device, const OpenOptions& options) {
  const auto file = calibration(options.camera_yaml_path, true, {options.width, options.height});
  if (!file) return file.error();
  V4l2Options defaults;
  defaults.width = options.width;
  defaults.height = options.height;
  take_calibration(*file, options, defaults);
  const auto wanted = parse_v4l2_uri(device, defaults);
  if (!wanted) return wanted.error();
  auto source = V4l2Source::open(*wanted);
  if (!source) return source.error();
  return std::unique_ptr<Source>(std::move(*source));
}
Result<std::vector<DeviceEntry>> list_v4l2() {
  std::vector<DeviceEntry> devices;
  for (const auto& device : list_v4l2_devices()) devices.push_back({"v4l2:" + device.path, device.name});
  return devices;
}
#else
Result<std::unique_ptr<Source>> open_v4l2(const std::string& device, const OpenOptions&) {
  return Error{ErrorCode::unsupported, "v4l2:" + device +
                                           ": V4L2 cameras are not in this build; use openni2, a .oni "
                                           "recording or a depth folder"};
}
Result<std::vector<DeviceEntry>> list_v4l2() {
  return std::vector<DeviceEntry>{};
}
#endif

}  // namespace

bool is_scan([[maybe_unused]] const std::string& uri) {
#if IM2FIT_HAVE_SCANS
  std::error_code code;
  return is_scan_name(uri) && !std::filesystem::is_directory(uri, code);
#else
  return false;
#endif
}

Result<std::unique_ptr<Source>> open_source(const std::string& uri, const OpenOptions& options) {
  if (options.rotate_deg && !is_rotation(*options.rotate_deg))
    return Error{ErrorCode::invalid_argument,
                 "rotation is " + std::to_string(*options.rotate_deg) + ", expected 0, 90, 180 or 270 degrees"};
  std::error_code code;
  if (options.unit_mm != 0 && options.unit_mm != 1 && !is_scan(uri) && !has_ending(uri, ".zip") &&
      !std::filesystem::is_directory(uri, code))
    return Error{ErrorCode::invalid_argument, uri + ": a unit can be given of depth folders and scans only"};
  if (const auto seed = after_scheme(uri, "synthetic")) {
    if (options.synthetic) return options.synthetic(*seed, options);
    return Error{ErrorCode::unsupported, uri + ": this program has no synthetic camera; use a camera or a recording"};
  }
  if (const auto device = after_scheme(uri, "openni2")) return open_camera(*device, options);
  if (const auto device = after_scheme(uri, "v4l2")) return open_v4l2(*device, options);
  if (const auto device = after_scheme(uri, "usb")) return open_usb(*device, options);
  const auto status = std::filesystem::status(uri, code);
  if (std::filesystem::is_directory(status)) return open_folder(uri, options);
  if (!std::filesystem::exists(status))
    return Error{ErrorCode::not_found, uri +
                                           " does not exist; expected openni2[:URI], usb[:SERIAL], v4l2[:NODE], "
                                           "synthetic[:SEED], a .oni, .mkv, .bag or .zip "
                                           "file, the folder of a recording or a scan (.ply, .obj, .glb, .pcd)"};
  if (has_ending(uri, ".oni")) return open_recording(uri, options);
  if (has_ending(uri, ".zip"))
    return open_zip(uri, [&](const std::string& folder) { return open_folder(folder, options); });
  if (has_ending(uri, ".bag")) return open_bag_recording(uri, {options.rotate_deg, options.camera_yaml_path});
  if (has_ending(uri, ".mkv")) return open_kinect_recording(uri, {options.rotate_deg, options.camera_yaml_path});
#if IM2FIT_HAVE_SCANS
  if (is_scan(uri) && (options.rotate_deg.value_or(0) != 0 || !options.camera_yaml_path.empty()))
    return Error{ErrorCode::invalid_argument, uri + ": a scan has no camera; leave out --rotate and --camera"};
  if (is_scan(uri)) return open_scan(uri, {options.unit_mm, options.scan_up});
#endif
  if (auto other = other_recording(uri)) return *other;
  return Error{
      ErrorCode::unsupported,
      uri +
          " is neither a folder nor a recording (.oni, .mkv, .bag, .zip); expected one of these or a scan (.ply, "
          ".obj, .glb, .pcd)"};
}

ReconnectingSource::Opener camera_opener(const std::string& uri, const OpenOptions& options) {
  OpenOptions kept = options;
  kept.synthetic = nullptr;  // no camera needs it, and it may not live as long
#if IM2FIT_HAVE_OPENNI2
  if (const auto device = after_scheme(uri, "openni2")) return openni2_opener(*device, kept);
#endif
  for (const char* scheme : {"openni2", "usb", "v4l2"}) {
    if (!after_scheme(uri, scheme)) continue;
    // By the URI it had when it was open, else by the caller's URI: the first camera of its kind.
    return [uri, kept](const SourceInfo* lost) {
      if (lost == nullptr || lost->uri == uri) return open_source(uri, kept);
      auto known = open_source(lost->uri, kept);
      return known ? std::move(known) : open_source(uri, kept);
    };
  }
  return nullptr;
}

Result<std::unique_ptr<Source>> open_reconnecting(const std::string& uri, const OpenOptions& options,
                                                  const ReconnectOptions& reconnect) {
  auto opener = camera_opener(uri, options);
  if (!opener) return open_source(uri, options);
  auto source = ReconnectingSource::open(std::move(opener), reconnect);
  if (!source) return source.error();
  return std::unique_ptr<Source>(std::move(*source));
}

Result<std::vector<DeviceEntry>> list_devices() {
  std::vector<DeviceEntry> devices;
  std::optional<Error> failed;
  // One library that does not start must not hide the cameras of another.
  for (const auto& list : {list_openni2, list_usb, list_v4l2}) {
    const auto found = list();
    if (found)
      devices.insert(devices.end(), found->begin(), found->end());
    else if (!failed)
      failed = found.error();
  }
  if (devices.empty() && failed) return *failed;
  return devices;
}

}  // namespace im2fit::hal
