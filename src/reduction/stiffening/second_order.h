#pragma once
#include "mimbre/beam_reduction.h"

namespace mimbre::fe {

/// Fills body.second_order for a body that is reduced and orthogonal (Lugrís 2008, chapter 4).
///
/// foreshortening: a bar that bends by slopes v' gets shorter, so that its points move along it by
/// −½ ∫ v'ᵀv' ds, summed up along the bars from the clamped node (4.19–4.24); rigid offsets turn to the
/// second order too. Elastic forces stay linear. nonlinear_stiffness: the strain energy ½∫EA u'² + ½∫EI v''²
/// gets the terms ½∫EA u' v'ᵀv' and, with nonlinear_stiffness_2, ⅛∫EA (v'ᵀv')² (4.5).
/// options.published_force: without what the first of them does on u (4.11). Throws std::invalid_argument
/// when the bars form a loop (foreshortening).
void add_second_order(const Mesh& mesh, const ReductionOptions& options, ReducedBody& body);

}  // namespace mimbre::fe
