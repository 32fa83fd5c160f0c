#pragma once
#include "compile/compiled.h"

/// Bodies between frames, and where their columns stand in rows of the Jacobian.
namespace mimbre {

/// The bodies whose coordinates move frame b relative to frame a.
Path make_path(const Compiled& c, int frame_a, int frame_b);
/// Gives the entry its place in the path's rows.
void append(const Compiled& c, PathEntry& e, Path& path);
/// Room for rows along the path; where it begins.
int add_jacobian(Compiled& c, const Path& path, int rows);

/// Any frame that no coordinate moves: the parent side of a tree joint on the ground.
int ground_frame(const Compiled& c);

/// Of a frame of the spec, in the assembled position.
spec::Pose global_pose(const Compiled& c, int frame);
double assembled_distance(const Compiled& c, int frame_a, int frame_b);

}  // namespace mimbre
