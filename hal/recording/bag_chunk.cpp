// SPDX-License-Identifier: Apache-2.0
#include "hal/recording/bag_chunk.h"

#include <algorithm>
#include <array>
#include <span>

#include "core/text.h"
#include "hal/recording/bag_file.h"
#if IM2FIT_HAVE_BZIP2
#include <bzlib.h>
#endif
#if IM2FIT_HAVE_LZ4
#include <lz4frame.h>
#endif

namespace im2fit::hal {
namespace {

// Reads packed bytes piece by piece. `step` takes from a piece and writes to the rest of `out`: how much it used and
// made, or none for damage.
struct Step {
  std::size_t used = 0, made = 0;
};
template <class Unpack>
[[maybe_unused]] Status unpack(FileCursor& file, std::uint32_t packed, std::vector<std::byte>& out, Unpack step) {
  std::array<std::byte, 16384> piece;
  std::size_t made = 0;
  const Error wrong{ErrorCode::corrupt, file.path() + ": a compressed chunk is damaged; copy or record it again"};
  while (packed > 0) {
    const std::span<std::byte> in = std::span(piece).first(std::min<std::size_t>(packed, piece.size()));
    if (auto ok = file.read(in); !ok) return ok;
    packed -= static_cast<std::uint32_t>(in.size());
    for (std::size_t used = 0; used < in.size();) {
      const auto done = step(in.subspan(used), std::span(out).subspan(made));
      if (!done || (done->used == 0 && done->made == 0)) return wrong;
      used += done->used;
      made += done->made;
    }
  }
  if (made != out.size()) return wrong;
  return Ok{};
}

#if IM2FIT_HAVE_BZIP2
Status unpack_bz2(FileCursor& file, std::uint32_t packed, std::vector<std::byte>& out) {
  bz_stream stream{};
  if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK)
    return Error{ErrorCode::io, file.path() + ": no memory for a compressed chunk"};
  auto status =
      unpack(file, packed, out, [&](std::span<std::byte> in, std::span<std::byte> room) -> std::optional<Step> {
        stream.next_in = reinterpret_cast<char*>(in.data());
        stream.avail_in = static_cast<unsigned>(in.size());
        stream.next_out = reinterpret_cast<char*>(room.data());
        stream.avail_out = static_cast<unsigned>(room.size());
        const int result = BZ2_bzDecompress(&stream);
        if (result != BZ_OK && result != BZ_STREAM_END) return std::nullopt;
        return Step{in.size() - stream.avail_in, room.size() - stream.avail_out};
      });
  BZ2_bzDecompressEnd(&stream);
  return status;
}
#endif

#if IM2FIT_HAVE_LZ4
Status unpack_lz4(FileCursor& file, std::uint32_t packed, std::vector<std::byte>& out) {
  LZ4F_dctx* context = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION)) != 0U)
    return Error{ErrorCode::io, file.path() + ": no memory for a compressed chunk"};
  auto status =
      unpack(file, packed, out, [&](std::span<std::byte> in, std::span<std::byte> room) -> std::optional<Step> {
        std::size_t used = in.size(), made = room.size();
        const std::size_t result = LZ4F_decompress(context, room.data(), &made, in.data(), &used, nullptr);
        if (LZ4F_isError(result) != 0U) return std::nullopt;
        return Step{used, made};
      });
  LZ4F_freeDecompressionContext(context);
  return status;
}
#endif

}  // namespace

Status unpack_chunk(FileCursor& file, [[maybe_unused]] std::uint32_t packed, const std::string& compression,
                    std::uint32_t size, std::vector<std::byte>& out) {
  if (size > kBagChunkMax)
    return Error{ErrorCode::unsupported, file.path() + " has a compressed chunk of " + std::to_string(size) +
                                             " bytes, expected at most " + std::to_string(kBagChunkMax) +
                                             "; write it plain by: rosbag decompress FILE"};
  const auto resized = [&] { out.resize(size); };
  const auto missing = [&](const std::string& library) {
    return Error{ErrorCode::unsupported, file.path() + " is compressed by " + compression +
                                             ", and this build has no " + library +
                                             "; write it plain by: rosbag decompress FILE"};
  };
  if (compression == "bz2") {
#if IM2FIT_HAVE_BZIP2
    resized();
    return unpack_bz2(file, packed, out);
#else
    return missing("libbz2");
#endif
  }
  if (compression == "lz4") {
#if IM2FIT_HAVE_LZ4
    resized();
    return unpack_lz4(file, packed, out);
#else
    return missing("liblz4");
#endif
  }
  (void)resized;
  (void)missing;
  return Error{ErrorCode::unsupported, file.path() + " is compressed by " + excerpt(compression) +
                                           ", expected none, bz2 or lz4; write it plain by: rosbag decompress FILE"};
}

}  // namespace im2fit::hal
