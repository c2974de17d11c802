// SPDX-License-Identifier: Apache-2.0
#include "index/index.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>

#include "core/container.h"
#include "core/file.h"
#include "index/answering.h"
#include "index/format.h"

namespace im2fit::index {
namespace {

std::string describe_method(const MetaRecord& meta) {
  std::string text = "ridge";
  if (meta.quadratic != 0) text += " + quadratic";
  if (meta.local_method == static_cast<std::uint32_t>(LocalMethod::mean)) text += " + mean residual of neighbours";
  if (meta.local_method == static_cast<std::uint32_t>(LocalMethod::linear)) text += " + local linear residual";
  return text;
}

Info make_info(const Contents& c) {
  Info info;
  info.provenance.assign(c.provenance.begin(), c.provenance.end());
  info.subject_count = c.meta.subject_count;
  info.entry_count = c.meta.entry_count;
  info.densified_count = c.meta.densified_count;
  info.tracker_key = c.meta.tracker_key;
  for (const GroupRecord& g : c.groups)
    info.groups.push_back(
        {std::string(g.name, strnlen(g.name, sizeof g.name)), g.first, g.count, g.weight, g.error_without});
  info.error_with_all = c.report.error_with_all;
  info.dimension_bits.assign(c.report.dimension_bits.begin(), c.report.dimension_bits.begin() + c.meta.dimensions);
  info.method = describe_method(c.meta);
  info.neighbour_count = static_cast<int>(c.meta.neighbour_count);
  info.prior_mae = c.report.prior_mae;
  info.ridge_mae = c.report.ridge_mae;
  info.nearest_mae = c.report.nearest_mae;
  info.answer_mae = c.report.answer_mae;
  info.coverage = c.report.coverage;
  info.sex_accuracy = c.report.sex_accuracy;
  for (std::size_t i = 0; i < kRefinementCount; ++i)
    if (const auto& r = c.refinements[i])
      info.refined[i] = {r->record.sample_count, r->record.mae, r->record.coverage};
  for (std::size_t v = 0; v < kClothingViews.size(); ++v)
    if (const auto& k = c.clothing[v]) info.clothing[v] = {k->record.sample_count, k->record.right_share};
  return info;
}

}  // namespace

struct Index::Data {
  std::vector<std::byte> memory;  // one of the two holds the bytes
  MappedFile file;
  Contents contents;
  Info info;
  std::string what;
  std::vector<Section> sections;
  std::unique_ptr<Answerer> answerer;
};

class Index::Scratch {
 public:
  explicit Scratch(const Answerer& answerer) : work(answerer) {}
  Answerer::Workspace work;
};

Index::Index() : data_(std::make_unique<Data>()) {}
Index::Index(Index&&) noexcept = default;
Index& Index::operator=(Index&&) noexcept = default;
Index::~Index() = default;

namespace {

Status load(Index::Data& data, std::span<const std::byte> bytes, const std::string& what) {
  auto contents = parse_contents(bytes, what);
  if (!contents) return contents.error();
  data.contents = *contents;
  data.info = make_info(*contents);
  data.what = what;
  const auto container = ContainerReader::parse(bytes, kMagic, kVersion, what, false);
  if (!container) return container.error();
  std::multimap<std::uint64_t, Index::Section> by_offset;  // an empty one shares its place with the next
  for (const auto& [name, entry] : container->entries())
    by_offset.emplace(entry.offset, Index::Section{name, entry.size});
  for (const auto& [offset, section] : by_offset) data.sections.push_back(section);
  data.answerer = std::make_unique<Answerer>(*contents);
  return Ok{};
}

}  // namespace

Result<Index> Index::open(const std::string& path) {
  auto file = MappedFile::open(path);
  if (!file) return file.error();
  Index index;
  index.data_->file = std::move(*file);
  if (auto s = load(*index.data_, index.data_->file.bytes(), path); !s) return s.error();
  return index;
}

Result<Index> Index::parse(std::vector<std::byte> bytes, const std::string& what) {
  Index index;
  index.data_->memory = std::move(bytes);
  if (auto s = load(*index.data_, index.data_->memory, what); !s) return s.error();
  return index;
}

std::size_t Index::size() const {
  return data_->contents.meta.entry_count;
}
int Index::dimensions() const {
  return static_cast<int>(data_->contents.meta.dimensions);
}
std::size_t Index::feature_size() const {
  return data_->contents.meta.feature_size;
}
const Info& Index::info() const {
  return data_->info;
}

std::unique_ptr<Index::Scratch, void (*)(Index::Scratch*)> Index::make_scratch() const {
  return {new Scratch(*data_->answerer), [](Scratch* s) { delete s; }};
}

Result<Answer> Index::query(std::span<const float> feature, const QueryOptions& options, Scratch& scratch) const {
  return query(Seen{feature, {}, {}, {}}, options, scratch);
}

Result<Answer> Index::query(const Seen& seen, const QueryOptions& options, Scratch& scratch) const {
  return data_->answerer->answer(seen, options, scratch.work);
}

Result<std::size_t> Index::alike(const Seen& seen, std::span<std::uint32_t> entries, Scratch& scratch) const {
  const auto found = data_->answerer->alike(seen, entries.size(), scratch.work);
  if (!found) return found.error();
  std::transform(found->begin(), found->end(), entries.begin(), [](const Neighbour& n) { return n.index; });
  return found->size();
}

FitLayout Index::fit_layout() const {
  for (const auto& refinement : data_->contents.refinements)
    if (refinement) return refinement->record.fit;
  return {};
}

bool Index::knows_clothed() const {
  const auto& known = data_->contents.refinements;
  return known[static_cast<std::size_t>(Refinement::clothed)] &&
         known[static_cast<std::size_t>(Refinement::clothed_turned)];
}

std::uint32_t Index::shape_key() const {
  for (const auto& refinement : data_->contents.refinements)
    if (refinement) return refinement->record.shape_key;
  return 0;
}

Result<IndexedPerson> Index::person_of(std::uint32_t entry) const {
  const Contents& c = data_->contents;
  if (auto sound = c.person_pages.check(c.number_of(entry)); !sound) return sound.error();
  return IndexedPerson{c.meta.population_version, c.meta.population_seed, c.person_of(entry)};
}

Result<float> Index::age_of(std::uint32_t entry) const {
  const Contents& c = data_->contents;
  if (auto sound = c.age_pages.check({entry, 1}); !sound) return sound.error();
  return age_of_step(c.age[entry]);
}

Result<MeasurementValues> Index::measurements_of(std::uint32_t entry) const {
  const Contents& c = data_->contents;
  if (auto sound = c.tree.pages.check(c.tree.block_of(entry)); !sound) return sound.error();
  if (auto sound = c.residual_pages.check(c.residual_of(entry)); !sound) return sound.error();
  return c.measurements_of_entry(entry);
}

std::vector<Index::Section> Index::sections() const {
  return data_->sections;
}

Status Index::verify(int trials) const {
  const Contents& c = data_->contents;
  const auto wrong = [&](const std::string& why) {
    return Error{ErrorCode::corrupt, data_->what + ": " + why + "; build the index again"};
  };
  const CodeTree& tree = c.tree;
  for (const PagedBytes* pages : {&tree.pages, &c.residual_pages, &c.person_pages, &c.age_pages})
    if (auto sound = pages->check_all(); !sound) return sound;
  const auto edges = [&](std::span<const std::int16_t> boxes, std::size_t box, std::size_t d) {
    const std::int16_t* edge =
        boxes.data() + (box / kBoxBlock * c.meta.dimensions + d) * 2 * kBoxBlock + box % kBoxBlock;
    return std::pair(edge[0], edge[kBoxBlock]);
  };
  for (std::size_t l = 0; l < tree.leaf_count(); ++l)
    for (std::size_t d = 0; d < c.meta.dimensions; ++d) {
      const auto [low, high] = edges(tree.leaf_boxes, l, d);
      const auto [group_low, group_high] = edges(tree.group_boxes, l / kGroupLeaves, d);
      if (low < group_low || high > group_high) return wrong("leaf " + std::to_string(l) + " lies outside its group");
      for (std::uint32_t i = tree.leaf_first[l]; i < tree.leaf_first[l + 1]; ++i)
        if (const int at = tree.code(i, d) * tree.steps[d]; at < low || at > high)
          return wrong("entry " + std::to_string(i) + " lies outside its leaf");
    }
  CodeSearch search(tree);
  std::vector<Neighbour> found;
  for (int t = 0; t < trials; ++t) {
    const auto entry =
        static_cast<std::uint32_t>(tree.point_count * static_cast<std::size_t>(t) / static_cast<std::size_t>(trials));
    Coordinates place{};
    for (std::size_t d = 0; d < c.meta.dimensions; ++d) place[d] = tree.code(entry, d) * tree.steps[d];
    const auto nearest = search.nearest(place, c.meta.neighbour_count);
    found.assign(nearest.begin(), nearest.end());
    const auto all = search.exhaustive(place, c.meta.neighbour_count);
    if (!std::equal(all.begin(), all.end(), found.begin(), found.end()))
      return wrong("the search near entry " + std::to_string(entry) + " misses neighbours");
  }
  return Ok{};
}

Index::Work Index::work_of(const Scratch& scratch) const {
  const Contents& c = data_->contents;
  const CodeSearch::Work& work = scratch.work.search.work();
  constexpr std::size_t kPage = 4096;
  const auto pages = [](std::size_t bytes) { return bytes / kPage + 2; };
  const std::size_t box_bytes = 4 * c.meta.dimensions, leaf_bytes = kLeafMax * 2 * c.tree.pair_count();
  const std::size_t neighbours = std::min<std::size_t>(kNeighbourMax, c.meta.neighbour_count);
  return {work.leaves, work.points,
          pages(c.tree.group_count() * box_bytes) + work.groups * pages(kGroupLeaves * (box_bytes + 4)) +
              work.leaves * pages(leaf_bytes) + 2 * neighbours};
}

std::size_t Index::pages_seen() const {
  const Contents& c = data_->contents;
  return c.tree.pages.pages_seen() + c.residual_pages.pages_seen() + c.person_pages.pages_seen() +
         c.age_pages.pages_seen();
}

}  // namespace im2fit::index
