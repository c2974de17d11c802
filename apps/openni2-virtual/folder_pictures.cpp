// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "hal/folder/depth_folder.h"
#include "pictures.h"

namespace im2fit::openni2_virtual {
namespace {

constexpr std::size_t kPicturesMax = 600;  // 20 s; at 640 x 480 they take 370 MB

class FolderPictures final : public Pictures {
 public:
  FolderPictures(const Intrinsics& camera, std::vector<std::vector<std::uint16_t>> pictures)
      : camera_(camera), pictures_(std::move(pictures)) {}
  const Intrinsics& camera() const override { return camera_; }
  void make(std::uint64_t index, DepthImage out) override {
    const auto& from = pictures_[static_cast<std::size_t>(index % pictures_.size())];
    std::memcpy(out.pixels, from.data(), from.size() * sizeof(std::uint16_t));
  }

 private:
  Intrinsics camera_;
  std::vector<std::vector<std::uint16_t>> pictures_;
};

}  // namespace

Result<std::unique_ptr<Pictures>> folder_pictures(const Settings& settings) {
  hal::FolderOptions options;
  options.rotate_deg = 0;
  auto source = hal::FolderSource::open(settings.folder, options);
  if (!source) return source.error();
  const Intrinsics& k = (*source)->info().intrinsics;
  // OpenNI2 devices tell a field of view and nothing of the principal point.
  if (std::abs(k.cx - 0.5F * static_cast<float>(k.width - 1)) > 1 ||
      std::abs(k.cy - 0.5F * static_cast<float>(k.height - 1)) > 1)
    return Error{ErrorCode::unsupported,
                 settings.folder +
                     ": the principal point is off the centre, which an OpenNI2 device cannot report; "
                     "replay the folder itself"};
  std::vector<std::vector<std::uint16_t>> pictures;
  while (pictures.size() < kPicturesMax) {
    std::vector<std::uint16_t> picture(static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height));
    auto frame = (*source)->next(DepthImage(picture.data(), k.width, k.height), 0);
    if (!frame && frame.error().code == ErrorCode::end_of_stream) break;
    if (!frame) return frame.error();
    pictures.push_back(std::move(picture));
  }
  return std::unique_ptr<Pictures>(new FolderPictures(k, std::move(pictures)));
}

}  // namespace im2fit::openni2_virtual
