// SPDX-License-Identifier: Apache-2.0
// Six people in trousers and a T-shirt look as they did: front, left side and back against pictures in dressed/.
//
// IM2FIT_WRITE_PICTURES=DIR writes those of today: look at them before they take the old ones' places.
#include <gtest/gtest.h>
#include <png.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "body_pack.h"
#include "core/file.h"
#include "report/dressed_picture.h"
#include "train/dressed/dressed_people.h"

namespace im2fit::lab {
namespace {

using body::real_body;

constexpr int kWidth = 100, kHeight = 215;  // pixels, of a view: 9 mm each

// Grey values of a picture, each the mean of 3 x 3 pixels: an edge that moved by less than a pixel does not count.
struct Grey {
  int width = 0, height = 0;
  std::vector<float> at;
};

template <class F>
Grey blurred(int width, int height, F value) {
  Grey grey{width, height, {}};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      float sum = 0;
      int count = 0;
      for (int v = std::max(0, y - 1); v <= std::min(height - 1, y + 1); ++v)
        for (int u = std::max(0, x - 1); u <= std::min(width - 1, x + 1); ++u, ++count) sum += value(u, v);
      grey.at.push_back(sum / static_cast<float>(count));
    }
  return grey;
}

Grey grey_of(const Canvas& canvas) {
  return blurred(canvas.width(), canvas.height(), [&](int x, int y) {
    const Rgb c = canvas.at(x, y);
    return static_cast<float>(c.r + c.g + c.b) / 3;
  });
}

Grey read(const std::string& path) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_file(&image, path.c_str()) == 0) return {};
  image.format = PNG_FORMAT_RGB;
  std::vector<png_byte> pixels(PNG_IMAGE_SIZE(image));
  if (png_image_finish_read(&image, nullptr, pixels.data(), 0, nullptr) == 0) return {};
  const auto width = static_cast<int>(image.width);
  return blurred(width, static_cast<int>(image.height), [&](int x, int y) {
    const auto at = 3 * static_cast<std::size_t>(y * width + x);
    return static_cast<float>(pixels[at] + pixels[at + 1] + pixels[at + 2]) / 3;
  });
}

Canvas picture_of(const DressedPerson& person) {
  body::Outfit outfit(*real_body(), pieces_for(person, {"trousers", "t_shirt"}));
  outfit.dress(person.rest, person.skeleton, dressed_poses(*real_body(), person)[0].pose);
  std::vector<LinearColour> colours;
  for (const char* id : {"trousers", "t_shirt"}) colours.push_back(builtin_wardrobe().garment(id)->colour);
  PictureFrame frame;
  frame.width = kWidth;
  frame.height = kHeight;
  frame.middle_z_mm = person.skeleton.head[0].z;
  float low = 1e9F;
  for (const Vec3f& v : outfit.body().first(static_cast<std::size_t>(real_body()->body_vertex_count())))
    low = std::min(low, v.y);
  frame.low_mm = low - 40;
  frame.high_mm = low + 1900;
  constexpr PictureView kViews[] = {kFrontView, kLeftView, kBackView};
  return draw_outfit(*real_body(), outfit, person.woman ? body::LookOf::woman : body::LookOf::man, colours, kViews,
                     frame);
}

TEST(DressedPictures, LookAsTheyDid) {
  IM2FIT_NEEDS_BODY();
  // Pixels that differ by kStep, in percent: 1.3 to 2.7 where the arms were up in between, so that cloth folds
  // elsewhere; 2.3 to 4.9 in the next size; 2.9 to 4.2 with long sleeves; 6.7 to 11 in shorts.
  constexpr float kStep = 24, kShareMax = 0.02F;
  const char* write = std::getenv("IM2FIT_WRITE_PICTURES");
  for (const DressedPerson& person : example_people(*real_body())) {
    const Canvas canvas = picture_of(person);
    if (write != nullptr) {
      const auto png = canvas.png();
      ASSERT_TRUE(png);
      ASSERT_TRUE(write_file_atomically(std::string(write) + "/" + person.name + ".png", *png));
    }
    const Grey is = grey_of(canvas);
    const Grey was = read(std::string(IM2FIT_DRESSED_PICTURES) + "/" + person.name + ".png");
    ASSERT_EQ(is.width, was.width) << person.name;
    ASSERT_EQ(is.height, was.height) << person.name;
    std::size_t other = 0;
    for (std::size_t i = 0; i < is.at.size(); ++i) other += std::abs(is.at[i] - was.at[i]) > kStep ? 1 : 0;
    EXPECT_LT(static_cast<float>(other), kShareMax * static_cast<float>(is.at.size())) << person.name;
  }
}

}  // namespace
}  // namespace im2fit::lab
