#pragma once
#include <string>
#include <vector>

#include "compile/compiled.h"
#include "dynamics/state_transfer.h"

namespace mimbre {

/// What went wrong at a contact or under a tyre, since the start.
struct ContactTrouble {
  /// A sphere and what it touches; of a tyre no more than the element.
  struct Where {
    int element = -1, frame_a = -1, frame_b = -1;
    double radius = 0;
    void transfer(StateTransfer& transfer) { transfer(element, frame_a, frame_b, radius); }
  };
  double passed = -1;  ///< s: when something was first gone through unseen; −1: never
  int passes = 0;
  Where passed_where;
  double sank = -1;                                   ///< s: when something was first too deep; −1: never
  double depth = 0, depth_limit = 0, deepest_at = 0;  ///< the worst of it, m, m, s
  Where sank_where;

  void transfer(StateTransfer& transfer) {
    transfer(passed, passes, sank, depth, depth_limit, deepest_at);
    passed_where.transfer(transfer);
    sank_where.transfer(transfer);
  }
};

/// Troubles by contact of the model, then by tyre. Of the same model copies take no memory.
using ContactLog = std::vector<ContactTrouble>;
ContactLog empty_contact_log(const Compiled& model);

/// A warning for each of them. `substeps`: parts in which a step is repeated.
std::vector<std::string> contact_warnings(const Compiled& model, const ContactLog& log, int substeps);

/// What a step that failed may owe to a wheel that was below its road before: "; tyre 'fl': …", or nothing.
std::string sunk_wheels(const Compiled& model, const ContactLog& log);

}  // namespace mimbre
