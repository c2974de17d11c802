// SPDX-License-Identifier: Apache-2.0
// References of kernels over depth pictures and masks.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <utility>
#include <vector>

#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {

void average_ref(const std::uint16_t* depth, const std::uint8_t* mask, int count, std::uint32_t* sum,
                 std::uint16_t* seen) {
  for (int i = 0; i < count; ++i) {
    const double z = depth[i];
    if (mask[i] == 0 || z == 0 || z > kFusedDepthMaxMm) continue;
    // In whole numbers: a mean of sum / seen would be rounded.
    if (seen[i] > 0 && std::fabs(z * seen[i] - sum[i]) > double{kOutlierMm} * seen[i]) continue;
    sum[i] += depth[i];
    ++seen[i];
  }
}

void blend_ref(const BlendRun* runs, int run_count, const std::int16_t* deltas, const BlendInto* into,
               int into_count) {
  for (int m = 0; m < into_count; ++m) {
    for (const BlendRun* run = runs; run != runs + run_count; ++run) {
      for (std::size_t i = 0; i < 3U * run->vertex_count; ++i) {
        float& value = into[m].vertices[std::size_t{run->first_vertex} * 3 + i];
        const double delta = deltas[std::size_t{run->first_delta} * 3 + i];
        value = static_cast<float>(double{value} + double{into[m].scale} * delta);
      }
    }
  }
}

void blocks_ref(DepthView depth_q4, MaskView mask, const BlockGrid& grid, std::uint32_t* sum_q4,
                std::uint16_t* count) {
  for (int j = 0; j < grid.rows; ++j) {
    for (int i = 0; i < grid.columns; ++i) {
      std::vector<std::uint32_t> seen;
      for (int v = j * grid.step; v < (j + 1) * grid.step; ++v)
        for (int u = i * grid.step; u < (i + 1) * grid.step; ++u)
          if (mask.at(u, v) != 0 && depth_q4.at(u, v) != 0) seen.push_back(depth_q4.at(u, v));
      *sum_q4 = 0;
      *count = 0;
      for (const std::uint32_t d : seen) {
        if (d > *std::min_element(seen.begin(), seen.end()) + kSurfaceQ4) continue;
        *sum_q4 += d;
        ++*count;
      }
      ++sum_q4;
      ++count;
    }
  }
}

void contour_ref(ImageView<const std::uint16_t> depth_q4, MaskView mask, ContourRow* rows, std::uint64_t* seen,
                 std::uint64_t* steps) {
  const std::size_t words = contour_words(depth_q4.width);
  std::fill_n(seen, words * static_cast<std::size_t>(depth_q4.height), 0);
  std::fill_n(steps, words * static_cast<std::size_t>(depth_q4.height), 0);
  const auto depth_at = [&](int u, int v) {
    return u >= 0 && mask.at(u, v) != 0 ? static_cast<int>(depth_q4.at(u, v)) : 0;
  };
  for (int v = 0; v < depth_q4.height; ++v) {
    ContourRow row = {depth_q4.width, -1, 0, 0, 0};
    for (int u = 0; u < depth_q4.width; ++u) {
      const int here = depth_at(u, v), before = depth_at(u - 1, v);
      if (here == 0) continue;
      const std::size_t word = static_cast<std::size_t>(v) * words + static_cast<std::size_t>(u) / 64;
      const std::uint64_t bit = std::uint64_t{1} << (u % 64);
      seen[word] |= bit;
      if (before != 0 && std::abs(here - before) >= kContourStepQ4) steps[word] |= bit;
      row.first = std::min(row.first, u);
      row.last = u;
      ++row.count;
      row.depth_sum += static_cast<std::uint32_t>(here);
      row.depth_square_sum += static_cast<std::uint64_t>(here) * static_cast<std::uint64_t>(here);
    }
    rows[v] = row;
  }
}

namespace joints {

void downsample_box_ref(const DownsampleBox& box, std::uint16_t* out, DownsampleMoments& moments) {
  moments = {};
  for (int v = 0; v < box.height; ++v) {
    for (int u = 0; u < box.width; ++u) {
      std::uint16_t z = 0;
      for (int y = (box.v_first + v) * box.step; y < (box.v_first + v + 1) * box.step; ++y)
        for (int x = (box.u_first + u) * box.step; x < (box.u_first + u + 1) * box.step; ++x)
          if (z == 0 && y < box.depth.height && x < box.depth.width && box.mask.at(x, y) != 0) z = box.depth.at(x, y);
      *out++ = z;
      moments.count += z != 0 ? 1 : 0;
      moments.z += z;
      moments.uz += std::int64_t{z} * u;
      moments.vz += std::int64_t{z} * v;
    }
  }
}

}  // namespace joints

void floor_sums_ref(DepthView depth, int step, const FloorGate& gate, const FloorCell* cells, int count,
                    PlaneSums& out) {
  out = {};
  for (int i = 0; i < count; ++i) {
    const FloorCell& cell = cells[i];
    for (int v = cell.v; v < cell.v + step; v += cell.stride) {
      for (int u = cell.u; u < cell.u + step; u += cell.stride) {
        const std::uint16_t raw = depth.at(u, v);
        if (raw == 0 || raw > 10000) continue;
        // The gate in float, as its edge decides about whole pixels.
        const float z = raw;
        const float height = (gate.up_x * gate.ray_x[u] + gate.row_up[v]) * z + gate.camera_height_mm;
        if (std::fabs(height) > gate.flat_mm + gate.noise * z) continue;
        const double x = gate.ray_x[u], y = gate.ray_y[v], t = -1.0 / raw, w = cell.weight;
        const double a[6] = {x * x, x * y, x, y * y, y, 1}, b[3] = {t * x, t * y, t};
        for (int k = 0; k < 6; ++k) out.a[k] += w * a[k];
        for (int k = 0; k < 3; ++k) out.b[k] += w * b[k];
        out.weight += w;
      }
    }
  }
}

void links_ref(const LinkCells& cells, std::uint8_t* links) {
  for (int r = 0; r < cells.height; ++r) {
    for (int c = 0; c < cells.width; ++c) {
      const auto at = [&](int dc, int dr) {
        return static_cast<std::size_t>(r + dr) * static_cast<std::size_t>(cells.width) +
               static_cast<std::size_t>(c + dc);
      };
      const auto inside = [&](int dc, int dr) {
        return c + dc >= 0 && c + dc < cells.width && r + dr < cells.height;
      };
      const auto joined = [&](int dc, int dr) {
        if (!inside(dc, dr)) return false;
        const std::size_t a = at(0, 0), b = at(dc, dr);
        return cells.surface[a] != 0 && cells.surface[b] != 0 &&
               std::abs(cells.surface[a] - cells.surface[b]) <= std::min(cells.limit[a], cells.limit[b]);
      };
      const auto hole = [&](int dc, int dr) { return inside(dc, dr) && cells.depth[at(dc, dr)] == 0; };
      int bits = 0;
      if (joined(1, 0)) bits |= kLinkRight;
      if (hole(1, 0) && joined(2, 0)) bits |= kLinkRightOverHole;
      if (joined(0, 1)) bits |= kLinkDown;
      if (hole(0, 1) && joined(0, 2)) bits |= kLinkDownOverHole;
      if (joined(-1, 1)) bits |= kLinkDownLeft;
      if (joined(1, 1)) bits |= kLinkDownRight;
      links[at(0, 0)] = static_cast<std::uint8_t>(bits);
    }
  }
}

void mean_ref(const std::uint32_t* sum, const std::uint16_t* seen, int count, int needed, std::uint16_t* depth_q4,
              std::uint8_t* mask) {
  for (int i = 0; i < count; ++i) {
    const bool keep = seen[i] >= needed;
    mask[i] = keep ? 255 : 0;
    // A double holds 2 x 16 sum + seen, and the quotient differs from a half by at least 1 / (2 seen).
    depth_q4[i] = keep ? static_cast<std::uint16_t>(std::floor(16.0 * sum[i] / seen[i] + 0.5)) : std::uint16_t{0};
  }
}

namespace {

double nearest(const std::vector<double>& depths, double z) {
  double best = 1e9;
  for (const double d : depths) best = std::min(best, std::fabs(z - d));
  return best;
}

}  // namespace

void membership_ref(DepthView depth, const MembershipCells& cells, const std::uint32_t* list, int count,
                    MaskImage mask) {
  for (int i = 0; i < count; ++i) {
    const int c = static_cast<int>(list[i] & 0xFFFF), r = static_cast<int>(list[i] >> 16);
    std::vector<double> person, other;
    for (int rr = r - 1; rr <= r + 1; ++rr) {
      for (int cc = c - 1; cc <= c + 1; ++cc) {
        const std::uint16_t p = cells.person[rr * cells.stride + cc], o = cells.other[rr * cells.stride + cc];
        if (p != kNoSurface) person.push_back(p);
        if (o != kNoSurface) other.push_back(o);
      }
    }
    const std::uint16_t own = cells.person[r * cells.stride + c];
    const int v_end = r + 1 == cells.height ? mask.height : (r + 1) * cells.step;
    const int u_end = c + 1 == cells.width ? mask.width : (c + 1) * cells.step;
    for (int v = r * cells.step; v < v_end; ++v) {
      for (int u = c * cells.step; u < u_end; ++u) {
        const double z = depth.at(u, v);
        const double limit = 40 + 1.5 * 2.85e-6 * z * z;
        const double away = nearest(person, z);
        const bool inside = other.empty() && own != kNoSurface && std::fabs(z - own) < 40;
        const bool belongs = away <= limit && away <= nearest(other, z);
        mask.at(u, v) = z >= 1 && z <= 10000 && (inside || belongs) ? 255 : 0;
      }
    }
  }
}

void sample_ref(DepthView depth, int step, std::uint16_t* out) {
  const int last = step - 1;
  for (int r = 0; r < depth.height / step; ++r) {
    for (int c = 0; c < depth.width / step; ++c) {
      std::array<std::uint16_t, 5> seen;
      seen.fill(65535);  // sorts last
      std::size_t count = 0;
      for (const auto& [u, v] : {std::pair(0, 0), {last, 0}, {step / 2, step / 2}, {0, last}, {last, last}}) {
        const std::uint16_t z = depth.at(c * step + u, r * step + v);
        if (z != 0 && z <= kSampleDepthMaxMm) seen[count++] = z;
      }
      std::sort(seen.begin(), seen.end());
      *out++ = count == 0 ? std::uint16_t{0} : seen[(count - 1) / 2];
    }
  }
}

void silhouette_ref(DepthView depth, MaskView mask, Silhouette& out) {
  out = {};
  for (int v = 0; v < mask.height; ++v) {
    for (int u = 0; u < mask.width; ++u) {
      if (mask.at(u, v) == 0) continue;
      const std::uint64_t z = depth.at(u, v);
      const bool first = out.count++ == 0;
      out.u_min = first ? u : std::min(out.u_min, u);
      out.u_max = first ? u : std::max(out.u_max, u);
      out.v_min = first ? v : std::min(out.v_min, v);
      out.v_max = v;
      out.sum_z += z;
      out.sum_uz += static_cast<std::uint64_t>(u) * z;
      out.sum_vz += static_cast<std::uint64_t>(v) * z;
    }
  }
}

void unpack11_ref(const std::uint8_t* packed, int count, std::uint16_t* out) {
  std::size_t bit = 0;
  for (int i = 0; i < count; ++i) {
    int value = 0;
    for (int k = 0; k < 11; ++k, ++bit) value = 2 * value + ((packed[bit / 8] >> (7 - bit % 8)) & 1);
    out[i] = static_cast<std::uint16_t>(value);
  }
}

}  // namespace im2fit
