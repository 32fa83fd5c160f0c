#include "fe_files/bodies/sid_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>

#include "fe_files/text.h"

// Format: O. Wallrapp, Standardization of flexible body modeling in multibody system codes, part I,
// Mechanics of Structures and Machines 22(3), 1994, appendix.

namespace mimbre::fe {
namespace {

/// Matrices of modes × modes are made by this number alone: entries that are zero are not in the file.
constexpr int kMostModes = 1000;

bool is_block(std::string_view word) {
  for (const std::string_view name : {"origin", "phi", "psi", "AP", "sigma", "mdCM", "J", "Ct", "Cr", "Me",
                                      "Gr", "Ge", "Oe", "ksigma", "Ke", "De"})
    if (word == name) return true;
  return false;
}

class SidReader {
 public:
  explicit SidReader(TextFile& file) : file_(file) {}

  SidFile read() {
    std::string_view line = file_.expect("the head");
    const auto nodes = to_integer(next_word(line)), modes = to_integer(next_word(line));
    if (!nodes || !modes || *nodes < 0 || *modes < 0 || *modes > kMostModes)
      file_.fail("is no SID file: the first line must begin with the numbers of nodes and of modes");
    sid_.modes = static_cast<int>(*modes);
    sid_.mode_names.resize(static_cast<std::size_t>(sid_.modes));
    bool ended = false;
    while (!ended && file_.next(line)) {
      std::string_view rest = line;
      const std::string_view word = next_word(rest);
      if (word == "new" && starts(rest, "modal")) modal_ = true;
      if (word == "new" && starts(rest, "node")) read_node(value_of(line));
      if (word == "refmod") read_refmod();
      if (word == "end" && starts(rest, "part")) ended = true;
      if (modal_ && is_block(word)) add(sid_.blocks, word);
    }
    if (!modal_) file_.fail("has no 'new modal'");
    if (!ended) file_.fail("ends without 'end part'");
    if (static_cast<std::int64_t>(sid_.nodes.size()) != *nodes)
      file_.fail(fmt::format("has {} nodes, its head has {}", sid_.nodes.size(), *nodes));
    find_index_order();
    return std::move(sid_);
  }

 private:
  TextFile& file_;
  SidFile sid_;
  bool modal_ = false;
  std::set<std::string> labels_;

  static bool starts(std::string_view rest, std::string_view word) { return trimmed(rest).starts_with(word); }

  static std::string_view value_of(std::string_view line) {
    const std::size_t equals = line.find('=');
    return equals == std::string_view::npos ? std::string_view() : trimmed(line.substr(equals + 1));
  }

  int integer(std::string_view text, const char* what, int most) {
    const auto value = to_integer(text);
    if (!value || *value < 0 || *value > most)
      file_.fail(fmt::format("'{}' is no {} (0 to {})", shown(text), what, most));
    return static_cast<int>(*value);
  }
  double real(std::string_view text) {
    const auto value = to_real(text);
    if (!value) file_.fail(fmt::format("'{}' is no finite number", shown(text)));
    return *value;
  }

  void read_refmod() {
    while (true) {
      const std::string_view line = file_.expect("refmod");
      std::string_view rest = line;
      const std::string_view word = next_word(rest);
      if (word == "end") return;
      if (word == "mass") sid_.mass = real(value_of(line));
      if (word == "nelastq" && integer(value_of(line), "number of modes", kMostModes) != sid_.modes)
        file_.fail(fmt::format("nelastq is {}, the head has {} modes", value_of(line), sid_.modes));
      if (word.starts_with("ielastq")) {
        const std::size_t open = line.find('('), close = line.find(')');
        if (open == std::string_view::npos || close == std::string_view::npos || close < open)
          file_.fail("ielastq needs a number: ielastq ( 1) = Eigen Mode 1 : 10.0 Hz");
        const int index = integer(line.substr(open + 1, close - open - 1), "number of a mode", sid_.modes);
        if (index < 1) file_.fail("modes count from 1");
        const std::string_view text = value_of(line);
        std::string name;
        std::string_view words = text.substr(0, text.find(':'));
        for (std::string_view part = next_word(words); !part.empty(); part = next_word(words))
          name += (name.empty() ? "" : " ") + std::string(part);
        sid_.mode_names[static_cast<std::size_t>(index - 1)] = name;
      }
    }
  }

  void read_node(std::string_view label) {
    SidNode node;
    node.label = label;
    if (!labels_.insert(node.label).second) file_.fail(fmt::format("node {} is there twice", shown(label)));
    while (true) {
      std::string_view line = file_.expect("a node");
      const std::string_view word = next_word(line);
      if (word == "end") break;
      if (is_block(word)) add(node.blocks, word);
    }
    sid_.nodes.push_back(std::move(node));
  }

  void add(std::map<std::string, SidBlock>& blocks, std::string_view word) {
    const std::string name(word);
    SidBlock block = read_block(name);
    if (!blocks.emplace(name, std::move(block)).second)
      file_.fail(fmt::format("block {} is there twice", name));
  }

  SidBlock read_block(const std::string& name) {
    SidBlock block;
    block.mark = file_.mark();
    const int widest = 3 * std::max(sid_.modes, 2);
    while (true) {
      const std::string_view line = file_.expect("a block");
      std::string_view rest = line;
      const std::string_view word = next_word(rest);
      if (word.empty()) continue;
      if (word == "end") return block;
      const std::string_view value = value_of(line);
      if (word == "order") {
        block.order = integer(value, "order", 100);
      } else if (word == "nrow") {
        block.rows = integer(value, "number of rows", widest);
      } else if (word == "ncol") {
        block.columns = integer(value, "number of columns", widest);
      } else if (word == "nq") {
        block.modes = integer(value, "number of modes", sid_.modes);
      } else if (word == "nqn") {
        if (integer(value, "number of higher terms", 1000000) != 0)
          file_.fail("terms of higher order (nqn) are not read");
      } else if (word == "structure") {
        block.structure = integer(value, "structure", 4);
      } else if (word.starts_with("m0")) {
        block.m0.push_back(entry(line, 2));
        check(block, block.m0.back(), name, true);
      } else if (word.starts_with("m1")) {
        block.m1.push_back(entry(line, 3));
        check(block, block.m1.back(), name, false);
      } else {
        file_.fail(fmt::format("'{}' in the block {} is not known", shown(word), name));
      }
    }
  }

  SidBlock::Entry entry(std::string_view line, int count) {
    const std::size_t open = line.find('('), close = line.find(')');
    if (open == std::string_view::npos || close == std::string_view::npos || close < open)
      file_.fail(fmt::format("'{}' has no indices", shown(trimmed(line))));
    std::string_view indices = line.substr(open + 1, close - open - 1);
    std::array<int, 3> numbers{};
    for (int i = 0; i < count; ++i)
      numbers[static_cast<std::size_t>(i)] = integer(next_field(indices), "index", 3 * kMostModes);
    if (!indices.empty())
      file_.fail(fmt::format("'{}' has more than {} indices", shown(trimmed(line)), count));
    return {numbers[0], numbers[1], numbers[2], real(value_of(line))};
  }

  void check(const SidBlock& block, const SidBlock::Entry& entry, const std::string& name, bool constant) {
    const auto within = [](int index, int most) { return index >= 1 && index <= most; };
    const bool plain = within(entry.second, block.modes) && within(entry.third, block.columns);
    const bool swapped = within(entry.second, block.columns) && within(entry.third, block.modes);
    const bool good =
        within(entry.row, block.rows) && (constant ? within(entry.second, block.columns) : plain || swapped);
    if (!good)
      file_.fail(fmt::format("an index of the block {} is outside of {} x {} and {} modes", name, block.rows,
                             block.columns, block.modes));
  }

  /// Programs index m1 as (row, mode, column) or as (row, column, mode): one order must do for the whole
  /// file.
  void find_index_order() {
    bool plain = true, swapped = true;
    const auto look = [&](const std::map<std::string, SidBlock>& blocks) {
      for (const auto& [name, block] : blocks)
        for (const SidBlock::Entry& entry : block.m1) {
          plain = plain && entry.second <= block.modes && entry.third <= block.columns;
          swapped = swapped && entry.second <= block.columns && entry.third <= block.modes;
        }
    };
    look(sid_.blocks);
    for (const SidNode& node : sid_.nodes) look(node.blocks);
    if (!plain && !swapped)
      file_.fail("has m1 indices in both orders, (row, mode, column) and (row, column, mode)");
    sid_.mode_is_last = !plain;
  }
};

}  // namespace

SidFile parse_sid_file(TextFile& file) { return SidReader(file).read(); }

Eigen::MatrixXd constant_part(const SidBlock& block) {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(block.rows, block.columns);
  if (block.structure == 4) return Eigen::MatrixXd::Identity(block.rows, block.columns);
  std::set<std::pair<int, int>> given;
  for (const SidBlock::Entry& entry : block.m0) {
    result(entry.row - 1, entry.second - 1) = entry.value;
    if (block.structure == 2) given.insert({entry.row, entry.second});
  }
  for (const auto& [row, column] : given)
    if (column <= block.rows && row <= block.columns && !given.count({column, row}))
      result(column - 1, row - 1) = result(row - 1, column - 1);
  return result;
}

std::vector<Eigen::MatrixXd> linear_parts(const SidBlock& block, const SidFile& file) {
  std::vector<Eigen::MatrixXd> result(static_cast<std::size_t>(file.modes),
                                      Eigen::MatrixXd::Zero(block.rows, block.columns));
  for (const SidBlock::Entry& entry : block.m1) {
    const int mode = file.mode_is_last ? entry.third : entry.second;
    const int column = file.mode_is_last ? entry.second : entry.third;
    result[static_cast<std::size_t>(mode - 1)](entry.row - 1, column - 1) = entry.value;
  }
  return result;
}

}  // namespace mimbre::fe
