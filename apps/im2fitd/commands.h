// SPDX-License-Identifier: Apache-2.0
// What a client of the socket may ask for, and what is answered in bytes: docs/daemon.md.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "apps/common/events.h"
#include "core/camera.h"
#include "core/status.h"

namespace im2fit::daemon {

enum class Wish { known, consent, reset, erase, select_user, users, avatar, mask };
// In the order of Wish; `hello` lists them.
inline constexpr std::array<std::string_view, 8> kCommands = {"known",       "consent", "reset",  "delete",
                                                              "select_user", "users",   "avatar", "mask"};

struct Command {
  Wish wish = Wish::known;
  apps::Json value;   // known: the facts; select_user: the id; avatar: the format as a text; else empty
  apps::Json client;  // its "id", which the answers repeat; null: none
};

// One line, {"COMMAND": VALUE} with or without an "id". Errors: invalid_argument, and no value of known facts is in
// one. `id`: set as soon as it is known, so that a refusal can repeat it.
Result<Command> parse_command(std::string_view line, apps::Json& id);

std::string base64_of(std::span<const std::byte> bytes);
// 8 bits a pixel, grey: 255 is the person, 0 is not.
Result<std::string> mask_png(MaskView mask);

}  // namespace im2fit::daemon
