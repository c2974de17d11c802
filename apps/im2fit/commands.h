// SPDX-License-Identifier: Apache-2.0
// The commands of im2fit: each adds its subcommand and options.
#pragma once

#include "apps/common/program.h"

namespace im2fit::apps {

void add_devices(cli::App& app, Command& chosen);
void add_measure(cli::App& app, Command& chosen);
void add_measure_scan(cli::App& app, Command& chosen);
void add_live(cli::App& app, Command& chosen);
#if IM2FIT_HAVE_PAGE
void add_serve(cli::App& app, Command& chosen);
#endif
void add_models(cli::App& app, Command& chosen);
void add_tape(cli::App& app, Command& chosen);
void add_try(cli::App& app, Command& chosen);
void add_record(cli::App& app, Command& chosen);
void add_convert(cli::App& app, Command& chosen);
void add_compare(cli::App& app, Command& chosen);
void add_sessions(cli::App& app, Command& chosen);

}  // namespace im2fit::apps
