// SPDX-License-Identifier: Apache-2.0
#include "apps/im2fitd/commands.h"

#include <fmt/core.h>
#include <png.h>

#include <algorithm>
#include <optional>

#include "formats/json_file.h"

namespace im2fit::daemon {
namespace {

using apps::Json;

constexpr std::size_t kIdBytesMax = 64;
constexpr int kUserIdMax = 1'000'000;

Error wrong(std::string what) {
  return {ErrorCode::invalid_argument, std::move(what)};
}

std::optional<Wish> wish_of(std::string_view word) {
  const auto* const found = std::find(kCommands.begin(), kCommands.end(), word);
  if (found == kCommands.end()) return std::nullopt;
  return static_cast<Wish>(found - kCommands.begin());
}

bool is_id(const Json& id) {
  return id.is_number_integer() || (id.is_string() && id.get_ref<const std::string&>().size() <= kIdBytesMax);
}

// The value in the form that Command states.
Result<Json> checked(Wish wish, const Json& value) {
  const std::string name(kCommands[static_cast<std::size_t>(wish)]);
  if (wish == Wish::select_user) {
    if (!value.is_number_integer() || value < 0 || value > kUserIdMax)
      return wrong("select_user: expected the id of a user, or 0 for whoever stands correctly first");
    return value;
  }
  if (!value.is_object()) return wrong(name + ": expected {\"" + name + "\": {}}");
  if (wish == Wish::known || value.empty()) return wish == Wish::avatar ? Json("glb") : value;
  if (wish != Wish::avatar) return wrong(name + ": takes no fields");
  const auto format = value.find("format");
  if (value.size() != 1 || format == value.end() || (*format != "glb" && *format != "obj" && *format != "bvh"))
    return wrong("avatar: expected {\"format\": \"glb\"}, \"obj\" or \"bvh\"");
  return *format;
}

}  // namespace

Result<Command> parse_command(std::string_view line, Json& id) {
  const auto read = parse_json<Json>(line, "the line");
  if (!read || !read->is_object() || read->empty())
    return wrong("expected {\"COMMAND\": {}} on one line (docs/daemon.md)");
  Command command;
  std::string name;
  if (const auto given = read->find("id"); given != read->end()) {
    if (!is_id(*given)) return wrong(fmt::format("id: expected a whole number or a text of {} bytes", kIdBytesMax));
    id = command.client = *given;
  }
  for (const auto& [key, value] : read->items()) {
    if (key == "id") continue;
    if (!name.empty()) return wrong("expected one command on a line (docs/daemon.md)");
    name = key;
    const auto wish = wish_of(key);
    if (!wish) return wrong("expected one of the commands of `hello` (docs/daemon.md)");
    command.wish = *wish;
    command.value = value;
  }
  if (name.empty()) return wrong("expected a command beside the id (docs/daemon.md)");
  auto value = checked(command.wish, command.value);
  if (!value) return value.error();
  command.value = std::move(*value);
  return command;
}

std::string base64_of(std::span<const std::byte> bytes) {
  static constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const auto at = [&](std::size_t offset) {
      return i + offset < bytes.size() ? std::to_integer<unsigned>(bytes[i + offset]) : 0U;
    };
    const unsigned three = at(0) << 16U | at(1) << 8U | at(2);
    text += kDigits[three >> 18U];
    text += kDigits[three >> 12U & 63U];
    text += i + 1 < bytes.size() ? kDigits[three >> 6U & 63U] : '=';
    text += i + 2 < bytes.size() ? kDigits[three & 63U] : '=';
  }
  return text;
}

Result<std::string> mask_png(MaskView mask) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(mask.width);
  image.height = static_cast<png_uint_32>(mask.height);
  image.format = PNG_FORMAT_GRAY;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::string bytes(size, '\0');
  if (png_image_write_to_memory(&image, bytes.data(), &size, 0, mask.pixels, mask.width, nullptr) == 0)
    return Error{ErrorCode::io, std::string("cannot make a PNG: ") + image.message};
  bytes.resize(size);
  return bytes;
}

}  // namespace im2fit::daemon
