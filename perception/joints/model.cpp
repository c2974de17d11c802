// SPDX-License-Identifier: Apache-2.0
// Reading a .i2t file: every size and index is checked once here, so that tracking needs no checks.
#include <algorithm>

#include "core/container.h"
#include "core/crc32c.h"
#include "perception/joints/model_data.h"

namespace im2fit {
namespace {

using joints::JumpNode;

constexpr float kBasisMaxMm = 100;  // a unit; times 127 a tree

Error damaged(const std::string& what, const std::string& detail) {
  return {ErrorCode::corrupt, what + ": " + detail + "; train the tracker again"};
}

Status check_meta(const joints::Meta& m, const std::string& what) {
  const auto within = [](std::uint32_t v, std::uint32_t low, std::uint32_t high) { return v >= low && v <= high; };
  if (!within(m.forest_tree_count, 2, 16) || m.forest_tree_count % 2 != 0)
    return damaged(what, "forest trees per joint are not 2, 4 .. 16");
  if (!within(m.jump_count, 1, 64)) return damaged(what, "jumps per joint are not 1..64");
  if (!within(m.level_count, 0, 32)) return damaged(what, "cascade levels are not 0..32");
  if (!within(m.level_tree_count, 1, 4096)) return damaged(what, "trees per cascade level are not 1..4096");
  if (!within(m.side_tree_count, 0, 1024)) return damaged(what, "trees for front or back are not 0..1024");
  if (!within(m.person_tree_count, 0, 1024)) return damaged(what, "trees for person votes are not 0..1024");
  if (!within(m.pixel_count, 2, joints::kPixelCountMax)) return damaged(what, "anchors per level are not 2..1024");
  return Ok{};
}

// Children lie behind their parent: walking a tree ends.
Status check_forest(const joints::ForestView& f, const std::string& what) {
  const std::size_t tree_count = f.tree_start.size() - 1;
  if (f.tree_start[0] != 0 || f.tree_start[tree_count] != f.nodes.size())
    return damaged(what, "section tree does not span section node");
  for (std::size_t t = 0; t < tree_count; ++t) {
    if (f.tree_start[t] >= f.tree_start[t + 1] || f.tree_start[t + 1] > f.nodes.size())
      return damaged(what, "tree " + std::to_string(t) + " has no nodes or starts out of order");
    const auto tree = f.nodes.subspan(f.tree_start[t], f.tree_start[t + 1] - f.tree_start[t]);
    for (std::size_t i = 0; i < tree.size(); ++i) {
      const std::size_t left = tree[i].left;
      if (left != 0 && (left <= i || left + 1 >= tree.size()))
        return damaged(what, "tree " + std::to_string(t) + " node " + std::to_string(i) + " has a child outside");
    }
  }
  return Ok{};
}

Status check_trees(std::span<const joints::Anchor> anchors, std::span<const joints::Split> splits,
                   std::uint32_t value_count, const std::string& what) {
  for (const joints::Anchor& a : anchors)
    if (a.joint >= kJointCount || a.towards >= kJointCount)
      return damaged(what, "an anchor names joint " + std::to_string(std::max(a.joint, a.towards)) + " of 15");
  for (const joints::Anchor& a : anchors)
    if (a.share_q8 < 0 || a.share_q8 > 256) return damaged(what, "an anchor does not lie between its joints");
  for (const joints::Split& s : splits)
    if (s.a >= value_count || s.b >= value_count)
      return damaged(
          what, "a split reads value " + std::to_string(std::max(s.a, s.b)) + " of " + std::to_string(value_count));
  return Ok{};
}

// `clue_count`: values beside the anchors' that splits may read.
Result<joints::Votes> read_votes(const ContainerReader& reader, const std::string& name, std::uint32_t tree_count,
                                 std::uint32_t pixel_count, std::uint32_t clue_count, const std::string& what) {
  auto anchors = reader.array<joints::Anchor>(name + " anchor", tree_count > 0 ? pixel_count : 0);
  if (!anchors) return anchors.error();
  auto splits =
      reader.array<joints::Split>(name + " split", static_cast<std::size_t>(tree_count) * joints::kSplitCount);
  if (!splits) return splits.error();
  auto leaves = reader.array<std::int16_t>(name + " leaf", static_cast<std::size_t>(tree_count) * joints::kLeafCount);
  if (!leaves) return leaves.error();
  if (Status ok = check_trees(*anchors, *splits, pixel_count + clue_count, what); !ok) return ok.error();
  return joints::Votes{*anchors, *splits, *leaves};
}

Status check_basis(const JointModel::Data& d, const std::string& what) {
  for (const joints::Basis& level : d.basis)
    for (const float mm : level)
      if (!(mm >= -kBasisMaxMm && mm <= kBasisMaxMm)) return damaged(what, "a basis holds no length in mm");
  return Ok{};
}

// Without a chance above 0 the person score, a share of their mean, would be no number.
Status check_bins(const JointModel::Data& d, const std::string& what) {
  for (std::size_t i = 1; i < d.bins.size(); ++i)
    if (i % static_cast<std::size_t>(joints::kConfidenceBinCount) != 0 &&
        d.bins[i].spread_mm_max < d.bins[i - 1].spread_mm_max)
      return damaged(what, "section confidence is not in order of rising spread");
  const bool none =
      std::all_of(d.bins.begin(), d.bins.end(), [](const joints::ConfidenceBin& bin) { return bin.chance == 0; });
  return none ? Status(damaged(what, "section confidence has no chance above 0")) : Ok{};
}

}  // namespace

JointModel::JointModel() : data_(std::make_unique<Data>()) {}
JointModel::JointModel(JointModel&&) noexcept = default;
JointModel& JointModel::operator=(JointModel&&) noexcept = default;
JointModel::~JointModel() = default;

std::string_view JointModel::provenance() const {
  return data_->provenance;
}

std::uint32_t JointModel::key() const {
  return data_->key;
}

Result<JointModel> JointModel::parse(std::span<const std::byte> bytes, const std::string& what) {
  auto reader = ContainerReader::parse(bytes, joints::kTrackerMagic, joints::kTrackerVersion, what);
  if (!reader) return reader.error();
  JointModel model;
  Data& d = *model.data_;
  auto meta = reader->array<joints::Meta>("meta", 1);
  if (!meta) return meta.error();
  d.meta = (*meta)[0];
  if (Status ok = check_meta(d.meta, what); !ok) return ok.error();
  const std::size_t level_trees = static_cast<std::size_t>(d.meta.level_count) * d.meta.level_tree_count;

  auto starts = reader->array<std::uint32_t>("tree", kJointCount * d.meta.forest_tree_count + 1);
  if (!starts) return starts.error();
  auto nodes = reader->array<JumpNode>("node");
  if (!nodes) return nodes.error();
  auto bone = reader->array<std::int16_t>("bone", kJointCount * 3);
  if (!bone) return bone.error();
  d.forest = {d.meta.forest_tree_count, d.meta.jump_count, *starts, *nodes, *bone};
  if (Status ok = check_forest(d.forest, what); !ok) return ok.error();

  auto anchors =
      reader->array<joints::Anchor>("anchor", static_cast<std::size_t>(d.meta.level_count) * d.meta.pixel_count);
  if (!anchors) return anchors.error();
  auto splits = reader->array<joints::Split>("split", level_trees * joints::kSplitCount);
  if (!splits) return splits.error();
  auto leaves = reader->array<std::int8_t>("leaf", level_trees * joints::kLeafCount * joints::kLeafSize);
  if (!leaves) return leaves.error();
  auto basis = reader->array<joints::Basis>("basis", d.meta.level_count);
  if (!basis) return basis.error();
  auto bins = reader->array<joints::ConfidenceBin>("confidence", kJointCount * joints::kConfidenceBinCount);
  if (!bins) return bins.error();
  auto side = read_votes(*reader, "side", d.meta.side_tree_count, d.meta.pixel_count, 0, what);
  if (!side) return side.error();
  auto person_votes = read_votes(*reader, "somebody", d.meta.person_tree_count, d.meta.pixel_count,
                                 static_cast<std::uint32_t>(joints::kClueCount), what);
  if (!person_votes) return person_votes.error();
  auto provenance = reader->array<char>("provenance");
  if (!provenance) return provenance.error();
  if (provenance->size() > joints::kProvenanceMax) return damaged(what, "provenance is longer than 64 KiB");
  d.provenance = {provenance->data(), provenance->size()};
  d.key = crc32c(bytes);
  d.anchors = *anchors;
  d.splits = *splits;
  d.leaves = *leaves;
  d.basis = *basis;
  d.bins = *bins;
  d.side = *side;
  d.person_votes = *person_votes;
  if (Status ok = check_trees(d.anchors, d.splits, d.meta.pixel_count, what); !ok) return ok.error();
  if (Status ok = check_basis(d, what); !ok) return ok.error();
  if (Status ok = check_bins(d, what); !ok) return ok.error();
  return model;
}

}  // namespace im2fit
