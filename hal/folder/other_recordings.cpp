// SPDX-License-Identifier: Apache-2.0
#include "hal/folder/other_recordings.h"

#include <filesystem>
#include <map>
#include <string_view>
#include <vector>

#include "core/file.h"
#include "core/text.h"
#include "hal/folder/frame_name.h"

namespace im2fit::hal {
namespace {

constexpr int kFilesLookedAt = 10'000;  // of a folder: enough to tell what most are

std::string ending_of(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  for (char& c : ending) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return ending;
}

// For a shell.
std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return printable(out + "'");
}

// A text below with its file or folder (\1) and the folder to make (\2).
std::string filled(std::string_view text, const std::string& from, const std::string& to) {
  std::string out;
  for (const char c : text) {
    if (c == '\1')
      out += from;
    else if (c == '\2')
      out += to;
    else
      out += c;
  }
  return out;
}

struct Make {
  std::string_view ending, words;
};

// \1: the file, quoted. \2: a folder beside it, quoted.
constexpr Make kFiles[] = {
    {".db3",
     "is a rosbag of ROS 2; its depth becomes pictures by: ros2 bag play \1 beside ros2 run image_view "
     "image_saver --ros-args -r image:=/camera/depth/image_raw -p filename_format:=%06i.png"},
    {".mcap",
     "is a recording of ROS 2; its depth becomes pictures by: ros2 bag play \1 beside ros2 run image_view "
     "image_saver --ros-args -r image:=/camera/depth/image_raw -p filename_format:=%06i.png"},
    {".r3d",
     "is a recording of Record3D, whose depth is compressed with LZFSE; export it in the app as EXR + RGB sequence, "
     "and give the folder of its .exr files: im2fit then prints the command for these"},
    {".tar", "is an archive; unpack it, and give the folder: mkdir \2 && tar -xf \1 -C \2"},
    {".gz", "is an archive; unpack it, and give the folder: mkdir \2 && tar -xf \1 -C \2"},
    {".tgz", "is an archive; unpack it, and give the folder: mkdir \2 && tar -xf \1 -C \2"},
    {".mp4", "is a video: it has colours and no millimetres; record depth as 16-bit pictures (docs/cameras)"},
    {".mov", "is a video: it has colours and no millimetres; record depth as 16-bit pictures (docs/cameras)"},
    {".avi", "is a video: it has colours and no millimetres; record depth as 16-bit pictures (docs/cameras)"},
    {".png", "is one picture; give its folder, with a camera.yaml in it (docs/cameras)"},
    {".pgm", "is one picture; give its folder, with a camera.yaml in it (docs/cameras)"},
    {".tif", "is one picture; give its folder"},
    {".tiff", "is one picture; give its folder"},
    {".exr", "is one picture; give its folder"},
    {".npy", "is an array of NumPy; give its folder"},
    {".raw",
     "holds raw numbers; it becomes a folder by: im2fit-lab import-raw \1 --width W --height H --focal F "
     "--out \2"},
    {".bin",
     "holds raw numbers; it becomes a folder by: im2fit-lab import-raw \1 --width W --height H --focal F "
     "--out \2"},
    {".gltf", "is a mesh in several files; export it as one .glb"},
    {".fbx", "is a mesh of a kind that is not read; export it as .ply, .obj or .glb"},
    {".stl", "is a mesh of a kind that is not read; export it as .ply, .obj or .glb"},
    {".usdz", "is a mesh of a kind that is not read; export it as .ply, .obj or .glb"}};

// Python's own words for a picture a file; \1: the folder, quoted. Frames are numbered in order of their names.
constexpr std::string_view kNpyInMm =
    "python3 -c \"import sys,glob,numpy as n;from PIL import Image;[Image.fromarray(n.load(f).astype('uint16'))"
    ".save('%s/%06d.png'%(sys.argv[1],i)) for i,f in enumerate(sorted(glob.glob(sys.argv[1]+'/*.npy')))]\" \1";
constexpr std::string_view kNpyInMetres =
    "python3 -c \"import sys,glob,numpy as n;from PIL import "
    "Image;[Image.fromarray((n.nan_to_num(n.load(f))*1000).clip(0,65535).astype('uint16'))"
    ".save('%s/%06d.png'%(sys.argv[1],i)) for i,f in enumerate(sorted(glob.glob(sys.argv[1]+'/*.npy')))]\" \1";
constexpr std::string_view kExr =
    "OPENCV_IO_ENABLE_OPENEXR=1 python3 -c \"import sys,glob,cv2,numpy as "
    "n;[cv2.imwrite('%s/%06d.png'%(sys.argv[1],i),(n.nan_to_num(cv2.imread(f,-1).reshape(cv2.imread(f,-1).shape[:2]+"
    "(-1,))[:,:,0])*1000).clip(0,65535).astype('uint16')) for i,f in "
    "enumerate(sorted(glob.glob(sys.argv[1]+'/*.exr')))]\" \1";
constexpr std::string_view kTiff =
    "python3 -c \"import sys,glob,cv2,numpy as n;[cv2.imwrite('%s/%06d.png'%(sys.argv[1],i),(lambda a:a if "
    "a.dtype=='uint16' else (n.nan_to_num(a)*1000).clip(0,65535).astype('uint16'))(cv2.imread(f,-1))) for i,f in "
    "enumerate(sorted(glob.glob(sys.argv[1]+'/*.tif*')))]\" \1";
constexpr std::string_view kRaw = "im2fit-lab import-raw \1/*\3 --width W --height H --focal F --out \2";

// Of 'descr' in the header of a .npy file.
bool npy_is_float(const std::string& path) {
  std::vector<std::byte> bytes;
  if (!read_file_into(path, std::size_t{1} << 30, 256, bytes)) return false;
  const std::string_view head(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::size_t at = head.find("descr");
  return at != std::string_view::npos && head.substr(at, 16).find('f') != std::string_view::npos;
}

// Files of one ending: how many, and the first.
struct Kind {
  int count = 0;
  std::string first;
};
using Kinds = std::map<std::string, Kind>;

Kinds kinds_in(const std::string& folder) {
  Kinds kinds;
  std::error_code code;
  std::filesystem::directory_iterator it(folder, code);
  int seen = 0;
  for (const std::filesystem::directory_iterator end; !code && it != end && seen < kFilesLookedAt;
       it.increment(code), ++seen) {
    if (std::error_code kind; it->is_directory(kind)) continue;
    Kind& kind = kinds[ending_of(it->path())];
    ++kind.count;
    if (const std::string file = it->path().string(); kind.first.empty() || file < kind.first) kind.first = file;
  }
  return kinds;
}

bool has_frames(const std::string& folder) {
  std::error_code code;
  std::filesystem::directory_iterator it(folder, code);
  for (const std::filesystem::directory_iterator end; !code && it != end; it.increment(code))
    if (frame_number(it->path().filename().string())) return true;
  return false;
}

Error found(const std::string& folder, const std::string& ending, const Kind& kind, const std::string& words) {
  return {ErrorCode::unsupported, printable(folder) + " holds " + std::to_string(kind.count) + " " + ending +
                                      (kind.count == 1 ? " file" : " files") + " and no depth pictures; " + words};
}

std::optional<Error> explained(const std::string& folder) {
  const Kinds kinds = kinds_in(folder);
  const auto of = [&](const char* ending) {
    const auto it = kinds.find(ending);
    return it == kinds.end() ? nullptr : &it->second;
  };
  const std::string in = quoted(folder), out = quoted(folder + "-depth");
  const std::string then = "; then give --camera FILE, or put camera.yaml there (docs/cameras)";
  if (const Kind* npy = of(".npy"))
    return found(
        folder, ".npy", *npy,
        "they become pictures by: " + filled(npy_is_float(npy->first) ? kNpyInMetres : kNpyInMm, in, out) + then);
  if (const Kind* exr = of(".exr"))
    return found(folder, ".exr", *exr, "they become pictures by: " + filled(kExr, in, out) + then);
  for (const char* ending : {".tiff", ".tif"})
    if (const Kind* tiff = of(ending))
      return found(folder, ending, *tiff, "they become pictures by: " + filled(kTiff, in, out) + then);
  for (const char* ending : {".raw", ".bin"})
    if (const Kind* raw = of(ending)) {
      std::string command = filled(kRaw, in, out);
      command.replace(command.find('\3'), 1, ending);
      return found(folder, ending, *raw, "16-bit millimetres become a depth folder by: " + command);
    }
  for (const char* ending : {".png", ".pgm"})
    if (const Kind* png = of(ending))
      return found(folder, ending, *png,
                   "names like " + quoted(std::filesystem::path(png->first).filename().string()) +
                       " have no number: name 16-bit pictures in millimetres 000000.png, 000001.png ...");
  for (const char* ending : {".mp4", ".mov", ".avi", ".jpg", ".jpeg"})
    if (const Kind* colour = of(ending))
      return found(folder, ending, *colour,
                   "they have colours and no millimetres: export depth from the app, as PNG or EXR (docs/cameras)");
  for (const char* ending : {".mkv", ".bag", ".r3d", ".oni", ".db3", ".mcap", ".zip"})
    if (const Kind* file = of(ending))
      return found(folder, ending, *file, "give the file itself: " + quoted(file->first));
  return std::nullopt;
}

}  // namespace

std::optional<Error> other_recording(const std::string& path) {
  const std::string ending = ending_of(path);
  const std::string out = quoted(std::filesystem::path(path).replace_extension().string() + "-depth");
  for (const Make& make : kFiles)
    if (make.ending == ending)
      return Error{ErrorCode::unsupported, printable(path) + " " + filled(make.words, quoted(path), out)};
  return std::nullopt;
}

std::optional<Error> other_folder(const std::string& path) {
  if (has_frames(path)) return std::nullopt;
  if (has_frames(path + "/depth"))
    return Error{ErrorCode::not_found, printable(path) + " holds its depth pictures in depth/; give " +
                                           quoted(path + "/depth") +
                                           ", with a camera.yaml in it or --camera FILE (docs/cameras)"};
  if (auto error = explained(path)) return error;
  return explained(path + "/depth");
}

}  // namespace im2fit::hal
