// SPDX-License-Identifier: Apache-2.0
// What IM2FIT_PRECOMPILE reads once: the standard headers that most files include.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
