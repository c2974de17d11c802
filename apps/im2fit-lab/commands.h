// SPDX-License-Identifier: Apache-2.0
// The commands of im2fit-lab: each adds its subcommand and options.
#pragma once

#include "apps/common/program.h"

namespace im2fit::lab {}

namespace im2fit::apps {

using namespace lab;  // what commands are about

void add_fetch(CLI::App& app, Command& chosen);
void add_population(CLI::App& app, Command& chosen);
void add_train(CLI::App& app, Command& chosen);
void add_dataset(CLI::App& app, Command& chosen);
void add_index(CLI::App& app, Command& chosen);
void add_render(CLI::App& app, Command& chosen);
void add_import_raw(CLI::App& app, Command& chosen);
void add_eval(CLI::App& app, Command& chosen);
void add_ellipse(CLI::App& app, Command& chosen);

}  // namespace im2fit::apps
