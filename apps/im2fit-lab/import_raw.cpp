// SPDX-License-Identifier: Apache-2.0
// Headerless little-endian uint16 frames in mm, as libfreenect tools dump them, into a depth folder.
#include <fmt/core.h>

#include <cstring>

#include "apps/im2fit-lab/commands.h"
#include "core/file.h"
#include "hal/folder/depth_folder.h"

namespace im2fit::apps {
namespace {

struct ImportOptions {
  std::vector<std::string> files;
  std::string out;
  int width = 640;
  int height = 480;
  double focal = 575.8;
  int rotate_deg = 0;
};

Result<std::vector<std::uint16_t>> read_raw(const std::string& path, std::size_t pixel_count) {
  const auto bytes = read_file(path);
  if (!bytes) return bytes.error();
  if (bytes->size() != pixel_count * 2)
    return Error{ErrorCode::corrupt,
                 fmt::format("{}: {} bytes, expected {} ({} pixels of 2); check --width, --height", path,
                             bytes->size(), pixel_count * 2, pixel_count)};
  std::vector<std::uint16_t> pixels(pixel_count);
  for (std::size_t i = 0; i < pixel_count; ++i)
    pixels[i] = static_cast<std::uint16_t>(std::to_integer<unsigned>((*bytes)[2 * i]) |
                                           std::to_integer<unsigned>((*bytes)[2 * i + 1]) << 8U);
  return pixels;
}

Result<int> run_import(const ImportOptions& options) {
  const auto pixel_count = static_cast<std::size_t>(options.width) * static_cast<std::size_t>(options.height);
  // All files are read before the folder is made: a bad one leaves nothing behind.
  std::vector<std::vector<std::uint16_t>> frames;
  for (const auto& path : options.files) {
    auto pixels = read_raw(path, pixel_count);
    if (!pixels) return pixels.error();
    frames.push_back(std::move(*pixels));
  }
  const auto focal = static_cast<float>(options.focal);
  const Intrinsics k{options.width,
                     options.height,
                     focal,
                     focal,
                     static_cast<float>(options.width - 1) / 2,
                     static_cast<float>(options.height - 1) / 2};
  hal::FolderWriter::Options writing;
  writing.camera_name = "imported raw depth";
  writing.rotate_deg = options.rotate_deg;
  auto writer = hal::FolderWriter::create(options.out, k, writing);
  if (!writer) return writer.error();
  for (std::size_t i = 0; i < frames.size(); ++i) {
    hal::FrameInfo info;
    info.sequence = i;
    info.host_ns = static_cast<std::int64_t>(i) * 33'333'333;
    const DepthView view(frames[i].data(), options.width, options.height);
    if (const auto written = (*writer)->write(view, info); !written) return written.error();
  }
  if (const auto finished = (*writer)->finish(); !finished) return finished.error();
  fmt::print("{}: {} frames\n", options.out, frames.size());
  return kExitOk;
}

}  // namespace

void add_import_raw(cli::App& app, Command& chosen) {
  auto options = std::make_shared<ImportOptions>();
  auto* sub = add_command<ImportOptions>(app, chosen, "import-raw",
                                         "Convert raw uint16 depth frames (little-endian, mm) to a depth folder",
                                         "  im2fit-lab import-raw frame1 frame2 --out folder\n"
                                         "  im2fit-lab import-raw registered.raw --focal 525 --out folder",
                                         options, run_import);
  sub->add_option("FILES", options->files, "Raw frames, in order")->required();
  sub->add_option("--out", options->out, "Folder to make")->required()->type_name("DIR");
  sub->add_option("--width", options->width, "Pixels per row")->range(1, 2048)->capture_default_str();
  sub->add_option("--height", options->height, "Rows")->range(1, 2048)->capture_default_str();
  sub->add_option("--focal", options->focal, "Focal length, px (Kinect depth 575.8; registered to colour 525)")
      ->range(50.0, 10000.0)
      ->capture_default_str();
  sub->add_option("--rotate", options->rotate_deg, "Mounting of the camera, degrees")
      ->one_of({0, 90, 180, 270})
      ->capture_default_str();
}

}  // namespace im2fit::apps
