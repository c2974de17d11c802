// SPDX-License-Identifier: Apache-2.0
// The paper's ellipse before real people.
#include <fmt/core.h>

#include "apps/im2fit-lab/commands.h"
#include "core/file.h"
#include "engine/data_files.h"
#include "engine/paths.h"
#include "lab/evaluation/section_study.h"
#include "lab/parallel.h"

namespace im2fit::apps {
namespace {

struct EllipseOptions {
  std::string ansur;
  std::string body = default_body_path();
  int synthetic = 600;
  double noise_mm = kBreadthNoiseMm;
  int threads = default_threads();
  std::string figure;
  bool json = false;
};

Result<int> run_ellipse(const EllipseOptions& options) {
  const auto people = read_section_people(options.ansur);
  if (!people)
    return Error{people.error().code,
                 people.error().message + "; --ansur takes the folder of the survey's two public CSV files"};
  SectionPeople synthetic;
  if (options.synthetic > 0) {
    const auto model = load_body(options.body);
    if (!model) return model.error();
    synthetic = synthetic_section_people(*model, options.synthetic, options.threads);
  }
  const SectionStudy study = study_sections(*people, synthetic, options.noise_mm);
  if (!options.figure.empty())
    if (const auto written = write_file_atomically(options.figure, picture_of(study).file()); !written)
      return written.error();
  fmt::print("{}", options.json ? json_of(study, options.noise_mm) : text_of(study));
  return kExitOk;
}

}  // namespace

void add_ellipse(cli::App& app, Command& chosen) {
  auto options = std::make_shared<EllipseOptions>();
  auto* sub = add_command<EllipseOptions>(
      app, chosen, "ellipse", "From breadth and depth to girth: the paper's ellipse and others, on real people",
      "  im2fit-lab ellipse --ansur DIR\n"
      "  im2fit-lab ellipse --ansur DIR --noise 0 --synthetic 0 --json",
      options, run_ellipse);
  sub->add_option("--ansur", options->ansur, "Folder of ANSUR_II_{FEMALE,MALE}_Public.csv")
      ->type_name("DIR")
      ->required();
  sub->add_option("--synthetic", options->synthetic,
                  "Synthetic people that one estimator is fitted to; 0: leave it out")
      ->range(0, 100000)
      ->capture_default_str();
  sub->add_option("--noise", options->noise_mm, "SD of what is added to every breadth and depth, mm")
      ->range(0.0, 100.0)
      ->capture_default_str();
  sub->add_option("--body", options->body, "Body file")->type_name("FILE")->capture_default_str();
  sub->add_option("--threads", options->threads, "Threads; the result does not depend on them")
      ->range(1, 256)
      ->capture_default_str();
  sub->add_option("--figure", options->figure, "Picture of it, SVG")->type_name("FILE");
  sub->add_flag("--json", options->json, "Print as JSON");
}

}  // namespace im2fit::apps
