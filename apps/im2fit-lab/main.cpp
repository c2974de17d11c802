// SPDX-License-Identifier: Apache-2.0
#include "apps/im2fit-lab/commands.h"

int main(int argc, char** argv) {
  using namespace im2fit::apps;
  cli::App app{"Workstation side of im2fit: body data, synthetic people, training, evaluation.", "im2fit-lab"};
  std::string footer = "Start with: im2fit-lab fetch, then im2fit-lab train, then im2fit-lab index --subjects 20000";
  Command chosen;
  for (auto* add : {add_fetch, add_train, add_dataset, add_index, add_render, add_import_raw, add_fingerprint,
                    add_pack, add_make})
    add(app, chosen);
#if IM2FIT_HAVE_EVALUATION
  add_population(app, chosen);
  add_eval(app, chosen);
  add_eval_limits(app, chosen);
  add_eval_turn(app, chosen);
  add_eval_scan(app, chosen);
  add_study(app, chosen);
  add_calibrate(app, chosen);
  add_simulate_site(app, chosen);
#else
  footer +=
      "\nThis build has no eval, eval-limits, eval-turn, eval-scan, population, study, calibrate and simulate-site: "
      "they come "
      "with "
      "IM2FIT_BUILD_EVALUATION, as in preset release.";
#endif
  app.footer(footer);
  return run_program(app, chosen, argc, argv);
}
