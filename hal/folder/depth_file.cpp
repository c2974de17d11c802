// SPDX-License-Identifier: Apache-2.0
#include "hal/folder/depth_file.h"

#include <bitset>
#include <cstdint>
#include <cstring>
#include <optional>

#include "formats/libpng.h"

namespace im2fit::hal {
namespace {

Error damaged(const std::string& what, const std::string& found) {
  return {ErrorCode::corrupt, what + " is damaged or truncated (" + found + "); write or copy it again"};
}

Status check_size(long long width, long long height, const std::string& what) {
  if (width >= 1 && height >= 1 && width <= kImageSideMax && height <= kImageSideMax) return Ok{};
  return Error{ErrorCode::unsupported, what + " is " + std::to_string(width) + "x" + std::to_string(height) +
                                           " pixels, expected 1 to " + std::to_string(kImageSideMax) +
                                           " a side; halve larger pictures, and the camera's values with them"};
}

int byte_at(std::span<const std::byte> bytes, std::size_t i) {
  return std::to_integer<int>(bytes[i]);
}

long long big_endian32(std::span<const std::byte> bytes, std::size_t i) {
  return (static_cast<long long>(byte_at(bytes, i)) << 24) | (byte_at(bytes, i + 1) << 16) |
         (byte_at(bytes, i + 2) << 8) | byte_at(bytes, i + 3);
}

// `wanted`: what is done about pictures of other bits.
Result<DepthHeader> parse_png_header(std::span<const std::byte> bytes, const std::string& what, int bits,
                                     const char* wanted) {
  if (bytes.size() < 33 || std::memcmp(bytes.data() + 12, "IHDR", 4) != 0)
    return damaged(what, "its header is incomplete");
  const int found_bits = byte_at(bytes, 24);
  const int colour = byte_at(bytes, 25);
  if (found_bits != bits || colour != PNG_COLOR_TYPE_GRAY) {
    const std::string found =
        std::to_string(found_bits) + "-bit " + (colour == PNG_COLOR_TYPE_GRAY ? "grey" : "colour");
    return Error{ErrorCode::unsupported, what + " is a " + found + " PNG, expected " + wanted};
  }
  const long long width = big_endian32(bytes, 16);
  const long long height = big_endian32(bytes, 20);
  if (auto ok = check_size(width, height, what); !ok) return ok.error();
  return DepthHeader{DepthFormat::png, static_cast<int>(width), static_cast<int>(height)};
}

struct PgmHeader {
  DepthHeader size;
  std::size_t pixels_at = 0;
};

// Netpbm's pgm(5): "P5", white space, width, height, maxval, one white space; '#' starts a comment to the line's end.
Result<PgmHeader> parse_pgm_header(std::span<const std::byte> bytes, const std::string& what) {
  std::size_t at = 2;
  const auto number = [&]() -> std::optional<long long> {
    while (at < bytes.size()) {
      const int c = byte_at(bytes, at);
      if (c == '#')
        while (at < bytes.size() && byte_at(bytes, at) != '\n') ++at;
      else if (c == ' ' || c == '\t' || c == '\n' || c == '\r')
        ++at;
      else
        break;
    }
    long long value = 0;
    int digits = 0;
    for (; at < bytes.size() && digits < 9; ++at, ++digits) {
      const int c = byte_at(bytes, at);
      if (c < '0' || c > '9') break;
      value = value * 10 + (c - '0');
    }
    if (digits == 0) return std::nullopt;
    return value;
  };
  const auto width = number();
  const auto height = number();
  const auto maxval = number();
  if (!width || !height || !maxval || at >= bytes.size()) return damaged(what, "its header is incomplete");
  ++at;
  if (*maxval <= 255 || *maxval > 65535)
    return Error{ErrorCode::unsupported, what + " has maxval " + std::to_string(*maxval) +
                                             ", expected 256 to 65535 (16-bit millimetres); export the depth again"};
  if (auto ok = check_size(*width, *height, what); !ok) return ok.error();
  return PgmHeader{{DepthFormat::pgm, static_cast<int>(*width), static_cast<int>(*height)}, at};
}

bool is_png(std::span<const std::byte> bytes) {
  return bytes.size() >= sizeof kPngSignature && std::memcmp(bytes.data(), kPngSignature, sizeof kPngSignature) == 0;
}

bool is_pgm(std::span<const std::byte> bytes) {
  return bytes.size() >= 3 && byte_at(bytes, 0) == 'P' && byte_at(bytes, 1) == '5';
}

struct PngInput : PngMessage {
  explicit PngInput(std::span<const std::byte> all) : bytes(all) {}
  std::span<const std::byte> bytes;
};

void read_some(png_structp png, png_bytep to, std::size_t count) {
  auto* input = static_cast<PngInput*>(png_get_io_ptr(png));
  if (count > input->bytes.size()) png_error(png, "it ends too early");
  std::memcpy(to, input->bytes.data(), count);
  input->bytes = input->bytes.subspan(count);
}

void big_endian_to_host(DepthImage image) {
  for (int v = 0; v < image.height; ++v) {
    std::uint16_t* row = image.row(v);
    for (int u = 0; u < image.width; ++u) {
      unsigned char b[2];
      std::memcpy(b, row + u, 2);
      row[u] = static_cast<std::uint16_t>((b[0] << 8) | b[1]);
    }
  }
}

bool read_png_rows(PngInput& input, png_bytep first_row, std::size_t row_bytes, int height) {
  png_structp png =
      png_create_read_struct(PNG_LIBPNG_VER_STRING, static_cast<PngMessage*>(&input), on_png_error, on_png_warning);
  if (png == nullptr) return false;
  png_infop info = png_create_info_struct(png);
  if (info == nullptr || setjmp(png_jmpbuf(png)) != 0) {
    png_destroy_read_struct(&png, &info, nullptr);
    return false;
  }
  png_set_read_fn(png, &input, read_some);
  // Texts, profiles and the like are skipped unread: a few kilobytes of them may expand to gigabytes.
  png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
  png_read_info(png, info);
  const int passes = png_set_interlace_handling(png);
  png_read_update_info(png, info);
  for (int pass = 0; pass < passes; ++pass)
    for (int v = 0; v < height; ++v) png_read_row(png, first_row + static_cast<std::size_t>(v) * row_bytes, nullptr);
  png_read_end(png, nullptr);
  png_destroy_read_struct(&png, &info, nullptr);
  return true;
}

// Structured light knows few depths: 11 bits of disparity leave about 300 between 1 and 5 m, time of flight and
// stereo of subpixels thousands.
bool has_few_depths(DepthView image) {
  constexpr int kRowStep = 8;
  constexpr std::size_t kFew = 512;
  std::bitset<65536> seen;
  for (int v = 0; v < image.height; v += kRowStep)
    for (int u = 0; u < image.width; ++u) seen.set(image.at(u, v));
  return seen.count() <= kFew;
}

std::vector<std::byte> encode_pgm(DepthView image) {
  const std::string header = "P5\n" + std::to_string(image.width) + " " + std::to_string(image.height) + "\n65535\n";
  std::vector<std::byte> bytes;
  bytes.reserve(header.size() + 2 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
  for (const char c : header) bytes.push_back(static_cast<std::byte>(c));
  for (int v = 0; v < image.height; ++v) {
    for (int u = 0; u < image.width; ++u) {
      bytes.push_back(static_cast<std::byte>(image.at(u, v) >> 8));
      bytes.push_back(static_cast<std::byte>(image.at(u, v) & 0xFF));
    }
  }
  return bytes;
}

}  // namespace

Result<DepthHeader> parse_depth_header(std::span<const std::byte> bytes, const std::string& what) {
  if (is_png(bytes)) return parse_png_header(bytes, what, 16, "16-bit grey in millimetres; export the depth again");
  if (is_pgm(bytes)) {
    auto pgm = parse_pgm_header(bytes, what);
    if (!pgm) return pgm.error();
    return pgm->size;
  }
  if (bytes.empty()) return damaged(what, "it is empty");
  return Error{ErrorCode::corrupt, what + " is neither a PNG nor a binary PGM (P5); expected 16-bit depth in mm"};
}

Status DepthDecoder::decode(std::span<const std::byte> bytes, const std::string& what, DepthImage out) {
  const auto header = parse_depth_header(bytes, what);
  if (!header) return header.error();
  if (header->width != out.width || header->height != out.height)
    return Error{ErrorCode::corrupt, what + " is " + std::to_string(header->width) + "x" +
                                         std::to_string(header->height) + ", expected " + std::to_string(out.width) +
                                         "x" + std::to_string(out.height) + " like the others; remove or rescale it"};
  if (header->format == DepthFormat::png) {
    PngInput input{bytes};
    const auto row_bytes = sizeof(std::uint16_t) * static_cast<std::size_t>(out.stride);
    if (!plain_.decode(bytes, out) &&
        !read_png_rows(input, reinterpret_cast<png_bytep>(out.pixels), row_bytes, out.height))
      return damaged(what, input.text[0] != '\0' ? input.text : "no memory");
  } else {
    const auto pgm = parse_pgm_header(bytes, what);
    if (!pgm) return pgm.error();
    const auto pixels = bytes.subspan(pgm->pixels_at);
    const std::size_t row_bytes = 2 * static_cast<std::size_t>(out.width);
    const std::size_t wanted = row_bytes * static_cast<std::size_t>(out.height);
    if (pixels.size() < wanted)
      return damaged(what, std::to_string(pixels.size()) + " of " + std::to_string(wanted) + " bytes of pixels");
    for (int v = 0; v < out.height; ++v)
      std::memcpy(out.row(v), pixels.data() + static_cast<std::size_t>(v) * row_bytes, row_bytes);
  }
  big_endian_to_host(out);
  return Ok{};
}

Status decode_depth(std::span<const std::byte> bytes, const std::string& what, DepthImage out) {
  return DepthDecoder().decode(bytes, what, out);
}

Status decode_confidence(std::span<const std::byte> bytes, const std::string& what, int width, int height,
                         std::vector<std::uint8_t>& out) {
  if (!is_png(bytes)) return damaged(what, "it is no PNG");
  const auto header = parse_png_header(bytes, what, 8, "8-bit grey; export the confidence again");
  if (!header) return header.error();
  if (header->width != width || header->height != height)
    return Error{ErrorCode::invalid_argument, what + " is " + std::to_string(header->width) + "x" +
                                                  std::to_string(header->height) + ", expected " +
                                                  std::to_string(width) + "x" + std::to_string(height) +
                                                  " as the depth has; export the confidence again"};
  out.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  PngInput input{bytes};
  if (read_png_rows(input, out.data(), static_cast<std::size_t>(width), height)) return Ok{};
  return damaged(what, input.text[0] != '\0' ? input.text : "no memory");
}

Result<std::vector<std::byte>> encode_depth(DepthView image, DepthFormat format) {
  if (image.pixels == nullptr) return Error{ErrorCode::invalid_argument, "there is no picture to write"};
  if (auto ok = check_size(image.width, image.height, "the picture to write"); !ok) return ok.error();
  if (format == DepthFormat::pgm) return encode_pgm(image);
  // Depth is smooth downwards. But where it is of few values, rows repeat one another's bytes, which differences
  // hide: of a Kinect's noise files are a sixth smaller without, of time of flight's a third larger.
  return encode_plain_png(image, has_few_depths(image) ? RowFilter::none : RowFilter::up);
}

}  // namespace im2fit::hal
