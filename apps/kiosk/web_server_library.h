// SPDX-License-Identifier: Apache-2.0
// libmicrohttpd, loaded when a page is served and not before: it brings eleven more libraries (TLS, which a page does
// not use), whose loading costs every other command more than its own start.
#pragma once

#include "core/status.h"

namespace im2fit::apps {

// Call once, before the first PageServer. Error: the library is not installed. The functions of microhttpd.h load the
// library too. Without it they return what they return when memory runs out.
Status load_web_server_library();

}  // namespace im2fit::apps
