// SPDX-License-Identifier: Apache-2.0
#include "train/makehuman/skin_texture.h"

#include <png.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace im2fit::body::makehuman {
namespace {

constexpr int kShade = 3;  // of a channel: finer ones double the file and are not seen on a lit body
constexpr int kSpread =
    8;  // pixels that the skin goes on beyond its edges: smaller copies of a texture mix neighbours

// Which place of the skin each pixel shows.
class Atlas {
 public:
  Atlas(const SkinMesh& mesh, int side) : side_(side), places_(count()), filled_(count()) {
    for (std::size_t q = 0; q < mesh.quads.size(); ++q)
      for (const std::array<std::size_t, 3>& t : {std::array<std::size_t, 3>{0, 1, 2}, {0, 2, 3}}) fill(mesh, q, t);
  }
  int side() const { return side_; }
  bool filled(std::size_t pixel) const { return filled_[pixel] != 0; }
  const SkinPlace& place(std::size_t pixel) const { return places_[pixel]; }

  // The largest empty square: its middle and half of its side, pixels.
  std::array<int, 3> empty_square() const {
    std::vector<int> square(count());  // side of the largest that ends here
    int best = 0, right = 0, bottom = 0;
    for (int y = 0; y < side_; ++y)
      for (int x = 0; x < side_; ++x) {
        const std::size_t i = at(x, y);
        if (filled_[i] != 0) continue;
        square[i] =
            x == 0 || y == 0 ? 1 : 1 + std::min({square[i - 1], square[at(x, y - 1)], square[at(x - 1, y - 1)]});
        if (square[i] <= best) continue;
        best = square[i];
        right = x;
        bottom = y;
      }
    return {right - best / 2, bottom - best / 2, best / 2};
  }
  std::size_t at(int x, int y) const { return static_cast<std::size_t>(y * side_ + x); }

 private:
  std::size_t count() const { return static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_); }

  void fill(const SkinMesh& mesh, std::size_t quad, const std::array<std::size_t, 3>& corner) {
    std::array<float, 3> x{}, y{};
    for (std::size_t k = 0; k < 3; ++k) {
      const TexturePlace p = mesh.corners[quad][corner[k]];
      x[k] = static_cast<float>(p.u) / 65535 * static_cast<float>(side_);
      y[k] = static_cast<float>(p.v) / 65535 * static_cast<float>(side_);
    }
    const float area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
    if (area == 0) return;
    const auto low = [](const std::array<float, 3>& v) { return std::min({v[0], v[1], v[2]}); };
    const auto high = [](const std::array<float, 3>& v) { return std::max({v[0], v[1], v[2]}); };
    const int x0 = std::max(0, static_cast<int>(low(x))), x1 = std::min(side_ - 1, static_cast<int>(high(x)));
    const int y0 = std::max(0, static_cast<int>(low(y))), y1 = std::min(side_ - 1, static_cast<int>(high(y)));
    for (int v = y0; v <= y1; ++v)
      for (int u = x0; u <= x1; ++u) {
        const float px = static_cast<float>(u) + 0.5F, py = static_cast<float>(v) + 0.5F;
        const float b = ((px - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (py - y[0])) / area;
        const float c = ((x[1] - x[0]) * (py - y[0]) - (px - x[0]) * (y[1] - y[0])) / area;
        const float a = 1 - b - c;
        constexpr float kEdge = -1e-3F;  // a pixel on the edge of two is of one of them, whatever was rounded
        if (a < kEdge || b < kEdge || c < kEdge) continue;
        const auto vertex = [&](std::size_t k) { return static_cast<std::size_t>(mesh.quads[quad][corner[k]]); };
        SkinPlace& place = places_[at(u, v)];
        place.at = mesh.positions[vertex(0)] * a + mesh.positions[vertex(1)] * b + mesh.positions[vertex(2)] * c;
        place.arm = mesh.arm[vertex(0)] * a + mesh.arm[vertex(1)] * b + mesh.arm[vertex(2)] * c;
        filled_[at(u, v)] = 1;
      }
  }

  int side_;
  std::vector<SkinPlace> places_;
  std::vector<std::uint8_t> filled_;
};

struct Drawing {
  std::vector<Colour> colours;
  std::vector<std::uint8_t> drawn;
};

void spread(const Atlas& atlas, Drawing& drawing) {
  std::vector<std::size_t> fresh;
  for (int pass = 0; pass < kSpread; ++pass) {
    fresh.clear();
    for (int y = 0; y < atlas.side(); ++y)
      for (int x = 0; x < atlas.side(); ++x) {
        const std::size_t i = atlas.at(x, y);
        if (drawing.drawn[i] != 0) continue;
        Colour sum{};
        float count = 0;
        for (int v = std::max(0, y - 1); v <= std::min(atlas.side() - 1, y + 1); ++v)
          for (int u = std::max(0, x - 1); u <= std::min(atlas.side() - 1, x + 1); ++u)
            if (const std::size_t n = atlas.at(u, v); drawing.drawn[n] == 1) {
              for (std::size_t k = 0; k < 3; ++k) sum[k] += drawing.colours[n][k];
              ++count;
            }
        if (count == 0) continue;
        for (std::size_t k = 0; k < 3; ++k) drawing.colours[i][k] = sum[k] / count;
        fresh.push_back(i);
      }
    for (const std::size_t i : fresh) drawing.drawn[i] = 1;
  }
}

Result<std::vector<std::byte>> png_of(const std::vector<Colour>& colours, int side) {
  std::vector<std::uint8_t> rgb;
  rgb.reserve(colours.size() * 3);
  for (const Colour& c : colours)
    for (const float v : c)
      rgb.push_back(
          static_cast<std::uint8_t>(kShade * static_cast<int>(std::clamp(v, 0.0F, 255.0F) / kShade + 0.5F)));
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = image.height = static_cast<png_uint_32>(side);
  image.format = PNG_FORMAT_RGB;
  std::vector<std::byte> bytes(PNG_IMAGE_PNG_SIZE_MAX(image));
  png_alloc_size_t size = bytes.size();
  if (png_image_write_to_memory(&image, bytes.data(), &size, 0, rgb.data(), 0, nullptr) == 0)
    return Error{ErrorCode::io, std::string("skin texture: ") + image.message};
  bytes.resize(size);
  return bytes;
}

}  // namespace

Result<SkinTextures> draw_skin_textures(const SkinMesh& mesh, int side_pixels) {
  const Atlas atlas(mesh, side_pixels);
  const auto [eye_x, eye_y, half] = atlas.empty_square();
  const float reach = std::min(static_cast<float>(half - kSpread), static_cast<float>(side_pixels) / 16);
  if (reach < 1) return Error{ErrorCode::unsupported, "base mesh: its texture has no place left for an eye"};
  const auto side = static_cast<float>(side_pixels);
  SkinTextures textures;
  textures.eye_u = (static_cast<float>(eye_x) + 0.5F) / side;
  textures.eye_v = (static_cast<float>(eye_y) + 0.5F) / side;
  textures.eye_r = reach / side;
  for (const LookOf whose : {LookOf::man, LookOf::woman}) {
    const auto pixels = static_cast<std::size_t>(side_pixels) * static_cast<std::size_t>(side_pixels);
    Drawing drawing{std::vector<Colour>(pixels, skin_colour({{0, 1e4F, 0}, 0}, whose)),
                    std::vector<std::uint8_t>(pixels)};
    for (std::size_t i = 0; i < pixels; ++i) {
      if (!atlas.filled(i)) continue;
      drawing.colours[i] = skin_colour(atlas.place(i), whose);
      drawing.drawn[i] = 1;
    }
    spread(atlas, drawing);
    for (int y = eye_y - half; y < eye_y + half; ++y)
      for (int x = eye_x - half; x < eye_x + half; ++x) {
        const float right = static_cast<float>(x - eye_x) / reach, above = static_cast<float>(eye_y - y) / reach;
        if (right * right + above * above < 1.21F && !atlas.filled(atlas.at(x, y)))
          drawing.colours[atlas.at(x, y)] = eye_colour(right, above);
      }
    auto png = png_of(drawing.colours, side_pixels);
    if (!png) return png.error();
    textures.png[static_cast<std::size_t>(whose)] = std::move(*png);
  }
  return textures;
}

}  // namespace im2fit::body::makehuman
