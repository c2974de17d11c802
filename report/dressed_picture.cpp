// SPDX-License-Identifier: Apache-2.0
#include "report/dressed_picture.h"

#include <png.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "body/look.h"
#include "body/model_data.h"
#include "core/status.h"
#include "garment/drape/body_surface.h"

namespace im2fit {
Result<Texture> Texture::decode(std::span<const std::byte> png) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  const auto failed = [&] {
    Error error{ErrorCode::corrupt, std::string("texture: ") + image.message};
    png_image_free(&image);
    return error;
  };
  if (png_image_begin_read_from_memory(&image, png.data(), png.size()) == 0) return failed();
  if (image.width > body::kTextureSideMax || image.height > body::kTextureSideMax) {
    png_image_free(&image);
    return Error{ErrorCode::corrupt,
                 "texture: more than " + std::to_string(body::kTextureSideMax) + " pixels along a side"};
  }
  image.format = PNG_FORMAT_RGB;
  Texture texture;
  texture.width_ = static_cast<int>(image.width);
  texture.height_ = static_cast<int>(image.height);
  texture.rgb_.resize(PNG_IMAGE_SIZE(image));
  if (png_image_finish_read(&image, nullptr, texture.rgb_.data(), 0, nullptr) == 0) return failed();
  return texture;
}

std::array<float, 3> Texture::at(float u, float v) const {
  const float x = std::clamp(u * static_cast<float>(width_) - 0.5F, 0.0F, static_cast<float>(width_ - 1));
  const float y = std::clamp(v * static_cast<float>(height_) - 0.5F, 0.0F, static_cast<float>(height_ - 1));
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const int x1 = std::min(x0 + 1, width_ - 1), y1 = std::min(y0 + 1, height_ - 1);
  const float right = x - static_cast<float>(x0), below = y - static_cast<float>(y0);
  std::array<float, 3> sum{};
  const auto add = [&](int column, int row, float share) {
    const std::uint8_t* pixel = &rgb_[static_cast<std::size_t>(3 * (row * width_ + column))];
    for (std::size_t i = 0; i < 3; ++i) {
      const float display = static_cast<float>(pixel[i]) / 255;
      sum[i] += share * display * display;  // the inverse of what pictures are displayed with
    }
  };
  add(x0, y0, (1 - right) * (1 - below));
  add(x1, y0, right * (1 - below));
  add(x0, y1, (1 - right) * below);
  add(x1, y1, right * below);
  return sum;
}

namespace {

constexpr int kFiner = 2;  // pixels a pixel, along each side
constexpr LinearColour kPaper = {0.90F, 0.90F, 0.92F};
constexpr LinearColour kSkin = {0.60F, 0.40F, 0.30F};
constexpr float kInside = 0.6F;  // of the colour, on a cloth's inside
const Vec3f kKeyLight = normalized({-0.55F, 0.65F, 0.55F}), kFillLight = normalized({0.8F, 0.1F, 0.35F});

struct Raster {
  int width, height;
  std::vector<float> nearest;
  std::vector<LinearColour> colour;
};

struct Corner {
  float x, y, z;  // pixels, and towards the viewer in mm
  Vec3f normal;
  LinearColour colour;
  body::TextureCoordinate place;
};

LinearColour lit(const LinearColour& colour, Vec3f normal) {
  const float key = std::max(0.0F, dot(normal, kKeyLight)), fill = std::max(0.0F, dot(normal, kFillLight));
  const float light = 0.22F + 0.10F * normal.y + 0.75F * key + 0.22F * fill;
  return {colour[0] * light, colour[1] * light, colour[2] * light};
}

void fill(Raster& raster, const std::array<Corner, 3>& c, const PictureMesh& mesh) {
  const float area = (c[1].x - c[0].x) * (c[2].y - c[0].y) - (c[2].x - c[0].x) * (c[1].y - c[0].y);
  const bool inside = area > 0;  // pictures' y goes down
  if (area == 0 || (inside && !mesh.two_sided)) return;
  const auto [x_low, x_high] = std::minmax({c[0].x, c[1].x, c[2].x});
  const auto [y_low, y_high] = std::minmax({c[0].y, c[1].y, c[2].y});
  const int x0 = std::max(0, static_cast<int>(std::floor(x_low)));
  const int x1 = std::min(raster.width - 1, static_cast<int>(std::ceil(x_high)));
  const int y0 = std::max(0, static_cast<int>(std::floor(y_low)));
  const int y1 = std::min(raster.height - 1, static_cast<int>(std::ceil(y_high)));
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) {
      const float px = static_cast<float>(x) + 0.5F, py = static_cast<float>(y) + 0.5F;
      const float b = ((px - c[0].x) * (c[2].y - c[0].y) - (c[2].x - c[0].x) * (py - c[0].y)) / area;
      const float d = ((c[1].x - c[0].x) * (py - c[0].y) - (px - c[0].x) * (c[1].y - c[0].y)) / area;
      const float a = 1 - b - d;
      if (a < 0 || b < 0 || d < 0) continue;
      const float z = a * c[0].z + b * c[1].z + d * c[2].z;
      const auto at = static_cast<std::size_t>(y * raster.width + x);
      if (z <= raster.nearest[at]) continue;
      raster.nearest[at] = z;
      Vec3f normal = normalized(c[0].normal * a + c[1].normal * b + c[2].normal * d);
      if (inside) normal = normal * -1.0F;
      LinearColour mixed{};
      for (std::size_t i = 0; i < 3; ++i) mixed[i] = c[0].colour[i] * a + c[1].colour[i] * b + c[2].colour[i] * d;
      if (mesh.texture != nullptr)
        mixed = mesh.texture->at(c[0].place.u * a + c[1].place.u * b + c[2].place.u * d,
                                 c[0].place.v * a + c[1].place.v * b + c[2].place.v * d);
      for (float& channel : mixed) channel *= inside ? kInside : 1.0F;
      raster.colour[at] = lit(mixed, normal);
    }
}

void draw(Raster& raster, const PictureMesh& mesh, const PictureView& view, const PictureFrame& frame) {
  const float scale = static_cast<float>(raster.height) / (frame.high_mm - frame.low_mm);
  const auto turned = [&](Vec3f v) {
    return Vec3f{view.cosine * v.x - view.sine * v.z, v.y, view.sine * v.x + view.cosine * v.z};
  };
  for (const auto& t : mesh.triangles) {
    std::array<Corner, 3> corners;
    bool all_left_out = !mesh.left_out.empty();
    for (std::size_t k = 0; k < 3; ++k) {
      const auto v = static_cast<std::size_t>(t[k]);
      all_left_out = all_left_out && mesh.left_out[v] != 0;
      const Vec3f p = turned(mesh.positions[v] - Vec3f{frame.middle_x_mm, 0, frame.middle_z_mm});
      corners[k] = {static_cast<float>(raster.width) / 2 + p.x * scale,
                    (frame.high_mm - p.y) * scale,
                    p.z,
                    turned(mesh.normals[v]),
                    mesh.colours.empty() ? mesh.colour : mesh.colours[v],
                    mesh.texture != nullptr ? mesh.coordinates[v] : body::TextureCoordinate{}};
    }
    if (!all_left_out) fill(raster, corners, mesh);
  }
}

std::uint8_t displayed(float linear) {
  return static_cast<std::uint8_t>(std::lround(255 * std::sqrt(std::clamp(linear, 0.0F, 1.0F))));
}

}  // namespace

Canvas draw_meshes(std::span<const PictureMesh> meshes, std::span<const PictureView> views,
                   const PictureFrame& frame) {
  Canvas canvas(frame.width * static_cast<int>(views.size()), frame.height);
  Raster raster{frame.width * kFiner, frame.height * kFiner, {}, {}};
  const auto pixels = static_cast<std::size_t>(raster.width * raster.height);
  for (std::size_t i = 0; i < views.size(); ++i) {
    raster.nearest.assign(pixels, -1e9F);
    raster.colour.assign(pixels, kPaper);
    for (const PictureMesh& mesh : meshes) draw(raster, mesh, views[i], frame);
    for (int y = 0; y < frame.height; ++y)
      for (int x = 0; x < frame.width; ++x) {
        LinearColour sum{};
        for (int k = 0; k < kFiner * kFiner; ++k) {
          const auto& c = raster.colour[static_cast<std::size_t>((y * kFiner + k / kFiner) * raster.width +
                                                                 x * kFiner + k % kFiner)];
          for (std::size_t j = 0; j < 3; ++j) sum[j] += c[j] / (kFiner * kFiner);
        }
        canvas.set(static_cast<int>(i) * frame.width + x, y,
                   {displayed(sum[0]), displayed(sum[1]), displayed(sum[2])});
      }
  }
  return canvas;
}

Canvas draw_outfit(const body::BodyModel& model, const body::Outfit& outfit, body::LookOf whose,
                   std::span<const LinearColour> colours, std::span<const PictureView> views,
                   const PictureFrame& frame) {
  const body::SkinPart skin = body::skin_part(model, outfit.body());
  const body::Mat3f& head = outfit.pose().rotation[static_cast<std::size_t>(body::Segment::head)];
  const std::array<body::LookPart, 2> others = {body::eyes_part(model, outfit.body()),
                                                body::hair_part(model, outfit.body(), head, whose)};
  const body::Look& look = model.data().look;
  const auto texture =
      look.empty() ? Result<Texture>(Error{}) : Texture::decode(look.texture[static_cast<std::size_t>(whose)]);
  const Texture* const worn = texture ? &*texture : nullptr;
  std::vector<std::uint8_t> hidden(static_cast<std::size_t>(model.body_vertex_count()));
  outfit.hidden_skin(hidden);
  for (std::size_t v = hidden.size(); v < skin.positions.size(); ++v)
    hidden.push_back(hidden[static_cast<std::size_t>(skin.body_vertex[v])]);
  std::array<std::vector<std::array<std::int32_t, 3>>, 3> triangles;
  std::vector<PictureMesh> meshes;
  const auto add = [&](const body::LookPart& part, LinearColour colour,
                       std::vector<std::array<std::int32_t, 3>>& of) {
    for (const auto& q : part.quads) {
      of.push_back({q[0], q[1], q[2]});
      of.push_back({q[0], q[2], q[3]});
    }
    meshes.push_back({part.positions, part.normals, of, colour, {}, {}, false, part.texture, worn});
  };
  add(skin, kSkin, triangles[0]);
  meshes.back().left_out = hidden;
  if (worn != nullptr)
    for (std::size_t i = 0; i < others.size(); ++i) add(others[i], kSkin, triangles[i + 1]);
  if (worn != nullptr) meshes.back().two_sided = true;  // the rim of hair
  std::vector<std::vector<Vec3f>> places(outfit.size());
  std::vector<std::vector<LinearColour>> tints(outfit.size());
  std::vector<std::vector<std::uint8_t>> covered(outfit.size());
  for (std::size_t i = 0; i < outfit.size(); ++i) {
    const body::Cloth& cloth = outfit.cloth(i);
    const body::GarmentMesh& mesh = cloth.mesh();
    places[i].resize(mesh.vertex_count());
    outfit.shown(i, places[i]);
    for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
      const bool opening = (mesh.border[v] & body::kOnOpening) != 0;
      LinearColour tint = colours[i];
      if (opening || (mesh.border[v] & body::kOnSeam) != 0)
        for (float& c : tint) c *= 0.7F;  // bands and seams
      tints[i].push_back(tint);
    }
    covered[i].resize(mesh.vertex_count());
    outfit.hidden_cloth(i, covered[i]);
    meshes.push_back(
        {places[i], cloth.normals(), mesh.triangles, colours[i], tints[i], covered[i], true, {}, nullptr});
  }
  return draw_meshes(meshes, views, frame);
}

}  // namespace im2fit
