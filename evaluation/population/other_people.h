// SPDX-License-Identifier: Apache-2.0
// The evaluation's family `other`: men of ANSUR II's dimensions on a surface of another make than the training
// people's: another mean mesh, another topology, a rig of its own (other_mesh.h, other_rig.h). Each is the smooth
// least-energy deformation of that mean to the dimensions of a row of the survey's judging part. The family judges:
// it never teaches, calibrates or tunes. Men only, since the make has no women.
//
// Heavier people are pooled: person `index` is a row drawn with replacement from the band `index` modulo 5 of
// kOtherBands, so every band has an equal share.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "core/status.h"
#include "evaluation/population/ansur_rows.h"
#include "evaluation/population/other_rig.h"
#include "train/population/population.h"

namespace im2fit::lab {

// Of body mass index: from the first on, below the second.
inline constexpr std::array<std::array<double, 2>, 5> kOtherBands = {
    {{18, 22}, {22, 26}, {26, 30}, {30, 34}, {34, 38}}};

class OtherPeople {
 public:
  // Folders of s-scape_male.obj and of ANSUR II's two files. `settings`: end_share is not used.
  static Result<OtherPeople> load(const std::string& mesh_folder, const std::string& survey_folder,
                                  const AnsurSettings& settings = {});
  OtherPeople(OtherPeople&&) noexcept;
  ~OtherPeople();

  // Deterministic: depends on the mesh, the survey, seed and index only. `family` is held_out, `actor` is set,
  // `params` say sex and age alone.
  Subject draw(std::uint64_t seed, std::uint64_t index) const;

  // The same with what was wanted and what the mesh has of it. NaN in `wanted`: left free.
  struct Made {
    Subject subject;
    DimensionValues wanted{}, achieved{};
  };
  Made make(std::uint64_t seed, std::uint64_t index) const;

  const OtherRig& rig() const;
  std::size_t rows_in_band(std::size_t band) const;  // of kOtherBands

 private:
  struct State;
  explicit OtherPeople(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace im2fit::lab
