// SPDX-License-Identifier: Apache-2.0
#include "evaluation/study/site_statistics.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "evaluation/study/calibrate.h"
#include "evaluation/study/site_model.h"

namespace im2fit::lab {
namespace {

using People = std::vector<const SitePerson*>;

// `shrink`: how far errors are drawn to their mean; 1: not at all.
ErrorFigures figures_of(const People& taken, std::size_t m, double bias, double shrink) {
  ErrorFigures figures;
  std::vector<double> errors;
  int inside = 0;
  for (const SitePerson* p : taken) {
    const double error = bias + (p->error(m) - bias) * shrink;
    const double truth = static_cast<double>(p->answer[m].value) - error;
    errors.push_back(error);
    if (holds(p->answer[m], truth)) ++inside;
  }
  const ErrorStatistics s = error_statistics(errors);
  figures.sd = s.sd;
  figures.mae = s.mae;
  figures.agreement_low = s.bias - 1.96 * s.sd;
  figures.agreement_high = s.bias + 1.96 * s.sd;
  figures.covered = share_of_count(inside, s.count);
  return figures;
}

MeasurementStudy measurement_study(const People& people, std::size_t m) {
  MeasurementStudy study;
  study.allowance_mm = iso_20685_limit_mm(static_cast<Measurement>(m));
  People taken;
  std::vector<double> errors;
  std::vector<std::array<double, 2>> pairs;
  for (const SitePerson* p : people) {
    if (!p->tape[m].taken()) continue;
    taken.push_back(p);
    errors.push_back(p->error(m));
    study.interval_width += static_cast<double>(p->answer[m].high - p->answer[m].low);
    if (p->tape[m].twice()) pairs.push_back({p->tape[m].first, p->tape[m].second});
  }
  if (taken.empty()) return study;
  study.interval_width /= static_cast<double>(taken.size());
  study.errors = error_statistics(errors);
  study.as_taken = figures_of(taken, m, study.errors.bias, 1);
  study.tape = repeatability(pairs);
  study.within = within_iso_20685(study.errors, static_cast<Measurement>(m));
  if (study.allowance_mm > 0 && study.errors.count > 1)
    study.people_for_claim = people_for_claim(study.errors.bias, study.errors.sd, study.allowance_mm);
  if (study.tape.pairs < kTapePairsMin) return study;
  double tape_variance = 0;  // a mean of two has half of it
  for (const SitePerson* p : taken)
    tape_variance +=
        study.tape.tem * study.tape.tem / (p->tape[m].twice() ? 2 : 1) / static_cast<double>(taken.size());
  const double variance = study.errors.sd * study.errors.sd;
  if (tape_variance >= variance) return study;
  study.tape_known = true;
  study.tape_out = figures_of(taken, m, study.errors.bias, std::sqrt((variance - tape_variance) / variance));
  return study;
}

StudyGroup group_of(std::string name, const People& people) {
  StudyGroup group{std::move(name), static_cast<int>(people.size())};
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    std::vector<double> errors;
    int inside = 0;
    for (const SitePerson* p : people) {
      if (!p->tape[m].taken()) continue;
      errors.push_back(p->error(m));
      const double truth = p->tape[m].mean();
      if (holds(p->answer[m], truth)) ++inside;
    }
    const ErrorStatistics s = error_statistics(errors);
    group.rows[m] = {s.count, s.bias, s.mae, share_of_count(inside, s.count)};
  }
  return group;
}

void add_group(std::vector<StudyGroup>& groups, const People& people, const std::string& name,
               const std::function<bool(const SitePerson&)>& belongs) {
  People those;
  std::copy_if(people.begin(), people.end(), std::back_inserter(those),
               [&](const SitePerson* p) { return belongs(*p); });
  if (!those.empty()) groups.push_back(group_of(name, those));
}

std::vector<StudyGroup> groups_of(const People& people) {
  std::vector<StudyGroup> groups;
  add_group(groups, people, "women", [](const SitePerson& p) { return p.woman == true; });
  add_group(groups, people, "men", [](const SitePerson& p) { return p.woman == false; });
  People weighed;
  std::copy_if(people.begin(), people.end(), std::back_inserter(weighed),
               [](const SitePerson* p) { return std::isfinite(p->mass_index()); });
  std::stable_sort(weighed.begin(), weighed.end(),
                   [](const SitePerson* a, const SitePerson* b) { return a->mass_index() < b->mass_index(); });
  constexpr const char* kThirds[] = {"lightest third by BMI", "middle third", "heaviest third"};
  for (std::size_t third = 0; third < 3 && weighed.size() >= 3; ++third) {
    const auto at = [&](std::size_t k) {
      return weighed.begin() + static_cast<std::ptrdiff_t>(k * weighed.size() / 3);
    };
    groups.push_back(group_of(kThirds[third], People(at(third), at(third + 1))));
  }
  for (const auto& [word, name] :
       {std::pair("bare", "bare"), {"close", "close-fitting clothes"}, {"loose", "loose clothes"}})
    add_group(groups, people, name, [word = word](const SitePerson& p) { return p.clothing == word; });
  return groups;
}

}  // namespace

int people_for_claim(double bias, double sd, double allowance) {
  const double room = allowance - std::abs(bias);
  if (room <= 0) return 0;
  const double roots = 1.96 * sd / room;
  return std::max(kIsoPeopleMin, static_cast<int>(std::min(1e6, std::ceil(roots * roots))));
}

SiteStudy study_of(const std::vector<SitePerson>& visits) {
  const std::vector<SitePerson> each = one_visit_each(visits);
  People people;
  for (const SitePerson& p : each) people.push_back(&p);
  SiteStudy study;
  study.visits = static_cast<int>(visits.size());
  study.people = static_cast<int>(each.size());
  for (std::size_t m = 0; m < kMeasurementCount; ++m) study.measurements[m] = measurement_study(people, m);
  study.groups = groups_of(people);
  int sexes = 0, sexes_right = 0, sizes = 0, sizes_right = 0;
  for (const SitePerson* p : people) {
    if (p->woman) ++sexes, sexes_right += (p->female > 0.5) == *p->woman ? 1 : 0;
    if (!p->worn_size.empty() && !p->answered_size.empty())
      ++sizes, sizes_right += p->worn_size == p->answered_size ? 1 : 0;
  }
  study.sex_right = share_of_count(sexes_right, sexes);
  study.size_right = share_of_count(sizes_right, sizes);
  return study;
}

}  // namespace im2fit::lab
