// SPDX-License-Identifier: Apache-2.0
// PNG (ISO/IEC 15948). What is taken here are files whose critical chunks are IHDR, IDAT and IEND, with right CRCs.
// The zlib stream's Adler-32 is not worked out: the CRCs protect the same bytes.
#include "formats/plain_png.h"

#include <libdeflate.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>

namespace im2fit::hal {
namespace {

constexpr std::size_t kPixelBytes = 2;

std::uint32_t big_endian32(const std::byte* p) {
  std::uint32_t value = 0;
  for (int i = 0; i < 4; ++i) value = value << 8 | std::to_integer<std::uint32_t>(p[i]);
  return value;
}

struct Chunk {
  const std::byte* type = nullptr;
  std::span<const std::byte> data;
  bool is(const char* name) const { return std::memcmp(type, name, 4) == 0; }
  bool critical() const { return (std::to_integer<unsigned>(type[0]) & 0x20U) == 0; }
};

// Takes the first chunk from `rest`; false when it is cut off, or damaged and critical.
bool take_chunk(std::span<const std::byte>& rest, Chunk& chunk) {
  constexpr std::size_t kFrame = 12;  // length, type and CRC
  if (rest.size() < kFrame) return false;
  const std::size_t size = big_endian32(rest.data());
  if (size > rest.size() - kFrame) return false;
  chunk = {rest.data() + 4, rest.subspan(8, size)};
  if (chunk.critical() && libdeflate_crc32(0, chunk.type, size + 4) != big_endian32(rest.data() + 8 + size))
    return false;
  rest = rest.subspan(kFrame + size);
  return true;
}

std::uint8_t paeth(int left, int above, int corner) {
  const int estimate = left + above - corner;
  const int from_left = std::abs(estimate - left);
  const int from_above = std::abs(estimate - above);
  const int from_corner = std::abs(estimate - corner);
  if (from_left <= from_above && from_left <= from_corner) return static_cast<std::uint8_t>(left);
  return static_cast<std::uint8_t>(from_above <= from_corner ? above : corner);
}

// `row` in place; `above`: the row before, zeros for the first one. False: no such filter.
bool unfilter(int filter, std::uint8_t* row, const std::uint8_t* above, std::size_t count) {
  const auto left = [&](std::size_t i) { return i < kPixelBytes ? 0 : row[i - kPixelBytes]; };
  const auto corner = [&](std::size_t i) { return i < kPixelBytes ? 0 : above[i - kPixelBytes]; };
  switch (filter) {
    case 0:
      return true;
    case 1:
      for (std::size_t i = kPixelBytes; i < count; ++i)
        row[i] = static_cast<std::uint8_t>(row[i] + row[i - kPixelBytes]);
      return true;
    case 2:
      for (std::size_t i = 0; i < count; ++i) row[i] = static_cast<std::uint8_t>(row[i] + above[i]);
      return true;
    case 3:
      for (std::size_t i = 0; i < count; ++i) row[i] = static_cast<std::uint8_t>(row[i] + (left(i) + above[i]) / 2);
      return true;
    case 4:
      for (std::size_t i = 0; i < count; ++i)
        row[i] = static_cast<std::uint8_t>(row[i] + paeth(left(i), above[i], corner(i)));
      return true;
    default:
      return false;
  }
}

// Of IHDR: bits, colour type, deflate, the five filters, not interlaced.
constexpr std::array<std::byte, 5> kPlain = {std::byte{16}}, kRgb = {std::byte{8}, std::byte{2}};

// 16-bit grey, deflate, the five filters, not interlaced; of the size of `image`.
bool is_plain(const Chunk& header, DepthView image) {
  return header.is("IHDR") && header.data.size() == 13 &&
         big_endian32(header.data.data()) == static_cast<std::uint32_t>(image.width) &&
         big_endian32(header.data.data() + 4) == static_cast<std::uint32_t>(image.height) &&
         std::memcmp(header.data.data() + 8, kPlain.data(), kPlain.size()) == 0;
}

// A fast deflate keeps up with 30 frames a second: as much work as zlib's quickest level, for a quarter less to store
// and to read. Slower levels save a fifth of the reading for twice the work and more.
constexpr int kDeflateLevel = 4;

void put_big_endian32(std::byte* to, std::size_t value) {
  for (unsigned i = 0; i < 4; ++i) to[i] = static_cast<std::byte>(value >> (24 - 8 * i));
}

// `chunk`: room for length and type, data, room for the CRC. Gives its end.
std::byte* frame_chunk(std::byte* chunk, const char* type, std::size_t data_size) {
  put_big_endian32(chunk, data_size);
  std::memcpy(chunk + 4, type, 4);
  put_big_endian32(chunk + 8 + data_size, libdeflate_crc32(0, chunk + 4, data_size + 4));
  return chunk + 12 + data_size;
}

// A whole file of `rows`, each after its filter's number. `kind`: the last five bytes of IHDR.
Result<std::vector<std::byte>> packed(int width, int height, const std::array<std::byte, 5>& kind,
                                      const std::vector<std::uint8_t>& rows) {
  struct Free {
    void operator()(libdeflate_compressor* compressor) const { libdeflate_free_compressor(compressor); }
  };
  const std::unique_ptr<libdeflate_compressor, Free> compressor(libdeflate_alloc_compressor(kDeflateLevel));
  if (compressor == nullptr) return Error{ErrorCode::io, "cannot make a PNG: no memory"};
  constexpr std::size_t kFrame = 12, kHeaderData = 13;  // length, type and CRC; of IHDR
  const std::size_t bound = libdeflate_zlib_compress_bound(compressor.get(), rows.size());
  std::vector<std::byte> bytes(sizeof kPngSignature + 3 * kFrame + kHeaderData + bound);
  std::memcpy(bytes.data(), kPngSignature, sizeof kPngSignature);
  std::byte* at = bytes.data() + sizeof kPngSignature;
  put_big_endian32(at + 8, static_cast<std::size_t>(width));
  put_big_endian32(at + 12, static_cast<std::size_t>(height));
  std::memcpy(at + 16, kind.data(), kind.size());
  at = frame_chunk(at, "IHDR", kHeaderData);
  at = frame_chunk(at, "IDAT", libdeflate_zlib_compress(compressor.get(), rows.data(), rows.size(), at + 8, bound));
  at = frame_chunk(at, "IEND", 0);
  bytes.resize(static_cast<std::size_t>(at - bytes.data()));
  return bytes;
}

// Rows as they go into the stream, each after its filter's number.
std::vector<std::uint8_t> filtered_rows(DepthView image, RowFilter filter) {
  const std::size_t row_bytes = kPixelBytes * static_cast<std::size_t>(image.width);
  std::vector<std::uint8_t> rows((1 + row_bytes) * static_cast<std::size_t>(image.height));
  std::uint8_t* row = rows.data();
  for (int v = 0; v < image.height; ++v) {
    *row++ = static_cast<std::uint8_t>(filter);
    const std::uint16_t *pixels = image.row(v),
                        *above = filter == RowFilter::up && v > 0 ? image.row(v - 1) : nullptr;
    for (int u = 0; u < image.width; ++u, row += kPixelBytes) {
      const unsigned here = pixels[u], less = above != nullptr ? above[u] : 0U;
      row[0] = static_cast<std::uint8_t>((here >> 8) - (less >> 8));
      row[1] = static_cast<std::uint8_t>(here - less);
    }
  }
  return rows;
}

}  // namespace

void PlainPngDecoder::Free::operator()(libdeflate_decompressor* decompressor) const {
  libdeflate_free_decompressor(decompressor);
}

// A whole zlib stream (RFC 1950) without a dictionary, which makes `rows` and nothing more.
bool PlainPngDecoder::inflate(std::span<const std::byte> stream, std::span<std::uint8_t> rows) {
  constexpr std::size_t kHeader = 2, kChecksum = 4;
  if (stream.size() < kHeader + kChecksum) return false;
  const auto method = std::to_integer<unsigned>(stream[0]), flags = std::to_integer<unsigned>(stream[1]);
  if ((method & 0x0FU) != 8 || method >> 4U > 7 || (method << 8U | flags) % 31 != 0 || (flags & 0x20U) != 0)
    return false;
  const std::size_t size = stream.size() - kHeader - kChecksum;
  std::size_t used = 0;
  return libdeflate_deflate_decompress_ex(decompressor_.get(), stream.data() + kHeader, size, rows.data(),
                                          rows.size(), &used, nullptr) == LIBDEFLATE_SUCCESS &&
         used == size;
}

// The pixels' filtered rows: IHDR, chunks without meaning, IDATs one after the other, such chunks, IEND.
bool PlainPngDecoder::inflate_rows(std::span<const std::byte> bytes, DepthView image, std::span<std::uint8_t> rows) {
  if (bytes.size() < sizeof kPngSignature) return false;
  std::span<const std::byte> rest = bytes.subspan(sizeof kPngSignature);
  Chunk chunk;
  if (!take_chunk(rest, chunk) || !is_plain(chunk, image)) return false;
  std::span<const std::byte> stream;
  enum class Part { before, pixels, after } part = Part::before;
  while (take_chunk(rest, chunk)) {
    if (chunk.is("IEND")) return inflate(stream, rows);
    if (chunk.is("IDAT")) {
      if (part == Part::after) return false;
      if (part == Part::before) {
        stream = chunk.data;
      } else {
        if (stream.data() != stream_.data()) stream_.assign(stream.begin(), stream.end());
        stream_.insert(stream_.end(), chunk.data.begin(), chunk.data.end());
        stream = stream_;
      }
      part = Part::pixels;
    } else if (chunk.critical() || chunk.is("tRNS")) {
      return false;
    } else if (part == Part::pixels) {
      part = Part::after;
    }
  }
  return false;
}

bool PlainPngDecoder::decode(std::span<const std::byte> bytes, DepthImage out) {
  if (decompressor_ == nullptr) decompressor_.reset(libdeflate_alloc_decompressor());
  if (decompressor_ == nullptr) return false;
  const std::size_t row_bytes = kPixelBytes * static_cast<std::size_t>(out.width);
  const std::size_t filtered = 1 + row_bytes;  // the filter's number first
  // A row of zeros before the first. The others are written whole, or the picture is refused.
  rows_.resize(row_bytes + filtered * static_cast<std::size_t>(out.height));
  std::fill_n(rows_.begin(), row_bytes, std::uint8_t{0});
  if (!inflate_rows(bytes, out, std::span(rows_).subspan(row_bytes))) return false;
  const std::uint8_t* above = rows_.data();
  std::uint8_t* row = rows_.data() + row_bytes;
  for (int v = 0; v < out.height; ++v, row += filtered) {
    if (!unfilter(row[0], row + 1, above, row_bytes)) return false;
    above = row + 1;
    std::memcpy(out.row(v), above, row_bytes);
  }
  return true;
}

Result<std::vector<std::byte>> encode_plain_png(DepthView image, RowFilter filter) {
  return packed(image.width, image.height, kPlain, filtered_rows(image, filter));
}

Result<std::vector<std::byte>> encode_rgb_png(int width, int height, std::span<const std::uint8_t> pixels) {
  const std::size_t row_bytes = 3 * static_cast<std::size_t>(width);
  std::vector<std::uint8_t> rows((1 + row_bytes) * static_cast<std::size_t>(height));
  for (std::size_t v = 0; v < static_cast<std::size_t>(height); ++v)
    std::memcpy(rows.data() + v * (1 + row_bytes) + 1, pixels.data() + v * row_bytes, row_bytes);
  return packed(width, height, kRgb, rows);
}

}  // namespace im2fit::hal
