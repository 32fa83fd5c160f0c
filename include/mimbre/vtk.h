#pragma once
#include <functional>
#include <string>

#include "mimbre/results.h"

namespace mimbre {

struct VtkOptions {
  int most_instants = 500;                    ///< of the run, evenly spread, the first and the last included
  std::function<void(double done)> progress;  ///< 0 to 1
};

/// A run for ParaView: FOLDER/run.pvd is a time series of all bodies, each instant of each body a PolyData
/// file (.vtp, XML, binary) with its points in global axes, triangles and lines, and, at the points,
/// displacement (from the body's rigid motion, global axes, m), for bodies with stress the components
/// (xx yy zz xy yz zx, body axes, Pa), von Mises stress and its largest value in the whole run. Makes the
/// folder where it is missing; where there is one, run.pvd and all .vtp in it are replaced at the end, all or
/// none, and other files stay. Returns the path of run.pvd. Throws std::runtime_error that names what cannot
/// be written.
std::string write_vtk(const Results& results, const std::string& folder, const VtkOptions& options = {});

}  // namespace mimbre
