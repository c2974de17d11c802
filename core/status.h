// SPDX-License-Identifier: Apache-2.0
// Errors as values. A message names the file or field, what was found, what was expected, and what to do.
#pragma once

#include <string>
#include <utility>
#include <variant>

namespace im2fit {

enum class ErrorCode {
  invalid_argument,  // an argument of the caller is wrong
  not_found,
  io,       // reading or writing failed (also: disk full, no permission)
  corrupt,  // a file is damaged, truncated or foreign
  unsupported,
  no_device,
  timeout,
  end_of_stream,
};

struct Error {
  ErrorCode code = ErrorCode::invalid_argument;
  std::string message;
};

// A value or the reason there is none. Use: `auto r = f(); if (!r) return r.error(); use(*r);`
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}      // NOLINT(google-explicit-constructor)
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}  // NOLINT(google-explicit-constructor)

  explicit operator bool() const { return state_.index() == 0; }
  T& operator*() & { return std::get<0>(state_); }
  const T& operator*() const& { return std::get<0>(state_); }
  T&& operator*() && { return std::get<0>(std::move(state_)); }
  T* operator->() { return &std::get<0>(state_); }
  const T* operator->() const { return &std::get<0>(state_); }
  const Error& error() const { return std::get<1>(state_); }

 private:
  std::variant<T, Error> state_;
};

struct Ok {};
using Status = Result<Ok>;

}  // namespace im2fit
