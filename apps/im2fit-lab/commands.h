// SPDX-License-Identifier: Apache-2.0
// The commands of im2fit-lab: each adds its subcommand and options.
#pragma once

#include "apps/common/program.h"

namespace im2fit::lab {}

namespace im2fit::apps {

using namespace lab;  // what commands are about

void add_fetch(cli::App& app, Command& chosen);
void add_fingerprint(cli::App& app, Command& chosen);
void add_population(cli::App& app, Command& chosen);
void add_train(cli::App& app, Command& chosen);
void add_dataset(cli::App& app, Command& chosen);
void add_make(cli::App& app, Command& chosen);
void add_pack(cli::App& app, Command& chosen);
void add_index(cli::App& app, Command& chosen);
void add_render(cli::App& app, Command& chosen);
void add_import_raw(cli::App& app, Command& chosen);
void add_eval(cli::App& app, Command& chosen);
void add_eval_limits(cli::App& app, Command& chosen);
void add_eval_turn(cli::App& app, Command& chosen);
void add_eval_scan(cli::App& app, Command& chosen);
void add_study(cli::App& app, Command& chosen);
void add_calibrate(cli::App& app, Command& chosen);
void add_simulate_site(cli::App& app, Command& chosen);

}  // namespace im2fit::apps
