// SPDX-License-Identifier: Apache-2.0
#include "evaluation/population/deformation_graph.h"

#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <queue>
#include <utility>

#include "body/model_data.h"

namespace im2fit::lab {
namespace {

constexpr int kNodes = 420;          // about 65 mm apart: sections of a trunk have a dozen, of an arm three or four
constexpr std::size_t kNearest = 5;  // nodes that move a vertex
// Energy: what neighbouring maps disagree on, mm^2 at each other's node, plus this times the squared difference of
// their matrices. Larger: smoother; well above the squared spacing details no longer follow.
constexpr double kStiffnessMm2 = 65.0 * 65.0 * 3;
constexpr double kHeld = 1e-4;  // share of the mean diagonal that keeps the whole mesh where it is
// Helpers follow the skin no farther from them than this times the nearest, plus the second.
constexpr float kAroundFactor = 1.3F, kAroundMm = 12;

struct Influence {
  int node = 0;
  float weight = 0;
};

using Graph = std::vector<std::vector<std::pair<int, float>>>;

Graph edges_of(const body::BodyModel& model, std::span<const Vec3f> rest) {
  Graph graph(static_cast<std::size_t>(model.body_vertex_count()));
  for (const auto& quad : model.body_quads())
    for (std::size_t i = 0; i < 4; ++i) {
      const auto a = static_cast<std::size_t>(quad[i]), b = static_cast<std::size_t>(quad[(i + 1) % 4]);
      if (a == b) continue;
      const float length = norm(rest[a] - rest[b]);
      graph[a].emplace_back(static_cast<int>(b), length);
      graph[b].emplace_back(static_cast<int>(a), length);
    }
  return graph;
}

// The largest connected part; the rest (eyes and the like, where a model has them) follows as helpers do.
std::vector<bool> main_part(const Graph& graph) {
  std::vector<int> part(graph.size(), -1);
  std::vector<std::size_t> size;
  for (std::size_t start = 0; start < graph.size(); ++start) {
    if (part[start] >= 0) continue;
    const int id = static_cast<int>(size.size());
    size.push_back(0);
    std::vector<std::size_t> open = {start};
    part[start] = id;
    while (!open.empty()) {
      const std::size_t v = open.back();
      open.pop_back();
      ++size.back();
      for (const auto& edge : graph[v]) {
        const auto to = static_cast<std::size_t>(edge.first);
        if (part[to] >= 0) continue;
        part[to] = id;
        open.push_back(to);
      }
    }
  }
  const auto largest = static_cast<int>(std::max_element(size.begin(), size.end()) - size.begin());
  std::vector<bool> inside(graph.size());
  for (std::size_t v = 0; v < graph.size(); ++v) inside[v] = part[v] == largest;
  return inside;
}

// Distances along edges that become no larger than `distance` already says; visited vertices are added to `reached`.
template <class Visit>
void spread(const Graph& graph, int source, float reach, std::vector<float>& distance, const Visit& visit) {
  using Item = std::pair<float, int>;
  std::priority_queue<Item, std::vector<Item>, std::greater<>> open;
  if (distance[static_cast<std::size_t>(source)] <= 0) return;
  distance[static_cast<std::size_t>(source)] = 0;
  open.emplace(0.0F, source);
  while (!open.empty()) {
    const auto [d, v] = open.top();
    open.pop();
    if (d > distance[static_cast<std::size_t>(v)]) continue;
    visit(v, d);
    for (const auto& [to, length] : graph[static_cast<std::size_t>(v)]) {
      const float next = d + length;
      if (next > reach || next >= distance[static_cast<std::size_t>(to)]) continue;
      distance[static_cast<std::size_t>(to)] = next;
      open.emplace(next, to);
    }
  }
}

// Farthest-point sampling along the surface.
std::vector<int> sample_nodes(const Graph& graph, const std::vector<bool>& inside, int first) {
  std::vector<float> distance(graph.size(), std::numeric_limits<float>::max());
  std::vector<int> nodes;
  int next = first;
  for (int i = 0; i < kNodes; ++i) {
    nodes.push_back(next);
    spread(graph, next, std::numeric_limits<float>::max(), distance, [](int, float) {});
    float farthest = -1;
    for (std::size_t v = 0; v < graph.size(); ++v)
      if (inside[v] && distance[v] > farthest) {
        farthest = distance[v];
        next = static_cast<int>(v);
      }
  }
  return nodes;
}

}  // namespace

struct DeformationGraph::State {
  std::vector<Vec3f> rest;
  std::vector<Vec3f> node;                                   // places
  std::vector<std::vector<Influence>> influences;            // of every vertex
  std::vector<std::vector<std::int32_t>> follows;            // of helpers: the skin around them; empty for the skin
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> energy;  // of one coordinate: four unknowns a node
  std::vector<Eigen::MatrixXd> solutions;                    // of responses: unknowns by coordinate
  std::vector<Eigen::MatrixXd> forces;

  void build(const Graph& graph, const std::vector<bool>& inside, std::int32_t first);
  void follow_skin(const body::BodyModel& model, const std::vector<bool>& inside);
  // The four unknowns of a node act on a vertex by these.
  Eigen::Vector4d arm(std::size_t vertex, int n) const {
    const Vec3f d = rest[vertex] - node[static_cast<std::size_t>(n)];
    return {static_cast<double>(d.x), static_cast<double>(d.y), static_cast<double>(d.z), 1.0};
  }
};

namespace {

// Entries of the energy's matrix; those of one place add up.
class Entries {
 public:
  void add(int i, int j, double value) {
    entries_.emplace_back(i, j, value);
    if (i == j) diagonal_[static_cast<std::size_t>(i % 4 == 3 ? 1 : 0)] += value;
  }
  // The map of j at l's place against l's own there.
  void add_edge(Vec3f from, Vec3f to, int j, int l) {
    const Vec3f d = to - from;
    const std::array<double, 5> row = {static_cast<double>(d.x), static_cast<double>(d.y), static_cast<double>(d.z),
                                       1, -1};
    const std::array<int, 5> place = {4 * j, 4 * j + 1, 4 * j + 2, 4 * j + 3, 4 * l + 3};
    for (std::size_t a = 0; a < 5; ++a)
      for (std::size_t b = 0; b < 5; ++b) add(place[a], place[b], row[a] * row[b]);
  }
  void add_stiffness(int j, int l) {
    for (int a = 0; a < 3; ++a) {
      add(4 * j + a, 4 * j + a, kStiffnessMm2);
      add(4 * l + a, 4 * l + a, kStiffnessMm2);
      add(4 * j + a, 4 * l + a, -kStiffnessMm2);
      add(4 * l + a, 4 * j + a, -kStiffnessMm2);
    }
  }
  // Every unknown by a share of the mean diagonal of its kind.
  void hold(double share) {
    const double matrices = share * diagonal_[0] / (3 * kNodes), places = share * diagonal_[1] / kNodes;
    for (int i = 0; i < 4 * kNodes; ++i) entries_.emplace_back(i, i, i % 4 == 3 ? places : matrices);
  }
  Eigen::SparseMatrix<double> matrix() const {
    Eigen::SparseMatrix<double> k(4 * kNodes, 4 * kNodes);
    k.setFromTriplets(entries_.begin(), entries_.end());
    return k;
  }

 private:
  std::vector<Eigen::Triplet<double>> entries_;
  std::array<double, 2> diagonal_{};  // sums: matrices, places
};

// Smoothly less towards the nearest node that no longer counts.
std::vector<std::vector<Influence>> influences_of(const Graph& graph, const std::vector<int>& nodes) {
  std::vector<std::vector<Influence>> near(graph.size());
  std::vector<float> distance(graph.size(), std::numeric_limits<float>::max());
  std::vector<int> touched;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    touched.clear();
    spread(graph, nodes[n], 420, distance, [&](int v, float d) {
      near[static_cast<std::size_t>(v)].push_back({static_cast<int>(n), d});
      touched.push_back(v);
    });
    std::fill(distance.begin(), distance.end(), std::numeric_limits<float>::max());
  }
  for (auto& list : near) {
    std::sort(list.begin(), list.end(),
              [](const Influence& a, const Influence& b) { return a.weight < b.weight; });  // still distances
    if (list.empty()) continue;
    const float reach = list.size() > kNearest ? list[kNearest].weight : 1.5F * list.back().weight + 1;
    if (list.size() > kNearest) list.resize(kNearest);
    float sum = 0;
    for (Influence& i : list) {
      const float away = 1 - i.weight / reach;
      i.weight = std::max(away * away, 1e-6F);
      sum += i.weight;
    }
    for (Influence& i : list) i.weight /= sum;
  }
  return near;
}

}  // namespace

// Nodes, what they move, and the energy of their maps. `rest` is set.
void DeformationGraph::State::build(const Graph& graph, const std::vector<bool>& inside, std::int32_t first) {
  const std::vector<int> nodes = sample_nodes(graph, inside, first);
  for (const int n : nodes) node.push_back(rest[static_cast<std::size_t>(n)]);
  influences = influences_of(graph, nodes);
  influences.resize(rest.size());

  Entries entries;
  std::vector<std::uint8_t> linked(static_cast<std::size_t>(kNodes) * kNodes, 0);
  for (std::size_t v = 0; v < graph.size(); ++v)
    for (const Influence& a : influences[v])
      for (const Influence& b : influences[v]) {
        auto& done = linked[static_cast<std::size_t>(a.node) * kNodes + static_cast<std::size_t>(b.node)];
        if (a.node == b.node || done != 0) continue;
        done = 1;
        entries.add_edge(node[static_cast<std::size_t>(a.node)], node[static_cast<std::size_t>(b.node)], a.node,
                         b.node);
        if (a.node < b.node) entries.add_stiffness(a.node, b.node);
      }
  entries.hold(kHeld);
  energy.compute(entries.matrix());
}

DeformationGraph::DeformationGraph(const body::BodyModel& model, std::span<const Vec3f> rest)
    : state_(std::make_unique<State>()) {
  State& s = *state_;
  s.rest.assign(rest.begin(), rest.end());
  const Graph graph = edges_of(model, rest);
  const std::vector<bool> inside = main_part(graph);
  s.build(graph, inside, model.data().landmark(body::Landmark::navel));
  s.follow_skin(model, inside);
}

DeformationGraph::DeformationGraph(std::span<const std::array<std::int32_t, 3>> triangles,
                                   std::span<const Vec3f> rest, std::int32_t first)
    : state_(std::make_unique<State>()) {
  State& s = *state_;
  s.rest.assign(rest.begin(), rest.end());
  Graph graph(rest.size());
  for (const auto& triangle : triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      // The neighbour across the edge passes it the other way round.
      const auto a = static_cast<std::size_t>(triangle[i]), b = static_cast<std::size_t>(triangle[(i + 1) % 3]);
      graph[a].emplace_back(static_cast<int>(b), norm(rest[a] - rest[b]));
    }
  s.build(graph, std::vector<bool>(rest.size(), true), first);
}

// Helpers: what lies within a segment follows the skin of that segment on all sides.
void DeformationGraph::State::follow_skin(const body::BodyModel& model, const std::vector<bool>& inside) {
  const auto skin = model.data().skin;
  std::array<std::vector<std::size_t>, body::kSegmentCount> skin_of;
  for (std::size_t v = 0; v < inside.size(); ++v)
    if (inside[v]) skin_of[skin[v].segment[0]].push_back(v);
  follows.resize(rest.size());
  for (std::size_t h = 0; h < rest.size(); ++h) {
    if (h < inside.size() && inside[h]) continue;
    const auto& same = skin_of[skin[h].segment[0]];
    const auto squared = [&](std::size_t v) { return dot(rest[v] - rest[h], rest[v] - rest[h]); };
    float nearest = 1e12F;
    for (const std::size_t v : same) nearest = std::min(nearest, squared(v));
    const float reach = kAroundFactor * std::sqrt(nearest) + kAroundMm;
    std::array<float, kNodes> weight{};
    for (const std::size_t v : same) {
      if (squared(v) > reach * reach) continue;
      follows[h].push_back(static_cast<std::int32_t>(v));
      for (const Influence& i : influences[v]) weight[static_cast<std::size_t>(i.node)] += i.weight;
    }
    influences[h].clear();
    for (int n = 0; n < kNodes; ++n)
      if (weight[static_cast<std::size_t>(n)] > 0)
        influences[h].push_back({n, weight[static_cast<std::size_t>(n)] / static_cast<float>(follows[h].size())});
  }
}

DeformationGraph::DeformationGraph(DeformationGraph&&) noexcept = default;
DeformationGraph::~DeformationGraph() = default;

std::vector<Vec3f> DeformationGraph::response(const PullRow& row) {
  State& s = *state_;
  Eigen::MatrixXd force = Eigen::MatrixXd::Zero(4 * kNodes, 3);
  for (const Pull& pull : row) {
    const auto v = static_cast<std::size_t>(pull.vertex);
    const Eigen::RowVector3d g(static_cast<double>(pull.gradient.x), static_cast<double>(pull.gradient.y),
                               static_cast<double>(pull.gradient.z));
    for (const Influence& i : s.influences[v])
      force.block<4, 3>(4 * i.node, 0) += static_cast<double>(i.weight) * s.arm(v, i.node) * g;
  }
  Eigen::MatrixXd x = s.energy.solve(force);
  const double energy = (x.array() * force.array()).sum();
  const double scale = energy > 0 ? 1 / std::sqrt(energy) : 0;
  x *= scale;
  s.forces.push_back(force * scale);
  s.solutions.push_back(x);
  std::vector<Vec3f> out(s.rest.size());
  for (std::size_t v = 0; v < out.size(); ++v) {
    Eigen::RowVector3d d = Eigen::RowVector3d::Zero();
    for (const Influence& i : s.influences[v])
      d += static_cast<double>(i.weight) * s.arm(v, i.node).transpose() * x.block<4, 3>(4 * i.node, 0);
    out[v] = {static_cast<float>(d[0]), static_cast<float>(d[1]), static_cast<float>(d[2])};
  }
  return out;
}

double DeformationGraph::product(std::size_t i, std::size_t j) const {
  return (state_->solutions[i].array() * state_->forces[j].array()).sum();
}

int DeformationGraph::node_count() const {
  return kNodes;
}

void DeformationGraph::carry_helpers(std::span<Vec3f> displacement) const {
  for (std::size_t h = 0; h < state_->follows.size(); ++h) {
    const auto& around = state_->follows[h];
    if (around.empty()) continue;
    Vec3f sum;
    for (const std::int32_t v : around) sum = sum + displacement[static_cast<std::size_t>(v)];
    displacement[h] = sum * (1.0F / static_cast<float>(around.size()));
  }
}

}  // namespace im2fit::lab
