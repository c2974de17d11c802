// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

namespace im2fit {

struct Vec3f {
  float x = 0;
  float y = 0;
  float z = 0;
};

inline Vec3f operator+(Vec3f a, Vec3f b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vec3f operator-(Vec3f a, Vec3f b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vec3f operator-(Vec3f a) {
  return {-a.x, -a.y, -a.z};
}
inline Vec3f operator*(Vec3f a, float s) {
  return {a.x * s, a.y * s, a.z * s};
}
inline float dot(Vec3f a, Vec3f b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vec3f cross(Vec3f a, Vec3f b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline float norm(Vec3f a) {
  return std::sqrt(dot(a, a));
}
// The zero vector stays zero.
inline Vec3f normalized(Vec3f a) {
  const float n = norm(a);
  return n > 0 ? a * (1.0F / n) : a;
}

}  // namespace im2fit
