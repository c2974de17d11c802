// SPDX-License-Identifier: Apache-2.0
// im2fit-lab make tape-regression BODY.i2b > person/tape_regression.inc
// How the measurements of the tape follow the eleven in people, and how much of them the eleven leave open. Minutes.
//
// Slopes: of the logarithm of each measurement on those of the eleven, over training people. Residual: what the body
// that person/avatar.h fits to the eleven true values of a held-out person measures, against the person's own body.
#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string_view>

#include "apps/im2fit-lab/make/make.h"
#include "body/fit/measurement_fit.h"
#include "body/measure.h"
#include "body/tape.h"
#include "person/builtin_tape.h"
#include "train/population/drawn_people.h"

namespace {

using namespace im2fit;
using namespace im2fit::body;

constexpr std::uint64_t kSeed = 0x7461;
constexpr int kTeaching = 800, kHeldOut = 400;  // people, half of them women
constexpr auto kEleven = static_cast<Eigen::Index>(kMeasurementCount);
// SDs of most people's answers from the front, mm and kg: they weigh goals that no body meets.
constexpr MeasurementValues kSd = {6, 10, 12, 8, 8, 20, 18, 20, 15, 11, 2};

struct Person {
  bool woman = false;
  Params params;
  MeasurementValues own{};
  std::vector<float> tape;
};

Person draw(const BodyModel& model, const Tape& tape, TapeMeasurer& measurer, Family family, int number) {
  Person person;
  Drawn drawn = draw_person(model, family, kSeed, static_cast<std::uint64_t>(number));
  person.woman = drawn.woman;
  person.params = std::move(drawn.params);
  person.tape.resize(tape.definitions.size());
  measurer.measure(tape, person.params, person.tape);
  person.own = measure_person(model, person.params);
  return person;
}

const Person& nearest(const std::vector<Person>& people, const Person& to) {
  const Person* best = &people[0];
  double least = std::numeric_limits<double>::max();
  for (const Person& person : people) {
    if (person.woman != to.woman) continue;
    double sum = 0;
    for (std::size_t i = 0; i < kMeasurementCount; ++i) {
      const double d = static_cast<double>(person.own[i] - to.own[i]) / static_cast<double>(kSd[i]);
      sum += d * d;
    }
    if (sum >= least) continue;
    least = sum;
    best = &person;
  }
  return *best;
}

Eigen::VectorXd slopes_of(const std::vector<Person>& people, bool woman, std::size_t definition) {
  std::vector<const Person*> some;
  for (const Person& person : people)
    if (person.woman == woman && person.tape[definition] > 0) some.push_back(&person);
  const auto count = static_cast<Eigen::Index>(some.size());
  Eigen::MatrixXd x(count, kEleven);
  Eigen::VectorXd y(count);
  for (Eigen::Index r = 0; r < count; ++r) {
    const Person& person = *some[static_cast<std::size_t>(r)];
    for (Eigen::Index c = 0; c < kEleven; ++c)
      x(r, c) = std::log(static_cast<double>(person.own[static_cast<std::size_t>(c)]));
    y[r] = std::log(static_cast<double>(person.tape[definition]));
  }
  x.rowwise() -= x.colwise().mean().eval();
  y.array() -= y.mean();
  const Eigen::MatrixXd normal = x.transpose() * x + 1e-3 * Eigen::MatrixXd::Identity(kEleven, kEleven);
  return normal.ldlt().solve(x.transpose() * y);
}

int run(const char* path) {
  const auto model = BodyModel::load(path);
  if (!model) {
    std::fprintf(stderr, "im2fit-lab make tape-regression: %s\n", model.error().message.c_str());
    return 1;
  }
  const Tape& tape = builtin_tape();
  TapeMeasurer measurer(*model);
  std::vector<Person> teaching;
  teaching.reserve(kTeaching);
  for (int i = 0; i < kTeaching; ++i) teaching.push_back(draw(*model, tape, measurer, Family::training, i));

  MeasurementFitter fitter(*model);
  std::array<std::vector<double>, 2> squares, counts;
  for (auto* lists : {&squares, &counts})
    for (auto& list : *lists) list.assign(tape.definitions.size(), 0);
  std::vector<float> fitted(tape.definitions.size());
  for (int i = 0; i < kHeldOut; ++i) {
    const Person person = draw(*model, tape, measurer, Family::held_out, i);
    MeasurementGoals goals;
    for (std::size_t m = 0; m < kMeasurementCount; ++m) goals[m] = {person.own[m], kSd[m]};
    Params params = nearest(teaching, person).params;
    fitter.run(params, goals);
    measurer.measure(tape, params, fitted);
    for (std::size_t d = 0; d < fitted.size(); ++d) {
      if (!(fitted[d] > 0) || !(person.tape[d] > 0)) continue;
      const double off = std::log(static_cast<double>(fitted[d]) / static_cast<double>(person.tape[d]));
      squares[person.woman ? 1 : 0][d] += off * off;
      counts[person.woman ? 1 : 0][d] += 1;
    }
  }
  std::printf(
      "// Made by im2fit-lab make tape-regression of %d training and %d held-out people; see "
      "person/tape_regression.h.\n"
      "// clang-format off\n",
      kTeaching, kHeldOut);
  for (std::size_t d = 0; d < tape.definitions.size(); ++d) {
    const TapeDefinition& definition = tape.definitions[d];
    if (definition.kind == TapeKind::value || definition.kind == TapeKind::refused) continue;
    for (const bool woman : {false, true}) {
      const std::size_t sex = woman ? 1 : 0;
      std::printf("{\"%s\", %s, %.4fF, {", definition.id.c_str(), woman ? "true" : "false",
                  std::sqrt(squares[sex][d] / counts[sex][d]));
      const Eigen::VectorXd slopes = slopes_of(teaching, woman, d);
      for (Eigen::Index i = 0; i < kEleven; ++i)
        std::printf("%s%.3fF", i > 0 ? ", " : "", std::fabs(slopes[i]) < 0.0005 ? 0.0 : slopes[i]);
      std::printf("}},\n");
    }
  }
  return 0;
}

}  // namespace

namespace im2fit::apps {

int make_tape_regression(int argc, char** argv) {
  if (argc != 2 || std::string_view(argv[1]) == "--help") {
    std::fprintf(stderr, "im2fit-lab make tape-regression BODY.i2b > person/tape_regression.inc\n");
    return 2;
  }
  return run(argv[1]);
}

}  // namespace im2fit::apps
