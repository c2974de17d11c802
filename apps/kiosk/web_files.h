// SPDX-License-Identifier: Apache-2.0
// The page's own files and three.js, inside the program: a device has no folder to serve them from.
#pragma once

#include <string_view>

namespace im2fit::apps {

struct WebFile {
  const char* path;  // "/page.js"; "/" is the page
  const char* type;
  std::string_view bytes;
  std::string_view gzip;  // the same, compressed when the program was built; "": it is too small for that
  bool lasting;           // its name holds its digest, so that a browser may keep it
};
const WebFile* web_file(std::string_view path);  // null: there is none

}  // namespace im2fit::apps
