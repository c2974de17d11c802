// SPDX-License-Identifier: Apache-2.0
// libmicrohttpd, loaded when a page is served and not before: it brings eleven more libraries (TLS, which a page does
// not use), whose loading costs every other command more than its own start.
#pragma once

#include "core/status.h"

namespace im2fit::apps {

// Once, before the first PageServer. Error: the library is not installed. Calls of its functions (microhttpd.h) load
// it, too; without the library they fail as they do when there is no memory.
Status load_web_server_library();

}  // namespace im2fit::apps
