// SPDX-License-Identifier: Apache-2.0
// Fixed point with the Q format in the type. Fixed<std::int32_t, 10> in mm: a value of raw / 2^10 mm.
//
// Scaling and overflow
// - a + b, a - b, -a: same format only. Two's complement wrap-round; a checked build (-DIM2FIT_CHECKED_FIXED) traps.
// - saturating_add(a, b): clamps (NEON vqadd).
// - a * b: the high half, rounded, defined as NEON's vqrdmulh: saturate((2 a b + 2^(bits-1)) >> bits) on the raws.
// The
//   integer bits add: Fixed<R, F> * Fixed<R, G> is Fixed<R, F + G - (bits - 1)>. Only min * min saturates; a checked
//   build traps it.
// - wide_product(a, b): exact, Fixed<twice as wide, F + G>.
// - rescale<G>(a): shifts; to fewer fraction bits rounds half up (NEON vrshr), to more saturates (vqshl; checked:
// traps).
// - from_real: nearest, half away from zero, saturating (checked: traps); NaN gives zero (checked: traps).
// - square_root(a): Fixed<std::int64_t, 2F> >= 0 to Fixed<std::int32_t, F>, rounded down, saturating (checked:
// traps).
#pragma once

#include <compare>
#include <cstdint>
#include <limits>
#include <type_traits>

namespace im2fit {

// Checked and plain code get different names, so that one program may hold both.
#ifdef IM2FIT_CHECKED_FIXED
inline namespace fixed_checked {
constexpr bool kFixedIsChecked = true;
#else
inline namespace fixed_plain {
constexpr bool kFixedIsChecked = false;
#endif

namespace fixed_detail {

template <class Raw>
struct WiderOf;
template <>
struct WiderOf<std::int8_t> {
  using type = std::int16_t;
};
template <>
struct WiderOf<std::int16_t> {
  using type = std::int32_t;
};
template <>
struct WiderOf<std::int32_t> {
  using type = std::int64_t;
};
template <class Raw>
using Wider = typename WiderOf<Raw>::type;

inline void must_hold(bool condition) {
  if (kFixedIsChecked && !condition) __builtin_trap();
}

// The nearest Raw to a value computed in a wider type.
template <class Raw, class Wide>
Raw clamp_to(Wide value) {
  constexpr Wide low = std::numeric_limits<Raw>::min(), high = std::numeric_limits<Raw>::max();
  return static_cast<Raw>(value < low ? low : value > high ? high : value);
}

template <class Raw, class Wide>
Raw clamp_checked(Wide value) {
  const Raw clamped = clamp_to<Raw>(value);
  must_hold(clamped == value);
  return clamped;
}

}  // namespace fixed_detail

template <class RawType, int kFraction>
class Fixed {
  static_assert(std::is_signed_v<RawType>);
  static_assert(kFraction >= 0 && kFraction < static_cast<int>(8 * sizeof(RawType)));

 public:
  using Raw = RawType;
  static constexpr int kFractionBits = kFraction;
  static constexpr int kBits = static_cast<int>(8 * sizeof(RawType));

  constexpr Fixed() = default;
  static constexpr Fixed from_raw(Raw raw) {
    Fixed f;
    f.raw_ = raw;
    return f;
  }
  static Fixed from_real(double value) {
    const double scaled = value * scale();
    // The largest Raw as a double may round up to 2^(bits-1): compare with that power itself.
    const double limit = scale_of(kBits - 1);
    const bool fits = scaled > -limit - 0.5 && scaled < limit - 0.5;
    fixed_detail::must_hold(fits);
    if (scaled != scaled) return from_raw(0);
    if (!fits) return from_raw(scaled > 0 ? std::numeric_limits<Raw>::max() : std::numeric_limits<Raw>::min());
    return from_raw(static_cast<Raw>(scaled + (scaled < 0 ? -0.5 : 0.5)));
  }

  constexpr Raw raw() const { return raw_; }
  constexpr double real() const { return static_cast<double>(raw_) / scale(); }

  friend constexpr auto operator<=>(const Fixed&, const Fixed&) = default;  // NOLINT(modernize-use-nullptr)
  friend Fixed operator+(Fixed a, Fixed b) {
    Raw sum;
    const bool overflow = __builtin_add_overflow(a.raw_, b.raw_, &sum);
    fixed_detail::must_hold(!overflow);
    return from_raw(sum);
  }
  friend Fixed operator-(Fixed a, Fixed b) {
    Raw difference;
    const bool overflow = __builtin_sub_overflow(a.raw_, b.raw_, &difference);
    fixed_detail::must_hold(!overflow);
    return from_raw(difference);
  }
  friend Fixed operator-(Fixed a) { return Fixed() - a; }

 private:
  static constexpr double scale_of(int bits) { return static_cast<double>(std::uint64_t{1} << bits); }
  static constexpr double scale() { return scale_of(kFraction); }

  Raw raw_ = 0;
};

template <class Raw, int kFraction>
Fixed<Raw, kFraction> saturating_add(Fixed<Raw, kFraction> a, Fixed<Raw, kFraction> b) {
  using Wide = fixed_detail::Wider<Raw>;
  const Wide sum = static_cast<Wide>(static_cast<Wide>(a.raw()) + static_cast<Wide>(b.raw()));
  return Fixed<Raw, kFraction>::from_raw(fixed_detail::clamp_to<Raw>(sum));
}

// vqrdmulh on raws.
template <class Raw>
Raw rounding_doubling_high_multiply(Raw a, Raw b) {
  using Wide = fixed_detail::Wider<Raw>;
  constexpr int kBits = static_cast<int>(8 * sizeof(Raw));
  constexpr Raw kMin = std::numeric_limits<Raw>::min();
  const bool saturates = a == kMin && b == kMin;
  fixed_detail::must_hold(!saturates);
  if (saturates) return std::numeric_limits<Raw>::max();
  const Wide product = static_cast<Wide>(static_cast<Wide>(a) * static_cast<Wide>(b));
  // (2ab + 2^(bits-1)) >> bits, without the doubling that would need one more bit.
  return static_cast<Raw>((product + (Wide{1} << (kBits - 2))) >> (kBits - 1));
}

template <class Raw, int kA, int kB>
auto operator*(Fixed<Raw, kA> a, Fixed<Raw, kB> b) {
  constexpr int kFraction = kA + kB - (Fixed<Raw, kA>::kBits - 1);
  static_assert(kFraction >= 0, "the product has more integer bits than the type: rescale a factor first");
  return Fixed<Raw, kFraction>::from_raw(rounding_doubling_high_multiply(a.raw(), b.raw()));
}

template <class Raw, int kA, int kB>
auto wide_product(Fixed<Raw, kA> a, Fixed<Raw, kB> b) {
  using Wide = fixed_detail::Wider<Raw>;
  return Fixed<Wide, kA + kB>::from_raw(static_cast<Wide>(static_cast<Wide>(a.raw()) * static_cast<Wide>(b.raw())));
}

template <int kTo, class Raw, int kFrom>
Fixed<Raw, kTo> rescale(Fixed<Raw, kFrom> a) {
  using Wide = fixed_detail::Wider<Raw>;
  const Wide raw = a.raw();
  if constexpr (kTo < kFrom) {
    constexpr int kShift = kFrom - kTo;
    return Fixed<Raw, kTo>::from_raw(static_cast<Raw>((raw + (Wide{1} << (kShift - 1))) >> kShift));
  } else {
    return Fixed<Raw, kTo>::from_raw(
        fixed_detail::clamp_checked<Raw>(static_cast<Wide>(raw * (Wide{1} << (kTo - kFrom)))));
  }
}

// The largest integer whose square is at most n. The double root is within one of it: 53 bits hold a 32-bit root.
inline std::uint32_t integer_square_root(std::uint64_t n) {
  auto root = static_cast<std::uint64_t>(__builtin_sqrt(static_cast<double>(n)));
  if (root > 0xFFFFFFFFU) root = 0xFFFFFFFFU;
  while (root * root > n) --root;
  while (root < 0xFFFFFFFFU && (root + 1) * (root + 1) <= n) ++root;
  return static_cast<std::uint32_t>(root);
}

template <int kTwice>
auto square_root(Fixed<std::int64_t, kTwice> a) {
  static_assert(kTwice % 2 == 0);
  fixed_detail::must_hold(a.raw() >= 0);
  const std::int64_t root = a.raw() < 0 ? 0 : integer_square_root(static_cast<std::uint64_t>(a.raw()));
  return Fixed<std::int32_t, kTwice / 2>::from_raw(fixed_detail::clamp_checked<std::int32_t>(root));
}

}  // inline namespace

}  // namespace im2fit
