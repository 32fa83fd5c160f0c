#pragma once
#include <vector>

#include "dynamics/natural/once/layout.h"

namespace mimbre::natural {

/// Unknowns that a body, a joint, a force element, a drive or a constraint couples with each other: the
/// pattern of all derivatives of the residual, but for signals that act elsewhere than where they are
/// measured.
inline std::vector<std::vector<int>> column_groups(const Layout& l) {
  std::vector<std::vector<int>> groups;
  const auto add = [&](const Stencil& s) {
    if (s.size() > 1) groups.push_back(s.columns);
  };
  for (const Body& b : l.bodies) add(b.stencil);
  for (const Joint& j : l.joints) add(j.link.stencil);
  for (const Link& link : l.elements) add(link.stencil);
  for (const Link& link : l.drives) add(link.stencil);
  for (const ConstraintLink& link : l.constraints) add(link.stencil);
  return groups;
}

}  // namespace mimbre::natural
