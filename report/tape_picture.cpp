// SPDX-License-Identifier: Apache-2.0
#include "report/tape_picture.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <vector>

namespace im2fit {
namespace {

constexpr int kBodyHeight = 820;  // pixels
constexpr int kPanelWidth = 480;
constexpr int kMargin = 40;
constexpr int kHeight = kBodyHeight + 2 * kMargin;
constexpr float kHiddenMm = 12;  // so far behind the skin a line is hidden: tapes bridge hollows and cut corners
constexpr float kStepMm = 2;     // of a line
constexpr Rgb kPaper = {255, 255, 255}, kLine = {208, 32, 48}, kInk = {40, 40, 40};

// One view: across the picture, up, and towards the viewer, mm.
struct View {
  bool side;
  int left;  // of the panel, pixels
  float middle, low, scale;
  float across(const Vec3f& p) const { return side ? -p.z : p.x; }
  float near(const Vec3f& p) const { return side ? p.x : p.z; }
  float x(const Vec3f& p) const {
    return static_cast<float>(left) + kPanelWidth / 2.0F + (across(p) - middle) * scale;
  }
  float y(const Vec3f& p) const { return static_cast<float>(kHeight - kMargin) - (p.y - low) * scale; }
};

struct Surface {
  std::vector<float> nearest = std::vector<float>(static_cast<std::size_t>(2 * kPanelWidth * kHeight), -1e9F);
  float& at(int x, int y) { return nearest[static_cast<std::size_t>(y * 2 * kPanelWidth + x)]; }
};

std::string upper(std::string text) {
  for (char& c : text) c = c == '_' ? ' ' : static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

void fill(const View& view, const std::array<Vec3f, 3>& t, Surface& surface, Canvas& canvas) {
  const Vec3f n = normalized(cross(t[1] - t[0], t[2] - t[0]));
  const float facing = view.side ? n.x : n.z;
  if (facing <= 0) return;
  const auto grey = static_cast<std::uint8_t>(120 + 100 * facing);
  const std::array<float, 3> x = {view.x(t[0]), view.x(t[1]), view.x(t[2])};
  const std::array<float, 3> y = {view.y(t[0]), view.y(t[1]), view.y(t[2])};
  const int x0 = std::max(view.left, static_cast<int>(std::floor(*std::min_element(x.begin(), x.end()))));
  const int x1 =
      std::min(view.left + kPanelWidth - 1, static_cast<int>(std::ceil(*std::max_element(x.begin(), x.end()))));
  const int y0 = std::max(0, static_cast<int>(std::floor(*std::min_element(y.begin(), y.end()))));
  const int y1 = std::min(kHeight - 1, static_cast<int>(std::ceil(*std::max_element(y.begin(), y.end()))));
  const float area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
  if (area == 0) return;
  for (int py = y0; py <= y1; ++py)
    for (int px = x0; px <= x1; ++px) {
      const float fx = static_cast<float>(px), fy = static_cast<float>(py);
      const float b = ((fx - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (fy - y[0])) / area;
      const float c = ((x[1] - x[0]) * (fy - y[0]) - (fx - x[0]) * (y[1] - y[0])) / area;
      if (b < 0 || c < 0 || b + c > 1) continue;
      const float depth = (1 - b - c) * view.near(t[0]) + b * view.near(t[1]) + c * view.near(t[2]);
      if (depth <= surface.at(px, py)) continue;
      surface.at(px, py) = depth;
      canvas.set(px, py, {grey, grey, grey});
    }
}

bool hidden(const View& view, const Vec3f& p, Surface& surface) {
  const int x = static_cast<int>(std::lround(view.x(p))), y = static_cast<int>(std::lround(view.y(p)));
  if (x < 0 || x >= 2 * kPanelWidth || y < 0 || y >= kHeight) return false;
  return view.near(p) < surface.at(x, y) - kHiddenMm;
}

void draw_segment(const View& view, const Vec3f& a, const Vec3f& b, Surface& surface, TapePicture& picture) {
  const int steps = 1 + static_cast<int>(norm(b - a) / kStepMm);
  for (int i = 0; i < steps; ++i) {
    const Vec3f p = a + (b - a) * (static_cast<float>(i) / static_cast<float>(steps));
    const Vec3f q = a + (b - a) * (static_cast<float>(i + 1) / static_cast<float>(steps));
    const bool behind = hidden(view, p, surface) && hidden(view, q, surface);
    picture.canvas.line(view.x(p), view.y(p), view.x(q), view.y(q), behind ? 1.5F : 3.0F, kLine,
                        behind ? 0.4F : 1.0F);
    picture.svg += fmt::format("<path class=\"{}\" d=\"M{:.1f} {:.1f}L{:.1f} {:.1f}\"/>\n", behind ? "h" : "t",
                               view.x(p), view.y(p), view.x(q), view.y(q));
  }
}

// The silhouette as runs of pixels, a stroke a run.
std::string silhouette(Surface& surface) {
  std::string path;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < 2 * kPanelWidth; ++x) {
      if (surface.at(x, y) < -1e8F) continue;
      const int from = x;
      while (x < 2 * kPanelWidth && surface.at(x, y) >= -1e8F) ++x;
      path += fmt::format("M{} {}h{}", from, y, x - from);
    }
  return path;
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '&' ? "&amp;" : c == '<' ? "&lt;" : std::string(1, c);
  return out;
}

}  // namespace

TapePicture draw_tape(const body::BodyModel& model, std::span<const Vec3f> mesh, const body::TapeLines& lines,
                      const std::string& title) {
  Vec3f low = mesh[0], high = low;
  for (const Vec3f& v : mesh.first(static_cast<std::size_t>(model.body_vertex_count()))) {
    low = {std::min(low.x, v.x), std::min(low.y, v.y), std::min(low.z, v.z)};
    high = {std::max(high.x, v.x), std::max(high.y, v.y), std::max(high.z, v.z)};
  }
  const float scale = std::min(kBodyHeight / (high.y - low.y), (kPanelWidth - 20) / (high.x - low.x));
  const std::array<View, 2> views = {
      {{false, 0, (low.x + high.x) / 2, low.y, scale}, {true, kPanelWidth, -(low.z + high.z) / 2, low.y, scale}}};
  TapePicture picture;
  picture.canvas = Canvas(2 * kPanelWidth, kHeight);
  picture.canvas.rectangle(0, 0, 2 * kPanelWidth, kHeight, kPaper);
  Surface surface;
  for (const View& view : views)
    for (const auto& t : model.body_triangles())
      fill(view,
           {mesh[static_cast<std::size_t>(t[0])], mesh[static_cast<std::size_t>(t[1])],
            mesh[static_cast<std::size_t>(t[2])]},
           surface, picture.canvas);
  for (const View& view : views)
    for (const auto& line : lines)
      for (std::size_t i = 1; i < line.size(); ++i) draw_segment(view, line[i - 1], line[i], surface, picture);
  picture.canvas.text(16, 12, upper(title), 2, kInk);
  picture.svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\">\n"
      "<title>{2}</title>\n<style>.b{{stroke:#bbb}}.t{{stroke:#d02030;stroke-width:3;stroke-linecap:round}}"
      ".h{{stroke:#d02030;stroke-opacity:.4;stroke-width:1.5}}</style>\n"
      "<rect width=\"{0}\" height=\"{1}\" fill=\"#fff\"/>\n<path class=\"b\" d=\"{3}\"/>\n{4}"
      "<text x=\"16\" y=\"26\" font-family=\"sans-serif\" font-size=\"16\" fill=\"#282828\">{2}</text>\n</svg>\n",
      2 * kPanelWidth, kHeight, escaped(title), silhouette(surface), picture.svg);
  return picture;
}

}  // namespace im2fit
