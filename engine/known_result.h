// SPDX-License-Identifier: Apache-2.0
// Known facts in a result of the engine, also of a session that is over: a corrected fact needs no new frames.
#pragma once

#include "engine/engine.h"
#include "estimate/known_facts.h"

namespace im2fit {

// What Engine::result() gives when the person of `before` reports `facts`. `before`: read while no fact was known.
inline EngineResult with_known(const EngineResult& before, const KnownFacts& facts) {
  EngineResult result = before;
  result.unconditioned = result.answer.measurements;
  result.known = facts;
  result.known_outcome = {};
  if (result.measured || result.front_measured) result.known_outcome = condition(facts, result.answer, result.age);
  return result;
}

}  // namespace im2fit
