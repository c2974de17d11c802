// SPDX-License-Identifier: Apache-2.0
// Which dimensions the evaluation's family `ansur` wants of its people: rows of ANSUR II's judging part
// (ansur.h), as they are or carried along the survey's own regression to builds it hardly has.
//
// What calipers and tape say of one section does not agree. Against the ellipse of breadth and depth the tape is
// longer by (mean, SD of the survey): waist 1.054 .018 (men), 1.061 .022 (women); hip 1.090, 1.097;
// chest 1.238, 1.165.
// - Waist and hip: the tape's excess is shared out. `pressed_share` of it: calipers press, so breadth and depth are
// of a
//   larger section of the same ratio. `square_share`, varied by person: the section is squarer than an ellipse. The
//   rest: the tape is longer than the hull. Sections of scanned people are about 1.01 of their ellipse, which leaves
//   a fifth of the excess to squareness; scans read waists longer than tapes do, not shorter, which leaves nothing to
//   the rest. No survey decides it: other shares are an option of the evaluation.
// - Chest: girth and depth are honoured. The survey's breadth cannot be of the section its tape goes round (it would
//   have to be a rectangle): its blades lie against the ribs below the arms. A constant by sex is added so that
//   sections are superellipses of exponent 2.5 on average; persons differ in it as they do in the survey.
// - Upper arm and forearm: the survey's are flexed; 0.92 (men), 0.95 (women) and 0.97 of them is taken for hanging
// arms (an assumption, +-2 %).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/rng.h"
#include "core/status.h"
#include "evaluation/population/body_dimensions.h"

namespace im2fit::lab {

inline constexpr double kSquareShareSd = 0.15;
// Perimeter of a superellipse of exponent 2.5 over that of the ellipse: 1.040 for axes like a chest's.
inline constexpr double kChestOverEllipse = 1.040;

struct AnsurSettings {
  double end_share = 0.25;  // of people, carried to the ends of body mass
  // Shares of the tape's excess over the ellipse: by calipers that press and by squareness (mean over people;
  // kSquareShareSd about it); together 1 at most.
  double pressed_share = 0.8, square_share = 0.2;
};

// A person to be made. Weight is the survey's own, kg.
struct WantedPerson {
  bool woman = false;
  double age_years = 30;
  DimensionValues wanted{};  // NaN: the survey does not say
};

class AnsurRows {
 public:
  // Of the judging part, both sexes. Errors name the file and the missing part.
  static Result<AnsurRows> load(const std::string& folder);

  // A row drawn with replacement. A share of people are carried to an end instead, evenly to either: from a row
  // of the lighter or heavier third, every dimension by its elasticity on weight at equal stature, to a body mass
  // index drawn evenly from 17..19 or 32..42.
  WantedPerson draw(bool woman, const AnsurSettings& settings, Rng& rng) const;

  // A row drawn with replacement from those of a body mass index of at least `index_low` and below `index_high`, as
  // it is. There must be one: see count_between.
  WantedPerson draw_between(bool woman, double index_low, double index_high, const AnsurSettings& settings,
                            Rng& rng) const;
  std::size_t count_between(bool woman, double index_low, double index_high) const;

  std::size_t count(bool woman) const { return sexes_[woman ? 1 : 0].people.size(); }

 private:
  struct Sex {
    std::vector<std::vector<double>> people;  // columns as in the .cpp
    std::vector<double> elasticity;           // of each column on weight
    std::vector<std::size_t> by_mass_index;   // lightest first
    double chest_wider_mm = 0;
  };
  // Places in by_mass_index: first, one past the last.
  std::array<std::size_t, 2> between(bool woman, double index_low, double index_high) const;
  WantedPerson wanted_of(bool woman, const std::vector<double>& row, const AnsurSettings& settings, Rng& rng) const;

  std::vector<Sex> sexes_;  // men, women
};

// Perimeter of an ellipse of these axes (Ramanujan 1914).
double ellipse_perimeter(double breadth, double depth);

}  // namespace im2fit::lab
