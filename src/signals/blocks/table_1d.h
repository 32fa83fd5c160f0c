#pragma once
#include "signals/blocks/block.h"

/// A table of one variable: a function of points, which goes on beyond its ends as it ends.
namespace mimbre::blocks {

namespace table {

template <class T>
void output(const BlockCall<T>& c) {
  c.out[0] = value_at(*c.function, c.in[0]);
}

template <class T>
void slope(const BlockCall<T>& c, T* by) {
  by[0] = tangent_at(*c.function, c.in[0]).second;
}

inline bool keep(const BlockCall<double>&, double*) { return false; }

}  // namespace table

struct Table {
  static void check(const spec::Block& b, const checks::CheckedItem& item) {
    if (b.function.is_zero()) item.error("has no points");
  }
  static void compile(const spec::Block& b, const BlockPlan& plan) {
    plan.block.function = static_cast<int>(plan.signals.functions.size());
    plan.signals.functions.push_back(b.function.data());
  }
  static constexpr BlockInfo info{
      .name = "table", .key = "table", .points = true, .check = check, .compile = compile};
  template <class T>
  static constexpr BlockRow<T> row{table::output<T>, table::slope<T>, nullptr, table::keep};
};

}  // namespace mimbre::blocks
