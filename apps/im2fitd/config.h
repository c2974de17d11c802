// SPDX-License-Identifier: Apache-2.0
// The daemon's one file, im2fitd.yaml; every key is explained there.
#pragma once

#include <cstddef>
#include <string>

#include "apps/common/measuring.h"
#include "core/status.h"

namespace im2fit::daemon {

struct Config {
  std::string source = "openni2";
  int rotate_deg = -1;      // -1: as the recording or calibration specifies
  std::string camera_yaml;  // "": the camera's own
  std::string body = default_body_path();
  apps::MeasuringOptions measuring;
  bool consent_ask = false;   // nobody is looked at until a client says that the person consents
  int consent_absent_s = 30;  // consent ends when no person is in view for that long
  std::string socket_path = "/run/im2fitd/events.sock";
  unsigned socket_mode = 0660;
  std::string socket_group;  // "": the process's
  int clients_max = 16;
  std::size_t client_buffer_bytes = 256 * 1024;
  std::string state_directory;  // "": $STATE_DIRECTORY, else nothing is written
};

// Errors: the file's; invalid_argument for a key that is not known, is there twice or has a value out of range. Each
// names file, line and key.
Result<Config> load_config(const std::string& path);

}  // namespace im2fit::daemon
