// SPDX-License-Identifier: Apache-2.0
// Sockets to listen at.
#pragma once

#include <string>

namespace im2fit::apps {

// A socket that listens at the host's address, which may be a name; -1: none, and errno says why, 0 for a host that
// is no address. `port` 0: any that is free.
int listen_at(const std::string& host, int port);
// That a socket listens at; 0: unknown.
int port_of(int socket);

}  // namespace im2fit::apps
