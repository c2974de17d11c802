// SPDX-License-Identifier: Apache-2.0
// Where libdeflate is missing: libpng reads and writes everything.
#include <bit>
#include <string>
#include <utility>

#include "formats/libpng.h"
#include "formats/plain_png.h"

namespace im2fit::hal {
namespace {

struct Output : PngMessage {
  std::vector<std::byte> bytes;
};

void write_some(png_structp png, png_bytep from, std::size_t count) {
  auto& bytes = static_cast<Output*>(png_get_io_ptr(png))->bytes;
  const auto* begin = reinterpret_cast<const std::byte*>(from);
  bytes.insert(bytes.end(), begin, begin + count);
}

bool write_rows(Output& output, const DepthView& image, RowFilter filter) {
  png_structp png =
      png_create_write_struct(PNG_LIBPNG_VER_STRING, static_cast<PngMessage*>(&output), on_png_error, on_png_warning);
  if (png == nullptr) return false;
  png_infop info = png_create_info_struct(png);
  if (info == nullptr || setjmp(png_jmpbuf(png)) != 0) {
    png_destroy_write_struct(&png, &info);
    return false;
  }
  png_set_write_fn(png, &output, write_some, nullptr);
  png_set_IHDR(png, info, static_cast<png_uint_32>(image.width), static_cast<png_uint_32>(image.height), 16,
               PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_filter(png, 0, filter == RowFilter::up ? PNG_FILTER_UP : PNG_FILTER_NONE);
  // A fast deflate keeps up with 30 frames a second.
  png_set_compression_level(png, 1);
  png_write_info(png, info);
  if constexpr (std::endian::native == std::endian::little) png_set_swap(png);
  for (int v = 0; v < image.height; ++v)
    png_write_row(png, const_cast<png_bytep>(reinterpret_cast<png_const_bytep>(image.row(v))));
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  return true;
}

}  // namespace

void PlainPngDecoder::Free::operator()(libdeflate_decompressor* /*decompressor*/) const {}

bool PlainPngDecoder::decode(std::span<const std::byte> /*bytes*/, DepthImage /*out*/) {
  return false;
}

Result<std::vector<std::byte>> encode_plain_png(DepthView image, RowFilter filter) {
  Output output;
  if (!write_rows(output, image, filter))
    return Error{ErrorCode::io, std::string("cannot make a PNG: ") + output.text};
  return std::move(output.bytes);
}

Result<std::vector<std::byte>> encode_rgb_png(int width, int height, std::span<const std::uint8_t> pixels) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width);
  image.height = static_cast<png_uint_32>(height);
  image.format = PNG_FORMAT_RGB;
  image.flags = PNG_IMAGE_FLAG_FAST;  // a third of the work
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::vector<std::byte> bytes(size);
  if (png_image_write_to_memory(&image, bytes.data(), &size, 0, pixels.data(), 0, nullptr) == 0)
    return Error{ErrorCode::io, std::string("cannot make a PNG: ") + image.message};
  bytes.resize(size);
  return bytes;
}

}  // namespace im2fit::hal
