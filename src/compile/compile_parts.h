#pragma once
#include "compile/compiled.h"
#include "compile/topology.h"
#include "spec/contact_pairs.h"

/// The phases of compile(), in their order (compile.cpp). Each appends to `c`, whose spec is checked, and
/// uses what those before it made.
namespace mimbre {

/// Bodies in the order of the tree, and their coordinates.
void compile_bodies(Compiled& c, const Topology& topology);
/// Frames: by body those that a step needs, then those for output.
void compile_frames(Compiled& c, const Topology& topology, const ContactPairs& pairs);
/// Motion subspaces of bodies and of frames that modes move.
void compile_subspaces(Compiled& c);

void compile_roads(Compiled& c);
/// Force elements but contacts.
void compile_elements(Compiled& c, const Topology& topology);
/// Surfaces, and an element for each pair of a sphere and what it can touch.
void compile_contacts(Compiled& c, const ContactPairs& pairs);
/// Elements that measure the summands of each sum, and the sum's path over their bodies.
void compile_sums(Compiled& c);

/// Equations of cut joints, of drives, of constraints.
void compile_loops(Compiled& c, const Topology& topology);
void compile_drives(Compiled& c);
void compile_constraints(Compiled& c);

/// The pattern of the matrix, and the places of all that is added to it.
void compile_sparsity(Compiled& c);

}  // namespace mimbre
