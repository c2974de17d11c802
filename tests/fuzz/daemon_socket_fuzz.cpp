// SPDX-License-Identifier: Apache-2.0
// Clients of the daemon's socket: each byte of the input is something one of four does.
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string>

#include "apps/im2fitd/publisher.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace im2fit::daemon;
  const std::string path = "/dev/shm/im2fit-fuzz-" + std::to_string(::getpid()) + ".sock";
  PublisherOptions options;
  options.path = path;
  options.clients_max = 3;
  options.client_buffer_bytes = 16 * 1024;
  auto publisher = Publisher::open(options);
  if (!publisher) std::abort();
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, path.data(), path.size());
  std::array<int, 4> clients = {-1, -1, -1, -1};
  for (std::size_t i = 0; i < size; ++i) {
    int& client = clients[data[i] & 3U];
    char buffer[512] = {};
    switch (data[i] >> 2 & 7U) {
      case 0:
        if (client >= 0) break;
        client = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
        if (::connect(client, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
          ::close(client);
          client = -1;
        }
        break;
      case 1:
        if (client >= 0) ::close(client);
        client = -1;
        break;
      case 2:
        if (i % 3 == 0) buffer[data[i]] = '\n';
        if (client >= 0) (void)!::send(client, buffer, data[i] + 1U, MSG_NOSIGNAL | MSG_DONTWAIT);
        break;
      case 3:
        if (client >= 0) (void)!::recv(client, buffer, sizeof buffer, MSG_DONTWAIT);
        break;
      case 4:
        if (client >= 0) ::shutdown(client, SHUT_WR);
        break;
      case 5:
        (*publisher)->publish(std::string(4000, 'x') + "\n");
        break;
      case 6:
        (*publisher)->publish("{}\n");
        break;
      default:
        (*publisher)->serve("hello\n");
        if (i % 2 == 0)
          for (const ClientLine& line : (*publisher)->take_lines()) {
            if (line.text.size() > kClientLineMax || line.text.find('\n') != std::string::npos) __builtin_trap();
            if (i % 4 == 0 && !(*publisher)->owes(line.client))
              (*publisher)->answer_long(line.client, std::string(20'000, ' ') + "{}\n");
            else
              (*publisher)->answer(line.client, "{}\n");
          }
    }
    if ((*publisher)->clients() > 3) __builtin_trap();
  }
  for (const int client : clients)
    if (client >= 0) ::close(client);
  // A client that has gone is removed once its earlier bytes are dropped: 16 KB a turn.
  for (int turn = 0; turn < 100 && (turn == 0 || (*publisher)->clients() != 0); ++turn)
    (*publisher)->serve("hello\n");
  if ((*publisher)->clients() != 0) __builtin_trap();
  return 0;
}
