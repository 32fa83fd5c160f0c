#pragma once
#include <memory>
#include <utility>
#include <variant>

#include "math/function_data.h"
#include "mimbre/function.h"
#include "spec/archive.h"

namespace mimbre {

/// What functions and formulas are made of, of which a copy gives the same bits.
struct FunctionParts {
  template <class A>
  static void of(A& archive, archive::Of<Pieces> auto& p) {
    archive(p.breaks_, p.origins_, p.first_, p.coefficients_, p.integrals_, p.integral_at_origin_,
            p.integral_at_zero_, p.wrap_.start, p.wrap_.period, p.wrap_.integral);
  }
  template <class A>
  static void of(A& archive, archive::Of<Expression> auto& e) {
    auto& [code, stack] = e.program_;
    archive(code, stack, e.variables_);
  }
  template <class A>
  static void of(A& archive, archive::Of<IntegralTable> auto& t) {
    archive(t.edges_, t.values_);
  }

  static void of(archive::Writer& archive, const FunctionData& f) {
    archive(static_cast<std::int32_t>(f.kind_.index()));
    std::visit(
        [&](const auto& kind) {
          if constexpr (!std::is_same_v<std::remove_cvref_t<decltype(kind)>, std::monostate>) archive(kind);
        },
        f.kind_);
  }
  static void of(archive::Reader& archive, FunctionData& f) {
    std::int32_t index = 0;
    archive(index);
    switch (index) {
      case 0:
        f.kind_ = std::monostate();
        return;
      case 1:
        return archive(f.kind_.emplace<1>());
      case 2:
        return archive(f.kind_.emplace<2>());
      case 3:
        return archive(f.kind_.emplace<3>());
      default:
        throw InputError(Mark{}, "these bytes of a model have a function of an unknown kind");
    }
  }

  /// Function and Formula, which share what they evaluate.
  template <class A>
  static void shared(A& archive, auto& f) {
    archive(f.data_);
  }
};

}  // namespace mimbre
