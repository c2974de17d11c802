// SPDX-License-Identifier: Apache-2.0
// The evaluation's family `ansur`: people of ANSUR II's dimensions on bodies that the training people's maker did not
// make. Each is a smooth least-energy deformation (deformation_graph.h) of one of six fixed mean meshes (sex, build)
// to the 40 dimensions of body_dimensions.h; no slider is moved for a person, no section is scaled. The mean meshes
// are the body model's, smoothed, with other heads, hands and feet. What the survey does not say varies: how far the
// back lies behind the sides, bumps, left against right.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/status.h"
#include "evaluation/population/ansur_rows.h"
#include "evaluation/population/body_dimensions.h"
#include "train/population/population.h"

namespace im2fit::lab {

class AnsurPeople {
 public:
  // About five seconds, 150 MB; then 0.2 s a person. `model` must outlive it. `folder`: of ANSUR II's two files.
  static Result<AnsurPeople> load(const body::BodyModel& model, const std::string& folder,
                                  const AnsurSettings& settings = {});
  AnsurPeople(AnsurPeople&&) noexcept;
  ~AnsurPeople();

  // Deterministic: depends on the model, the survey, seed and index only. Even indices are men, odd ones women.
  // Offsets are of all vertices, helpers too; `family` is held_out. `rest` becomes what morph_subject() makes of it.
  Subject draw(std::uint64_t seed, std::uint64_t index, std::vector<Vec3f>& rest) const;

  // The same with the wanted dimensions and those of the mesh. NaN in `wanted`: any.
  struct Made {
    Subject subject;
    DimensionValues wanted{}, achieved{};
  };
  Made make(std::uint64_t seed, std::uint64_t index, std::vector<Vec3f>& rest) const;

 private:
  struct State;
  explicit AnsurPeople(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

// Where ANSUR II lies when no option says: $IM2FIT_SHARED/data/ansur2, else ../shared/data/ansur2 from the folder the
// program is called in.
std::string default_ansur_folder();

}  // namespace im2fit::lab
