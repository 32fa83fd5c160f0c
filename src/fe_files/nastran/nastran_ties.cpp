#include <fmt/format.h>

#include "fe_files/nastran/nastran_model.h"
#include "fe_files/text.h"

// MSC Nastran Quick Reference Guide, R cards and MPC.

namespace mimbre::fe {

namespace {

constexpr unsigned kAll = 63;

/// Without what stands behind the nodes: ALPHA and TREF, real numbers.
bool is_real_number(std::string_view field) {
  return !field.empty() && !to_integer(field) && to_real(field).has_value();
}

void read_rbe2(NastranModel& model, const NastranCard& card) {
  NastranRigid rigid;
  rigid.label = card.label(0, "element number");
  rigid.reference = card.label(1, "node");
  rigid.card = card.name;
  rigid.place = model.place(card.mark);
  const unsigned components = card.components(2);
  for (std::size_t i = 3; i < card.fields.size(); ++i) {
    if (card.blank(i)) continue;
    if (is_real_number(card.field(i))) break;
    if (capitals(card.field(i)) == "THRU") {
      if (rigid.followers.empty()) card.fail("THRU stands before every node");
      const std::int64_t last = card.label(++i, "node");
      for (std::int64_t node = rigid.followers.back().first + 1; node <= last; ++node) {
        if (rigid.followers.size() > 1'000'000) card.fail("has too many nodes");
        rigid.followers.emplace_back(node, components);
      }
      continue;
    }
    rigid.followers.emplace_back(card.label(i, "node"), components);
  }
  if (components == 0) card.fail("has no components that follow");
  model.rigid.push_back(std::move(rigid));
}

/// Six components of its two nodes are free; all others, or those of CMA and CMB, follow.
void read_rbar(NastranModel& model, const NastranCard& card) {
  NastranRigid rigid;
  rigid.label = card.label(0, "element number");
  rigid.card = card.name;
  rigid.place = model.place(card.mark);
  const std::int64_t a = card.label(1, "node"), b = card.label(2, "node");
  const unsigned free_a = card.components(3), free_b = card.components(4);
  const unsigned follow_a = card.components(5), follow_b = card.components(6);
  const bool partly = follow_a != 0 || follow_b != 0;
  if (!partly) {
    rigid.reference = free_b == kAll ? b : a;
    rigid.followers = {{free_b == kAll ? a : b, kAll}};
  } else if (free_a == kAll && follow_a == 0) {
    rigid.reference = a;
    rigid.followers = {{b, follow_b}};
  } else if (free_b == kAll && follow_b == 0) {
    rigid.reference = b;
    rigid.followers = {{a, follow_a}};
  } else if ((free_a | follow_a) == kAll && (free_b | follow_b) == kAll) {
    rigid.reference = a;
    rigid.followers = {{b, kAll}};
  } else {
    card.fail("components of both nodes follow in part only; let all six of one be free (CNA or CNB 123456)");
  }
  model.rigid.push_back(std::move(rigid));
}

/// Nodes and components that are free, behind UM those that follow.
void read_rbe1(NastranModel& model, const NastranCard& card) {
  NastranRigid rigid;
  rigid.label = card.label(0, "element number");
  rigid.card = card.name;
  rigid.place = model.place(card.mark);
  bool follow = false;
  std::vector<std::pair<std::int64_t, unsigned>> free;
  for (std::size_t line = 0; line < card.fields.size(); line += 8) {
    if (capitals(card.field(line)) == "UM") follow = true;
    for (std::size_t i = line + 1; i + 1 < line + 8; i += 2) {
      if (card.blank(i) || is_real_number(card.field(i)) || capitals(card.field(i)) == "UM") continue;
      (follow ? rigid.followers : free).emplace_back(card.label(i, "node"), card.components(i + 1));
    }
  }
  for (const auto& [node, components] : free)
    if (components == kAll) rigid.reference = node;
  if (rigid.reference == 0 || free.size() != 1)
    card.fail("several nodes share the six free components; give one node all six (123456)");
  model.rigid.push_back(std::move(rigid));
}

void read_rbe3(NastranModel& model, const NastranCard& card) {
  NastranMean mean;
  mean.label = card.label(0, "element number");
  mean.reference = card.label(2, "reference node");
  mean.components = card.components(3);
  mean.place = model.place(card.mark);
  if (mean.components == 0) card.fail("has no components of the reference node");
  // Weight, components, nodes, and so on. Weights are real, nodes whole numbers.
  double weight = 0;
  unsigned components = 0;
  bool after_weight = false;
  for (std::size_t i = 4; i < card.fields.size(); ++i) {
    const std::string_view field = card.field(i);
    if (field.empty()) continue;
    const std::string word = capitals(field);
    if (word == "UM" || word == "ALPHA") break;  // which of the components are dependent does not matter
    if (is_real_number(field)) {
      weight = card.real(i, "weight");
      after_weight = true;
    } else if (after_weight) {
      components = card.components(i);
      after_weight = false;
    } else if (word == "THRU") {
      if (mean.nodes.empty()) card.fail("THRU stands before every node");
      const std::int64_t last = card.label(++i, "node");
      for (std::int64_t node = mean.nodes.back().node + 1; node <= last; ++node) {
        if (mean.nodes.size() > 1'000'000) card.fail("has too many nodes");
        mean.nodes.push_back({node, components, weight});
      }
    } else {
      mean.nodes.push_back({card.label(i, "node"), components, weight});
    }
  }
  if (mean.nodes.empty()) card.fail("has no nodes");
  model.means.push_back(std::move(mean));
}

/// Lines G1 C1 A1 G2 C2 A2, with a blank before and, of all lines but the first, behind the first number.
void read_equation(NastranModel& model, const NastranCard& card) {
  NastranEquation equation;
  equation.set = card.label(0, "set number");
  equation.place = model.place(card.mark);
  for (std::size_t line = 0; line < card.fields.size(); line += 8)
    for (const std::size_t i : {line + 1, line + 4}) {
      if (card.blank(i)) continue;
      const std::int64_t component = card.whole(i + 1, "component", 0);
      if (component < 0 || component > 6) card.fail(fmt::format("component {} is not in 1 to 6", component));
      equation.terms.push_back(
          {card.label(i, "node"), static_cast<int>(component) - 1, card.real(i + 2, "factor")});
    }
  if (equation.terms.empty()) card.fail("has no terms");
  model.equations.push_back(std::move(equation));
}

/// A rod that keeps its length: one translation follows. Kept as a rigid element without components, see
/// finish_nastran.
void read_rrod(NastranModel& model, const NastranCard& card) {
  NastranRigid rigid;
  rigid.label = card.label(0, "element number");
  rigid.reference = card.label(1, "node");
  rigid.followers = {{card.label(2, "node"), 0u}};
  rigid.card = card.name;
  rigid.place = model.place(card.mark);
  model.rigid.push_back(std::move(rigid));
}

}  // namespace

bool read_nastran_tie(NastranModel& model, const NastranCard& card) {
  const std::string& name = card.name;
  if (name == "RBE2") {
    read_rbe2(model, card);
  } else if (name == "RBE1") {
    read_rbe1(model, card);
  } else if (name == "RBE3") {
    read_rbe3(model, card);
  } else if (name == "RBAR") {
    read_rbar(model, card);
  } else if (name == "RROD") {
    read_rrod(model, card);
  } else if (name == "MPC") {
    read_equation(model, card);
  } else if (name == "MPCADD") {
    std::vector<std::int64_t>& sum = model.equation_sums[card.label(0, "set number")];
    for (std::size_t i = 1; i < card.fields.size(); ++i)
      if (!card.blank(i)) sum.push_back(card.label(i, "set number"));
  } else {
    return false;
  }
  return true;
}

}  // namespace mimbre::fe
