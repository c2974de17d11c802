// SPDX-License-Identifier: Apache-2.0
// Sockets to listen at.
#pragma once

#include <string>

namespace im2fit::apps {

// A socket that listens at the host's address; `host` may be a name. -1: error in errno, 0 if `host` is not an
// address. `port` 0: any free port.
int listen_at(const std::string& host, int port);
// That a socket listens at; 0: unknown.
int port_of(int socket);

}  // namespace im2fit::apps
